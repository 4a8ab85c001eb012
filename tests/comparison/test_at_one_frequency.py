"""A linear model has a storage and a loss at one frequency.

Models with more parameters need a shift to be told.
"""

import numpy as np
import pytest

import springpot


def strain_sweep():
    """A gel at 1 Hz that softens as a whole beyond a strain of 0.1."""
    rng = np.random.default_rng(5)
    strain = np.geomspace(0.001, 1.0, 16)
    real, imaginary = 0.01 * rng.normal(size=(2, len(strain)))
    modulus = (900.0 + 120.0j) / (1.0 + (strain / 0.1) ** 1.2) * (1.0 + real + 1j * imaginary)
    omega = np.full(len(strain), 2.0 * np.pi)
    return springpot.Measurement(
        omega, modulus, conditions={"amplitude": strain}, units=springpot.Units("Pa", "-")
    )


@pytest.mark.soak
def test_only_models_that_can_be_told_are_fitted():
    ranking = springpot.compare(strain_sweep())
    sizes = {len(one.model.material.parameters) for one in ranking.judgements}
    assert max(sizes) <= 2
    reasons = {one.reason for one in ranking.skipped}
    assert any("at one frequency" in reason for reason in reasons)


@pytest.mark.soak
def test_a_ramp_of_temperature_reads_the_curve_of_a_model_at_many_places():
    """A time shift makes one frequency at forty temperatures a sweep that tells five parameters."""
    rng = np.random.default_rng(1)
    celsius = np.linspace(-20.0, 100.0, 40)
    shifted = np.exp(60e3 / 8.314 * (1.0 / (celsius + 273.15) - 1.0 / 313.15))
    along = (0.6j * np.pi * shifted) ** 0.8
    real, imaginary = 0.005 * rng.normal(size=(2, len(celsius)))
    modulus = (1e6 + 5e6 * along / (1.0 + along)) * (1.0 + real + 1j * imaginary)
    omega = np.full(len(celsius), 2.0 * np.pi)
    data = springpot.Measurement(
        omega, modulus, conditions={"temperature": celsius}, units=springpot.Units("Pa", "-")
    )
    ranking = springpot.compare(data)
    assert "fractional-zener + arrhenius-shift" in {one.model.name for one in ranking.adequate}
