"""Very few points: nothing is missing of which they could not tell."""

import numpy as np
import pytest

import springpot


def noisy(stiffness, level, seed=5):
    """Noise as a complex factor, each of its parts of the size `level`."""
    storage, loss = np.random.default_rng(seed).normal(size=(2, len(stiffness)))
    return stiffness * (1.0 + level * (storage + 1j * loss))


def few(points, seed):
    """A Maxwell element, 1 % noise."""
    omega = np.geomspace(1.0, 100.0, points)
    stiffness = 400.0 * 20j * omega / (400.0 + 20j * omega)
    data = noisy(stiffness, 0.01, [points, seed])
    return springpot.Measurement(omega, data, units=springpot.Units("kN/m", "mm"))


@pytest.mark.soak_cases("3", "4", "5")
@pytest.mark.parametrize("points", [3, 4, 5])
def test_a_handful_of_points_is_never_missing_an_effect(points):
    for seed in range(3):
        for model in (None, "maxwell"):
            found = springpot.diagnose(few(points, seed), model)
            assert found.verdict != "effect-missing", (seed, model, found.says)


@pytest.mark.soak
def test_three_points_that_leave_nothing_are_judged_without_a_warning():
    """The draw leaves a residual of which nothing remains to be divided by."""
    assert springpot.diagnose(few(3, 142)).verdict in {"adequate", "inconclusive"}


@pytest.mark.soak
@pytest.mark.parametrize("points", [3, 4, 5])
def test_many_handfuls_of_points_are_hardly_ever_missing_an_effect(points):
    """Two in a hundred are granted, as to any data from which nothing is missing."""
    cases = [(seed, model) for seed in range(3, 103) for model in (None, "maxwell")]
    flagged = [
        case
        for case in cases
        if springpot.diagnose(few(points, case[0]), case[1]).verdict == "effect-missing"
    ]
    assert len(flagged) <= 0.02 * len(cases), flagged
