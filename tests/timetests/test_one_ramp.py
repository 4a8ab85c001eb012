"""A motion one way passes each place once: a stop and a stiffer specimen are the same to it."""

import numpy as np
import pytest

from springpot.measurement import Loading, TimeTest
from springpot.registry import parse_model, plugins
from springpot.timetests import diagnose

TIME = np.geomspace(0.2, 40.0, 60)
LIBRARY = [plugins().effect(name) for name in ("dead-zone", "cubic-stiffness", "inertia")]


def pulled(rate):
    """A melt that hardens from a strain of two on, as a branched one does when it is stretched."""
    strain = rate * TIME
    stress = 50.0 * rate * (1.0 - np.exp(-TIME / 5.0)) + 8.0 * np.maximum(strain - 2.0, 0.0)
    stress += 0.005 * stress.max() * np.random.default_rng(3).normal(size=len(TIME))
    ramp = Loading(np.array([0.0, TIME[-1]]), np.array([0.0, strain[-1]]))
    return TimeTest(TIME, stress, ramp, force_unit="kPa")


@pytest.mark.soak
def test_a_stop_in_one_ramp_may_be_a_specimen_that_is_not_linear():
    found = diagnose(pulled(0.1), parse_model("maxwell"), LIBRARY)
    assert found.leading == ("dead-zone",)
    assert "or a specimen that is not linear (cubic-stiffness: " in found.says
    assert "move at another rate, or back" in found.says


@pytest.mark.parametrize(
    ("moved", "one_way"),
    [
        ([0.0, 1.0, 2.0, 2.0, 2.0], True),
        ([-25.0, -12.0, -5.0, -5.0003, -5.0001], True),
        ([0.0, 1.0, 2.0, 1.0, 0.0], False),
        ([0.0, 1.0, 0.0, -1.0, -2.0], False),
    ],
)
def test_what_is_held_behind_a_ramp_passed_each_place_once_too(moved, one_way):
    """What a rig gives way by while it holds is no way back."""
    assert Loading(np.arange(5.0), np.array(moved)).goes_one_way is one_way
