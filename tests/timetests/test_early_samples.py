"""Samples from the time in which a step is still being made may be left out, and it is offered."""

import numpy as np

from springpot.constraints import excluded
from springpot.diagnosis.actions import of_data
from springpot.measurement import TimeTest
from springpot.registry import parse_model, plugins
from springpot.timetests import diagnose

TIME = np.geomspace(0.3, 3000.0, 60)
MODEL = parse_model("fractional-maxwell")
LIBRARY = [plugins().effect("inertia")]


def relaxation(early):
    """A gel whose stress was still rising in the first five samples, by this share."""
    stress = MODEL.relaxation(MODEL.theta(k=450.0, c=14000.0, alpha=0.35), TIME)
    stress *= 1.0 + 0.003 * np.random.default_rng(2).normal(size=len(TIME))
    stress[:5] *= 1.0 - early * np.array([1.0, 0.8, 0.6, 0.4, 0.2])
    return TimeTest.of_relaxation(TIME, stress, "Pa")


def test_a_beginning_that_is_missed_most_is_left_out_by_a_command_that_lowers_the_error():
    test = relaxation(0.03)
    found = diagnose(test, MODEL, LIBRARY)
    assert found.verdict == "unexplained"
    [step] = found.steps
    where = step.command.rpartition(" ")[2]
    assert step.command == f"springpot diagnose DATA --exclude {where}"
    later = diagnose(excluded([test], where), MODEL, LIBRARY)
    assert later.verdict == "adequate"
    assert later.steps == ()
    assert later.error.relative_rms < 0.5 * found.error.relative_rms


def test_commands_hold_the_data_and_the_model_as_the_user_called_them():
    found = diagnose(relaxation(0.03), MODEL, LIBRARY)
    [step] = of_data(found.steps, "my gel.csv", "--model", "kv")
    assert step.command.startswith("springpot diagnose 'my gel.csv' --model kv --exclude time=..")
