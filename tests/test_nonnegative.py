"""Non-negative least squares where the columns are nearly one."""

import numpy as np
import pytest
import scipy.optimize
from scipy.optimize import lsq_linear

from springpot.numerics import non_negative


def columns(step):
    """Relaxations so close that neighbours hardly differ."""
    omega = np.geomspace(0.01, 100.0, 40)
    rates = np.exp(np.arange(np.log(1e-4), np.log(1e4), step))
    modes = 1j * omega[:, None] / (1j * omega[:, None] + rates)
    return np.vstack([modes.real, modes.imag])


@pytest.mark.parametrize("step", [1.0, 0.2])
def test_no_weights_come_nearer(step):
    matrix = columns(step)
    target = matrix[:, ::7].sum(axis=1) + 0.01 * np.random.default_rng(0).normal(size=len(matrix))
    weights, left = non_negative(matrix, target)
    assert np.all(weights >= 0.0)
    assert left == pytest.approx(float(np.sum((matrix @ weights - target) ** 2)))
    assert left <= 2.0 * lsq_linear(matrix, target, (0.0, np.inf)).cost * (1.0 + 1e-6)


def test_where_the_active_set_goes_round_another_way_is_found(monkeypatch):
    def gives_up(*_, **__):
        raise RuntimeError("Maximum number of iterations reached.")

    matrix = columns(1.0)
    target = matrix @ np.linspace(0.0, 1.0, matrix.shape[1])
    _, left = non_negative(matrix, target)
    monkeypatch.setattr(scipy.optimize, "nnls", gives_up)
    weights, other = non_negative(matrix, target)
    assert np.all(weights >= 0.0)
    assert other == pytest.approx(left, abs=1e-6 * float(target @ target))


def test_a_column_too_small_for_its_square_has_no_weight():
    # What slow tests tell of relaxations that have faded long before their first sample.
    matrix = np.linspace(0.5, 1.0, 10)[:, None] * np.array([0.01, 1e-77, 0.0])
    matrix[1, :2] *= -20.0
    matrix[2:, 2] = 5e-324
    target = np.array([1.1, -25.8, 11.9, 12.3, 9.6, 6.0, 2.3, -1.2, -3.5, -1.5])
    weights, left = non_negative(matrix, target)
    assert np.all(np.isfinite(weights))
    assert weights[-1] == 0.0
    assert left == pytest.approx(float(np.sum((matrix @ weights - target) ** 2)))
