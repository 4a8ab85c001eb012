"""What a file's few digits round away bounds the noise from below."""

import numpy as np
import pytest
from hidden_data import design

import springpot
from soaked import soaked
from springpot import Measurement
from springpot.diagnosis.noise import at_least_rounding


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


@pytest.mark.parametrize("seed", [0, 1, *map(soaked, range(2, 6))])
def test_three_digits_of_a_plateau_are_no_structure(seed):
    """Neighbours on a plateau are all rounded the same way; the noise is a quarter of a step."""
    at = design(60, 0.01, 100.0)
    exact = 100.0 + 50.0 * 1j * at.omega / (30.0 + 1j * at.omega)
    noise = 0.25 * np.random.default_rng(seed).normal(size=(2, 60))
    values = exact + noise[0] + 0.1j * noise[1]

    def written(part):
        step = 10.0 ** (np.floor(np.log10(np.abs(part))) - 2)
        return np.round(part / step) * step

    data = Measurement(at.omega, written(values.real) + 1j * written(values.imag))
    assert springpot.diagnose(data, "zener").verdict in ("adequate", "inconclusive")
