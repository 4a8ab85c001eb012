"""The modes of springs and dashpots are the network, also where it is shifted."""

import numpy as np
import pytest

from springpot.registry import parse_model
from springpot.rheology import Points
from springpot.rheology.nodes import GRADIENT
from springpot.rheology.rational import rational_of

OMEGA = np.geomspace(0.1, 100.0, 12)


def points(celsius):
    return Points.at(OMEGA, temperature=np.full(12, celsius), reference=20.0)


EFFECTS = [
    "gain-error",
    "arrhenius-shift",
    "arrhenius-dashpot",
    "rig-drag",
    "entropic-spring",
]


@pytest.mark.parametrize("effect", EFFECTS)
def test_what_shifts_or_multiplies_all_frequencies_alike_keeps_the_modes(effect):
    model = parse_model(f"zener + {effect}")
    size = {"k1": 40.0, "k2": 30.0, "c": 6.0, "gain-error.g": 0.1, "arrhenius-shift.Ea": 8e4}
    size |= {"arrhenius-dashpot.Ea": 5e4, "rig-drag.c": 3.0}
    theta = np.array([size.get(name, 1.0) for name in model.names])
    at = points(35.0)
    found = rational_of(model.network, theta, np.eye(len(theta)), at)
    s = 1j * OMEGA
    rates, weights, rate_slopes, weight_slopes = found.lines
    modes = weights[:, None] * s / (s + rates[:, None])
    whole = found.ends[0] + found.ends[1] * s + modes.sum(axis=0)
    np.testing.assert_allclose(whole, model.stiffness(theta, at), rtol=1e-9)
    by_rate = -weights[:, None] * s / (s + rates[:, None]) ** 2
    slopes = found.end_slopes[0][:, None] + found.end_slopes[1][:, None] * s
    slopes = slopes + weight_slopes.T @ (s / (s + rates[:, None]))
    slopes = slopes + rate_slopes.T @ by_rate
    exact = model.network.respond(theta, at, GRADIENT).by_theta
    np.testing.assert_allclose(slopes, exact, rtol=1e-9, atol=1e-12 * np.abs(exact).max())


def test_a_delay_is_not_alike_at_all_frequencies_and_leaves_no_modes():
    model = parse_model("zener + time-delay")
    theta = np.array([40.0, 30.0, 6.0, 1e-3])
    assert rational_of(model.network, theta, np.eye(4), points(20.0)) is None
