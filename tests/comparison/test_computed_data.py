"""Data that were computed without noise.

Only rounding is left, and the model that made them is named.
"""

import numpy as np
import pytest

import springpot
from soaked import soaked

OMEGA = 2.0 * np.pi * np.geomspace(0.1, 10.0, 20)


@pytest.mark.soak_cases("kelvin-stiffness0")
@pytest.mark.parametrize(
    ("name", "stiffness"),
    [
        ("kelvin", 1000.0 + 100.0j * OMEGA),
        soaked("spring", np.full(20, 1000.0 + 0.0j)),
        soaked("fractional-kelvin", 1000.0 + 50.0 * (1j * OMEGA) ** 0.5),
    ],
)
def test_the_model_that_made_the_data_is_the_simplest(name, stiffness):
    ranking = springpot.compare(
        springpot.Measurement(OMEGA, stiffness, units=springpot.Units("Pa", "-"))
    )
    assert ranking.best.model.name == name
    assert ranking.best.adequate
    assert "that of arithmetic" in ranking.best.says
    assert "noise" not in ranking.says
