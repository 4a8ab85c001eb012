"""The stratum of what real files do: files as an instrument writes them, read by their headers.

A step that took its time, a specimen that hung loose, a melt that flows, a force counted the other
way, a specimen that changes while it is measured, a calibration shared by rows, rows that are
missing, conditions that moved together. What is hidden is an effect of the library, or a cause
that is none: then an answer must tell it in a note or propose what mends it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from hidden_effects.bases import Real, Sweep
from hidden_effects.cases import expression, hide_in, write_table
from hidden_effects.fit import refit
from hidden_effects.scaling import NotVisible
from hidden_effects.setup import draw_base, draw_sweep
from hidden_effects.strata.drawn import (
    CLEAR,
    StratumCase,
    columns_of,
    log_uniform,
    relative_level,
    white,
)
from hidden_effects_time.physics import Stiffness, creep, inverse, material, relaxation, to_history

LEVEL = (0.002, 0.02)
"""Noise: of a record as a share of its largest value, of K as a share of |K|."""
SAMPLES = (80, 300)
BASES = {
    "zener": ("k1", "k2", "c"),
    "fractional-kelvin": ("k", "c", "alpha"),
    "fractional-zener": ("k1", "k2", "c", "alpha"),
}
"""Models of a solid, with their parameters."""


@dataclass(frozen=True, kw_only=True)
class Written(StratumCase):
    """A file, and what is true of it.

    Where the cause is no effect, one of the words of ``told`` must stand in a note or in what is
    proposed.
    """

    columns: dict[str, np.ndarray]
    told: tuple[str, ...] = ()
    floor: float = nan
    kind: str = "one"
    stratum: str = "measured"

    def to_csv(self, path: str | Path) -> Path:
        """Write what a tool may see, and nothing of the truth; a gap as n/a."""
        written = write_table(self.columns, path)
        written.write_text(written.read_text("utf-8").replace("nan", "n/a"), encoding="utf-8")
        return written

    def summary(self) -> dict[str, Any]:
        """Return the truth as plain JSON values."""
        points = len(next(iter(self.columns.values())))
        return super().summary() | {"told": list(self.told), "points": points}


def measured(seed: int, rng: np.random.Generator) -> Written:
    """One file; what is the matter with it takes turns."""
    return MATTERS[seed % len(MATTERS)](seed, rng)


# --- tests in time


@dataclass(frozen=True)
class Solid:
    """A solid of one of the bases, with times near one second."""

    base: str
    theta: dict[str, float]

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> Solid:
        """Any of them."""
        base, alpha = str(rng.choice(list(BASES))), float(rng.uniform(0.25, 0.75))
        k, soft = log_uniform(rng, 10.0, 1000.0), float(rng.uniform(0.1, 0.6))
        tau = log_uniform(rng, 0.3, 3.0)
        rubber, glass = ("k", "") if base == "fractional-kelvin" else ("k1", "k2")
        order = alpha if "alpha" in BASES[base] else 1.0
        known = {rubber: soft * k, glass: k, "c": k * tau**order, "alpha": alpha}
        return cls(base, {name: known[name] for name in BASES[base]})

    @property
    def law(self) -> Stiffness:
        """K(s)."""
        return material(self.base, self.theta)

    def left(self, shown: Callable[[Stiffness], Real], exact: Real, sd: float) -> float:
        """The least chi-square of this base over what is shown without noise."""
        names = BASES[self.base]
        linear = np.array([name == "alpha" for name in names])
        start = np.array([self.theta[name] for name in names])
        begin = np.where(linear, start, np.log(start))

        def missed(u: Real) -> Real:
            values = np.where(linear, u, np.exp(np.where(linear, 0.0, u)))
            theta = dict(zip(names, values.tolist(), strict=True))
            return (shown(material(self.base, theta)) - exact) / sd

        low, high = np.where(linear, 0.01, begin - 12.0), np.where(linear, 0.99, begin + 12.0)
        return 2.0 * float(least_squares(missed, begin, bounds=(low, high)).cost)


def _recorded(
    rng: np.random.Generator,
    solid: Solid,
    columns: dict[str, Real],
    answer: str,
    exact: Real,
    ideal: Callable[[Stiffness], Real],
    **truth: Any,
) -> Written:
    """A file whose column ``answer`` is the exact one in noise.

    ``ideal`` is what a material would show if nothing were the matter.

    Raises
    ------
    NotVisible
        If no eye, or any, would see what is the matter.
    """
    sd = log_uniform(rng, *LEVEL) * float(np.max(np.abs(exact)))
    seen = exact + sd * rng.standard_normal(len(exact))
    chi2 = _clear(solid.left(ideal, exact, sd))
    return Written(model=solid.base, columns=columns | {answer: seen}, chi2=chi2, **truth)


def _clear(chi2: float) -> float:
    """A chi-square from what a goal asks of to ten times what an eye sees.

    Raises
    ------
    NotVisible
        If it is smaller or larger.
    """
    if not CLEAR[0] <= chi2 <= 10.0 * CLEAR[1]:
        raise NotVisible
    return chi2


def _times(rng: np.random.Generator) -> Real:
    return np.geomspace(0.01, 100.0, int(log_uniform(rng, *SAMPLES)))


def _ramp(seed: int, rng: np.random.Generator) -> Written:
    """A relaxation whose step took its time, counted from when it began."""
    solid, t = Solid.drawn(rng), _times(rng)
    rise = log_uniform(rng, 0.03, 1.0)
    exact = inverse(lambda s: solid.law(s) / s**2, t)
    after = t > rise
    exact[after] -= inverse(lambda s: solid.law(s) / s**2, t[after] - rise)
    return _recorded(
        rng,
        solid,
        {"time [s]": t},
        "relaxation [N/mm]",
        exact / rise,
        lambda law: relaxation(law, t),
        seed=seed,
        detail="ramp",
        right=("finite-ramp",),
        told=("still made",),
        parameters={"rise": rise},
    )


def _slack(seed: int, rng: np.random.Generator) -> Written:
    """A ramp and a hold, of which the specimen feels nothing until it is taut."""
    solid = Solid.drawn(rng)
    t = np.linspace(0.0, 20.0, int(log_uniform(rng, *SAMPLES)))
    x = np.minimum(t / float(rng.uniform(1.0, 4.0)), 1.0)
    loose = float(rng.uniform(0.05, 0.5))
    return _recorded(
        rng,
        solid,
        {"time [s]": t, "displacement [mm]": x},
        "force [N]",
        to_history(solid.law, t, np.maximum(x - loose, 0.0)),
        lambda law: to_history(law, t, x),
        seed=seed,
        detail="slack",
        right=("slack",),
        parameters={"loose": loose},
    )


def _flow(seed: int, rng: np.random.Generator) -> Written:
    """The creep of what flows, asked as a solid."""
    solid, t = Solid.drawn(rng), _times(rng)
    ideal = creep(solid.law, t)
    viscosity = float(t[-1] / (ideal[-1] * log_uniform(rng, 0.02, 2.0)))
    return _recorded(
        rng,
        solid,
        {"time [s]": t},
        "compliance [mm/N]",
        ideal + t / viscosity,
        lambda law: creep(law, t),
        seed=seed,
        detail="flow",
        right=("series-dashpot",),
        parameters={"c": viscosity},
    )


def _sign(seed: int, rng: np.random.Generator) -> Written:
    """A record whose force counts against the displacement."""
    solid = Solid.drawn(rng)
    t = np.linspace(0.0, 30.0, int(log_uniform(rng, 200, 600)))
    x = np.sin(float(rng.uniform(0.7, 1.6)) * t)
    exact = -to_history(solid.law, t, x)
    sd = log_uniform(rng, *LEVEL) * float(np.max(np.abs(exact)))
    seen = exact + sd * rng.standard_normal(len(exact))
    return Written(
        seed=seed,
        detail="sign",
        model=solid.base,
        columns={"time [s]": t, "displacement [mm]": x, "force [N]": seen},
        told=("other way",),
        # No passive material pushes back: none of it can be taken.
        chi2=float(np.sum(exact**2)) / sd**2,
    )


# --- sweeps


def _drift(seed: int, rng: np.random.Generator) -> Written:
    """A specimen that changes while a sweep is made three times, by its own clock."""
    once = draw_sweep(rng, "sweep", 1, strain=False)
    sweep = Sweep(np.tile(once.omega, 3), None, None, None)
    network, theta = draw_base(rng, sweep)
    level = log_uniform(rng, 0.001, 0.01)
    time = np.cumsum(5.0 + 12.0 * np.pi / sweep.omega)
    tau = float(rng.uniform(0.3, 3.0)) * time[-1]
    size = level * float(rng.uniform(4.0, 40.0)) * float(rng.choice([-1.0, 1.0]))
    k = network.stiffness(sweep, theta) * (1.0 + size * (1.0 - np.exp(-time / tau)))
    sigma = level * np.abs(k)
    return Written(
        seed=seed,
        detail="drift",
        model=expression(network),
        columns=columns_of(sweep, k + sigma * white(rng, k.size)) | {"time [s]": time},
        told=("time", "specimen", "round"),
        chi2=_clear(refit(network, theta, sweep, k, sigma, 150)[1]),
        parameters={"size": size, "tau": tau},
        floor=float(np.sqrt(2.0)) * level,
    )


def _calibration(seed: int, rng: np.random.Generator) -> Written:
    """A field whose sweeps were made on two geometries, of which one is wrong by some percent."""
    sweep = draw_sweep(rng, "field", 1, strain=False)
    network, theta = draw_base(rng, sweep)
    level = log_uniform(rng, 0.002, 0.01)
    lines = np.arange(len(sweep)) // len(np.unique(sweep.omega))
    plates = 25.0 - 17.0 * (rng.permutation(int(lines[-1]) + 1) % 2)[lines]
    size = level * float(rng.uniform(3.0, 20.0)) * float(rng.choice([-1.0, 1.0]))
    k = network.stiffness(sweep, theta) * np.where(plates < 20.0, 1.0 + size, 1.0)
    sigma = level * np.abs(k)
    return Written(
        seed=seed,
        detail="calibration",
        model=expression(network),
        columns=columns_of(sweep, k + sigma * white(rng, k.size)) | {"plates": plates},
        told=("goes with plates",),
        chi2=_clear(refit(network, theta, sweep, k, sigma, 150)[1]),
        parameters={"gain": size},
        floor=float(np.sqrt(2.0)) * level,
    )


def _missing(seed: int, rng: np.random.Generator) -> Written:
    """A field with an effect, of which a third of the rows is gone and some cells are blank."""
    sweep = draw_sweep(rng, "field", 1, strain=False)
    kept = np.sort(rng.permutation(len(sweep))[: int(len(sweep) * rng.uniform(0.6, 0.8))])
    written = _with_one(seed, rng, "missing", _rows(sweep, kept))
    blank = rng.permutation(kept.size)[: int(rng.integers(1, 5))]
    written.columns["loss [kN/m]"][blank] = np.nan
    return written


def _confounded(seed: int, rng: np.random.Generator) -> Written:
    """A sweep whose amplitude falls as the frequency rises, as a shaker's does."""
    sweep = draw_sweep(rng, "sweep", 1, strain=False)
    power = float(rng.uniform(0.3, 1.0))
    top = log_uniform(rng, 0.1, 5.0)
    amplitude = top * (sweep.omega / sweep.omega.min()) ** -power
    return _with_one(seed, rng, "confounded", Sweep(sweep.omega, None, amplitude, None))


