"""Relaxations of a few decades at temperatures whose times lie many decades apart."""

from dataclasses import replace

import numpy as np
import pytest

import springpot
from springpot import TimeTest

TIME = np.geomspace(0.01, 10.0, 12)
CELSIUS = np.array([-20.0, -5.0, 10.0, 25.0, 40.0, 60.0])
TIMES = np.geomspace(1e-12, 1e12, 25)
"""Relaxation times in s at the reference temperature: one Maxwell element a decade."""


def log10_shift(celsius: float) -> float:
    """WLF with C1 = 15 and C2 = 60 K about 10 degC (Williams, Landel and Ferry 1955)."""
    return -15.0 * (celsius - 10.0) / (60.0 + celsius - 10.0)


def relaxations(noise: float, seed: int) -> list[TimeTest]:
    draw, tests = np.random.default_rng(seed), []
    for number, celsius in enumerate(CELSIUS):
        reduced = TIME / 10.0 ** log10_shift(float(celsius))
        modulus = 5.0 + 1000.0 / len(TIMES) * np.exp(-reduced[:, None] / TIMES).sum(axis=1)
        measured = modulus * (1.0 + noise * draw.normal(size=len(TIME)))
        tests.append(
            TimeTest.of_relaxation(
                TIME, measured, "MPa", temperature=float(celsius), name=f"specimen#{number + 1}"
            )
        )
    return tests


@pytest.mark.soak
def test_the_law_by_which_times_move_by_decades_is_what_is_missing():
    few = ["wlf-shift", "arrhenius-shift", "ageing", "force-drift"]
    answer = springpot.diagnose(relaxations(0.01, 1), only=few)
    assert answer.verdict == "effect-missing"
    assert answer.best.effect == "wlf-shift"
    assert answer.data == "specimen (6 tests)"


@pytest.mark.soak
def test_a_law_of_temperature_is_identified_from_any_material_alone():
    fit = springpot.identify(relaxations(0.001, 2), "material + wlf-shift")
    found = dict(zip(fit.model.names, fit.theta.tolist(), strict=True))
    reference = fit.reference - 273.15
    for celsius in CELSIUS:
        shift = -found["wlf-shift.C1"] * (celsius - reference)
        shift /= found["wlf-shift.C2"] + celsius - reference
        truth = log10_shift(float(celsius)) - log10_shift(reference)
        assert shift == pytest.approx(truth, abs=0.15)
    assert max(test.relative_rms for test in fit.tests) < 0.01


def test_tests_that_differ_more_than_each_is_missed_are_not_of_one_state():
    """None is followed by itself either: what no material does lies in each."""
    ripple = 1.0 + 0.2 * np.sin(9.0 * np.log(TIME))
    first, second = (
        TimeTest.of_relaxation(TIME, level * TIME**-0.2 * ripple, "MPa", name=name)
        for level, name in ((1.0, "specimen#1"), (10.0, "specimen#2"))
    )
    answer = springpot.diagnose([first, second], only=["inertia"])
    assert answer.verdict == "unexplained"
    assert "of the misfit goes where each test has a material of its own" in answer.says
    assert "of another temperature, age or specimen" in answer.says


@pytest.mark.soak
def test_tests_that_are_followed_one_by_one_alone_are_not_of_one_state():
    untold = [replace(test, temperature=None) for test in relaxations(0.01, 4)]
    answer = springpot.diagnose(untold)
    assert answer.verdict == "unexplained"
    assert "each test by itself is followed to" in answer.says
    assert "temperature=25[degC]" in answer.says


@pytest.mark.soak
@pytest.mark.parametrize("seed", [2, 5])
def test_the_truth_leaves_no_more_than_noise_and_nothing_is_missing_from_it(seed):
    few = ["vertical-shift", "inertia"]
    answer = springpot.diagnose(relaxations(0.01, seed), "material + wlf-shift", only=few)
    assert answer.verdict == "adequate"
    # Noise is 1 % of each sample, and told of a test over its root mean square.
    assert max(test.relative_rms for test in answer.tests) < 0.015
    assert max(test.over_floor for test in answer.tests) < 1.5
