"""What a problem is like: by hand on a valley of two axes."""

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.benchmark import traits
from springpot.benchmark.traits import Features, features_of, parts_of, uniform

OPTIMUM = np.array([1.25, 0.0])


def valley(slopes=(10.0, 0.5), sign=1.0):
    """Residuals whose slopes over a box of 1 x 2 are 10 and 1, falling towards the optimum."""
    width = np.array([1.0, 2.0])

    def evaluate(points):
        value = sign * np.linalg.norm((points - OPTIMUM) / width, axis=1)
        return np.where(points[:, 0] < 1.1, np.nan, value)

    return SimpleNamespace(
        dimension=2,
        lower=np.array([1.0, -1.0]),
        upper=np.array([2.0, 1.0]),
        residuals_and_jacobian=lambda x: (np.zeros(2), np.diag(slopes)),
        evaluate=evaluate,
    )


def test_a_valley_by_hand(monkeypatch):
    """Four of ten descents find it; of the wrong ones three end alike, but for a thousandth."""
    ends = np.array([0.0, 0.0, 1e-4, 5e-5, 1.0, 1.0005, 1.0009, 2.0, 3.0, 4.0])
    monkeypatch.setattr(traits, "descents", lambda problem, points: (points, ends))
    found = features_of(valley(), OPTIMUM, 0.0, 1e-4)
    assert found.parameters == 2
    assert found.conditioning == pytest.approx(1.0)
    # A rise of 1e-4 is a hundredth along the slope of 1, a thousandth along that of 10.
    assert found.smallness == pytest.approx(2.5)
    assert found.modality == pytest.approx(0.6)
    assert found.funnel == pytest.approx(1.0)
    assert found.lure == pytest.approx(0.3 - 0.4)
    assert features_of(valley(sign=-1.0), OPTIMUM, 0.0, 1e-4).funnel == pytest.approx(-1.0)
    # No region is larger than the box, and no valley longer than rounding shows.
    assert features_of(valley(), OPTIMUM, 0.0, 25.0).smallness == pytest.approx(0.5 * np.log10(2))
    flat = features_of(valley((10.0, 0.0)), OPTIMUM, 0.0, 1e-4)
    assert flat.conditioning == pytest.approx(-np.log10(np.finfo(float).eps))
    assert features_of(valley(), OPTIMUM, 0.0, 9.0).lure == -1.0


def test_points_fill_the_box_and_are_always_the_same():
    points = uniform(valley(), 1000)
    assert np.all(points.min(axis=0) < [1.01, -0.98])
    assert np.all(points.min(axis=0) >= [1.0, -1.0])
    assert np.all(points.max(axis=0) > [1.99, 0.98])
    assert np.all(points.max(axis=0) <= [2.0, 1.0])
    np.testing.assert_array_equal(points, uniform(valley(), 1000, 0))
    assert not np.any(points == uniform(valley(), 1000, 1))


def test_the_easier_half_is_easy_and_what_leads_astray_deceptive():
    def like(rank, funnel=0.5, lure=-0.5):
        return Features(rank, rank, rank, rank, funnel, lure)

    given = {
        "d": like(9, lure=0.1),
        "e": like(8, funnel=-0.1),
        "f": like(7),
        "g": like(6, funnel=0.0, lure=0.0),
        "a": like(1, lure=0.1),
        "b": like(2, funnel=-0.1),
        "c": like(3),
    }
    deceptive, hard, easy = "deceptive", "hard", "easy"
    assert parts_of(given) == {
        "d": deceptive, "e": deceptive, "f": hard, "g": hard, "a": easy, "b": easy, "c": easy
    }  # fmt: skip
    assert like(2).to_dict()["funnel"] == 0.5
