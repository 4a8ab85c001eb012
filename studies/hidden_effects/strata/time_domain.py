"""The strata of truths that live in time.

Elements integrated step by step, and specimens that remember.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hidden_effects.bases import Complex, Real, Sweep
from hidden_effects.fit import Network
from hidden_effects.setup import draw_base
from hidden_effects.strata.drawn import LOUD, QUIET, Drawn, level_for, log_uniform, white
from hidden_effects.strata.in_time import (
    Motion,
    Solid,
    bouc_wen_force,
    harmonic,
    instant_force,
    load_cell_force,
    mount_force,
    sliders_force,
    slip_force,
    solid_force,
)

HYSTERESIS = ("smooth-hysteresis", "elasto-sliding")
"""Names that are right for any spring that gives way and comes back along another path."""
MEMORY = ("mullins", "ageing", "drift")
Parts = tuple[Real, dict[str, float]]
Element = Callable[[np.random.Generator, Solid, Motion, Real], Parts]


def _amplitude_field(rng: np.random.Generator, shuffled: bool = False) -> Sweep:
    """Frequencies at three or four amplitudes, one temperature.

    Sweep after sweep in rising or random order.
    """
    decades, count = rng.uniform(1.0, 2.0), int(rng.integers(8, 16))
    first = 10.0 ** rng.uniform(-1.0, 1.0)
    hertz = np.geomspace(first, first * 10.0**decades, count)
    top = 10.0 ** rng.uniform(-1.0, 1.0)
    amplitudes = np.geomspace(top / rng.uniform(4.0, 15.0), top, int(rng.integers(3, 6)))
    if shuffled:
        while np.all(np.diff(amplitudes) > 0.0):
            rng.shuffle(amplitudes)
    x, f = (g.ravel() for g in np.meshgrid(amplitudes, hertz, indexing="ij"))
    return Sweep(2.0 * np.pi * f, None, x)


def _inside(rng: np.random.Generator, motion: Motion) -> float:
    """An amplitude between the smallest and the largest."""
    return log_uniform(rng, 1.2 * float(motion.top.min()), 0.8 * float(motion.top.max()))


def _typical(force: Real, motion: Motion) -> float:
    return float(np.median(np.abs(harmonic(force, 1)) / motion.top))


# --- one element each; ``force`` is that of the specimen alone in the last turn
def _linear(rng: np.random.Generator, solid: Solid, motion: Motion, force: Real) -> Parts:
    return force, {}


def _mass(rng: np.random.Generator, solid: Solid, motion: Motion, force: Real) -> Parts:
    m = log_uniform(rng, 0.03, 0.5) * _typical(force, motion) / float(motion.omega.max()) ** 2
    return force + instant_force(lambda x, v, a: m * a, motion), {"m": m}


def _cubic(rng: np.random.Generator, solid: Solid, motion: Motion, force: Real) -> Parts:
    k3 = log_uniform(rng, 0.03, 0.5) * _typical(force, motion) / float(motion.top.max()) ** 2
    return force + instant_force(lambda x, v, a: k3 * x**3, motion), {"k3": k3}


def _friction(rng: np.random.Generator, solid: Solid, motion: Motion, force: Real) -> Parts:
    f = log_uniform(rng, 0.03, 0.3) * _typical(force, motion) * float(np.median(motion.top))
    creep = 0.005 * motion.omega * motion.top  # below this speed the contact creeps
    return force + instant_force(lambda x, v, a: f * np.tanh(v / creep), motion), {"force": f}


def _power(rng: np.random.Generator, solid: Solid, motion: Motion, force: Real) -> Parts:
    exponent = float(rng.choice([rng.uniform(0.25, 0.6), rng.uniform(1.5, 2.0)]))
    speed = float(np.median(motion.omega * motion.top))
    c = (
        log_uniform(rng, 0.05, 0.3)
        * _typical(force, motion)
        * float(np.median(motion.top))
        / speed**exponent
    )
    parts = {"c": c, "exponent": exponent}
    return (
        force + instant_force(lambda x, v, a: c * np.abs(v) ** exponent * np.sign(v), motion),
        parts,
    )


def _sliding(rng: np.random.Generator, solid: Solid, motion: Motion, force: Real) -> Parts:
    k, slip = log_uniform(rng, 0.1, 1.0) * _typical(force, motion), _inside(rng, motion)
    return force + sliders_force(k, np.array([slip]), motion), {"k": k, "slip": slip}


def _load_cell(rng: np.random.Generator, solid: Solid, motion: Motion, force: Real) -> Parts:
    resonance, zeta = (
        float(motion.omega.max()) * log_uniform(rng, 1.5, 4.0),
        float(rng.uniform(0.03, 0.1)),
    )
    return load_cell_force(force, motion, resonance, zeta), {"resonance": resonance, "zeta": zeta}


def _mount(rng: np.random.Generator, solid: Solid, motion: Motion, force: Real) -> Parts:
    stiffness = log_uniform(rng, 1.0, 5.0) * (solid.ke + solid.k)
    give = float(motion.top.max()) * (solid.ke + solid.k) / (stiffness + solid.ke + solid.k)
    cubic = log_uniform(rng, 0.3, 3.0) * stiffness / give**2
    return mount_force(solid, motion, stiffness, cubic), {"stiffness": stiffness, "cubic": cubic}


def _slip(rng: np.random.Generator, solid: Solid, motion: Motion, force: Real) -> Parts:
    exponent = float(rng.uniform(2.0, 3.5))
    pull = float(np.median(np.abs(harmonic(force, 1))))
    fluidity = (
        log_uniform(rng, 0.02, 0.3) * float(np.median(motion.omega * motion.top)) / pull**exponent
    )
    return slip_force(solid, motion, fluidity, exponent), {
        "fluidity": fluidity,
        "exponent": exponent,
    }


def _bouc_wen(rng: np.random.Generator, solid: Solid, motion: Motion, force: Real) -> Parts:
    k, limit = log_uniform(rng, 0.1, 1.0) * _typical(force, motion), _inside(rng, motion)
    sharpness, share = float(rng.uniform(1.0, 3.0)), float(rng.uniform(0.5, 1.0))
    parts = {"k": k, "limit": limit, "sharpness": sharpness, "share": share}
    return force + bouc_wen_force(k, limit, sharpness, share, motion), parts


def _iwan(rng: np.random.Generator, solid: Solid, motion: Motion, force: Real) -> Parts:
    k, widest = log_uniform(rng, 0.1, 1.0) * _typical(force, motion), 2.0 * _inside(rng, motion)
    limits = widest * (np.arange(40) + 0.5) / 40.0
    return force + sliders_force(k, limits, motion), {"k": k, "widest": widest}


TIME: tuple[tuple[str, Element, tuple[str, ...]], ...] = (
    ("linear", _linear, ()),
    ("mass", _mass, ("inertia",)),
    ("cubic", _cubic, ("cubic-stiffness",)),
    ("friction", _friction, ("friction",)),
    ("power-damper", _power, ("power-law-damper",)),
    ("linear", _linear, ()),
    ("sliding", _sliding, ("elasto-sliding",)),
    ("load-cell", _load_cell, ("fixture-resonance",)),
    ("hardening-mount", _mount, ("hardening-mount",)),
    ("wall-slip", _slip, ("power-law-slip",)),
)
"""Turns of the stratum: its elements, and the names that are right.

