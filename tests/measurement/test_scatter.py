"""How far the values of a file can be told apart bounds their noise from below."""

import numpy as np
import pytest

from springpot import Measurement
from springpot.measurement import at_least_rounding, scatter


def measured(storage, loss):
    return Measurement(np.arange(1.0, 4.0), np.array(storage) + 1j * np.array(loss))


def test_few_digits_bound_the_noise():
    data = measured([102.8, 141.4, 185.0], [73.25, 85.91, 91.84])
    sd = at_least_rounding(np.full(3, 1e-9 + 1e-9j), data)
    assert sd.real == pytest.approx(0.1 / np.sqrt(12))
    assert sd.imag == pytest.approx(0.01 / np.sqrt(12))


def test_full_digits_leave_the_noise_as_it_is():
    values = np.random.default_rng(0).uniform(1.0, 2.0, (2, 3))
    sd = np.full(3, 1e-3 + 2e-3j)
    assert np.array_equal(at_least_rounding(sd, measured(*values)), sd)


def test_a_loss_of_zero_has_no_last_digit():
    sd = at_least_rounding(np.full(3, 1e-3 + 1e-3j), measured([1.0, 2.0, 3.0], [0.0, 0.0, 0.0]))
    assert sd.imag == pytest.approx(1e-3)


def test_noise_rises_to_the_upper_end_the_lower_end_or_both():
    rises = np.array(list(scatter._rises(np.linspace(-1.0, 3.0, 9))))
    slope = np.diff(rises, axis=1)
    up, down = np.all(slope > 0.0, axis=1), np.all(slope < 0.0, axis=1)
    both = np.all(slope[:, :4] < 0.0, axis=1) & np.all(slope[:, 4:] > 0.0, axis=1)
    assert up.sum() == down.sum() == both.sum() == len(rises) / 3
    np.testing.assert_allclose(rises.min(axis=1), 1.0)
    assert not list(scatter._rises(np.zeros(9)))
