"""Samples from the time in which a step is still being made may be left out, and it is offered."""

import numpy as np
import pytest

from springpot.constraints import excluded
from springpot.diagnosis.result import of_data
from springpot.measurement import TimeTest
from springpot.registry import parse_model, plugins
from springpot.timetests import diagnose

TIME = np.geomspace(0.3, 3000.0, 60)
MODEL = parse_model("fractional-maxwell")
THETA = MODEL.theta(k=450.0, c=14000.0, alpha=0.35)
LIBRARY = [plugins().effect("inertia")]


def relaxation(early):
    """A gel whose stress was still rising in the first five samples, by this share."""
    stress = MODEL.relaxation(THETA, TIME)
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


@pytest.mark.suite_cases("False-0.05", "True-0.02")
@pytest.mark.parametrize("early", [0.02, 0.05, 0.1, 0.2, 0.3])
@pytest.mark.parametrize("at_the_end", [False, True])
def test_an_error_well_above_the_noise_is_never_nothing_missing(early, at_the_end):
    test = relaxation(early)
    if at_the_end:
        missed = test.response[4::-1] / MODEL.relaxation(THETA, TIME[4::-1])
        whole = relaxation(0.0).response
        test = TimeTest.of_relaxation(TIME, np.append(whole[:-5], whole[-5:] * missed), "Pa")
    found = diagnose(test, MODEL, LIBRARY)
    assert found.error.over_floor > 1.2
    assert found.verdict == "unexplained"
