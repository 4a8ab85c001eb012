"""What a test in time did stands in the one model, and each test has the effects that are its."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import springpot
from springpot.errors import ModelError
from springpot.misfit.residuals_of_tests import parts_of_specimen
from springpot.rheology import Effect, on_response, parallel, spring
from springpot.timetests import diagnose, identify, recorded
from springpot.timetests.exponentials import quick_parts
from springpot.timetests.score import TimeScan

OMEGA = np.geomspace(0.1, 100.0, 25)
T = np.geomspace(0.01, 100.0, 60)
MODEL = springpot.parse_model("fractional-maxwell")
THETA = MODEL.theta(k=400.0, c=60.0, alpha=0.5)
DELAY = 2e-3


def sweep(name, expression="fractional-maxwell", theta=THETA):
    k = springpot.parse_model(expression).stiffness(theta, OMEGA)
    noise = 1.0 + 0.002 * np.random.default_rng(ord(name[0])).normal(size=(2, len(OMEGA)))
    measured = noise[0] * k.real + 1j * noise[1] * k.imag
    return springpot.Measurement(OMEGA, measured, units=springpot.Units("kPa"), name=name)


def relaxation():
    exact = MODEL.relaxation(THETA, T)
    noise = 1.0 + 0.002 * np.random.default_rng(5).normal(size=len(T))
    return springpot.TimeTest.of_relaxation(T, exact * noise, "kPa")


def test_no_law_of_a_test_changes_the_stiffness():
    grown = springpot.parse_model("fractional-maxwell + force-drift + finite-ramp")
    theta = np.append(THETA, [0.3, 0.1])
    assert grown.names[3:] == ("finite-ramp.rise", "force-drift.rate")
    assert np.array_equal(grown.stiffness(theta, OMEGA), MODEL.stiffness(THETA, OMEGA))
    slopes = grown.jacobian(theta, OMEGA)
    assert np.array_equal(slopes[:, :3], MODEL.jacobian(THETA, OMEGA))
    assert not slopes[:, 3:].any()


@pytest.mark.parametrize("effect", ["finite-ramp", "inertia:another.csv"])
def test_a_sweep_refuses_an_effect_of_other_tests(effect):
    model = f"fractional-maxwell + {effect}"
    for asked in (springpot.identify, springpot.diagnose):
        with pytest.raises(ModelError, match=f"pad: '{effect}', an effect of .*: leave it out"):
            asked(sweep("pad"), model)


@pytest.mark.soak
def test_a_delay_may_be_that_of_one_rig_of_three():
    expression = "fractional-maxwell + time-delay:b"
    late = sweep("b", "fractional-maxwell + time-delay", np.append(THETA, DELAY))
    model = springpot.parse_model(expression)
    fit = identify([sweep("a"), late, relaxation()], model)
    assert fit.parameters["time-delay:b.tau"].value == pytest.approx(DELAY, rel=0.02)
    assert max(test.over_floor for test in fit.tests) < 1.5
    own, places = model.had_by(sweep("a"))
    assert own.name == "fractional-maxwell"
    assert places == [0, 1, 2]


def test_the_scan_looks_at_each_test_with_its_own_effects():
    model = springpot.parse_model("fractional-maxwell + series-spring:a")
    tests = [sweep("a"), sweep("b"), relaxation()]
    fit = identify(tests, model, seeds=[np.append(THETA, 500.0)], thorough=False)
    scan = TimeScan(fit, quick_parts(parts_of_specimen(tests)))
    dashpot = springpot.plugins().effect("parallel-dashpot")
    [entry] = scan.entries([dashpot])["parallel-dashpot"]
    assert np.isfinite(entry.drop)
    # In a test that the spring is not in, a dashpot changes as much as without it.
    alone = replace(fit, model=springpot.parse_model("fractional-maxwell"), theta=fit.theta[:3])
    without = TimeScan(alone, quick_parts(parts_of_specimen(tests[2:])))
    [atom], [other] = scan._atoms(dashpot), without._atoms(dashpot)
    size = len(without.residual)
    np.testing.assert_allclose(atom.column[-size:], other.column, rtol=1e-3)


@pytest.mark.parametrize("changed", ["alpha", "ageing.mu", "finite-ramp.rise", "force-drift.rate"])
def test_many_places_asked_at_once_are_those_asked_one_by_one(changed):
    model = springpot.parse_model("fractional-maxwell + finite-ramp + ageing + force-drift")
    theta = np.append(THETA, [0.3, 0.4, 20.0, 0.1])
    [quick], place = quick_parts(parts_of_specimen([relaxation()])), model.names.index(changed)
    many = np.tile(theta, (3, 1))
    many[:, place] *= [0.9, 1.0, 1.1]
    for each, told in zip(many, quick.nearly(model, many, 293.0, [place]), strict=True):
        alone = quick.residual(model, each, 293.0)
        np.testing.assert_allclose(told.value, alone.value, rtol=1e-6)
        np.testing.assert_allclose(told.by_theta[:, place], alone.by_theta[:, place], rtol=1e-4)


def test_a_law_stands_at_a_stage_and_an_element_in_the_network():
    law = springpot.plugins().effect("force-drift").element
    for composition, element in ((on_response, spring()), (parallel, law)):
        with pytest.raises(ModelError, match="take a StageLaw"):
            Effect("wrong", composition, element, "neither here nor there")


def test_a_law_may_be_held():
    model = springpot.parse_model("fractional-maxwell + finite-ramp + force-drift")
    held = model.holding({"finite-ramp.rise": 0.3})
    test, theta = relaxation(), np.append(THETA, [0.3, 0.1])
    free = recorded(model, theta, test)
    fixed = recorded(held, np.delete(theta, 3), test)
    assert held.names[3:] == ("force-drift.rate",)
    assert np.array_equal(fixed.value, free.value)
    assert np.array_equal(fixed.by_theta, np.delete(free.by_theta, 3, axis=1))
    still = recorded(held.fixed_at(np.delete(theta, 3)), np.empty(0), test)
    assert np.allclose(still.value, free.value, rtol=1e-5)


def late():
    return sweep("b", "fractional-maxwell + time-delay", np.append(THETA, DELAY))


def yielding():
    yields = springpot.parse_model("fractional-maxwell + series-spring")
    blank = springpot.TimeTest.of_compliance(T, T, "kPa", name="b")
    exact = recorded(yields, np.append(THETA, 900.0), blank).value
    noise = 1.0 + 0.002 * np.random.default_rng(7).normal(size=len(T))
    return springpot.TimeTest.of_compliance(T, exact * noise, "kPa", name="b")


@pytest.mark.soak_cases("late-time-delay", "yielding-series-spring")
@pytest.mark.parametrize(("of", "effect"), [(late, "time-delay"), (yielding, "series-spring")])
def test_an_effect_of_one_rig_of_three_is_found_there(of, effect):
    effects = [springpot.plugins().effect(name) for name in (effect, "parallel-dashpot")]
    found = diagnose([sweep("a"), of(), relaxation()], MODEL, effects)
    assert found.verdict == "effect-missing"
    assert found.leading == (f"{effect}:b",)