def _rows(sweep: Sweep, kept: np.ndarray) -> Sweep:
    assert sweep.temperature is not None
    assert sweep.amplitude is not None
    return Sweep(sweep.omega[kept], sweep.temperature[kept], sweep.amplitude[kept], None)


def _with_one(seed: int, rng: np.random.Generator, detail: str, sweep: Sweep) -> Written:
    """A sweep from which one effect is missing."""
    network, theta = draw_base(rng, sweep)
    noise = relative_level(*LEVEL)(rng, sweep, network.stiffness(sweep, theta))
    truth = hide_in(rng, sweep, network, theta, noise, log_uniform(rng, *CLEAR), 1)
    k, sigma = truth.stiffness, noise["relative"] * np.abs(truth.stiffness)
    return Written(
        seed=seed,
        detail=detail,
        model=truth.model,
        columns=columns_of(sweep, k + sigma * white(rng, k.size)),
        right=tuple(hidden.name for hidden in truth.hidden),
        chi2=truth.chi2,
        parameters=truth.hidden[0].parameters,
        floor=float(np.sqrt(2.0)) * noise["relative"],
    )


MATTERS: tuple[Callable[[int, np.random.Generator], Written], ...] = (
    _ramp,
    _slack,
    _flow,
    _sign,
    _drift,
    _calibration,
    _missing,
    _confounded,
)
