"""What changed with time under the name of another column: only where its values take turns."""

import numpy as np
import pytest

from springpot.measurement import Measurement
from springpot.misfit.drift_search import change_in_order, moves_with_frequency

TIME = np.arange(60.0)


def told(batch, **given):
    stiffness = (1000.0 + 200.0j) * np.geomspace(1.0, 4.0, 60)
    conditions = {"batch": batch, "time": TIME, **given}
    data = Measurement(np.ones(60), stiffness, conditions=conditions)
    return change_in_order(data, "batch")


@pytest.mark.parametrize("names", [(1.0, 2.0), (3.0, 1.0, 2.0)])
def test_one_after_another_is_told(names):
    assert "in the order of time, as which batch stands" in told(np.repeat(names, 60 // len(names)))


@pytest.mark.parametrize(
    "batch", [np.tile([1.0, 2.0], 30), np.repeat([1.0, 2.0, 3.0, 1.0], 15), np.arange(60) // 59.5]
)
def test_in_turns_is_not(batch):
    mixed = len(np.unique(batch)) > 1
    assert bool(told(batch)) is not mixed


def test_two_that_share_an_instant_are_not_in_order():
    time = TIME.copy()
    time[30] = time[29]
    batch = np.repeat([1.0, 2.0], 30)
    assert told(batch)
    assert not told(batch, time=time)


def test_without_a_time_or_the_column_nothing_is_told():
    data = Measurement(np.ones(60), np.full(60, 1j), conditions={"batch": TIME})
    assert change_in_order(data, "batch") == ""
    timed = Measurement(np.ones(60), np.full(60, 1j), conditions={"time": TIME})
    assert change_in_order(timed, "batch") == ""


@pytest.mark.parametrize(
    ("omega", "moves"),
    [
        (1.0 + TIME, True),
        (61.0 - TIME, True),
        (np.ones(60), False),
        (1.0 + np.abs(TIME - 30.0), False),
        (1.0 + TIME // 2, True),
    ],
)
def test_a_single_sweep_goes_one_way(omega, moves):
    data = Measurement(omega, np.full(60, 1j), conditions={"time": TIME})
    assert moves_with_frequency(data) is moves
