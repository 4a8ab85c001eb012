"""Where no law joins the times of several temperatures, the advice gives a command that works."""

import re

import numpy as np
import pytest

import springpot

CELSIUS = np.repeat([20.0, 25.0, 30.0, 35.0, 40.0, 45.0], 16)
OMEGA = np.tile(np.geomspace(0.1, 10.0, 16), 6)
SLOWER = np.repeat([1.0, 0.3, 0.2, 0.01, 0.008, 0.001], 16)


SHIFTS = ["free-shift", "arrhenius-shift", "wlf-shift", "vertical-shift", "inertia"]


@pytest.fixture(scope="module")
def gelling():
    """A gel that hardens as it is heated: all its times grow, as by no law of temperature."""
    real, imaginary = 0.003 * np.random.default_rng(1).normal(size=(2, len(OMEGA)))
    stiffness = 2000.0 / (1.0 + (2j * OMEGA / SLOWER) ** -0.3) * (1.0 + real + 1j * imaginary)
    return springpot.Measurement(
        OMEGA, stiffness, conditions={"temperature": CELSIUS}, units=springpot.Units("Pa", "-")
    )


@pytest.mark.soak
def test_a_factor_at_each_level_can_be_accepted(gelling):
    ladder = springpot.discover(gelling, accept=["free-shift"])
    assert [step.accepted for step in ladder.steps] == [None, "free-shift"]
    assert ladder.steps[-1].relative_rms < 0.005


@pytest.mark.soak
def test_they_are_named_before_a_law_that_leaves_most(gelling):
    """A power of the temperature takes half of the error.

    A factor of the times at each takes all of it.
    """
    found = springpot.diagnose(gelling)
    assert found.leading[0] == "free-shift"
    told = re.search(
        r"free-shift takes it to ([\d.]+) x: a factor of its own at each temperature", found.says
    )
    assert told is not None
    assert float(told[1]) < 1.2


@pytest.mark.soak
def test_nothing_is_accepted_unasked_in_their_place(gelling):
    assert [step.accepted for step in springpot.discover(gelling, only=SHIFTS).steps] == [None]
