"""Sweeps of a measurement: one for each set of conditions, labelled by what was measured."""

import numpy as np

from springpot import Measurement


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
