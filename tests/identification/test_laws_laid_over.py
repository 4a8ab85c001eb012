"""The search for laws of temperature begins where overlapping sweeps lie over one another."""

from __future__ import annotations

import numpy as np
import pytest

import springpot
from springpot.identification import identify

NOISE = 0.004
MODEL = springpot.parse_model("material + wlf-shift + vertical-shift")


def sweeps(seed, c1, c2):
    """A broad spectrum at six temperatures: times by WLF, moduli by the temperature."""
    celsius = np.repeat([0.0, 10.0, 20.0, 40.0, 60.0, 80.0], 12)
    omega = np.tile(2.0 * np.pi * np.geomspace(0.1, 30.0, 12), 6)
    away = celsius - 20.0
    s = 1j * omega * 10.0 ** (-c1 * away / (c2 + away))
    lines = zip(10.0 ** np.linspace(0.0, 2.5, 20), 10.0 ** np.linspace(-6.0, 10.0, 20), strict=True)
    exact = (1.0 + sum(g * s / (s + r) for g, r in lines)) * (celsius + 273.15) / 293.15
    scatter = NOISE * np.random.default_rng(seed).normal(size=(2, 72))
    measured = exact * (1.0 + scatter[0] + 1j * scatter[1])
    return springpot.Measurement(omega, measured, conditions={"temperature": celsius})


@pytest.mark.soak
@pytest.mark.parametrize(
    ("seed", "c1", "c2"), [(0, 15.0, 60.0), (1, 15.0, 60.0), (0, 10.0, 40.0), (2, 10.0, 40.0)]
)
def test_two_laws_of_temperature_are_found_together(seed, c1, c2):
    assert identify(sweeps(seed, c1, c2), MODEL).relative_rms < np.sqrt(2.0) * NOISE
