"""Sweeps of a measurement: one for each set of conditions, labelled by what was measured."""

import copy
from dataclasses import replace

import numpy as np
import pytest

from springpot import Measurement
from springpot.errors import DataError
from springpot.measurement import average_repeats


def test_sweeps_are_labelled_by_their_own_conditions():
    temperature = np.array([20.0, 20.0, 30.0, 30.0])
    measured = Measurement(
        np.array([1.0, 2.0] * 2), np.full(4, 1 + 1j), conditions={"temperature": temperature}
    )
    sweeps = dict(measured.sweeps())
    assert list(sweeps) == ["temperature 20", "temperature 30"]
    assert sweeps["temperature 30"].tolist() == [2, 3]


def test_slightly_different_temperatures_are_one_sweep():
    temperature = np.array([20.00, 20.01, 19.99])
    measured = Measurement(
        np.array([1.0, 2.0, 3.0]), np.full(3, 1 + 1j), conditions={"temperature": temperature}
    )
    assert [label for label, _ in measured.sweeps()] == ["temperature 20"]


def test_rows_without_a_name_keep_the_temperature_at_which_shift_factors_are_one():
    temperature = np.array([10.0, 20.0, 30.0, 30.0, 30.0])
    measured = Measurement(
        np.arange(1.0, 6.0), np.full(5, 1 + 1j), conditions={"temperature": temperature}
    )
    once = measured.subset(np.array([0, 1, 2]))
    assert measured.reference_temperature == once.reference_temperature == 303.15
    assert replace(once, stiffness=2 * once.stiffness).points.reference_temperature == 303.15
    assert copy.copy(once).reference_temperature == 303.15
    assert measured.subset(np.array([0, 1]), "cold").reference_temperature == 283.15


def test_averages_of_repeats_are_shifted_from_the_same_temperature_as_the_repeats():
    """Else a fit to the averages is drawn and judged at the wrong place."""
    temperature = np.array([10.0, 20.0, 30.0, 30.0, 30.0])
    measured = Measurement(
        np.ones(5),
        np.array([4 + 1j, 2 + 1j, 1 + 1j, 1.01 + 1j, 0.99 + 1j]),
        conditions={"temperature": temperature},
        repeat=np.array([1, 1, 1, 2, 3]),
    )
    averaged = average_repeats(measured)
    assert len(averaged.mean) == 3
    assert averaged.mean.reference_temperature == measured.reference_temperature


def test_lists_do():
    measured = Measurement(
        [1, 2, 3],
        [1 + 1j, 2, 3],
        conditions={"temperature": [20, 20, 30]},
        repeat=[1, 1, 2],
        labels={"by": ["a"] * 3},
    )
    assert measured.frequency[1] == 1.0 / np.pi
    assert measured.loss.tolist() == [1.0, 0.0, 0.0]
    assert measured.conditions["temperature"].dtype == float
    assert [len(rows) for _, rows in measured.sweeps()] == [2, 1]


def test_arrays_are_taken_as_they_are():
    omega, stiffness = np.arange(1.0, 4.0), np.ones(3, dtype=complex)
    measured = Measurement(omega, stiffness)
    assert measured.omega is omega
    assert measured.stiffness is stiffness


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"stiffness": [1, 0, 0]}, "both zero in 2 of 3 points, first at 0.3183 Hz"),
        ({"stiffness": ["a", "b", "c"]}, "column stiffness must hold numbers"),
        ({"omega": [1j, 2, 3]}, "column omega must hold real numbers"),
        ({"omega": [[1, 2, 3]] * 3}, "column omega must have one value for each"),
        ({"omega": 3.0}, "column omega must have one value for each"),
        ({"repeat": [1, 1.5, 2]}, "column repeat must hold whole numbers"),
        ({"repeat": [1, np.nan, 2]}, "column repeat must hold whole numbers"),
        ({"repeat": [1, np.inf, 2]}, "column repeat must hold whole numbers"),
        ({"repeat": [1, 1e300, 2]}, "column repeat must hold whole numbers"),
        (
            {"conditions": {"temperature": [20, np.nan, np.nan]}},
            "temperature is no finite number in 2 of 3 points, first at 0.3183 Hz",
        ),
        (
            {"conditions": {"amplitude": [np.inf, 1, 1]}},
            "amplitude is no finite number in 1 of 3 points",
        ),
        (
            {"sd": [1 + 1j, complex(np.inf, 1.0), 1 + 1j]},
            "standard deviations must be positive and finite",
        ),
        (
            {"sd": [1 + 1j, complex(1.0, np.inf), 1 + 1j]},
            "standard deviations must be positive and finite",
        ),
        (
            {"sd": [1 + 1j, complex(np.nan, 1.0), 1 + 1j]},
            "standard deviations must be positive and finite",
        ),
        ({"conditions": {"temperatur": [1, 2, 3]}}, "'temperatur' is nearly 'temperature'"),
        ({"conditions": {"Amplitudes": [1, 2, 3]}}, "models know temperature and amplitude"),
    ],
)
def test_what_is_no_measurement_is_said(given, says):
    with pytest.raises(DataError, match=says):
        Measurement(**{"omega": [1, 2, 3], "stiffness": [1, 2, 3], **given})


def test_gaps_in_other_conditions_are_welcome():
    assert np.isnan(
        Measurement([1.0], [1.0 + 0.0j], conditions={"pressure": [np.nan]}).conditions["pressure"][
            0
        ]
    )


def test_other_conditions_are_welcome():
    others = {"pressure": [1.0], "humidity": [2.0], "static strain": [3.0]}
    assert set(Measurement([1.0], [1.0 + 0.0j], conditions=others).conditions) == set(others)
