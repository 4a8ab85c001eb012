"""A mass under a suddenly applied force rings: it is found from the frequency of its ring."""

from __future__ import annotations

import numpy as np
import pytest

from springpot.measurement import TimeTest
from springpot.registry import parse_model, plugins
from springpot.timetests import diagnose, identify, predicted

ZENER, MASS = parse_model("zener"), 0.003


@pytest.fixture(scope="module")
def creep(n=150):
    t = np.geomspace(0.01, 50.0, n)
    model = ZENER + "inertia"
    theta = model.theta(k1=5.0, k2=15.0, c=8.0, inertia__m=MASS)
    exact = predicted(model, theta, TimeTest.of_compliance(t, np.ones(n), "kPa")).value
    noise = 1e-3 * exact.max() * np.random.default_rng(1).normal(size=n)
    return TimeTest.of_compliance(t, exact + noise, "kPa")


def test_the_mass_is_identified(creep):
    fit = identify(creep, ZENER + "inertia")
    assert fit.theta[-1] == pytest.approx(MASS, rel=0.01)
    assert fit.parts[0].over_floor < 1.05


def test_a_light_mass_is_what_is_missing(creep):
    some = [plugins().effect(name) for name in ("inertia", "retardation-mode")]
    found = diagnose(creep, ZENER, some)
    assert (found.verdict, found.leading) == ("effect-missing", ("inertia",))
    assert found.candidates[0].over_floor < 1.05


@pytest.mark.soak
def test_beside_any_material_no_line_of_its_spectrum_is_off(creep):
    fit = identify(creep, parse_model("material + inertia"))
    assert fit.theta[-1] == pytest.approx(MASS, rel=0.01)
    assert fit.parts[0].over_floor < 1.05
