"""The contract of what a test in time did: laws of the library keep it, slips are told."""

import numpy as np
import pytest

from springpot.measurement.recording import recorded
from springpot.registry import plugins
from springpot.testing import effects
from springpot.testing.effects import THETA, _derivatives


@pytest.fixture(scope="module")
def made_up():
    return effects.tests_in_time()


def law(made_up):
    """An effect of the library that belongs to a stage of a test, and tests that can have it."""
    for effect in plugins().items("effect"):
        tests = [test for test in made_up if effect.applies_to(test)]
        if tests:
            return effect, tests[:1]
    raise AssertionError("there is no such effect")


def test_the_made_up_tests_hold_the_response_of_their_own_material(made_up):
    kinds = {test.name for test in made_up}
    assert len(kinds) == len(made_up) == 7
    for test in made_up:
        np.testing.assert_array_equal(test.response, recorded(effects.MODEL, THETA, test).value)


@pytest.mark.parametrize("wrong", [False, True])
def test_a_derivative_is_held_against_differences(made_up, monkeypatch, wrong):
    effect, tests = law(made_up)

    def spoilt(model, theta, test, **given):
        record = recorded(model, theta, test, **given)
        if not wrong:
            return record
        slopes = record.by_theta.copy()
        slopes[:, 1] *= 1.1
        return record._replace(by_theta=slopes)

    monkeypatch.setattr(effects, "recorded", spoilt)
    found = list(_derivatives(effect, tests))
    assert len(found) == wrong
    assert all("the derivative by k is wrong at" in says for says in found)
