"""One case of a stratum: what a tool may see, and the truth about it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from hidden_effects.bases import Complex, Real, Sweep
from hidden_effects.cases import Truth, expression, hide_in, write_table
from hidden_effects.fit import Network, refit
from hidden_effects.scaling import NotVisible
from hidden_effects.setup import draw_base, draw_sweep

CLEAR = (60.0, 3000.0)
"""Chi-square left by the base model: from what the goals call nameable to what an eye sees."""
QUIET, LOUD = 1e-3, 0.03
"""Relative noise of each part, as in the other designs."""


@dataclass(frozen=True, kw_only=True)
class StratumCase:
    """What is true of a case of a stratum.

    ``kind`` is "nothing", "one" (a library effect, or a cause, is missing), "two" or "three" (so
    many are), "outside" (something that has no name) or "base" (the model's own spectrum is wrong);
    ``right`` holds every name that is a right answer, ``own`` the chi-square left without each of
    several. ``floor`` is the relative rms error per complex point of the noise alone, NaN where
    that is not what an answer tells; ``chi2`` is what the best refitted model leaves of the
    noise-free data. ``material`` is a second model that is asked for.
    """

    seed: int
    stratum: str
    detail: str
    kind: str
    model: str
    floor: float
    right: tuple[str, ...] = ()
    chi2: float = 0.0
    parameters: dict[str, float] = field(default_factory=dict)
    own: tuple[float, ...] = ()
    material: str | None = None

    @property
    def name(self) -> str:
        """A name for files and tables."""
        return f"{self.seed:06d}-{self.stratum}-{self.detail}-{self.kind}"

    def summary(self) -> dict[str, Any]:
        """Return the truth as plain JSON values."""
        return {
            "seed": self.seed,
            "name": self.name,
            "kind": self.kind,
            "design": self.stratum,
            "detail": self.detail,
            "model": self.model,
            "truth": list(self.right),
            "parameters": [self.parameters],
            "own_chi2": list(self.own) or [self.chi2],
            "chi2": self.chi2,
            "floor": self.floor,
        }


@dataclass(frozen=True, kw_only=True)
class Drawn(StratumCase):
    """A measurement of a stratum. Frequencies in rad/s, stiffness in kN/m, amplitude in mm.

    ``network`` names the true spectrum where that is not the model's; ``material_chi2`` is what any
    passive spectrum leaves of the noise-free data, where that was asked.
    """

    sweep: Sweep
    K: Complex
    K_true: Complex
    sd: Real | None = None
    digits: int = 10
    third: Complex | None = None
    network: str = ""
    material_chi2: float | None = None
    material_right: tuple[str, ...] = ()

    def columns(self) -> dict[str, np.ndarray]:
        """Return the columns of the CSV file by header, rows in measuring order."""
        out = columns_of(self.sweep, self.K)
        optional = {
            "storage_sd [kN/m]": self.sd,
            "loss_sd [kN/m]": self.sd,
            "repeat": self.sweep.repeat,
            "h3_re [-]": None if self.third is None else self.third.real,
            "h3_im [-]": None if self.third is None else self.third.imag,
        }
        return out | {name: values for name, values in optional.items() if values is not None}

    def to_csv(self, path: str | Path) -> Path:
        """Write what a tool may see, and nothing of the truth."""
        return write_table(
            self.columns(), path, {"storage [kN/m]": self.digits, "loss [kN/m]": self.digits}
        )

    def summary(self) -> dict[str, Any]:
        """Return the truth as plain JSON values."""
        sigma = "unknown" if self.sweep.repeat is None else "repeats"
        return super().summary() | {
            "network": self.network,
            "material_chi2": self.material_chi2,
            "material_truth": list(self.material_right),
            "points": len(self.sweep),
            "harmonics": self.third is not None,
            "sigma": sigma if self.sd is None else "given",
        }


def columns_of(sweep: Sweep, k: Complex) -> dict[str, np.ndarray]:
    """The columns of a sweep by header, rows in measuring order."""
    out = {"frequency [Hz]": sweep.omega / (2.0 * np.pi)}
    out |= {"storage [kN/m]": k.real, "loss [kN/m]": k.imag}
    optional = {"temperature [degC]": sweep.temperature, "amplitude [mm]": sweep.amplitude}
    return out | {name: values for name, values in optional.items() if values is not None}


Noise = Callable[[np.random.Generator, Sweep, Complex], dict[str, float]]


@dataclass(frozen=True)
class Specimen:
    """A base model on a sweep, with the noise-free stiffness of one hidden effect or of none."""

    sweep: Sweep
    network: Network
    theta: Real
    noise: dict[str, float]
    truth: Truth

    @property
    def model(self) -> str:
        """The model that the user believes in."""
        return self.truth.model or expression(self.network)

    @property
    def right(self) -> tuple[str, ...]:
        """Names of what is hidden."""
        return tuple(hidden.name for hidden in self.truth.hidden)

    @property
    def kind(self) -> str:
        """Return "nothing" or "one"."""
        return "one" if self.truth.hidden else "nothing"

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters of what is hidden."""
        return self.truth.hidden[0].parameters if self.truth.hidden else {}


def draw_specimen(
    rng: np.random.Generator, design: str, hidden: bool, noise: Noise, repeats: int = 1
) -> Specimen:
    """Draw sweep, base and at most one effect of clear size.

    ``noise`` gives ``relative`` and ``force``.

    Raises
    ------
    NotVisible
        If the drawn effect cannot be seen in such data.
    """
    sweep = draw_sweep(rng, design, repeats, strain=False)
    network, theta = draw_base(rng, sweep)
    bare = network.stiffness(sweep, theta)
    level = noise(rng, sweep, bare)
    truth = Truth(bare, 0.0)
    if hidden:
        target = float(np.exp(rng.uniform(*np.log(CLEAR))))
        truth = hide_in(rng, sweep, network, theta, level, target, 1)
    return Specimen(sweep, network, theta, level, truth)


def relative_level(low: float = QUIET, high: float = LOUD) -> Noise:
    """Noise proportional to |K|, its level even in the logarithm."""
    return lambda rng, sweep, k: {"relative": log_uniform(rng, low, high), "force": 0.0}


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """A number even in the logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def white(rng: np.random.Generator, count: int) -> Complex:
    """Complex normal numbers whose parts have unit variance."""
    return rng.standard_normal(count) + 1j * rng.standard_normal(count)


def pick_design(rng: np.random.Generator) -> str:
    """One sweep or a field, half each."""
    return "sweep" if rng.random() < 0.5 else "field"


def level_for(
    rng: np.random.Generator,
    network: Network,
    start: Real,
    sweep: Sweep,
    k: Complex,
    low: float,
    high: float,
) -> tuple[float, float]:
    """Relative noise at which the refitted ``network`` leaves a clear chi-square of ``k``.

    Both are returned.

    It is the noise that is scaled, not the effect: chi-square goes exactly as one over its square.

    Raises
    ------
    NotVisible
        If that takes noise outside of ``low`` to ``high``.
    """
    at_one_per_cent = refit(network, start, sweep, k, 0.01 * np.abs(k), 150)[1]
    target = float(np.exp(rng.uniform(*np.log(CLEAR))))
    level = 0.01 * float(np.sqrt(at_one_per_cent / target))
    if not low <= level <= high:
        raise NotVisible
    return level, target
