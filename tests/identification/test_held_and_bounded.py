"""Fits of models some of whose parameters are held, or end at a bound."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import springpot
from springpot import Measurement, parse_model
from springpot.identification import fit

OMEGA = np.geomspace(0.01, 100.0, 25)
NAMES = (
    "fractional-zener",
    "fractional-maxwell + inertia",
    "makris",
    "fractional-zener + time-delay",
)


def made(name, seed, share=0.01):
    """A model, some parameters of it, and data of it with noise."""
    rng = np.random.default_rng(seed)
    model = parse_model(name)
    middle = np.array([p.scale != "log" for p in model.parameters])
    theta = np.where(
        middle, rng.uniform(0.2, 0.8, len(middle)), 10.0 ** rng.uniform(-1.0, 1.0, len(middle))
    )
    exact = model.stiffness(theta, OMEGA)
    noise = rng.normal(size=(2, len(OMEGA))) * share * np.abs(exact)
    return model, theta, Measurement(OMEGA, exact + noise[0] + 1j * noise[1])


@pytest.mark.soak
@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.sampled_from(NAMES), st.integers(0, 10**6), st.data())
def test_a_search_at_its_optimum_has_come_to_rest(name, seed, data):
    """Of starts that end alike the one that stopped by itself is told, not one a rounding lower."""
    model, theta, measured = made(name, seed)
    some = st.sets(st.integers(0, len(theta) - 1), max_size=len(theta) - 1)
    held = data.draw(some)
    bounded = data.draw(some) - held
    known = model.holding(
        {model.names[i]: float(theta[i]) for i in held},
        {model.names[i]: (0.0, float(0.9 * theta[i])) for i in bounded},
    )
    assert fit(known, measured).converged


def test_a_model_of_which_nothing_is_left_but_an_effect_is_fitted():
    model, theta, measured = made("springpot + inertia", 4)
    found = springpot.identify(measured, model.holding({"c": theta[0], "alpha": theta[1]}, {}))
    assert found.theta == pytest.approx(theta[2:], rel=0.05)
