"""An effect of the rig of one test in time among several is found, and said of which test."""

import numpy as np
import pytest

from springpot import parse_model
from springpot.measurement import TimeTest
from springpot.misfit.residuals_of_tests import parts_of_specimen
from springpot.registry import plugins
from springpot.timetests import diagnose, identify
from springpot.timetests.exponentials import quick_parts
from springpot.timetests.score import TimeScan

TIME = np.geomspace(0.01, 100.0, 100)
MATERIAL = {"k": 400.0, "c": 60.0, "alpha": 0.5}


def shown(expression, kind, seed, **effect):
    """A relaxation or a creep test of a model, with noise, named by its kind."""
    model = parse_model(expression)
    theta = model.vector(
        MATERIAL | {f"{expression.split(' + ')[-1]}.{n}": effect[n] for n in effect}
    )
    exact = getattr(model, kind)(theta, TIME)
    record = exact + 0.005 * exact.max() * np.random.default_rng(seed).normal(size=len(TIME))
    make = TimeTest.of_relaxation if kind == "relaxation" else TimeTest.of_compliance
    return make(TIME, record, "kPa", name=kind)


@pytest.mark.soak
@pytest.mark.parametrize(
    ("name", "size"), [("inertia", {"m": 0.5}), ("series-spring", {"k": 1500.0})]
)
def test_what_the_rig_of_the_creep_test_has_is_said_of_it_alone(name, size):
    tests = [
        shown("fractional-maxwell", "relaxation", 2),
        shown(f"fractional-maxwell + {name}", "creep", 3, **size),
    ]
    library = [plugins().effect(each) for each in (name, "test-gain", "finite-ramp")]
    found = diagnose(tests, "fractional-maxwell", library)
    assert found.verdict == "effect-missing"
    assert f"{name}:creep" in found.leading


def test_what_gives_way_in_one_rig_changes_no_other_test():
    """At sizes to which no small step leads, too: K of the other test stays as it is."""
    tests = [shown("fractional-maxwell", kind, 4) for kind in ("relaxation", "creep")]
    base = identify(tests, parse_model("fractional-maxwell"))
    scan = TimeScan(base, quick_parts(parts_of_specimen(tests)))
    there = scan._atoms(plugins().effect("series-spring").of_one("creep"))
    first = len(scan.views[0].residual)
    for atom in there:
        np.testing.assert_array_equal(atom.column[:first], 0.0)
        assert np.linalg.norm(atom.column[first:]) > 0.0


@pytest.mark.parametrize("name", ["time-delay", "friction"])
def test_what_one_record_has_beside_its_specimen_changes_no_other_record(name):
    model, time = parse_model("zener"), np.linspace(0.0, 4.0, 120)
    theta, moved = model.theta(k1=5.0, k2=7.0, c=0.7), np.sin(4.0 * time)
    noise = 0.01 * np.random.default_rng(5).normal(size=(2, len(time)))
    force = model.respond(theta, time, moved) + noise
    tests = [
        TimeTest.of_history(time, moved, record, "mm", "N", name=own)
        for own, record in zip(("one", "other"), force, strict=True)
    ]
    base = identify(tests, model)
    scan = TimeScan(base, quick_parts(parts_of_specimen(tests)))
    first = len(scan.views[0].residual)
    for atom in scan._atoms(plugins().effect(name).of_one("other")):
        np.testing.assert_array_equal(atom.column[:first], 0.0)
        assert np.linalg.norm(atom.column[first:]) > 0.0


@pytest.mark.suite_cases("friction")
@pytest.mark.parametrize("name", ["time-delay", "friction"])
def test_what_a_record_has_is_found_beside_a_step_which_cannot_have_it(name):
    """A step has no answer to it: that is no reason not to ask the record."""
    model, time, rng = parse_model("zener"), np.linspace(0.0, 4.0, 120), np.random.default_rng(3)
    theta = model.theta(k1=5.0, k2=7.0, c=0.7)
    moved, after = np.sin(4.0 * time), np.geomspace(0.02, 20.0, 40)
    exact = model.respond(theta, time, moved)
    shaken = {
        "time-delay": np.interp(time - 0.02, time, exact),
        "friction": exact + 0.6 * np.sign(np.gradient(moved, time)),
    }
    record = shaken[name] + 0.02 * rng.normal(size=len(time))
    relaxed = model.relaxation(theta, after) * (1.0 + 0.005 * rng.normal(size=len(after)))
    tests = [
        TimeTest.of_history(time, moved, record, "mm", "N", name="record"),
        TimeTest.of_relaxation(after, relaxed, "N/mm", name="step"),
    ]
    found = diagnose(tests, model, [plugins().effect(name)])
    assert found.candidates[0].effect == f"{name}:record"
    assert found.verdict == "effect-missing"
