"""An effect of a plugin that gives no number is told by its name, not passed over."""

import numpy as np
import pytest

import springpot
from springpot.registry import effect_of
from springpot.rheology import RADIAN_PER_SECOND, Effect, Formula, Layer, Parameter, chain


def nowhere(at, omega_c):
    value = np.full(len(at.omega), np.nan) + 0j * omega_c
    return value, (value,), value


MUTE = Effect(
    "mute-channel",
    chain,
    Formula((Parameter("omega_c", "ω_c", RADIAN_PER_SECOND),), nowhere, kind="high-pass"),
    "a channel of which nothing is known",
    Layer.SIGNAL,
    "nobody",
)


@pytest.mark.soak
def test_an_effect_without_numbers_is_left_out_by_name(rng):
    omega = np.geomspace(1.0, 100.0, 12)
    stiffness = 100.0 + 5.0 * (1j * omega) ** 0.5 - 0.01 * omega**2
    stiffness = stiffness * (1.0 + 0.003 * (rng.normal(size=12) + 1j * rng.normal(size=12)))
    data = springpot.Measurement(omega, stiffness, units=springpot.Units("N/mm", "mm"))
    inertia = effect_of("inertia")
    found = springpot.diagnose(data, "fractional-kelvin", effects=[inertia, MUTE])
    assert found.best.effect == "inertia"
    assert "gives no number" in found.left_out["mute-channel"]
