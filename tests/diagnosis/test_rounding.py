"""What a file's few digits round away bounds the noise from below."""

import numpy as np
import pytest
from hidden_data import design

import springpot
from soaked import soaked
from springpot import Measurement


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
