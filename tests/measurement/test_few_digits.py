"""Repeats that were written with few digits: what all of them were rounded by, none tells."""

import numpy as np
import pytest

import springpot
from springpot.measurement import Measurement, average_repeats
from springpot.measurement.instrument import noise_before_rounding, shared_rounding
from springpot.measurement.replicates import noise_of_repeats
from springpot.measurement.scatter import steps_as_written

OMEGA = np.geomspace(1.0, 300.0, 40)
EXACT = 300.0 + 400.0 * (0.05j * OMEGA) ** 0.6


def with_digits(values, digits):
    return np.array([float(f"{value:.{digits}g}") for value in values])


def repeated(level, written, repeats=3):
    noise = np.random.default_rng(5).normal(size=(2, repeats * len(OMEGA)))
    values = np.tile(EXACT, repeats) * (1.0 + level * (noise[0] + 1j * noise[1]))
    number = np.repeat(np.arange(repeats), len(OMEGA))
    return Measurement(np.tile(OMEGA, repeats), written(values), repeat=number)


def as_parts(values):
    return with_digits(values.real, 3) + 1j * with_digits(values.imag, 3)


def as_modulus_and_phase(values):
    phase = np.radians(with_digits(np.degrees(np.angle(values)), 3))
    return with_digits(np.abs(values), 3) * np.exp(1j * phase)


def as_loss_factor(values):
    storage = with_digits(values.real, 3)
    return storage * (1.0 + 1j * with_digits(values.imag / values.real, 3))


@pytest.mark.parametrize("noise", [0.0, 0.1, 0.25, 0.5])
def test_what_is_shared_is_what_a_simulation_leaves_of_the_mean(noise):
    rng = np.random.default_rng(1)
    place = rng.uniform(0.0, 1.0, 2000)
    written = np.round(place + noise * rng.normal(size=(400, 2000)))
    off = np.sqrt(np.mean((written.mean(axis=0) - place) ** 2))
    assert shared_rounding(np.array([noise]), np.ones(1))[0] == pytest.approx(off, abs=0.03)


def test_the_noise_before_values_were_rounded_is_found():
    rng = np.random.default_rng(2)
    written = np.round(rng.uniform(0.0, 9.0, 500) + 0.2 * rng.normal(size=(3, 500)))
    squares = np.sum((written - written.mean(axis=0)) ** 2, axis=0)
    ones = np.ones(500)
    assert noise_before_rounding(squares, 2.0 * ones, ones, ones) == pytest.approx(0.2, abs=0.02)


@pytest.mark.parametrize("written", [as_parts, as_modulus_and_phase, as_loss_factor])
def test_the_mean_of_repeats_is_no_better_than_its_digits(written):
    data = average_repeats(repeated(2e-4, written))
    noise = noise_of_repeats(data)
    off = data.mean.stiffness - EXACT
    assert 0.6 < np.sqrt(np.mean((off.real / noise.sd.real) ** 2)) < 1.5
    assert 0.6 < np.sqrt(np.mean((off.imag / noise.sd.imag) ** 2)) < 1.5
    assert data.floor(noise) == pytest.approx(
        float(np.sqrt(np.mean(np.abs(data.raw.stiffness / np.tile(EXACT, 3) - 1.0) ** 2))), rel=0.3
    )


def test_steps_of_a_modulus_turn_with_its_phase():
    steps = steps_as_written(Measurement(OMEGA, as_modulus_and_phase(EXACT)))
    off = as_modulus_and_phase(EXACT) - EXACT
    assert np.sqrt(np.mean((off.real / steps.real) ** 2)) == pytest.approx(12**-0.5, rel=0.3)
    assert np.sqrt(np.mean((off.imag / steps.imag) ** 2)) == pytest.approx(12**-0.5, rel=0.3)


def test_all_digits_leave_the_noise_of_repeats_as_it_was():
    data = average_repeats(repeated(2e-4, lambda values: values))
    assert not np.any(data.shared)


@pytest.mark.soak
def test_three_digits_of_repeats_are_nothing_that_is_missing():
    data = repeated(5e-4, as_parts)
    found = springpot.diagnose(data, model="fractional-kelvin")
    assert found.verdict == "adequate"
