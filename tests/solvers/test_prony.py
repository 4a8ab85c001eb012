"""Prony series of few terms.

Within the tolerance, never negative, as few as published, exact where they can be.
"""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from springpot.errors import ModelError
from springpot.registry import parse_model
from springpot.solvers import prony, prony_of


def spectrum_of(name: str, theta: list[float], decades: float = 2.0):
    return parse_model(name).spectrum(theta, (1.0, 10.0**decades))


@pytest.mark.soak_cases(
    "springpot-theta0-0.005",
    "huet-sayegh-theta2-0.005",
    "huet-sayegh-theta2-0.0005",
    "fractional-zener-theta1-0.0005",
    "springpot-theta0-0.0005",
)
@pytest.mark.parametrize("tolerance", [0.05, 0.005, 0.0005])
@pytest.mark.parametrize(
    ("name", "theta"),
    [
        ("springpot", [2.0, 0.4]),
        ("fractional-zener", [1.0, 20.0, 3.0, 0.6]),
        ("huet-sayegh", [1.0, 50.0, 2.0, 0.1, 0.3, 0.7]),
    ],
)
def test_the_tolerance_holds_against_the_model_itself(
    name: str, theta: list[float], tolerance: float
):
    found = prony_of(spectrum_of(name, theta), tolerance=tolerance)
    omega = np.geomspace(1.0, 100.0, 301)
    exact = parse_model(name).stiffness(theta, omega)
    off = np.max(np.abs(found.stiffness(omega) / exact - 1))
    assert off < 1.02 * tolerance + 1e-6
    assert found.error == pytest.approx(off, rel=0.05)
    assert np.all(found.weights > 0)
    assert found.equilibrium >= 0
    assert np.all(np.diff(found.times) > 0)


@pytest.mark.soak_cases("0.4", "0.6", "0.8")
@pytest.mark.parametrize("alpha", [0.2, 0.4, 0.6, 0.8])
def test_two_terms_a_decade_hold_half_a_percent(alpha: float):
    assert prony_of(spectrum_of("springpot", [1.0, alpha], 4.0), terms=8).error < 0.005
    assert len(prony_of(spectrum_of("springpot", [1.0, alpha], 2.0)).times) <= 5


@pytest.mark.soak
@given(st.floats(0.05, 0.95))
@settings(max_examples=10, deadline=None)
def test_a_dashpot_beside_never_harms(alpha: float):
    spectrum = spectrum_of("springpot", [1.0, alpha])
    with_one = prony_of(spectrum, terms=3, dashpot=True).error
    assert with_one < 1.1 * prony_of(spectrum, terms=3).error


def test_more_terms_are_better():
    spectrum = spectrum_of("fractional-maxwell", [400.0, 60.0, 0.55])
    errors = [prony_of(spectrum, terms=n).error for n in (1, 2, 3, 4, 5, 6)]
    assert all(later < 0.5 * sooner for sooner, later in pairwise(errors))


def test_classical_models_are_their_own_series():
    found = prony_of(spectrum_of("zener", [1.0, 2.0, 3.0]))
    assert found.equilibrium == pytest.approx(1.0, rel=1e-12)
    assert found.weights == pytest.approx(np.array([2.0]), rel=1e-12)
    assert found.times == pytest.approx(np.array([1.5]), rel=1e-12)
    assert found.error < 1e-12
    kelvin = prony_of(spectrum_of("kelvin", [1.0, 2.0]), dashpot=True)
    assert (kelvin.equilibrium, kelvin.viscosity, len(kelvin.times)) == (1.0, 2.0, 0)


def test_terms_that_win_nothing_are_given_up_unless_more_of_them_are_exact(monkeypatch):
    asked = []

    def fitted(grid, target, count, dashpot, band):
        asked.append(count)
        return SimpleNamespace(error=0.1)

    monkeypatch.setattr(prony, "_fitted", fitted)
    times = [part for i in range(9) for part in (1.0, 2.0**i)]
    exact = spectrum_of("prony-9", [1.0, *times])
    assert len(prony_of(exact, tolerance=0.01).times) == 9
    assert asked == list(range(1, 9))
    asked.clear()
    with pytest.raises(ModelError, match="10 %"):
        prony_of(spectrum_of("springpot", [1.0, 0.5]), tolerance=0.01)
    assert asked == list(range(1, 2 + prony.IN_VAIN))


def test_a_solver_carries_no_term_without_weight():
    """Of a dashpot that may not stand beside them only the shortest term takes a share."""
    found = prony_of(spectrum_of("kelvin", [1.0, 2.0]), terms=3)
    assert len(found.times) == len(found.weights) == 1
    assert found.weights > 0.0


def test_a_dashpot_that_may_not_stand_is_refused_with_what_helps():
    with pytest.raises(
        ModelError, match=r"follow its dashpot no nearer than 0\.\d+ %: .*\(--dashpot\)"
    ) as told:
        prony_of(spectrum_of("kelvin", [1.0, 2.0]))
    assert "\n" not in str(told.value)
    assert prony_of(spectrum_of("kelvin", [1.0, 2.0]), tolerance=0.02).error < 0.02


@pytest.mark.parametrize(
    "options", [{"terms": 0}, {"terms": 61}, {"tolerance": 0.0}, {"tolerance": 2.0}]
)
def test_nonsense_is_refused(options: dict[str, float]):
    with pytest.raises(ModelError):
        prony_of(spectrum_of("springpot", [1.0, 0.5]), **options)
