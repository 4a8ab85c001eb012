"""Noise with a memory: one recursion, for sweeps and for records."""

import numpy as np
import pytest

from springpot.distributions import (
    Links,
    autoregressive,
    covariance_along,
    effective_share,
    fitted_memory,
    prewhitened,
    spectrum_of,
)


@pytest.mark.parametrize("memory", [0.0, 0.3, 0.97])
def test_what_is_remembered_is_forgotten(memory):
    new = np.random.default_rng(1).normal(size=(3, 100))
    noise = autoregressive(new, memory)
    np.testing.assert_allclose(prewhitened(noise.T, memory).T, new)
    kept = np.sqrt(1.0 - memory**2)
    assert noise[0, 1] == pytest.approx(memory * new[0, 0] + kept * new[0, 1])


def test_lines_do_not_remember_one_another():
    links = Links.along([np.array([0, 2]), np.array([3, 1, 4])])
    told = prewhitened(np.arange(1.0, 6.0), 0.6, links)
    assert told.tolist() == pytest.approx([1.0, (2 - 0.6 * 4) / 0.8, (3 - 0.6) / 0.8, 4.0, 4.75])


def test_a_memory_is_told_beside_curves():
    noise = autoregressive(np.random.default_rng(2).normal(size=2000), 0.6)
    curves = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, 2000), 6)
    columns = np.column_stack([curves, noise + curves @ np.arange(7.0)])
    told = fitted_memory(columns, Links(), 0.9)
    assert told.memory == pytest.approx(0.6, abs=0.05)
    assert told.gain > 0.0
    assert told.likeliest == told.memory
    assert fitted_memory(columns, Links(), 0.3).likeliest == told.memory
    columns[:, -1] = np.random.default_rng(3).normal(size=2000)
    assert fitted_memory(columns, Links(), 0.9).gain < 0.0


def test_slow_waves_hold_more_of_it_than_they_are_worth():
    assert spectrum_of(np.zeros(1), 2.0, 0.6) == pytest.approx(4.0 / effective_share(0.6))


def test_what_columns_have_of_noise_is_by_its_correlations():
    columns = np.random.default_rng(4).normal(size=(9, 2))
    lines, alike = [np.arange(6), np.arange(8, 5, -1)], np.zeros((9, 9))
    for line in lines:
        alike[np.ix_(line, line)] = 0.7 ** np.abs(np.subtract.outer(line, line))
    expected = columns.T @ alike @ columns
    np.testing.assert_allclose(covariance_along(columns, 0.7, lines), expected)
    alike[6:, 6:] = np.eye(3)
    single = covariance_along(columns, 0.7, lines[:1])
    np.testing.assert_allclose(single, columns.T @ alike @ columns)
