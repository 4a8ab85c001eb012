"""What an instrument that may be off does to a test and to an interval, by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.errors import OptionError
from springpot.identification import calibration, known_factors, starts
from springpot.measurement import Measurement
from springpot.rheology.parameters import Dimension, Parameter
from springpot.thresholds import SUPERPOSITION

SD = 0.3 / calibration.QUANTILE
"""A standard uncertainty that reaches 0.3 far."""


@pytest.mark.parametrize(
    ("scale", "value", "ends", "bounds", "found"),
    [
        ("linear", 2.0, (1.6, 2.4), (-9.0, 9.0), (1.5, 2.5)),
        ("linear", 2.0, (1.6, 2.4), (1.55, 2.45), (1.55, 2.45)),
        ("linear", 2.0, (1.4, 2.4), (1.45, 9.0), (1.4, 2.5)),
        ("log", 2.0, (2.0 * np.exp(-0.2), 2.0 * np.exp(0.36)), (0.0, np.inf), (-0.25, 0.39)),
        ("log", 2.0, (0.0, 2.0 * np.exp(0.36)), (0.0, np.inf), (-np.inf, 0.39)),
        ("log", -2.0, (-2.4, -1.6), (-9.0, 9.0), (-2.5, -1.5)),
    ],
)
def test_an_interval_widens_by_the_root_of_squares(scale, value, ends, bounds, found):
    """Of 0.4 and 0.3 a half; of a positive quantity in logarithms, where 0.3 of 2 is 0.15."""
    parameter = Parameter("k", "k", Dimension(), *bounds, scale)
    if scale == "log" and value > 0.0:
        found = tuple(value * np.exp(found))
    widened = calibration._widened(parameter, value, *ends, SD)
    assert widened == pytest.approx(found)


def test_a_gain_or_a_phase_is_off_in_what_was_measured():
    data = Measurement(np.array([1.0]), np.array([3.0 + 4.0j]))
    assert calibration._off(data, "gain", 0.1).stiffness == pytest.approx([3.3 + 4.4j])
    turned = calibration._off(data, "phase", 0.1).stiffness
    assert np.abs(turned) == pytest.approx([5.0])
    assert np.angle(turned / data.stiffness) == pytest.approx([0.1])
    with pytest.raises(OptionError, match="an accuracy is of stiffness, not of a spectrum"):
        calibration._off(SimpleNamespace(name="made", kind="a spectrum"), "gain", 0.1)


@pytest.mark.parametrize(
    ("control", "term", "factor"),
    [
        ("displacement", "gain", 1.25),
        ("force", "gain", 0.8),
        ("displacement", "phase", 1.0),
        ("force", "phase", 1.0),
    ],
)
def test_what_answers_to_a_force_is_stiffer_as_it_moves_less(monkeypatch, control, term, factor):
    class Test(SimpleNamespace):
        """A test in time."""

    monkeypatch.setattr(calibration, "TimeTest", Test)
    monkeypatch.setattr(calibration, "replace", lambda test, response: response)
    test = Test(control=control, response=np.array([2.0, 4.0]))
    np.testing.assert_allclose(calibration._off(test, term, 0.25), factor * test.response)


def test_values_are_level_where_no_slope_is_seen_and_none_could_be_large():
    x = np.linspace(-1.0, 1.0, 21)
    rough = np.cos(np.pi * np.arange(21)) * (1.0 - x**2)
    rough -= x * (x @ rough) / (x @ x)
    small = 1e-4 * SUPERPOSITION.flat
    assert known_factors._is_level(x, 5.0 + small * rough)
    assert not known_factors._is_level(x, 5.0 + small * rough + 9.0 * SUPERPOSITION.flat * x)
    # So scattered, it may as well have a slope.
    assert not known_factors._is_level(x, 5.0 + 9.0 * SUPERPOSITION.flat * rough)
    # A slope that is seen is one, however small.
    assert not known_factors._is_level(x, 5.0 + small * rough + 10.0 * small * x)


def test_the_nearest_shapes_are_told_on_a_torus(monkeypatch):
    """Of evenly spread ones the neighbours, over the edge too."""
    count = starts.NEIGHBOURS + 5
    monkeypatch.setattr(starts, "low_discrepancy", lambda n, dimension: (np.arange(n) / n)[:, None])
    found = starts._nearest(count, 1)
    assert found.shape == (count, starts.NEIGHBOURS)
    for i, near in enumerate(found.tolist()):
        steps = sorted(min((j - i) % count, (i - j) % count) for j in near)
        assert steps == [1 + k // 2 for k in range(starts.NEIGHBOURS)]
    assert starts._nearest(starts.NEIGHBOURS, 1).shape == (starts.NEIGHBOURS, 0)
    assert starts._nearest(count, 0).shape == (count, 0)
