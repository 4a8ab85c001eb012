"""Data with a law that no library has."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from springpot import Measurement, Units
from springpot.rheology.points import Complex, Real

OMEGA = np.tile(2.0 * np.pi * np.geomspace(0.5, 50.0, 8), 6)
AMPLITUDE = np.repeat(np.geomspace(0.1, 5.0, 6), 8)


def material(omega: Real) -> Complex:
    """A fractional Maxwell element beside a spring, in kN/m."""
    s = (1j * omega) ** 0.5
    return 50.0 + 400.0 * 60.0 * s / (400.0 + 60.0 * s)


def swept(
    law: Callable[[Complex, Real], Complex], noise: float = 0.005, seed: int = 1, **more: Any
) -> Measurement:
    """K of the material with a law of it and of the amplitude."""
    exact = law(material(OMEGA), AMPLITUDE)
    draws = noise * np.random.default_rng(seed).normal(size=(2, len(OMEGA))) * np.abs(exact)
    known = {"conditions": {"amplitude": AMPLITUDE}, "units": Units("kN/m", "mm"), "name": "made"}
    return Measurement(OMEGA, exact + draws[0] + 1j * draws[1], **(known | more))


def lossy(k: Complex, x: Real) -> Complex:
    """A loss that falls as X^-0.6."""
    return k + 20j * x**-0.6
