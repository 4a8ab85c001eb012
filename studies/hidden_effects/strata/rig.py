"""Strata of narrow and periodic faults of the rig, of replicates and of rounding.

Noise of unknown size.
"""

from __future__ import annotations

import numpy as np

from hidden_effects.bases import Complex, Real
from hidden_effects.fit import refit
from hidden_effects.strata.drawn import (
    Drawn,
    Specimen,
    draw_specimen,
    pick_design,
    relative_level,
    white,
)

LOW, HIGH = 0.003, 0.02
"""Noise of notch and ripple: 0.3 to 2 % of |K| per complex point."""
PART = 1.0 / np.sqrt(2.0)


def notch(seed: int, rng: np.random.Generator) -> Drawn:
    """A dip of 15 to 35 % three points wide, with the turn of phase that belongs to it."""
    specimen = _plain(rng)
    depth, place = float(rng.uniform(0.15, 0.35)), int(rng.integers(3, len(specimen.sweep) - 3))
    turn, sharp = float(rng.uniform(-1.0, 1.0)), float(rng.uniform(0.8, 1.1))
    x = (np.arange(len(specimen.sweep)) - place) / sharp
    pattern = depth * (-1.0 + 1j * turn * x) * np.exp(-0.5 * x**2)
    return _faulty(
        seed, rng, "notch", specimen, pattern, {"depth": depth, "place": float(place), "turn": turn}
    )


def ripple(seed: int, rng: np.random.Generator) -> Drawn:
    """A ripple of 4 to 10 % in ln omega, from 1.2 waves over the window to one of five points."""
    specimen = _plain(rng)
    size, most = float(rng.uniform(0.04, 0.10)), len(specimen.sweep) / 5.0
    waves, start, tilt = (
        rng.uniform(1.2, min(most, 8.0)),
        rng.uniform(0.0, 2.0 * np.pi),
        rng.uniform(-1.0, 1.0),
    )
    x = np.log(specimen.sweep.omega)
    turn = 2.0 * np.pi * waves * (x - x.min()) / np.ptp(x) + start
    pattern = size * (np.cos(turn) + 1j * tilt * np.sin(turn))
    return _faulty(
        seed,
        rng,
        "ripple",
        specimen,
        pattern,
        {"size": size, "waves": float(waves), "tilt": float(tilt)},
    )


def _plain(rng: np.random.Generator) -> Specimen:
    """A single sweep of the bare base."""
    return draw_specimen(rng, "sweep", False, relative_level(LOW * PART, HIGH * PART))


def _faulty(
    seed: int,
    rng: np.random.Generator,
    stratum: str,
    specimen: Specimen,
    pattern: Complex,
    details: dict[str, float],
) -> Drawn:
    """The specimen seen through a factor 1 + pattern, with noise that nobody admits to."""
    k, level = specimen.truth.stiffness * (1.0 + pattern), specimen.noise["relative"]
    sigma = level * np.abs(k)
    chi2 = refit(specimen.network, specimen.theta, specimen.sweep, k, sigma, 150)[1]
    return Drawn(
        seed=seed,
        stratum=stratum,
        detail=f"noise {'below' if level < np.sqrt(LOW * HIGH) * PART else 'above'} 0.8 %",
        kind="outside",
        model=specimen.model,
        sweep=specimen.sweep,
        K=k + sigma * white(rng, k.size),
        K_true=k,
        floor=level / PART,
        chi2=chi2,
        parameters=details,
    )


def replicates(seed: int, rng: np.random.Generator) -> Drawn:
    """Two to four specimens, each with a gain of its own of 2 to 20 times the noise.

    No model of the material follows the difference of specimens, so that the floor holds their
    realised spread.
    """
    repeats = int(rng.integers(2, 5))
    specimen = draw_specimen(
        rng, pick_design(rng), seed % 2 == 1, relative_level(0.001, 0.01), repeats
    )
    level, k = specimen.noise["relative"], specimen.truth.stiffness
    spread = level * float(rng.uniform(2.0, 20.0))
    assert specimen.sweep.repeat is not None
    gains = spread * rng.standard_normal(repeats)
    gain = np.exp(gains)[specimen.sweep.repeat - 1]
    return Drawn(
        seed=seed,
        stratum="replicates",
        detail=f"gain {'below' if spread < 10.0 * level else 'above'} 10 x noise",
        kind=specimen.kind,
        model=specimen.model,
        sweep=specimen.sweep,
        K=gain * (k + level * np.abs(k) * white(rng, k.size)),
        K_true=k,
        floor=float(np.hypot(level / PART, np.std(gains))),
        right=specimen.right,
        chi2=specimen.truth.chi2,
        parameters=specimen.parameters | {"gain": spread},
    )


def rounding(seed: int, rng: np.random.Generator) -> Drawn:
    """Three significant digits, on noise smaller or larger than half a step."""
    specimen = draw_specimen(rng, pick_design(rng), seed % 2 == 1, relative_level(0.0003, 0.005))
    level, k = specimen.noise["relative"], specimen.truth.stiffness
    step = (_step(k.real) ** 2 + _step(k.imag) ** 2) / 12.0
    return Drawn(
        seed=seed,
        stratum="rounding",
        detail=f"noise {'below' if level < 0.001 else 'above'} 0.1 %",
        kind=specimen.kind,
        model=specimen.model,
        sweep=specimen.sweep,
        K=k + level * np.abs(k) * white(rng, k.size),
        K_true=k,
        floor=float(np.sqrt(np.mean(2.0 * level**2 + step / np.abs(k) ** 2))),
        right=specimen.right,
        chi2=specimen.truth.chi2,
        parameters=specimen.parameters,
        digits=3,
    )


def _step(part: Real) -> Real:
    """The step of a number printed with three significant digits."""
    return 10.0 ** (np.floor(np.log10(np.abs(part))) - 2.0)
