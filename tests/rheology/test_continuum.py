"""Any material: interpolation at very many frequencies equals summation at few."""

import numpy as np
import pytest

from springpot.rheology import Continuum, Points
from springpot.rheology.elements import MANY

THETA = np.array([1.0, 0.1, 2.0, 3.0])


@pytest.mark.parametrize(
    "omega", [[6.283], [0.5, 0.50001], [0.1, 100.0]], ids=["one", "near", "wide"]
)
def test_very_many_points_at_any_frequencies_are_those_of_few(omega):
    material = Continuum((1.0, 10.0))
    few = material.respond(THETA, Points.at(omega)).value
    many = material.respond(THETA, Points.at(np.repeat(omega, 2 * MANY))).value
    np.testing.assert_allclose(many, np.repeat(few, 2 * MANY), rtol=1e-8)
