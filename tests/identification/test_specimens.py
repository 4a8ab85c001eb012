"""Specimens that differ are no repeats.

Intervals of a joint fit follow the specimens, or say that they do not.
"""

from __future__ import annotations

import numpy as np
import pytest

import springpot
from springpot.identification import identify
from springpot.measurement import Measurement, joined

MODEL = springpot.parse_model("fractional-maxwell")
TRUTH = MODEL.theta(k=400.0, c=60.0, alpha=0.5)
OMEGA = np.geomspace(0.5, 200.0, 12)


def specimens(count, rng, differ=0.03, noise=0.005, temperatures=None):
    """Sweeps of specimens whose constants differ, in files of their own."""
    sweeps = []
    for i in range(count):
        own = TRUTH * np.exp(differ * rng.normal(size=3) * np.array([1.0, 1.0, 0.3]))
        exact = MODEL.stiffness(own, OMEGA)
        scatter = noise * (rng.normal(size=12) + 1j * rng.normal(size=12))
        conditions = {}
        if temperatures is not None:
            conditions["temperature"] = np.full(12, temperatures[i])
        sweeps.append(
            Measurement(OMEGA, exact * (1.0 + scatter), conditions=conditions, name=f"{i}.csv")
        )
    return joined(sweeps)


def coverage(count, cases, rng):
    """Share of 95 % intervals that hold the mean specimen."""
    held = []
    for _ in range(cases):
        fit = identify(specimens(count, rng), MODEL)
        held.append((fit.low <= TRUTH) & (fit.high >= TRUTH))
    return float(np.mean(held))


@pytest.mark.soak
@pytest.mark.parametrize("count", [3, 5, 10])
def test_intervals_hold_the_mean_specimen_as_often_as_they_say(count):
    # 180 intervals: two standard deviations of 95 % are 3.2 %.
    assert coverage(count, 60, np.random.default_rng(count)) > 0.91


@pytest.mark.soak_cases("profile-3", "profile-6", "bootstrap-6")
@pytest.mark.parametrize("count", [3, 6])
@pytest.mark.parametrize("kind", ["profile", "bootstrap"])
def test_every_kind_of_interval_follows_the_specimens(kind, count):
    ratios = []
    for seed in range(4):
        data = specimens(count, np.random.default_rng([count, seed]))
        known, other = identify(data, MODEL), identify(data, MODEL, intervals=kind)
        assert any("intervals follow the scatter" in note for note in other.notes)
        ratios.append((other.high - other.low) / (known.high - known.low))
    # Those of the points are two to eight times narrower.
    assert 0.7 < np.median(ratios) < 1.4


def test_specimens_that_differ_are_told_in_place_of_noise():
    fit = springpot.identify(specimens(5, np.random.default_rng(1)), "fractional-maxwell")
    assert any(
        "specimens differ by" in note and "follow the scatter of 5" in note for note in fit.notes
    )
    assert "nothing is left but noise" not in fit.standing.says
    assert "specimens differ by" in fit.standing.says


@pytest.mark.parametrize("points", [1, 4])
def test_files_that_share_no_frequency_are_parts_of_one_sweep(points):
    exact = MODEL.stiffness(TRUTH, OMEGA)
    noise = 0.005 * np.random.default_rng(2).normal(size=(2, 12))
    measured = exact * (1.0 + noise[0] + 1j * noise[1])
    parts = [
        Measurement(OMEGA[i : i + points], measured[i : i + points], name=f"{i}.csv")
        for i in range(0, 12, points)
    ]
    joint, whole = (identify(data, MODEL) for data in (joined(parts), Measurement(OMEGA, measured)))
    assert not any("specimens" in note for note in joint.notes)
    np.testing.assert_allclose(joint.high - joint.low, whole.high - whole.low, rtol=1e-6)


def test_of_two_specimens_it_is_said_that_intervals_are_too_narrow():
    fit = springpot.identify(specimens(2, np.random.default_rng(1)), "fractional-maxwell")
    assert any("too narrow; three or more specimens" in note for note in fit.notes)


def test_a_file_for_each_temperature_holds_no_specimens():
    data = specimens(3, np.random.default_rng(1), temperatures=[10.0, 20.0, 30.0])
    fit = identify(data, MODEL)
    assert not any("specimens" in note for note in fit.notes)


def test_files_of_one_specimen_are_not_said_to_differ():
    fit = identify(specimens(5, np.random.default_rng(2), differ=0.0), MODEL)
    assert not any("differ by" in note for note in fit.notes)
