"""A ladder goes on from the rungs that are there, the same as one climbed from the ground."""

import json

import pytest

import springpot

MODEL = "fractional-maxwell"
FEW = ["inertia", "time-delay"]
IN_TIME = ["parallel-springpot", "force-drift"]


@pytest.mark.soak
def test_a_ladder_of_a_sweep_goes_on_to_the_bit():
    data = springpot.read("artificial-hidden")
    whole = springpot.discover(data, MODEL, accept=["inertia"], only=FEW)
    first = springpot.discover(data, MODEL, accept=[], only=FEW)
    second = springpot.discover(data, MODEL, accept=["inertia"], begun=first, only=FEW)
    assert json.dumps(second.to_dict()) == json.dumps(whole.to_dict())
    assert second.steps[0] is first.steps[0]


@pytest.mark.soak
def test_a_ladder_of_a_test_in_time_goes_on_too():
    time = [0.1 * 1.3**i for i in range(16)]
    force = [300.0 * t**-0.2 + (-1.0) ** i for i, t in enumerate(time)]
    test = springpot.TimeTest.of_relaxation(time, force, "kPa")
    begun = springpot.discover([test], "maxwell", accept=[], only=IN_TIME)
    whole = springpot.discover([test], "maxwell", accept=IN_TIME[0], only=IN_TIME)
    again = springpot.discover([test], "maxwell", accept=IN_TIME[0], begun=begun, only=IN_TIME)
    assert json.dumps(again.to_dict()) == json.dumps(whole.to_dict())
