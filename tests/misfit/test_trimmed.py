"""The scatter about slow curves: fitted without what stands out, and white where noise is white."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from springpot.measurement.measurement import Measurement
from springpot.misfit.frame import NoiseFrame, waves
from springpot.misfit.outliers import _energy_of_ripples, left_by, trimmed

SWEEPS, POINTS, NOISE = 80, 12, 0.01


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), curves=st.integers(1, 12), out=st.integers(0, 15))
def test_rows_left_out_have_no_say(seed, curves, out):
    rng = np.random.default_rng(seed)
    followed, _ = np.linalg.qr(rng.normal(size=(40, curves)))
    values, rows = rng.normal(size=(40, 2)), np.ones(40, dtype=bool)
    rows[rng.choice(40, out, replace=False)] = False
    solved = np.linalg.lstsq(followed[rows], values[rows], rcond=None)[0]
    np.testing.assert_allclose(
        left_by(followed, values, rows), values - followed @ solved, atol=1e-9
    )


def test_a_curve_that_only_left_out_rows_show_has_no_size():
    followed, rows = np.eye(6)[:, :2], np.array([False, True, True, True, True, True])
    left = left_by(followed, np.arange(1.0, 7.0), rows)
    np.testing.assert_allclose(left, [1.0, 0.0, 3.0, 4.0, 5.0, 6.0], atol=1e-12)


def framed(ripple: float, seed: int) -> NoiseFrame:
    """Springs, each measured in a sweep of its own; slow curves follow a third of the numbers."""
    rng = np.random.default_rng(seed)
    omega = np.tile(np.geomspace(1.0, 100.0, POINTS), SWEEPS)
    specimen = np.repeat(np.arange(1.0, SWEEPS + 1.0), POINTS)
    error = NOISE * (rng.normal(size=omega.size) + 1j * rng.normal(size=omega.size))
    along = ripple * np.cos(2.0 * np.pi / 3.0 * np.arange(omega.size) + specimen)
    stiffness = (10.0 + 2.0j) * (1.0 + error + along)
    data = Measurement(omega, stiffness, conditions={"specimen": specimen})
    k = np.full(omega.size, 10.0 + 2.0j)
    weights = (1.0 + 1.0j) / (NOISE * np.abs(k))
    return NoiseFrame(data, k, weights, np.zeros((0, omega.size), dtype=np.complex128))


@pytest.mark.soak_cases("2", "3")
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_white_noise_of_many_short_sweeps_holds_no_ripple(seed):
    found = trimmed(framed(0.0, seed))
    # Of about 1,200 numbers that are free: 0.04 is one standard deviation.
    assert found.variance == pytest.approx(1.0, abs=0.12)
    assert found.dof > 0.6 * found.left.size


@pytest.mark.soak
def test_a_ripple_in_many_sweeps_is_no_noise():
    assert trimmed(framed(NOISE, 4)).variance == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("share", [0.0, 0.7])
def test_a_ripple_is_fitted_beside_the_curves_that_were_fitted_before(share):
    """In one sweep its energy is what plain least squares of both gains over the curves alone."""
    rng, n = np.random.default_rng(7), 24
    k = (1.0 + 0.3j) * np.geomspace(1.0, 30.0, n)
    weights = 1.0 / np.abs(k) + 2.0j / np.abs(k)
    data = Measurement(np.geomspace(1.0, 50.0, n), k)
    frame = NoiseFrame(data, k, weights, np.zeros((0, n), dtype=np.complex128))
    periods = np.array([3.3, 7.9, 8.1, 12.0])
    ripple = frame.relative(waves(data, 8.1))
    curves, _ = np.linalg.qr(share * ripple[:, :1] + rng.normal(size=(2 * n, 5)) / n)
    residual = ripple @ np.array([3.0, 1.0, -2.0, 1.0]) + rng.normal(size=2 * n)
    left = residual - curves @ (curves.T @ residual)
    told = []
    for period in periods:
        both = np.concatenate([curves, frame.relative(waves(data, period))], axis=1)
        told.append(left @ left - np.linalg.lstsq(both, residual, rcond=None)[1][0])
    np.testing.assert_allclose(_energy_of_ripples(frame, curves, left, periods), told)
