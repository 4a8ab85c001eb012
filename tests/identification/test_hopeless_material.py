"""A material that is given up early: not for what its first lattice leaves of a sharp relaxation.

The lines of the first lattice lie apart, and a single Maxwell element between two of them is missed
by more than a noise of some thousandths.
"""

import numpy as np
import pytest

import springpot
from springpot.identification import Effort, fit
from springpot.measurement.scatter import Noise
from springpot.misfit.refit import noise_objective

AT = 2.0 * np.pi * np.tile(np.geomspace(1.0, 100.0, 16), 3)
AMPLITUDE = np.repeat([0.1, 0.3, 1.0], 16)
"""Frequencies in rad/s and displacements in mm."""


def stopped(b=0.4):
    """A Maxwell element beside a spring, and one more beyond a gap of b mm."""
    r = np.minimum(b / AMPLITUDE, 1.0)
    touched = 1.0 - 2.0 / np.pi * (np.arcsin(r) + r * np.sqrt(1.0 - r**2))
    k = 2.0 + 5.0j * AT * 0.02 / (1.0 + 1j * AT * 0.02) + 0.4 * touched
    return springpot.Measurement(
        AT, k, conditions={"amplitude": AMPLITUDE}, units=springpot.Units("kN/m", "mm")
    )


@pytest.fixture(scope="module")
def cost():
    data = stopped()
    noise = noise_objective(Noise(2e-4 * np.abs(data.stiffness) * (1 + 1j), np.inf, "given"))
    model = springpot.parse_model("material + dead-zone")
    seed = np.array([0.3, 0.35])

    def of(hopeless):
        found = fit(model, data, noise, starts=0, seeds_theta=[seed], effort=Effort(1e-6, hopeless))
        return found.cost

    return of


def test_what_only_the_lattice_leaves_is_gone_on_with(cost):
    whole = cost(np.inf)
    assert cost(10.0 * whole + 1.0) == pytest.approx(whole, rel=1e-3, abs=1e-3)
