"""A part that yields gradually, at any rate alike, in a record: no flow, and no dry friction."""

from __future__ import annotations

import numpy as np
import pytest

import springpot
from springpot import TimeTest
from springpot.registry import plugins
from springpot.timetests import diagnose

NAMES = ("friction", "elasto-sliding", "yielding", "smooth-hysteresis", "power-law-damper")


@pytest.mark.soak
def test_smooth_hysteresis_is_named():
    model = springpot.parse_model("zener + smooth-hysteresis")
    t = np.linspace(0.0, 6.0, 361)
    x = (1.0 + np.floor(0.5 * t)) * np.sin(2.0 * np.pi * t)
    theta = np.array([1.0, 2.0, 0.3, 1.5, 0.8, 1.0, 0.5])
    noise = 0.02 * np.random.default_rng(1).normal(size=len(t))
    force = model.respond(theta, t, x) + noise
    test = TimeTest.of_history(t, x, force, "mm", "N", control="displacement")
    found = diagnose(test, "zener", [plugins().effect(name) for name in NAMES])
    assert (found.verdict, found.leading) == ("effect-missing", ("smooth-hysteresis",))
    sizes = found.best.parameters
    assert sizes["k"].low < 1.5 < sizes["k"].high
    assert sizes["F"].low < 0.8 < sizes["F"].high
