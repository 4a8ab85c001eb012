"""Of a material's times there is one law.

What a second one would mend is no physics of the material.
"""

import numpy as np
import pytest

import springpot
from springpot.diagnosis.grown import _second_law
from springpot.registry import plugins

FREQUENCY = np.geomspace(0.05, 50.0, 16)
TEMPERATURE = np.repeat([5.0, 20.0, 35.0, 50.0, 65.0], FREQUENCY.size)
OMEGA = np.tile(2.0 * np.pi * FREQUENCY, 5)


def measured(misread=0.0, seed=2):
    """A fractional solid that follows WLF; one temperature is misread by so many kelvin."""
    true = TEMPERATURE + np.where(TEMPERATURE == 50.0, misread, 0.0)
    shift = 10.0 ** (-12.0 * (true - 20.0) / (70.0 + true - 20.0))
    stiffness = 2e4 + 3e4 * (1j * OMEGA * shift) ** 0.35
    noise = np.random.default_rng(seed).normal(size=(2, OMEGA.size))
    disturbed = stiffness * (1.0 + 0.004 * (noise[0] + 1j * noise[1]))
    return springpot.Measurement(
        OMEGA, disturbed, conditions={"temperature": TEMPERATURE}, name="melt"
    )


def effects(*names):
    return [plugins().effect(name) for name in names]


@pytest.mark.parametrize(
    ("first", "second", "is_one"),
    [
        ("wlf-shift", "arrhenius-shift", True),
        ("wlf-shift", "vertical-shift", False),
        ("wlf-shift", "self-heating", False),
        ("inertia", "wlf-shift", False),
    ],
)
def test_a_second_law_is_one_of_the_same_condition(first, second, is_one):
    own, other = effects(first, second)
    assert _second_law([own], other) is is_one


@pytest.mark.soak_cases("1.5", "0.0")
@pytest.mark.parametrize("misread", [0.0, 1.5])
def test_a_misread_temperature_is_no_second_law(misread):
    found = springpot.diagnose(measured(misread), "fractional-kelvin-voigt")
    assert found.leading[0] == "wlf-shift"
    assert "beside it arrhenius-shift" not in found.says
