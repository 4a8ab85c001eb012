"""Columns of the fit of signals, and how they turn with the frequency."""

from __future__ import annotations

import numpy as np
import pytest

from springpot.measurement.fit import GONE, Basis

TIME = np.linspace(1.0, 5.0, 41)


@pytest.mark.parametrize("transient", [0.0, 0.7])
def test_columns_are_level_drift_harmonics_and_a_transient(transient):
    basis = Basis(3.0, 1.0, 5.0, 2, transient)
    found = basis.columns(TIME)
    middle = TIME - 3.0
    wanted = [np.ones(41), middle / 2.0]
    for order in (1, 2):
        wanted += [np.cos(3.0 * order * middle), np.sin(3.0 * order * middle)]
    if transient:
        age = (TIME - 1.0) / transient
        wanted += [np.exp(-age), age * np.exp(-age)]
    np.testing.assert_allclose(found, np.array(wanted).T, atol=1e-12)
    assert basis.size == found.shape[1] == (8 if transient else 6)
    assert basis.slow == ([1, 6, 7] if transient else [1])


def test_what_has_died_out_is_no_endless_age():
    basis = Basis(3.0, 1.0, 5.0, 1, 1e-6)
    assert np.all(np.isfinite(basis.columns(TIME)))
    assert basis.columns(TIME)[-1, -1] == pytest.approx(GONE * np.exp(-GONE))


@pytest.mark.parametrize("transient", [0.0, 0.7])
@pytest.mark.parametrize("harmonics", [1, 3])
def test_the_slope_by_the_frequency_is_that_of_the_harmonics_alone(harmonics, transient):
    basis = Basis(3.0, 1.0, 5.0, harmonics, transient)
    coefficients = np.cos(np.arange(basis.size)) + 2.0
    near = [
        Basis(3.0 + step, 1.0, 5.0, harmonics, transient).columns(TIME) @ coefficients
        for step in (1e-5, -1e-5)
    ]
    found = basis.frequency_column(basis.columns(TIME), coefficients)
    np.testing.assert_allclose(found, (near[0] - near[1]) / 2e-5, rtol=1e-7, atol=1e-7)
