"""What was done in one test alone: a slow step, another temperature, a zero that was off.

Also how the specimen came to where it was held, which a record that begins there does not tell.
"""

from __future__ import annotations

import numpy as np
import pytest

from springpot.identification.value import PartResult
from springpot.measurement import Measurement, TimeTest
from springpot.registry import parse_model, plugins
from springpot.timetests import diagnose
from springpot.timetests.specimen import at_tests
from springpot.timetests.verdict import said_apart

NOISE = 0.005
OMEGA = np.geomspace(0.1, 100.0, 25)
TIME = np.geomspace(0.01, 100.0, 50)
ZENER = {"k1": 400.0, "k2": 300.0, "c": 60.0}
TAU = ZENER["c"] / ZENER["k2"]
MODEL = parse_model("zener")
THETA = MODEL.vector(ZENER)
SOME = (*("test-gain", "test-shift", "time-delay", "finite-ramp", "sudden-step", "force-offset"),)


def library():
    """A few effects, so that a diagnosis is short."""
    return [plugins().effect(name) for name in SOME]


def noisy(exact, seed):
    """Values with noise in proportion to them."""
    return exact * (1.0 + NOISE * np.random.default_rng(seed).normal(size=len(exact)))


def swept():
    """A sweep of the specimen."""
    rng = np.random.default_rng(9)
    noise = 1.0 + NOISE * (rng.normal(size=25) + 1j * rng.normal(size=25))
    return Measurement(OMEGA, MODEL.stiffness(THETA, OMEGA) * noise, name="sweep")


def crept(pace=1.0):
    """A creep test, sooner by a factor."""
    return TimeTest.of_compliance(TIME, noisy(MODEL.creep(THETA, pace * TIME), 2), name="creep")


def relaxed(modulus):
    """A relaxation as it was written."""
    return TimeTest.of_relaxation(TIME, noisy(modulus, 3), name="relax")


def ramped(rise):
    """The modulus after a ramp, as if it had been a step: the mean over when its parts came."""

    def gathered(time):
        time = np.maximum(time, 0.0)
        return ZENER["k1"] * time + ZENER["c"] * (1.0 - np.exp(-time / TAU))

    return (gathered(TIME) - gathered(TIME - rise)) / rise


def found(*tests):
    """What is missing of a zener."""
    return diagnose(list(tests), MODEL, library())


@pytest.mark.soak
def test_a_slow_step_is_said_of_the_test_that_had_it():
    diagnosis = found(relaxed(ramped(0.1)), crept())
    assert (diagnosis.verdict, diagnosis.leading) == ("effect-missing", ("finite-ramp:relax",))


@pytest.mark.soak
def test_a_test_at_another_temperature_is_named_with_its_shift():
    diagnosis = found(relaxed(MODEL.relaxation(THETA, TIME)), crept(np.exp(0.9)), swept())
    assert (diagnosis.verdict, diagnosis.leading) == ("effect-missing", ("test-shift:creep",))
    assert diagnosis.best.parameters["s"].value == pytest.approx(-0.9, abs=0.05)


@pytest.mark.soak
def test_a_zero_that_is_off_in_a_step_is_seen_beside_a_sweep():
    diagnosis = found(relaxed(MODEL.relaxation(THETA, TIME) + 150.0), swept())
    assert diagnosis.verdict == "effect-missing"
    assert "force-offset" in diagnosis.leading


def test_a_step_by_itself_asks_for_no_zero():
    step, offset = relaxed(ramped(0.1)), plugins().effect("force-offset")
    assert (at_tests(offset, [step]), at_tests(offset, [step, swept()])) == ([], [offset])


@pytest.mark.soak
def test_a_step_that_was_over_before_the_first_sample_is_no_delay_of_the_sweep():
    time = np.geomspace(0.08, 100.0, 50)
    force = noisy(MODEL.relaxation(THETA, time), 3)
    step = TimeTest.of_history(time, np.ones(50), force, "-", "Pa", name="relax")
    diagnosis = found(step, swept())
    assert (diagnosis.verdict, diagnosis.leading) == ("effect-missing", ("sudden-step",))
    assert "ramp=0[s]" in diagnosis.best.says


def test_what_an_effect_takes_away_is_not_told_as_another_specimen():
    def row(over_floor):
        return PartResult("creep", "creep", 50, 0.01 * over_floor, 0.01, over_floor, 4.0)

    assert "60%" in said_apart([], [row(6.32)], [row(5.0)])
    assert not said_apart([], [row(6.32)], [row(1.1)])
