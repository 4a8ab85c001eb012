"""Sweeps of a measurement: one for each set of conditions, labelled by what was measured."""

import copy
from dataclasses import replace

import numpy as np

from springpot import Measurement
from springpot.diagnosis.noise import average_repeats


def test_sweeps_are_labelled_by_their_own_conditions():
    temperature = np.array([20.0, 20.0, 30.0, 30.0])
    measured = Measurement(np.array([1.0, 2.0] * 2), np.full(4, 1 + 1j), conditions={"temperature": temperature})
    sweeps = dict(measured.sweeps())
    assert list(sweeps) == ["temperature 20", "temperature 30"]
    assert sweeps["temperature 30"].tolist() == [2, 3]


def test_slightly_different_temperatures_are_one_sweep():
    temperature = np.array([20.00, 20.01, 19.99])
    measured = Measurement(np.array([1.0, 2.0, 3.0]), np.full(3, 1 + 1j), conditions={"temperature": temperature})
    assert [label for label, _ in measured.sweeps()] == ["temperature 20"]


def test_rows_without_a_name_keep_the_temperature_at_which_shift_factors_are_one():
    temperature = np.array([10.0, 20.0, 30.0, 30.0, 30.0])
    measured = Measurement(np.arange(1.0, 6.0), np.full(5, 1 + 1j), conditions={"temperature": temperature})
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
