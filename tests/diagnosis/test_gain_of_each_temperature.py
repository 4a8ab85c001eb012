"""A specimen that was clamped anew at each temperature.

A gain of its own at each, which no law joins.
"""

import numpy as np
import pytest

import springpot
from springpot.cli.diagnose import _next_command
from springpot.diagnosis import diagnose

MODEL = "material + wlf-shift"
EFFECTS = (
    "free-shift",
    "free-vertical-shift",
    "vertical-shift",
    "arrhenius-dashpot",
    "time-delay",
    "inertia",
)


@pytest.fixture(scope="module")
def found():
    rng = np.random.default_rng(1)
    celsius, hertz = np.repeat(np.linspace(0.0, 70.0, 8), 8), np.tile(np.geomspace(0.1, 30.0, 8), 8)
    s = 2j * np.pi * hertz * 10.0 ** (-8.0 * (celsius - 35.0) / (90.0 + celsius - 35.0))
    gain = np.repeat(1.0 + 0.02 * rng.normal(size=8), 8)
    real, imaginary = 0.003 * rng.normal(size=(2, len(s)))
    stiffness = (
        gain * (2.0 + 1.0 / (1.0 / 400.0 + 1.0 / (30.0 * s**0.5))) * (1.0 + real + 1j * imaginary)
    )
    data = springpot.Measurement(
        2.0 * np.pi * hertz,
        stiffness,
        conditions={"temperature": celsius},
        units=springpot.Units("kN/m", "mm"),
    )
    effects = [springpot.plugins().effect(name) for name in EFFECTS]
    return diagnose(data, springpot.parse_model(MODEL), effects, np.random.default_rng(0))


@pytest.mark.soak
def test_no_law_explains_it_and_a_factor_at_each_takes_it_to_the_noise(found):
    assert found.verdict == "unexplained"
    assert found.leading == ("free-vertical-shift",)
    assert "free-vertical-shift takes it to" in found.says
    assert "a factor of its own at each temperature, which no law joins" in found.says


@pytest.mark.soak
def test_the_next_command_accepts_it(found):
    command = _next_command(found, ["steps.csv"], MODEL, ["steps.csv"])
    assert command == f"springpot discover steps.csv --model '{MODEL}' --accept free-vertical-shift"
