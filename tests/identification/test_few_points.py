"""Few points and exact ones: every answer that many points with noise get."""

import numpy as np
import pytest

import springpot
from springpot.identification import default_objective
from springpot.identification.native import fit
from springpot.misfit import any_material
from springpot.numerics import FEWEST


def zener(count: int, noise: float, seed: int = 0) -> springpot.Measurement:
    """A fractional Zener element, k0 = 120 kN/m to 560 kN/m, from 0.1 to 50 Hz."""
    omega = 2 * np.pi * np.geomspace(0.1, 50.0, count)
    power = (1j * omega * 0.03) ** 0.62
    real, imaginary = noise * np.random.default_rng(seed).normal(size=(2, count))
    stiffness = (120.0 + 440.0 * power / (1.0 + power)) * (1.0 + real + 1j * imaginary)
    return springpot.Measurement(
        omega, stiffness, units=springpot.Units("kN/m", "mm"), name=f"zener{count}"
    )


@pytest.mark.parametrize("count", [5, 6, 8, 14])
@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_a_spectrum_leaves_numbers_over_that_tell_the_scatter(count, noise):
    data = zener(count, noise)
    found = fit(any_material(), data, default_objective(data))
    assert len(found.theta) <= 2 * count - FEWEST
    # What is left out is of no weight: the curve is still followed to a small part of the noise of
    # any instrument.
    assert np.sqrt(found.cost / (2 * count)) < 0.01


def test_more_points_with_noise_use_fewer_lines_than_they_might():
    data = zener(30, 0.01)
    found = fit(any_material(), data, default_objective(data))
    assert len(found.theta) < 20


@pytest.mark.soak
def test_few_points_and_exact_ones_can_be_judged_without_a_model():
    """Both were refused: a spectrum with a line for every number left nothing over to judge by."""
    assert springpot.compare(zener(6, 1e-3)).best.error.over_floor < 1.5
    assert springpot.diagnose("artificial-springpot").verdict != "effect-missing"


def test_a_search_that_stopped_short_is_not_called_good_enough():
    data = zener(14, 1e-4)
    short = springpot.identify(data, "fractional-zener", optimiser="pso-paper", budget=300, seed=1)
    assert not short.standing.good_enough
    assert "the search stopped short" in short.standing.says
    assert springpot.identify(data, "fractional-zener").standing.good_enough
