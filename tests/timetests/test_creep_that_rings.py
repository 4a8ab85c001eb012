"""A mass under a suddenly applied force rings: it is found from the frequency of its ring."""

from __future__ import annotations

import numpy as np
import pytest

from springpot.measurement import TimeTest
from springpot.misfit.residuals_of_tests import parts_of_specimen
from springpot.registry import parse_model, plugins
from springpot.timetests import diagnose, identify, predicted
from springpot.timetests.exponentials import quick_parts
from springpot.timetests.score import TimeScan

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


def let_go(friction, n=101):
    """A mass on a spring of 1 N/mm, let go at 5 mm, that dry friction slows down (Coulomb)."""
    t = 0.03 * (np.arange(n) - 4.5)
    halves = np.floor(np.maximum(t, 0.0) * 10.0 / np.pi)
    swing = (5.0 - (2.0 * halves + 1.0) * friction) * np.cos(10.0 * t)
    x = np.where(t < 0.0, 5.0, swing + (-1.0) ** halves * friction)
    noise = 0.002 * np.random.default_rng(2).normal(size=n)
    # Pushed out it was held back as well.
    load = np.where(t < 0.0, 5.0 + friction, 0.0)
    return TimeTest.of_history(t, x + noise, load, "mm", "N")


def test_what_slows_a_mass_down_that_was_let_go_is_foretold():
    """No sum of exponentials follows what swings: the exact answer tells what an effect changes."""
    test = let_go(0.1)
    model = parse_model("kelvin + inertia")
    near = model.theta(k=1.0, c=0.01, inertia__m=0.01)
    base = identify(test, model, seeds=[near], thorough=False)
    scan = TimeScan(base, quick_parts(parts_of_specimen([test])))
    (best,) = scan.entries([plugins().effect("friction")])["friction"]
    assert 0.02 < best.values[0] < 0.1
    assert best.drop > 0.09 * float(scan.residual @ scan.residual)


@pytest.mark.soak
def test_beside_any_material_no_line_of_its_spectrum_is_off(creep):
    fit = identify(creep, parse_model("material + inertia"))
    assert fit.theta[-1] == pytest.approx(MASS, rel=0.01)
    assert fit.parts[0].over_floor < 1.05
