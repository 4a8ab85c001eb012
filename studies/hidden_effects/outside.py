"""Disturbances that no effect of a library explains.

Each is a multiplicative pattern whose size is scaled later.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hidden_effects.bases import Complex, Real, Sweep

Pattern = Callable[[Complex, float], Complex]


def _where(sweep: Sweep, rng: np.random.Generator, margin: float) -> float:
    """A frequency away from the ends of the window."""
    low, high = np.log(sweep.omega.min()), np.log(sweep.omega.max())
    return float(np.exp(rng.uniform(low + margin * (high - low), high - margin * (high - low))))


def gain_step(sweep: Sweep, rng: np.random.Generator) -> tuple[Pattern, dict[str, float]]:
    """A transducer range is switched at one frequency: the gain jumps there."""
    switch, sign = _where(sweep, rng, 0.25), float(rng.choice([-1.0, 1.0]))
    above = sign * (sweep.omega > switch)
    return (lambda k, size: k * (1.0 + size * above)), {"omega": switch, "sign": sign}


def ripple(sweep: Sweep, rng: np.random.Generator) -> tuple[Pattern, dict[str, float]]:
    """Magnitude and phase ripple in ln omega, one to four waves over the window."""
    x = np.log(sweep.omega)
    waves, start, tilt = (
        rng.uniform(1.2, 4.0),
        rng.uniform(0.0, 2.0 * np.pi),
        rng.uniform(-1.0, 1.0),
    )
    turn = 2.0 * np.pi * waves * (x - x.min()) / np.ptp(x) + start
    wave = np.cos(turn) + 1j * tilt * np.sin(turn)
    return (lambda k, size: k * (1.0 + size * wave)), {"waves": float(waves), "tilt": float(tilt)}


def notch(sweep: Sweep, rng: np.random.Generator) -> tuple[Pattern, dict[str, float]]:
    """An antiresonance beside a resonance, fixed in Hz.

    A fixture mode seen by the force channel only in part.
    """
    centre, zeta = _where(sweep, rng, 0.2), float(rng.uniform(0.04, 0.15))
    r = sweep.omega / centre

    def pattern(k: Complex, size: float) -> Complex:
        split = (1.0 + min(size, 3.0)) ** 2
        return k * (1.0 - r**2 + 2j * zeta * r) / (1.0 - r**2 / split + 2j * zeta * r)

    return pattern, {"omega": centre, "zeta": zeta}


def drift(sweep: Sweep, rng: np.random.Generator) -> tuple[Pattern, dict[str, float]]:
    """The gain creeps with the time of measurement (row by row), whatever the frequency."""
    order = np.arange(len(sweep)) / max(len(sweep) - 1, 1)
    tau, sign = float(rng.uniform(0.15, 0.6)), float(rng.choice([-1.0, 1.0]))
    creep = sign * (1.0 - np.exp(-order / tau))
    return (lambda k, size: k * (1.0 + size * creep)), {"tau": tau, "sign": sign}


def correlated_noise(sweep: Sweep, rng: np.random.Generator) -> tuple[Pattern, dict[str, float]]:
    """One smooth random error per sweep in ln omega, on top of the white noise of the data."""
    spacing = float(np.median(np.diff(np.unique(np.log(sweep.omega)))))
    length = max(float(rng.uniform(0.3, 1.0)), 2.0 * spacing)
    field = np.zeros(len(sweep), dtype=complex)
    series = sweep.series()
    for number in range(series.max() + 1):
        rows = np.flatnonzero(series == number)
        x = np.log(sweep.omega[rows])
        cover: Real = np.exp(-0.5 * ((x[:, None] - x[None, :]) / length) ** 2) + 1e-9 * np.eye(
            rows.size
        )
        root = np.linalg.cholesky(cover)
        field[rows] = root @ rng.standard_normal(rows.size) + 1j * (
            root @ rng.standard_normal(rows.size)
        )
    return (lambda k, size: k * (1.0 + size * field)), {"length": length}


OUTSIDE = {
    "gain-step": gain_step,
    "ripple": ripple,
    "notch": notch,
    "drift": drift,
    "correlated-noise": correlated_noise,
}
ASYMMETRY = "asymmetric-spectrum"


def havriliak_negami(s: Complex, p: Real, size: float) -> Complex:
    """Fractional Zener (ke, k, c, alpha) with a skewed spectrum.

    The inner exponent 1 becomes exp(-size).
    """
    ke, k, c, alpha = p
    return ke + k - k * (1.0 + (c / k) * s**alpha) ** (-np.exp(-size))