Without one the truth has no name.
"""
HISTORY: tuple[tuple[str, Element | None, tuple[str, ...]], ...] = (
    ("nothing", None, ()),
    ("bouc-wen", _bouc_wen, HYSTERESIS),
    ("iwan", _iwan, HYSTERESIS),
    ("ageing", None, MEMORY),
    ("mullins", None, MEMORY),
)


def time(seed: int, rng: np.random.Generator) -> Drawn:
    """One element whose force is integrated in time beside, before or behind a linear solid."""
    detail, element, right = TIME[seed % len(TIME)]
    return _integrated(seed, rng, "time", detail, element, right)


def history(seed: int, rng: np.random.Generator) -> Drawn:
    """Hysteresis with a memory in the cycle, or a specimen that ages or breaks in over rows."""
    detail, element, right = HISTORY[seed % len(HISTORY)]
    if element is not None:
        return _integrated(seed, rng, "history", detail, element, right)
    sweep = _amplitude_field(rng, shuffled=True)
    network, theta = draw_base(rng, sweep)
    pattern, parameters = _memory(rng, detail, sweep)
    k = network.stiffness(sweep, theta) * pattern
    return _noisy(seed, rng, "history", detail, network, theta, sweep, k, right, parameters, None)


def _memory(rng: np.random.Generator, detail: str, sweep: Sweep) -> tuple[Real, dict[str, float]]:
    """The factor on K from row to row."""
    assert sweep.amplitude is not None
    size = log_uniform(rng, 0.01, 0.2)
    if detail == "ageing":
        tau = len(sweep) * float(rng.uniform(0.02, 0.5))
        return 1.0 + size * np.log1p(np.arange(len(sweep)) / tau), {"size": size, "tau": tau}
    if detail == "mullins":
        worst = np.maximum.accumulate(sweep.amplitude)
        scale = log_uniform(rng, float(sweep.amplitude.min()), float(sweep.amplitude.max()))
        return 1.0 - 2.0 * size * (1.0 - np.exp(-worst / scale)), {
            "size": 2.0 * size,
            "scale": scale,
        }
    return np.ones(len(sweep)), {}


def _integrated(
    seed: int,
    rng: np.random.Generator,
    stratum: str,
    detail: str,
    element: Element,
    right: tuple[str, ...],
) -> Drawn:
    """Reduce the force of one integrated device to harmonics.

    The user believes in its linear solid.
    """
    sweep = _amplitude_field(rng)
    network, theta = draw_base(rng, sweep, "zener")
    assert sweep.amplitude is not None
    motion, solid = (
        Motion(sweep.omega, sweep.amplitude),
        Solid(theta[0], theta[1], theta[2] / theta[1]),
    )
    force, parameters = element(rng, solid, motion, solid_force(solid, motion))
    first = harmonic(force, 1)
    third = harmonic(force, 3) / first if rng.random() < 0.5 else None
    k = first / motion.top
    return _noisy(seed, rng, stratum, detail, network, theta, sweep, k, right, parameters, third)


def _noisy(
    seed: int,
    rng: np.random.Generator,
    stratum: str,
    detail: str,
    network: Network,
    theta: Real,
    sweep: Sweep,
    k: Complex,
    right: tuple[str, ...],
    parameters: dict[str, float],
    third: Complex | None,
) -> Drawn:
    """Add noise at which what is missing is plain, or any noise where nothing is."""
    if detail in ("linear", "nothing"):
        kind, level, chi2 = "nothing", log_uniform(rng, QUIET, LOUD), 0.0
    else:
        kind = "one" if right and right != MEMORY else "outside"
        level, chi2 = level_for(rng, network, theta, sweep, k, QUIET, LOUD)
    return Drawn(
        seed=seed,
        stratum=stratum,
        detail=detail,
        kind=kind,
        model=network.base.name,
        sweep=sweep,
        K=k + level * np.abs(k) * white(rng, k.size),
        K_true=k,
        floor=float(np.sqrt(2.0) * level),
        right=right,
        chi2=chi2,
        parameters=parameters,
        third=None if third is None else third + level * white(rng, k.size),
    )
