"""Noise of the displacement that was imposed: a model answers to it, and no effect is its cause."""

import numpy as np
import pytest

from springpot import parse_model
from springpot.measurement import Loading, TimeTest
from springpot.measurement.imposed import imposed_noise
from springpot.measurement.steady_start import gone_on
from springpot.misfit import coloured_noise
from springpot.numerics import DEVIATIONS
from springpot.registry import plugins
from springpot.timetests import compare, diagnose

TIME = 0.005 * np.arange(1000)
EFFECTS = ("inertia", "time-delay", "filter-mismatch")


def judged(noise, mass, seed=0, digit=0.0, rate=0.0):
    """A Zener element under a sine or a sweep, its displacement read with noise or to a digit."""
    rng = np.random.default_rng(seed)
    stroke = 2.0 * np.sin(3.0 * np.pi * TIME * (1.0 + rate * TIME))
    model = parse_model("zener + inertia")
    theta = model.theta(k1=0.1, k2=0.3, c=0.02, **{"inertia.m": mass})
    force = model.respond(theta, TIME, stroke) + 0.002 * rng.normal(size=len(TIME))
    read = stroke + noise * rng.normal(size=len(TIME))
    if digit:
        read = digit * np.round(read / digit)
    test = TimeTest(TIME, force, Loading(TIME, read), control="displacement", name="record")
    return diagnose([test], parse_model("zener"), [plugins().effect(name) for name in EFFECTS])


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(3))
def test_no_mass_is_found_in_it(seed):
    found = judged(0.004, 1e-9, seed)
    assert found.verdict == "adequate"
    assert found.leading == ()


@pytest.mark.soak
def test_nor_is_the_noise_read_from_what_a_mass_leaves_of_it():
    rng, t = np.random.default_rng(5), 0.01 * np.arange(600)
    stroke = 5.0 * np.sin(2.0 * np.pi * t) * np.minimum(1.0, 0.2 + t / 6.0)
    model = parse_model("prony-2")
    theta = model.theta(k0=19.0, k1=24.0, tau1=0.13, k2=9.0, tau2=0.9)
    force = model.respond(theta, t, stroke)
    force += 0.003 * np.sqrt(np.mean(force**2)) * rng.normal(size=600)
    read = stroke + 0.01 * rng.normal(size=600)
    found = diagnose(TimeTest.of_history(t, read, force, "mm", "kN"), model)
    assert found.verdict == "adequate"


@pytest.mark.soak
@pytest.mark.parametrize("seed", [103, 104, 106])
def test_nor_any_effect_in_the_loops_of_a_rig_at_one_frequency(seed):
    """Of two numbers a model with three parameters can miss nothing, whatever it answers to."""
    rng, t, turn = np.random.default_rng(seed), np.arange(1000) / 500.0, 10.0j * np.pi
    stiffness = 1.0 / (1.0 / 400.0 + 1.0 / (60.0 * turn**0.55)) + 6e-4 * turn**2
    force = 2.0 * abs(stiffness) * np.sin(abs(turn) * t + np.angle(stiffness))
    force += 0.003 * np.std(force) * rng.normal(size=len(t))
    read = 2.0 * np.sin(abs(turn) * t) + 0.002 * rng.normal(size=len(t))
    found = diagnose([TimeTest.of_history(t, read, force, "mm", "N")], "fractional-maxwell")
    assert found.leading == ()
    assert found.verdict != "effect-missing"


def test_nor_in_coarse_digits_of_the_displacement():
    assert "inertia" not in judged(0.0, 1e-9, digit=0.05).leading


@pytest.mark.soak
def test_a_mass_is_found_all_the_same():
    # Under a sweep: at one frequency a mass is no more than a softer spring.
    found = judged(0.001, 2.5e-4, rate=0.2)
    assert found.verdict == "effect-missing"
    assert "inertia" in found.leading


def test_a_dashpot_that_answers_to_it_is_no_worse_than_a_spring_that_does_not():
    """At one frequency both models are one stiffness: `compare` and `identify` say the same."""
    rng, t = np.random.default_rng(1), 0.005 * np.arange(1000)
    turn = 2.0 * np.pi * t
    force = 615.0 * np.sin(turn) + 298.0 * np.cos(turn) + 3.0 * rng.normal(size=1000)
    read = 5.0 * np.sin(turn) + 0.002 * rng.normal(size=1000)
    # As it was read: of a steady motion the noise would be taken off.
    loading = gone_on(Loading(t, read, sampled=True), force)
    test = TimeTest(t, force, loading, "displacement", "mm", "N", name="record")
    found = {one.model.name: one for one in compare([test], ["kelvin", "maxwell"]).judgements}
    assert not any(one.fails or one.unclear for one in found.values())
    assert all(one.error.over_floor < 1.15 for one in found.values())
    assert found["kelvin"].delta_bic < 6.0
    # The spring swallows what the dashpot passes on: its error is less, and its noise too.
    assert found["maxwell"].error.noise_floor < 0.8 * found["kelvin"].error.noise_floor


def test_corners_and_smooth_motion_are_no_noise():
    triangle = np.abs((TIME % 1.0) - 0.5)
    assert imposed_noise(triangle) < 1e-12
    assert imposed_noise(np.sin(0.3 * np.arange(1000))) < 1e-5
    # Of a channel too short for its differences nothing is known.
    assert imposed_noise(np.arange(8.0) ** 2) == 0.0
    assert imposed_noise(0.1 * np.random.default_rng(1).normal(size=3000)) == pytest.approx(
        0.1, rel=0.1
    )


def test_a_noise_that_drowns_is_none_and_a_heard_one_as_large_as_it_may_well_be(monkeypatch):
    at = np.linspace(0.0, 1.0, 400)
    monkeypatch.setattr(coloured_noise, "imposed_noise", lambda value: 0.3)

    def noise_with_imposed(sd, control="displacement", moved=0.0):
        loading = Loading(at + moved, at)
        test = TimeTest(at, at, loading, control=control)
        return coloured_noise.Imposed.of(test, 4.0, np.full(400, sd)).noise

    # A variance is known to the root of two by their number.
    most = 0.3 * np.sqrt(1.0 + DEVIATIONS * np.sqrt(2.0 / (coloured_noise.WORTH * 400)))
    least = coloured_noise.HEARD
    assert noise_with_imposed(0.99 * 1.2 / least) == pytest.approx(most)
    assert noise_with_imposed(1.01 * 1.2 / least) == 0.0
    assert noise_with_imposed(0.99 * 0.075 / least, "force") == pytest.approx(most)
    assert noise_with_imposed(1.01 * 0.075 / least, "force") == 0.0
    assert noise_with_imposed(0.1, moved=-1e-3) == 0.0
