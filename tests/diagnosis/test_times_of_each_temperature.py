"""A temperature that was not what the file says: the times of one level are off, not its gain."""

import numpy as np
import pytest

import springpot

CELSIUS = np.repeat([0.0, 15.0, 30.0, 45.0], 8)
OMEGA = 2.0 * np.pi * np.tile(np.geomspace(0.1, 50.0, 8), 4)
MODEL = "fractional-zener + arrhenius-shift"


def told(true_celsius, gain, seed=0):
    """The notes on what is missing from a solid of 60 kJ/mol."""
    times = np.exp(60e3 / 8.314 * (1.0 / (true_celsius + 273.15) - 1.0 / 288.15))
    springpot_part = 0.8 * (1j * OMEGA * times) ** 0.6
    exact = 1.0 + 6.0 * springpot_part / (6.0 + springpot_part)
    noise = 0.008 * np.random.default_rng(seed).normal(size=(2, len(OMEGA)))
    stiffness = gain * exact * (1.0 + noise[0] + 1j * noise[1])
    data = springpot.Measurement(
        OMEGA,
        stiffness,
        conditions={"temperature": CELSIUS},
        units=springpot.Units("MPa", "%"),
    )
    found = springpot.diagnose(data, MODEL, only=["wlf-shift", "inertia"])
    assert found.verdict == "unexplained"
    return " ".join(found.notes)


@pytest.mark.soak
def test_times_of_one_temperature_are_no_gain_of_the_chain():
    says = told(CELSIUS + 7.0 * (CELSIUS == 45.0), 1.0)
    assert "times of their own at each temperature" in says
    assert "a temperature that was not what the file says" in says
    assert "measuring chain" not in says


@pytest.mark.soak
def test_a_gain_of_one_temperature_is_the_chain():
    says = told(CELSIUS, 1.0 + 0.1 * (CELSIUS == 30.0))
    assert "a gain of its own at each temperature: the measuring chain" in says
