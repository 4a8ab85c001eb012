"""Noise along K and across it, as errors of gain and of phase are, each of its own size."""

from __future__ import annotations

import numpy as np
import pytest
from hidden_data import KELVIN, design, exact

import springpot
from springpot.measurement import Measurement
from springpot.measurement.replicates import average_repeats
from springpot.measurement.scatter import Noise
from springpot.misfit.floor import fitted_to_floor
from springpot.misfit.refit import refit

MODEL = springpot.parse_model("fractional-kelvin")
AT = design(60, 0.1, 50.0)
TRUE = exact(KELVIN, AT)
PHASE = TRUE / np.abs(TRUE)


def scattered(gain, phase, seed=3, digits=12):
    """The model's K with errors along it and across it of these relative sizes."""
    parts = np.random.default_rng(seed).normal(size=(2, len(TRUE)))
    noisy = TRUE * (1.0 + gain * parts[0] + 1j * phase * parts[1])
    return Measurement(AT.omega, noisy.round(digits))


@pytest.mark.parametrize(("gain", "phase"), [(0.03, 0.002), (0.001, 0.02)])
def test_each_size_is_found(gain, phase):
    noise = fitted_to_floor(MODEL, scattered(gain, phase)).noise
    assert noise.along is not None
    share = noise.along.sd / np.abs(TRUE)
    assert np.median(share.real) == pytest.approx(gain, rel=0.35)
    assert np.median(share.imag) == pytest.approx(phase, rel=0.35)


def test_equal_parts_are_no_reason_for_two_sizes():
    assert fitted_to_floor(MODEL, scattered(0.01, 0.01)).noise.along is None


def test_deviations_of_storage_and_loss_are_those_of_the_turned_covariance():
    along = np.abs(TRUE) * (0.03 + 0.002j)
    noise = Noise.shaped(along, np.conj(PHASE), np.inf, "given")
    turn = np.array([[PHASE.real, -PHASE.imag], [PHASE.imag, PHASE.real]]).transpose(2, 0, 1)
    squares = np.stack([along.real**2, along.imag**2], axis=-1)
    covariance = turn @ (squares[:, :, None] * turn.transpose(0, 2, 1))
    assert np.allclose(noise.sd.real**2, covariance[:, 0, 0])
    assert np.allclose(noise.sd.imag**2, covariance[:, 1, 1])
    off = 0.01 * TRUE * (1.0 - 0.3j)
    seen = noise.of_whitened(refit_of(noise, TRUE + off, TRUE).frame().whiten(off))
    assert np.allclose(seen, off)


def refit_of(noise, measured, start):
    data = average_repeats(Measurement(AT.omega, measured))
    return refit(springpot.parse_model("kelvin"), data, noise, starts=4)


def test_a_fit_is_that_of_generalised_least_squares():
    """A spring beside a dashpot is linear: what covariance-weighted least squares make of it."""
    spring, dashpot = 3.0, 0.05
    k = spring + 1j * AT.omega * dashpot
    phase = k / np.abs(k)
    parts = np.random.default_rng(5).normal(size=(2, len(k)))
    measured = k * (1.0 + 0.05 * parts[0] + 0.002j * parts[1])
    noise = Noise.shaped(np.abs(k) * (0.05 + 0.002j), np.conj(phase), np.inf, "given")
    columns = np.stack([np.ones_like(k), 1j * AT.omega], axis=1)

    def white(values):
        turned = (values.T * np.conj(phase)).T
        scale = np.abs(k) if values.ndim == 1 else np.abs(k)[:, None]
        return np.concatenate([turned.real / (0.05 * scale), turned.imag / (0.002 * scale)])

    wanted = np.linalg.lstsq(white(columns), white(measured), rcond=None)[0]
    found = refit_of(noise, measured, k)
    assert found.theta == pytest.approx(wanted, rel=1e-6)
    free = refit(springpot.parse_model("material"), found.data, noise)
    assert free.rss <= found.rss * (1.0 + 1e-9)


def test_what_follows_the_quiet_part_is_seen_beside_a_loud_one():
    """A delay turns K by a tenth of what its gain scatters."""
    late = scattered(0.03, 0.001)
    late = Measurement(AT.omega, late.stiffness * np.exp(-1j * AT.omega * 3e-5))
    answer = springpot.diagnose(late, MODEL, only=["time-delay", "inertia", "friction"])
    assert answer.verdict == "effect-missing"
    assert answer.candidates[0].effect == "time-delay"
