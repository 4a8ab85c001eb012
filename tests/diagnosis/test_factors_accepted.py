"""Where no law joins the times at several temperatures: what is told leads to a command that works."""

import numpy as np
import pytest

import springpot

CELSIUS = np.repeat([20.0, 25.0, 30.0, 35.0, 40.0, 45.0], 16)
OMEGA = np.tile(np.geomspace(0.1, 10.0, 16), 6)
SLOWER = np.repeat([1.0, 0.3, 0.2, 0.01, 0.008, 0.001], 16)


@pytest.fixture(scope="module")
def gelling():
    """A gel that hardens as it is heated: all its times grow, as by no law of temperature."""
    real, imaginary = 0.003 * np.random.default_rng(1).normal(size=(2, len(OMEGA)))
    stiffness = 2000.0 / (1.0 + (2j * OMEGA / SLOWER) ** -0.3) * (1.0 + real + 1j * imaginary)
    return springpot.Measurement(
        OMEGA, stiffness, conditions={"temperature": CELSIUS}, units=springpot.Units("Pa", "-")
    )


def test_a_factor_at_each_level_can_be_accepted(gelling):
    ladder = springpot.discover(gelling, accept=["free-shift"])
    assert [step.accepted for step in ladder.steps] == [None, "free-shift"]
    assert ladder.steps[-1].relative_rms < 0.005
