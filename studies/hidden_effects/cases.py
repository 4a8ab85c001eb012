"""Draw one measurement with a known truth: ``draw_case(seed)``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from hidden_effects.bases import Complex, Real, Sweep
from hidden_effects.fit import Network
from hidden_effects.outside import ASYMMETRY, OUTSIDE, havriliak_negami
from hidden_effects.scaling import NotVisible, Plan, hide, own_chi2, pick, scale_to
from hidden_effects.setup import deviation, draw_base, draw_noise, draw_sweep

MIX = ("nothing",) * 10 + ("one",) * 16 + ("two",) * 8 + ("outside",) * 6
TARGET = {"one": (5.0, 3000.0), "two": (15.0, 6000.0), "outside": (5.0, 3000.0)}


@dataclass(frozen=True)
class Hidden:
    """One hidden effect.

    Its name, its parameters (the first is the size) and its own detectability.

    ``chi2`` is what remains, free of noise, when only this one is left out and all the rest is
    refitted.
    """

    name: str
    parameters: dict[str, float]
    chi2: float


@dataclass(frozen=True)
class Case:
    """A measurement whose truth is known.

    Frequencies in rad/s, stiffness in ``unit``, amplitude in ``length``.
    """

    seed: int
    kind: str
    design: str
    model: str
    base: dict[str, float]
    hidden: tuple[Hidden, ...]
    outside: str | None
    outside_parameters: dict[str, float]
    sweep: Sweep
    K: Complex
    K_true: Complex
    sigma: Real
    sd: Real | None
    chi2: float
    noise: dict[str, float]
    unit: str
    length: str
    in_hertz: bool
    network: Network = field(repr=False)
    theta: Real = field(repr=False)

    @property
    def name(self) -> str:
        """A name for files and tables."""
        return f"{self.seed:06d}-{self.design}-{self.kind}-{'+'.join(self.truth) or 'nothing'}"

    @property
    def truth(self) -> tuple[str, ...]:
        """Names of the hidden effects, or of the disturbance from outside the library."""
        return (self.outside,) if self.outside else tuple(h.name for h in self.hidden)

    @property
    def omega(self) -> Real:
        """Angular frequency per row."""
        return self.sweep.omega

    @property
    def temperature(self) -> Real | None:
        """Temperature per row in degC."""
        return self.sweep.temperature

    @property
    def amplitude(self) -> Real | None:
        """Amplitude per row."""
        return self.sweep.amplitude

    @property
    def repeat(self) -> np.ndarray | None:
        """Number of the repeat per row."""
        return self.sweep.repeat

    @property
    def floor(self) -> float:
        """Relative rms error per complex point that noise alone causes.

        sqrt(mean(2 sigma^2 / |K|^2)).
        """
        return float(np.sqrt(np.mean(2.0 * self.sigma**2 / np.abs(self.K_true) ** 2)))

    def columns(self) -> dict[str, np.ndarray]:
        """Return the columns of the CSV file by header."""
        x = self.sweep.omega
        out = {"frequency [Hz]": x / (2.0 * np.pi)} if self.in_hertz else {"omega [rad/s]": x}
        out |= {f"storage [{self.unit}]": self.K.real, f"loss [{self.unit}]": self.K.imag}
        if self.sd is not None:
            out |= {f"storage_sd [{self.unit}]": self.sd, f"loss_sd [{self.unit}]": self.sd}
        optional = {
            "temperature [degC]": self.sweep.temperature,
            f"amplitude [{self.length}]": self.sweep.amplitude,
            "repeat": self.sweep.repeat,
        }
        return out | {name: values for name, values in optional.items() if values is not None}

    def to_csv(self, path: str | Path) -> Path:
        """Write what a tool may see, and nothing of the truth, rows in measuring order."""
        return write_table(self.columns(), path)

    def summary(self) -> dict[str, Any]:
        """Return the truth as plain JSON values."""
        return {
            "seed": self.seed,
            "name": self.name,
            "kind": self.kind,
            "design": self.design,
            "model": self.model,
            "truth": list(self.truth),
            "parameters": [h.parameters for h in self.hidden] or [self.outside_parameters],
            "own_chi2": [h.chi2 for h in self.hidden],
            "chi2": self.chi2,
            "floor": self.floor,
            "points": len(self.sweep),
            "sigma": (
                "given"
                if self.sd is not None
                else ("repeats" if self.sweep.repeat is not None else "unknown")
            ),
            "noise": self.noise,
        }


def write_table(
    columns: dict[str, np.ndarray], path: str | Path, digits: dict[str, int] | None = None
) -> Path:
    """Write columns as CSV; ``digits`` gives the significant digits of those that are rounded."""
    places = [(digits or {}).get(name, 10) for name in columns]
    rows = zip(*columns.values(), strict=True)
    lines = [
        ",".join(columns),
        *(",".join(f"{v:.{n}g}" for v, n in zip(row, places, strict=True)) for row in rows),
    ]
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return Path(path)


def draw_case(seed: int) -> Case:
    """Return the case of this seed, always the same.

    Any 40 consecutive seeds that start at a multiple of 40 hold exactly 10 cases with nothing
    missing, 16 with one effect, 8 with two and 6 from outside the library; half of each kind are
    single sweeps.
    """
    block, place = divmod(seed, 40)
    deck = [(kind, design) for i, kind in enumerate(MIX) for design in [("sweep", "field")[i % 2]]]
    kind, design = deck[np.random.default_rng([40, block]).permutation(40)[place]]
    for attempt in range(400):
        try:
            return _attempt(seed, kind, design, np.random.default_rng([seed, attempt]))
        except NotVisible:
            continue
    raise RuntimeError(f"seed {seed}: no visible effect in 400 draws")


@dataclass(frozen=True)
class Truth:
    """The noise-free part of a case."""

    stiffness: Complex
    chi2: float
    hidden: tuple[Hidden, ...] = ()
    outside: str | None = None
    details: dict[str, float] = field(default_factory=dict)
    network: Network | None = None
    theta: Real | None = None
    model: str = ""


def _attempt(seed: int, kind: str, design: str, rng: np.random.Generator) -> Case:
    """Draw everything once; raise NotVisible where the draw does not make a case."""
    strain, known = bool(rng.random() < 0.4), bool(rng.random() < 0.5)
    repeats = int(rng.integers(2, 5)) if not known and rng.random() < 0.5 else 1
    sweep = draw_sweep(rng, design, repeats, strain)
    outside = str(rng.choice([*OUTSIDE, ASYMMETRY])) if kind == "outside" else None
    network, theta = draw_base(rng, sweep, "fractional-zener" if outside == ASYMMETRY else None)
    noise = draw_noise(rng, sweep, network.stiffness(sweep, theta))
    target = float(np.exp(rng.uniform(*np.log(TARGET[kind])))) if kind in TARGET else 0.0
    if outside:
        truth = _disturb(rng, sweep, network, theta, noise, target, outside)
    elif kind == "nothing":
        truth = Truth(network.stiffness(sweep, theta), 0.0)
    else:
        truth = hide_in(rng, sweep, network, theta, noise, target, 2 if kind == "two" else 1)
    sigma = deviation(noise, sweep, truth.stiffness)
    error = sigma * (rng.standard_normal(len(sweep)) + 1j * rng.standard_normal(len(sweep)))
    return Case(
        seed=seed,
        kind=kind,
        design=design,
        model=truth.model or expression(network),
        base=dict(zip(network.base.parameters, theta.tolist(), strict=False)),
        hidden=truth.hidden,
        outside=outside,
        outside_parameters=truth.details,
        sweep=sweep,
        K=truth.stiffness + error,
        K_true=truth.stiffness,
        sigma=sigma,
        sd=sigma if known else None,
        chi2=truth.chi2,
        noise=noise,
        unit="Pa" if strain else "kN/m",
        length="-" if strain else "mm",
        in_hertz=bool(rng.random() < 0.8),
        network=truth.network or network,
        theta=theta if truth.theta is None else truth.theta,
    )


def expression(network: Network) -> str:
    """Return the model as a user types it."""
    return network.base.name + (f" + {network.law.name}" if network.law else "")


def hide_in(
    rng: np.random.Generator,
    sweep: Sweep,
    network: Network,
    theta: Real,
    noise: dict[str, float],
    target: float,
    count: int,
) -> Truth:
    """Hide one or two effects so that the refitted base leaves ``target``."""
    plan = hide(rng, sweep, network, theta, pick(rng, sweep, network, count))
    scales = np.ones(count)
    if (
        count > 1
    ):  # share the detectability between them, from 1:3 to 3:1, before scaling both together
        shares = np.exp(rng.uniform(-1.1, 1.1, count))
        for i in range(count):
            scales[i] = scale_to(
                _only(plan, sweep, i), plan.fitted, plan.start, sweep, noise, target * shares[i]
            )[0]

    def truth(scale: float) -> Complex:
        return plan.network.stiffness(sweep, plan.at(scale * scales))

    scale, chi2 = scale_to(truth, plan.fitted, plan.start, sweep, noise, target)
    full = plan.at(scale * scales)
    own = [chi2] if count == 1 else [own_chi2(plan, full, n, sweep, noise) for n in plan.names]
    if min(own) < 3.0:  # one of the two hides in the other: nobody could know
        raise NotVisible
    hidden = tuple(
        Hidden(plan.label(n), plan.values(n, full), c) for n, c in zip(plan.names, own, strict=True)
    )
    return Truth(
        truth(scale), chi2, hidden, network=plan.network, theta=full, model=expression(plan.fitted)
    )


def _only(plan: Plan, sweep: Sweep, index: int) -> Callable[[float], Complex]:
    """Return the truth with one effect of size ``scale`` and the others switched off."""

    def truth(scale: float) -> Complex:
        sizes = np.zeros(len(plan.sizes))
        sizes[index] = scale
        return plan.network.stiffness(sweep, plan.at(sizes))

    return truth


def _disturb(
    rng: np.random.Generator,
    sweep: Sweep,
    network: Network,
    theta: Real,
    noise: dict[str, float],
    target: float,
    outside: str,
) -> Truth:
    """Disturb the base in a way that no effect of a library has."""
    k0 = network.stiffness(sweep, theta)
    if outside == ASYMMETRY:
        s, own = 1j * network.reduced(sweep, theta), theta[: len(network.base.parameters)]
        sign = float(rng.choice([-1.0, 1.0]))
        details: dict[str, float] = {}

        def truth(scale: float) -> Complex:
            return havriliak_negami(s, own, 0.01 * sign * scale)

    else:
        pattern, details = OUTSIDE[outside](sweep, rng)

        def truth(scale: float) -> Complex:
            return pattern(k0, 0.01 * scale)

    scale, chi2 = scale_to(truth, network, theta, sweep, noise, target)
    if outside == ASYMMETRY and own[-1] * np.exp(-0.01 * sign * scale) > 1.0:
        # Its spectrum would be negative somewhere, and no passive material is like that: skewed the
        # other way.
        sign = 1.0
        scale, chi2 = scale_to(truth, network, theta, sweep, noise, target)
    return Truth(truth(scale), chi2, outside=outside, details=details | {"size": 0.01 * scale})
