"""What goes with time, stands alone or touches: each rule at both sides of its edge."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.measurement import Measurement
from springpot.misfit import drift_search, outliers, regions


@pytest.mark.parametrize(
    ("one", "other", "touch"),
    [
        ([(0, 2), (1, 3)], [(2, 4), (1, 3)], True),
        ([(2, 4), (1, 3)], [(0, 2), (1, 3)], True),
        ([(0, 2), (1, 3)], [(3, 4), (1, 3)], False),
        ([(0, 2), (1, 3)], [(2, 4), (3, 4)], False),
        ([(0, 2), (1, 3)], [(0, 2), (1, 3)], False),
        ([(0, 2)], [(0, 3)], False),
    ],
)
def test_blocks_touch_that_differ_along_one_axis_and_end_where_the_other_begins(one, other, touch):
    assert regions._neighbours(one, other) is touch


@pytest.mark.parametrize(
    ("rows", "beside", "alone"),
    [([2], 1.0, True), ([2], 9.0, False), ([2, 3], 1.0, False), ([2, 7], 1.0, False)],
)
def test_what_stands_out_is_alone_where_its_neighbours_are_noise(rows, beside, alone):
    """Two sweeps of five; beside the third point are two, and a third at its frequency."""
    data = Measurement(
        np.tile(np.arange(1.0, 6.0), 2),
        np.full(10, 1.0 + 1.0j),
        conditions={"temperature": np.repeat([20.0, 60.0], 5)},
    )
    for place in (1, 3, 7):
        residual = np.zeros(20)
        residual[[2, 12]] = 50.0
        residual[place + 10] = beside
        frame = SimpleNamespace(measurement=data, residual=residual, scale_dof=np.inf)
        if place not in rows:
            assert outliers.stands_alone(frame, np.array(rows)) is alone
    # What is far from it is no neighbour.
    residual = np.zeros(20)
    residual[[0, 4, 5, 9]] = 99.0
    frame = SimpleNamespace(measurement=data, residual=residual, scale_dof=np.inf)
    assert outliers.stands_alone(frame, np.array([2]))


def timed(time, unit="s", omega=2.0 * np.pi, magnitude=1.0, **conditions):
    """Points at one frequency, of one hertz, with a column of time."""
    count = len(time)
    data = Measurement(
        np.full(count, omega) * np.ones(count),
        np.full(count, 1.0 + 0.0j) * magnitude,
        conditions={"time": np.array(time, dtype=float), **conditions},
        provenance={"unit time": unit},
    )
    return data, np.array(time, dtype=float)


@pytest.mark.parametrize(
    ("time", "unit", "early"),
    [
        ([5.0, 5.5, 5.99, 6.0], "s", 3),
        ([5.0, 6.0, 7.0, 8.0], "s", 0),
        ([0.0, 0.01, 0.02, 0.03], "min", 2),
        ([0.0, 0.01, 0.02, 0.03], "yards", 0),
    ],
)
def test_the_first_period_of_a_test_is_what_one_cycle_took(time, unit, early):
    data, at = timed(time, unit)
    np.testing.assert_array_equal(drift_search._first_period(data, at), np.arange(4) < early)
    moved, at = timed(time, unit, omega=np.arange(6.0, 10.0))
    assert not np.any(drift_search._first_period(moved, at))


def test_a_force_was_held_where_it_is_steadier_than_the_amplitude_that_it_made():
    time = np.arange(12.0)
    stiffness = np.exp(-0.2 * time + 0.05 * np.cos(2.0 * time))
    made, _ = timed(time, magnitude=stiffness, amplitude=0.1 / stiffness)
    assert drift_search._force_was_held(made)
    chosen, _ = timed(time, magnitude=stiffness, amplitude=np.full(12, 0.1))
    assert not drift_search._force_was_held(chosen)
    without, _ = timed(time, magnitude=stiffness)
    assert not drift_search._force_was_held(without)


@pytest.mark.parametrize(("unit", "seconds"), [("s", 1.0), ("min", 60.0)])
def test_a_specimen_changes_in_a_period_by_its_slope_in_time(unit, seconds):
    """At two hertz, of ln |K| that falls by 0.3 of a unit of time."""
    time = np.arange(40.0)
    data, at = timed(time, unit, omega=4.0 * np.pi, magnitude=np.exp(-0.3 * time))
    found = drift_search._mutation(data, at, np.arange(40), unit)
    assert found == pytest.approx(0.3 / seconds / 2.0)
    assert drift_search._mutation(data, at, np.arange(40), "yards") is None
    assert drift_search._mutation(data, np.zeros(40), np.arange(40), unit) is None


def test_a_course_is_that_of_what_was_measured_most_often():
    """Thrice at three frequencies, of which the middle one counts, and once at another."""
    omega = np.r_[np.tile([1.0, 2.0, 3.0], 3), 4.0]
    data = Measurement(omega, np.full(10, 1.0 + 1.0j))
    np.testing.assert_array_equal(drift_search._most_alike(data), [1, 4, 7])
    warm = {"temperature": np.where(np.arange(10) < 6, 20.0, 60.0)}
    data = Measurement(omega, np.full(10, 1.0 + 1.0j), conditions=warm)
    np.testing.assert_array_equal(drift_search._most_alike(data), [1, 4])
