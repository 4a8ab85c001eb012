"""Small rules of identification, by hand and at both sides of their edges."""

from __future__ import annotations

import numpy as np
import pytest

import springpot
from springpot.identification import fitting, kept, problem as derivative
from springpot.identification.leastsquares import Trial
from springpot.identification.material import FINE, SpectrumSearch
from springpot.identification.problem import relative_objective

OMEGA = np.geomspace(0.1, 10.0, 15)


@pytest.mark.parametrize(
    ("low", "high", "whole"),
    [([1.0, None], [2.0, None], True), ([1.0], [2.0, 3.0], False), ([1.0, 2.0], [3.0], False)],
)
def test_kept_intervals_are_as_many_as_the_parameters(low, high, whole):
    if not whole:
        with pytest.raises(ValueError, match="there are 2 parameters, and other intervals"):
            kept.ends_of({"low": low, "high": high}, 2)
        return
    ends = kept.ends_of({"low": low, "high": high}, 2)
    assert [end.tolist() for end in ends] == [[1.0, -np.inf], [2.0, np.inf]]


@pytest.mark.parametrize("start", [None, {}, {"k": 3.0}])
def test_values_to_start_at_reach_the_native_search(monkeypatch, start):
    asked = []

    def searched(model, measurement, objective, seeds, restarts, rng):
        asked.append([seed.tolist() for seed in seeds])
        return native(model, measurement, objective, seeds, restarts, rng)

    native = fitting.searched
    monkeypatch.setattr(fitting, "searched", searched)
    data = springpot.Measurement(OMEGA, 3.0 + 0.5j * OMEGA)
    springpot.identify(data, "kelvin", start=start)
    assert asked[0] == ([[3.0, pytest.approx(0.5)]] if start else [])


def test_a_derivative_is_checked_once_for_each_network(monkeypatch):
    asked = []
    monkeypatch.setattr(derivative, "_least_apart", lambda *given: asked.append(given) or 0.0)
    monkeypatch.setattr(derivative, "_checked", type(derivative._checked)())
    model, points = springpot.parse_model("kelvin"), springpot.Measurement(OMEGA, OMEGA + 1j).points
    for _ in range(2):
        derivative.require_derivative(model, np.array([2.0, 0.5]), points)
        assert len(asked) == 1


def test_a_line_is_tried_where_one_would_explain_most():
    """Of exact data of one Maxwell element: at its rate, whatever lines are there already."""
    rate = 1.37
    data = springpot.Measurement(OMEGA, 2.0 + 5.0 * 1j * OMEGA / (1j * OMEGA + rate))
    search = SpectrumSearch.of(springpot.parse_model("material"), data, relative_objective())
    lines = np.log(np.array([0.02, 40.0, 90.0]))
    weights = np.array([2.0, 0.0, 0.0, 0.0, 0.0])
    tops = search._promising(Trial(np.zeros(0), lines, weights, 1.0))
    tried = np.arange(np.log(0.02), np.log(90.0), FINE / 10)
    columns = 1j * OMEGA / (1j * OMEGA + np.exp(tried)[:, None]) / np.abs(data.stiffness)
    left = (data.stiffness - 2.0) / np.abs(data.stiffness)
    slopes = (columns @ left.conj()).real / np.sqrt((np.abs(columns) ** 2).sum(1))
    assert np.abs(tops - tried[np.argmax(slopes)]).min() < 0.2 * FINE
    assert np.abs(tops - np.log(rate)).min() < FINE


def test_where_no_lattice_can_stand_no_line_is_tried(monkeypatch):
    """A search ended in an IndexError there, of given lines at a setting too far for others."""
    data = springpot.Measurement(OMEGA, 2.0 + 0.5j * OMEGA)
    search = SpectrumSearch.of(springpot.parse_model("material"), data, relative_objective())
    monkeypatch.setattr(search, "lattice", lambda own: np.zeros(0))
    trial = Trial(np.zeros(0), np.zeros(1), np.array([2.0, 0.5, 0.1]), 1.0)
    assert len(search._promising(trial)) == 0
    assert search.nearest(trial).cost < 1e-9
