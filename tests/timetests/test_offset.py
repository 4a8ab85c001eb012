"""A loop that stands off zero.

A gas charge, a weight or the zero of the transducer, and not a fixture that warms.
"""

import numpy as np
import pytest

from springpot.measurement import TimeTest
from springpot.registry import plugins
from springpot.timetests import diagnose
from springpot.timetests.specimen import at_tests

TIME = np.arange(600) / 200.0
OTHERS = ("force-drift", "displacement-drift", "thermal-force", "thermal-growth")


def dampers(constant, control="displacement", middle=0.0, seed=1):
    """Three cycles of a damper with a spring, begun midway; force in N, displacement in mm."""
    moved = 20.0 * np.cos(2.0 * np.pi * TIME)
    speed = -40.0 * np.pi * np.sin(2.0 * np.pi * TIME)
    force = constant + 0.3 * moved + 0.15 * speed
    noise = np.random.default_rng(seed).normal(0.0, 1.0, len(TIME))
    if control == "displacement":
        return TimeTest.of_history(TIME, moved + middle, force + 0.3 * noise, "mm", "N")
    return TimeTest.of_history(
        TIME, moved + middle + 0.1 * noise, force, "mm", "N", control="force"
    )


def tried(*names):
    return [plugins().effect(name) for name in names]


@pytest.mark.suite_cases("30.0")
@pytest.mark.parametrize("constant", [30.0, -4.0])
def test_a_constant_force_is_named_with_its_size(constant):
    found = diagnose(dampers(constant), "kelvin", tried("force-offset", *OTHERS))
    assert found.leading[0] == "force-offset"
    assert found.best.parameters["size"].value == pytest.approx(constant, abs=0.2)


@pytest.mark.soak
def test_a_stroke_counted_from_its_end_is_one_too():
    found = diagnose(dampers(0.0, middle=20.0), "kelvin", tried("force-offset", *OTHERS))
    assert found.leading[0] == "force-offset"
    assert found.best.parameters["size"].value == pytest.approx(-0.3 * 20.0, abs=0.2)


def test_a_loop_about_zero_has_none():
    found = diagnose(dampers(0.0), "kelvin", tried("force-offset", *OTHERS))
    assert found.leading == ()


def test_a_step_that_is_held_cannot_show_one():
    """It is the stiffness that stays."""
    step = TimeTest.of_relaxation(TIME[1:], 3.0 + np.exp(-TIME[1:]), "kPa")
    (effect,) = tried("force-offset")
    assert at_tests(effect, [step]) == []
    assert at_tests(effect, [dampers(1.0)]) == [effect]


def test_a_blow_that_is_over_shows_one():
    """When the specimen is back the constant is still there, and a spring's force is not."""
    moved = 9.0 * np.sin(np.pi * np.minimum(2.0 * TIME[:200], 1.0)) ** 2
    for control, other in (("displacement", "force"), ("force", "displacement")):
        test = TimeTest.of_history(TIME[:200], moved, moved, "mm", "N", control=control)
        assert test.kind == "recovery"
        (effect,) = tried(f"{other}-offset")
        assert at_tests(effect, [test]) == [effect]


@pytest.mark.soak
def test_of_a_force_that_was_imposed_the_displacement_has_it():
    """A spring and a dashpot side by side that swing about a place that is not zero."""
    found = diagnose(
        dampers(0.0, "force", middle=5.0), "kelvin", tried("displacement-offset", *OTHERS)
    )
    assert found.leading[0] == "displacement-offset"


@pytest.mark.soak
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_no_fixture_warms_within_some_samples(seed):
    """A preload that a filter lets through within three samples is no quick warming."""
    test = dampers(-4.0, seed=seed)
    late = test.response + 4.0 * np.exp(-TIME / 0.015)
    started = TimeTest.of_history(TIME, 20.0 * np.cos(2.0 * np.pi * TIME), late, "mm", "N")
    found = diagnose(started, "kelvin", tried("force-offset", *OTHERS))
    assert found.leading[0] == "force-offset"
    rows = {row.effect: row for row in found.candidates}
    assert rows["thermal-force"].delta_bic < rows["force-offset"].delta_bic - 10.0


def held(rise):
    """A spring and dashpot stretched within `rise` seconds and held; a force of 5 N before."""
    moved = 20.0 * np.minimum(TIME / rise, 1.0)
    force = 5.0 + 0.3 * moved + 3.0 * (rise > TIME)
    noise = np.random.default_rng(2).normal(0.0, 0.1, len(TIME))
    return TimeTest.of_history(TIME, moved, force + noise, "mm", "N")


@pytest.mark.parametrize(("rise", "offered"), [(0.1, 1), (TIME[1], 0)])
def test_a_rise_that_was_recorded_tells_a_constant_from_a_spring(rise, offered):
    test = held(rise)
    assert test.kind == "relaxation"
    assert len(at_tests(plugins().effect("force-offset"), [test])) == offered


def test_a_start_up_tells_a_constant_from_a_spring_too():
    """At a steady rate a spring's force grows: the zero of the transducer is no part of it."""
    time = np.arange(60) / 10.0
    force = 4.0 + 0.3 * 5.0 * time + 20.0 * (1.0 - np.exp(-time))
    noise = np.random.default_rng(1).normal(0.0, 0.05, len(time))
    pulled = TimeTest.of_history(time, 5.0 * time, force + noise, "mm", "N")
    assert pulled.kind == "startup"
    found = diagnose(pulled, "zener", tried("force-offset", "force-drift"))
    assert found.leading[0] == "force-offset"
    assert found.best.parameters["size"].value == pytest.approx(4.0, abs=0.2)


@pytest.mark.parametrize(("cycles", "offered"), [(1, 0), (2, 1)])
@pytest.mark.parametrize(
    ("effect", "control"), [("thermal-force", "displacement"), ("thermal-growth", "force")]
)
def test_warming_is_told_from_a_first_loading_by_the_next_one(cycles, offered, effect, control):
    """What softens in the first loading leaves another force behind, as a fixture that warms."""
    time = np.arange(120 * cycles + 1) / 10.0
    moved = 5.0 * np.abs((time / 6.0 + 1.0) % 2.0 - 1.0)
    force = 2.0 * moved + 0.1 * moved**2
    test = TimeTest.of_history(time, moved, force, "mm", "N", control=control)
    assert test.kind == "history"
    assert len(at_tests(plugins().effect(effect), [test])) == offered


@pytest.mark.parametrize(("rise", "offered"), [(10.0, 1), (30.0, 0)])
def test_warming_is_told_from_a_slow_first_loading_by_a_long_hold(rise, offered):
    """While it is held time goes on, and the way does not."""
    time = np.arange(400) / 10.0
    moved = np.minimum(time / rise, 1.0)
    moved[-8:] = np.linspace(0.9, 0.2, 8)
    force = 2.0 * moved + 0.1 * moved**2
    test = TimeTest.of_history(time, moved, force, "mm", "N", control="displacement")
    assert test.kind == "history"
    assert len(at_tests(plugins().effect("thermal-force"), [test])) == offered
