"""Records of displacement and force with a nonlinear element in the signal.

``draw_signal_case(seed)``.

The displacement is prescribed, x = X sin(omega t). The force of the base model is its closed-form
steady state; the nonlinear force is computed sample by sample from x and its velocity, so it
carries all its harmonics. On top come noise on both channels, offsets and a start-up transient in
the force that dies away in the first cycles.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hidden_effects.bases import Complex, Real, Sweep
from hidden_effects.scaling import NotVisible, scale_to
from hidden_effects.setup import draw_base

KINDS = ("nothing", "friction", "cubic-stiffness", "elasto-sliding", "dead-zone", "inertia")


@dataclass(frozen=True)
class Record:
    """One test at one frequency and amplitude: time [s], displacement [mm], force [N]."""

    frequency: float
    amplitude: float
    time: Real
    displacement: Real
    force: Real

    def to_csv(self, path: str | Path) -> Path:
        """Write time, displacement and force."""
        table = np.column_stack([self.time, self.displacement, self.force])
        lines = [
            "time [s],displacement [mm],force [N]",
            *(",".join(f"{v:.9g}" for v in row) for row in table),
        ]
        Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")
        return Path(path)


@dataclass(frozen=True)
class SignalCase:
    """Records of one specimen at several amplitudes and frequencies; stiffness is in kN/m = N/mm.

    ``K_true`` is the first harmonic of the force over the displacement, free of noise, per record;
    ``sigma`` what a least-squares harmonic over the undisturbed cycles can reach; ``chi2`` the
    detectability of the hidden effect.
    """

    seed: int
    hidden: str | None
    parameters: dict[str, float]
    model: str
    base: dict[str, float]
    records: tuple[Record, ...]
    sweep: Sweep
    K_true: Complex
    sigma: Real
    chi2: float

    @property
    def kind(self) -> str:
        """Return "nothing" or "one"."""
        return "one" if self.hidden else "nothing"

    @property
    def truth(self) -> tuple[str, ...]:
        """Names of the hidden effects."""
        return (self.hidden,) if self.hidden else ()

    @property
    def name(self) -> str:
        """A name for files and tables."""
        return f"{self.seed:06d}-signals-{self.kind}-{self.hidden or 'nothing'}"

    @property
    def floor(self) -> float:
        """Relative rms error per complex point that noise alone causes."""
        return float(np.sqrt(np.mean(2.0 * self.sigma**2 / np.abs(self.K_true) ** 2)))

    def to_csvs(self, folder: str | Path) -> list[Path]:
        """Write one file per record."""
        Path(folder).mkdir(parents=True, exist_ok=True)
        return [r.to_csv(Path(folder) / f"record-{i:03d}.csv") for i, r in enumerate(self.records)]

    def summary(self) -> dict[str, Any]:
        """Return the truth as plain JSON values."""
        return {
            "seed": self.seed,
            "name": self.name,
            "kind": self.kind,
            "design": "signals",
            "model": self.model,
            "truth": list(self.truth),
            "parameters": [self.parameters],
            "own_chi2": [self.chi2],
            "chi2": self.chi2,
            "floor": self.floor,
            "points": len(self.records),
            "sigma": "signals",
        }


# --- forces in time, on whole cycles of x = X sin(omega t)
def friction_force(x: Real, v: Real, p: dict[str, float]) -> Real:
    """Coulomb friction whose sign is smoothed around standstill.

    It creeps below a hundredth of the top speed.
    """
    return p["force"] * np.tanh(v / (p["smooth"] * np.max(np.abs(v))))


def cubic_force(x: Real, v: Real, p: dict[str, float]) -> Real:
    """Hardening or softening spring k3 x^3."""
    return p["k3"] * x**3


def dead_zone_force(x: Real, v: Real, p: dict[str, float]) -> Real:
    """Stops on both sides at half-gap ``gap``."""
    return p["k"] * np.sign(x) * np.maximum(np.abs(x) - p["gap"], 0.0)


def sliding_force(x: Real, v: Real, p: dict[str, float]) -> Real:
    """Spring behind a slider.

    It sticks after every reversal until the spring has unloaded, then slides.
    """
    top, limit = np.max(np.abs(x)), p["slip"]
    if top <= limit:
        return p["k"] * x
    going_up = np.minimum(x + top - limit, limit)
    going_down = np.maximum(x - top + limit, -limit)
    return p["k"] * np.where(v >= 0.0, going_up, going_down)


def inertia_force(x: Real, v: Real, p: dict[str, float]) -> Real:
    """Return the force of a moving mass, m times the acceleration.

    x is one or more whole cycles of a sine.
    """
    top = np.max(np.abs(x))
    return -p["m"] * (np.max(np.abs(v)) / top) ** 2 * x


FORCES: dict[str, Callable[[Real, Real, dict[str, float]], Real]] = {
    "friction": friction_force,
    "cubic-stiffness": cubic_force,
    "dead-zone": dead_zone_force,
    "elasto-sliding": sliding_force,
    "inertia": inertia_force,
}


def first_harmonic(
    name: str, p: dict[str, float], omega: float, top: float, points: int = 4096
) -> complex:
    """Return the complex stiffness of a nonlinear element by Fourier sum over one cycle."""
    turn = 2.0 * np.pi * (np.arange(points) + 0.5) / points
    f = FORCES[name](top * np.sin(turn), top * omega * np.cos(turn), p)
    return complex(2.0 * np.mean(f * np.sin(turn)), 2.0 * np.mean(f * np.cos(turn))) / top


# --- drawing
def draw_signal_case(seed: int) -> SignalCase:
    """Return the records of this seed, always the same; one of six has nothing hidden."""
    hidden = KINDS[seed % len(KINDS)]
    for attempt in range(400):
        try:
            return _attempt(seed, hidden, np.random.default_rng([7, seed, attempt]))
        except NotVisible:
            continue
    raise RuntimeError(f"seed {seed}: no visible effect in 400 draws")


def _draw_element(
    rng: np.random.Generator, hidden: str, k: float, sweep: Sweep
) -> dict[str, float]:
    """Draw the element with a first size of about a per cent; the first entry is the size."""
    assert sweep.amplitude is not None
    low, high = float(sweep.amplitude.min()), float(sweep.amplitude.max())
    inside = float(np.exp(rng.uniform(np.log(1.1 * low), np.log(0.9 * high))))
    return {
        "friction": {
            "force": 0.01 * k * np.sqrt(low * high),
            "smooth": float(rng.uniform(0.002, 0.01)),
        },
        "cubic-stiffness": {"k3": 0.01 * k / high**2 * float(rng.choice([-1.0, 1.0]))},
        "dead-zone": {"k": 0.02 * k, "gap": inside},
        "elasto-sliding": {"k": 0.02 * k, "slip": inside},
        "inertia": {"m": 0.01 * k / float(sweep.omega.max()) ** 2},
    }[hidden]


def _attempt(seed: int, hidden: str, rng: np.random.Generator) -> SignalCase:
    """Draw everything once."""
    decades, top = rng.uniform(1.0, 2.5), 10.0 ** rng.uniform(0.0, 1.3)
    hertz = np.round(
        np.geomspace(1.0, 10.0**decades, int(rng.integers(6, 13))) * 10.0 ** rng.uniform(-1.0, 0.0),
        3,
    )
    amplitudes = np.geomspace(top / rng.uniform(4.0, 15.0), top, int(rng.integers(3, 5)))
    x, f = (g.ravel() for g in np.meshgrid(amplitudes, hertz, indexing="ij"))
    sweep = Sweep(2.0 * np.pi * f, None, x)
    network, theta = draw_base(rng, sweep)
    k0 = network.stiffness(sweep, theta)
    cycles, samples = int(rng.integers(8, 17)), int(rng.integers(100, 257))
    noise = {"relative": float(10.0 ** rng.uniform(-2.5, -1.0)), "force": 0.0}
    # White noise on N samples -> amplitude of a harmonic.
    gain = np.sqrt(2.0 / ((cycles - 3) * samples))
    parameters: dict[str, float] = {}
    k, chi2 = k0, 0.0
    if hidden != "nothing":
        element = _draw_element(rng, hidden, float(np.median(np.abs(k0))), sweep)
        size = next(iter(element))
        pairs = list(zip(sweep.omega, x, strict=True))

        unit = np.array([first_harmonic(hidden, element, w, a) for w, a in pairs])
        target = float(np.exp(rng.uniform(np.log(20.0), np.log(3000.0))))
        per_part = {"relative": noise["relative"] * gain, "force": 0.0}
        # Every element is proportional to its size, so the truth is the base plus a multiple of one
        # pattern.
        scale, chi2 = scale_to(
            lambda scale: k0 + scale * unit, network, theta, sweep, per_part, target
        )
        k, parameters = k0 + scale * unit, element | {size: element[size] * scale}
    records = tuple(
        _record(
            rng,
            hidden,
            parameters,
            complex(k0[i]),
            f[i],
            x[i],
            (cycles, samples),
            noise["relative"],
        )
        for i in range(f.size)
    )
    return SignalCase(
        seed=seed,
        hidden=None if hidden == "nothing" else hidden,
        parameters=parameters,
        model=network.base.name,
        base=dict(zip(network.base.parameters, theta.tolist(), strict=True)),
        records=records,
        sweep=sweep,
        K_true=k,
        sigma=noise["relative"] * np.abs(k) * gain,
        chi2=chi2,
    )


def _record(
    rng: np.random.Generator,
    hidden: str,
    parameters: dict[str, float],
    k: complex,
    frequency: float,
    top: float,
    length: tuple[int, int],
    relative: float,
) -> Record:
    """One record with noise, offsets, transient and a random start.

    ``length`` is (cycles, samples per cycle).
    """
    omega = 2.0 * np.pi * frequency
    time = np.arange(length[0] * length[1]) / (length[1] * frequency)
    turn = omega * time + rng.uniform(0.0, 2.0 * np.pi)
    x, v = top * np.sin(turn), top * omega * np.cos(turn)
    force = top * (k.real * np.sin(turn) + k.imag * np.cos(turn))
    if hidden != "nothing":
        force = force + FORCES[hidden](x, v, parameters)
    size = float(np.sqrt(np.mean(force**2)) * np.sqrt(2.0))
    start = rng.uniform(-0.3, 0.3) * size * np.exp(-time * frequency / rng.uniform(0.2, 0.6))
    # Half of the variance comes from the displacement channel, which the force sees through K.
    share = relative / np.sqrt(2.0)
    seen = x + top * (share * rng.standard_normal(time.size) + rng.uniform(-0.05, 0.05))
    felt = force + start + size * (share * rng.standard_normal(time.size) + rng.uniform(-0.2, 0.2))
    return Record(float(frequency), float(top), time, seen, felt)
