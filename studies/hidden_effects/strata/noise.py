"""The stratum of noise that is not white, equal in both parts and proportional to |K|."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hidden_effects.bases import Complex, Sweep
from hidden_effects.fit import refit
from hidden_effects.outside import correlated_noise
from hidden_effects.setup import deviation
from hidden_effects.strata.drawn import (
    Drawn,
    Noise,
    draw_specimen,
    log_uniform,
    pick_design,
    relative_level,
    white,
)

KINDS = ("gain", "phase", "floor", "tails", "correlated", "drift")
HONEST = KINDS[:4]
"""Kinds of noise that hold no structure: with these alone nothing is missing."""
FREEDOM = 3.0
"""Degrees of freedom of Student's t for heavy tails: the fewest whole number with a variance."""


def noise(seed: int, rng: np.random.Generator) -> Drawn:
    """One case; kinds take turns, and every second one without structure hides an effect."""
    kind = KINDS[seed % len(KINDS)]
    if kind not in HONEST:
        return _structured(seed, rng, kind)
    hidden = (seed // len(KINDS)) % 2 == 1
    level: Noise = _constant_force if kind == "floor" else relative_level()
    specimen = draw_specimen(rng, pick_design(rng), hidden, level)
    k, sweep = specimen.truth.stiffness, specimen.sweep
    sigma = deviation(specimen.noise, sweep, k)
    return Drawn(
        seed=seed,
        stratum="noise",
        detail=kind,
        kind=specimen.kind,
        model=specimen.model,
        sweep=sweep,
        K=k + sigma * _unit(kind, rng, k),
        K_true=k,
        floor=float(np.sqrt(np.mean(2.0 * sigma**2 / np.abs(k) ** 2))),
        right=specimen.right,
        chi2=specimen.truth.chi2,
        parameters=specimen.parameters | specimen.noise,
    )


def _constant_force(rng: np.random.Generator, sweep: Sweep, k: Complex) -> dict[str, float]:
    """A force resolution of up to a fifth of the least force, and a little proportional noise."""
    lever = np.ones(len(sweep)) if sweep.amplitude is None else sweep.amplitude
    worst = log_uniform(rng, 0.01, 0.2)
    return {"relative": 0.02 * worst, "force": worst * float(np.min(np.abs(k) * lever))}


def _unit(kind: str, rng: np.random.Generator, k: Complex) -> Complex:
    """Noise whose two parts have a mean variance of one."""
    if kind == "floor":
        return white(rng, k.size)
    if kind == "tails":
        parts = rng.standard_t(FREEDOM, (2, k.size)) * np.sqrt((FREEDOM - 2.0) / FREEDOM)
        return parts[0] + 1j * parts[1]
    larger, smaller = np.sqrt(2.0), np.sqrt(2.0) / rng.uniform(3.0, 20.0)
    size = (larger, smaller) if kind == "gain" else (smaller, larger)
    along = size[0] * rng.standard_normal(k.size) + 1j * size[1] * rng.standard_normal(k.size)
    return along * k / np.abs(k)


def _structured(seed: int, rng: np.random.Generator, kind: str) -> Drawn:
    """Errors that rows share.

    One smooth error a sweep, or a creep of the gain over rows measured in random order.
    """
    specimen = draw_specimen(rng, pick_design(rng), False, relative_level(0.001, 0.01))
    sweep, level = specimen.sweep, specimen.noise["relative"]
    if kind == "drift":
        order = rng.permutation(len(sweep))
        columns = {
            name: _taken(getattr(sweep, name), order)
            for name in ("temperature", "amplitude", "repeat")
        }
        sweep = replace(sweep, omega=sweep.omega[order], **columns)
        size = level * float(rng.uniform(2.0, 20.0))
        pattern = size * _creep(rng, len(sweep))
    else:
        size = level * float(rng.uniform(1.0, 5.0))
        smooth, _ = correlated_noise(sweep, rng)
        pattern = smooth(np.ones(len(sweep), dtype=complex), size) - 1.0
    k = specimen.network.stiffness(sweep, specimen.theta) * (1.0 + pattern)
    sigma = level * np.abs(k)
    return Drawn(
        seed=seed,
        stratum="noise",
        detail=kind,
        kind="outside",
        model=specimen.model,
        sweep=sweep,
        K=k + sigma * white(rng, k.size),
        K_true=k,
        floor=float(np.sqrt(2.0) * level),
        chi2=refit(specimen.network, specimen.theta, sweep, k, sigma, 150)[1],
        parameters={"relative": level, "size": size},
    )


def _taken(column: np.ndarray | None, order: np.ndarray) -> np.ndarray | None:
    return None if column is None else column[order]


def _creep(rng: np.random.Generator, count: int) -> np.ndarray:
    """A gain that creeps with the time of measurement, from zero to about one."""
    time = np.arange(count) / (count - 1)
    tau, sign = float(rng.uniform(0.15, 1.5)), float(rng.choice([-1.0, 1.0]))
    return sign * (1.0 - np.exp(-time / tau)) / (1.0 - np.exp(-1.0 / tau))
