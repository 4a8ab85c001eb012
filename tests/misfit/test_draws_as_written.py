"""What noise alone would leave of data that were written with few digits."""

from dataclasses import replace

import numpy as np
import pytest

import springpot
from springpot.misfit.floor import fitted_to_floor
from springpot.rheology import Model, dashpot, parallel, spring

MODEL = Model("kelvin", parallel(spring(), dashpot()))
OMEGA = np.geomspace(0.5, 50.0, 40)
STEP = 1.0


def frame_of(noise):
    """Values of some 57 and up to 30 in whole numbers, with noise of this share of them before."""
    rng = np.random.default_rng(4)
    exact = 57.3 + 0.6j * OMEGA
    values = exact + noise * np.abs(exact) * (rng.normal(size=40) + 1j * rng.normal(size=40))
    written = np.round(values.real / STEP) * STEP + 1j * np.round(values.imag / STEP) * STEP
    return fitted_to_floor(MODEL, springpot.Measurement(OMEGA, written)).frame()


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_draws_of_written_values_are_of_the_size_of_what_was_left(noise, rng):
    frame = frame_of(noise)
    assert frame._steps is not None, "rounding is a good part of this noise"
    draws = frame._as_written(frame._steps, 400, rng)
    left = np.sqrt(np.mean(frame.rest**2))
    assert np.sqrt(np.mean(draws**2)) == pytest.approx(left, rel=0.12)


def test_a_draw_is_what_would_have_been_written_less_what_is_exact(rng):
    frame = replace(frame_of(0.01), jacobian=np.zeros((0, 40), dtype=complex))
    draws = frame._as_written(frame._steps, 3, rng)
    weights = np.concatenate([frame.weights.real, frame.weights.imag])
    exact = np.concatenate([frame.model_stiffness.real, frame.model_stiffness.imag])
    steps = (exact + draws / weights) / STEP
    assert steps == pytest.approx(np.round(steps), abs=1e-3)


def test_exact_values_lie_where_the_parameters_let_them_and_are_not_rounded_alike(monkeypatch, rng):
    """Without noise of their own all draws would else be one."""
    frame = frame_of(0.0)
    monkeypatch.setattr(type(frame), "_own_level", lambda *given: 0.0)
    draws = frame._as_written(frame._steps, 400, rng)
    alike = np.mean(np.mean(draws, axis=0) ** 2) / np.mean(draws**2)
    assert alike < 0.9


def test_written_draws_remember_as_the_noise_does(rng):
    frame = replace(frame_of(0.05), jacobian=np.zeros((0, 40), dtype=complex), memory=0.8)
    draws = frame._as_written(np.full(40, 1e-6 * (1 + 1j)), 400, rng)
    draws -= draws.mean(axis=1, keepdims=True)
    assert np.mean(draws[:, 1:40] * draws[:, :39]) > 0.5 * np.mean(draws**2)
