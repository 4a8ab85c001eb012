"""To look at one test alone is advised where rows of several stand together, and nowhere else."""

import numpy as np
import pytest

import springpot
from springpot.misfit.floor import fitted_to_floor
from springpot.misfit.residual_causes import column_behind, one_test_of

CELSIUS = np.repeat(np.linspace(0.0, 50.0, 6), 8)
OMEGA = 2.0 * np.pi * np.tile(np.geomspace(0.1, 30.0, 8), 6)


def table(rng, name, number, gain=1.0):
    """A fractional Kelvin element whose times vary with temperature, unknown to the model."""
    stiffness = gain * (60.0 + 40.0 * (1j * OMEGA * np.exp(-0.05 * (CELSIUS - 25.0))) ** 0.4)
    real, imaginary = 0.003 * rng.normal(size=(2, len(OMEGA)))
    return springpot.Measurement(
        OMEGA,
        stiffness * (1.0 + real + 1j * imaginary),
        conditions={"temperature": CELSIUS, name: number},
    )


def advice(data):
    column = column_behind(
        fitted_to_floor(springpot.parse_model("fractional-kelvin"), data).frame()
    )
    return one_test_of(data, column)


@pytest.mark.parametrize("name", ["set", "step"])
def test_the_number_of_a_temperature_is_not_blamed_for_what_the_temperature_did(name):
    assert advice(table(np.random.default_rng(1), name, np.repeat(np.arange(6.0), 8))) == ("", "")


def test_two_specimens_that_differ_are_looked_at_one_by_one():
    number = np.tile(np.repeat([1001.0, 1002.0], 4), 6)
    gain = np.where(number == 1001.0, 1.0, 2.0)
    one_test, why = advice(table(np.random.default_rng(1), "specimen", number, gain))
    assert one_test in {"specimen=1001", "specimen=1002"}
    assert "specimen" in why
