"""What nobody knows of a load: when it stepped between two samples, its noise at the first one."""

from itertools import accumulate

import numpy as np
import pytest

import springpot
from springpot.misfit.residuals_of_tests import part_of
from springpot.timetests import diagnose, identify

TIME, TAU = np.linspace(0.0, 100.0, 101), 5.0
ZENER = springpot.parse_model("zener")


def released(late, noise=0.002):
    """Creep of J = 1 + 1.5 (1 - exp(-t / tau)), and what is left of it after a release."""

    def creep(t):
        return np.where(t >= 0.0, 2.5 - 1.5 * np.exp(-np.maximum(t, 0.0) / TAU), 0.0)

    strain = creep(TIME) - creep(TIME - 50.0 - late)
    strain += noise * np.random.default_rng(3).normal(size=len(TIME))
    return springpot.TimeTest.of_history(TIME, strain, 1.0 * (TIME <= 50.0), "-", "Pa")


@pytest.mark.parametrize("late", [0.1, 0.9])
def test_a_release_between_two_samples_bends_no_fit(late):
    """As a straight way down it made k2 of .6 Pa wrong by .06 and more."""
    test = released(late)
    assert test.loading.steps_between == [(50.0, 51.0, -1.0)]
    fit = identify(test, ZENER)
    assert fit.parts[0].over_floor < 1.1
    assert fit.parameters["k2"].value == pytest.approx(0.6, abs=0.006)


def test_a_release_between_two_samples_is_no_effect():
    """`finite-ramp` was named."""
    effects = [springpot.plugins().effect(name) for name in ("finite-ramp", "time-delay")]
    assert diagnose(released(0.2), ZENER, effects).verdict == "adequate"


def test_what_is_recorded_of_a_ramp_is_no_step():
    t = np.arange(60.0)
    for moved in (np.clip(t - 20.0, 0.0, 6.0), np.sin(0.3 * t), np.abs(t % 8.0 - 4.0)):
        test = springpot.TimeTest.of_history(
            t, moved, 2.0 * moved, "mm", "N", control="displacement"
        )
        assert part_of(test).unknowns.shape == (60, 0)
    # With a sample or two on the way both ends of it are unknown.
    short = np.clip((t - 20.3) / 1.8, 0.0, 1.0)
    test = springpot.TimeTest.of_history(t, short, 2.0 * short, "mm", "N", control="displacement")
    assert [before for before, _, _ in test.loading.steps_between] == [20.0, 21.0, 22.0]


@pytest.mark.parametrize("seed", [2, 5])
def test_noise_of_the_first_sample_is_no_earlier_motion(seed):
    """A fluid remembers where it was held: `parallel-spring` and `earlier-motion` were named."""
    draw = np.random.default_rng([5, seed])
    t, period = 0.1 * np.arange(180), 1.5 * draw.uniform(0.8, 1.2)
    fine = np.linspace(0.0, t[-1], 20 * (len(t) - 1) + 1)
    strain = 2.0 / np.pi * np.arcsin(np.sin(2.0 * np.pi * fine / period))
    tau, step = draw.uniform(0.8, 3.0), fine[1]
    left, gain = np.exp(-step / tau), -tau * np.expm1(-step / tau) / step
    grown = np.diff(strain) * gain
    stress = np.array([*accumulate(grown, lambda q, more: left * q + more, initial=0.0)])
    moved = strain[::20] + 0.008 * draw.normal(size=len(t))
    pulled = stress[::20] + 0.003 * draw.normal(size=len(t))
    test = springpot.TimeTest.of_history(t, moved, pulled, "mm", "N", control="displacement")
    effects = [springpot.plugins().effect(n) for n in ("earlier-motion", "parallel-spring")]
    assert diagnose(test, springpot.parse_model("maxwell"), effects).verdict == "adequate"
