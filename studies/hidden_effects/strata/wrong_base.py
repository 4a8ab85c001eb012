"""The stratum of wrong bases.

The user's fractional Kelvin model cannot follow the truth's spectrum.

Beside that there is nothing, an effect of the rig, of the amplitude, or a temperature that the
model leaves out. Two questions are asked: with the wrong model, and with no model at all (any
linear passive material).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import nnls

from hidden_effects.bases import BASES, Base, Complex, Real, Sweep
from hidden_effects.effects import EFFECTS
from hidden_effects.fit import Network, refit, whiten
from hidden_effects.scaling import NotVisible, hide
from hidden_effects.setup import draw_base, draw_sweep
from hidden_effects.strata.drawn import CLEAR, Drawn, log_uniform, pick_design, white

BESIDE = ("alone", "rig", "temperature", "amplitude")
RIG = (
    "inertia",
    "time-delay",
    "phase-error",
    "fixture-resonance",
    "specimen-inertia",
    "hysteretic-loss",
)
AMPLITUDE = (
    "friction",
    "power-law-damper",
    "elasto-sliding",
    "cubic-stiffness",
    "dead-zone",
    "payne",
)
SHIFTS = ("arrhenius-shift", "wlf-shift", "free-shift")
MATERIAL = (
    *("parallel-spring", "parallel-dashpot", "parallel-springpot", "relaxation-mode"),
    *("series-spring", "series-dashpot", "series-springpot", "retardation-mode", "diffusion"),
)
"""Every effect that is a spring, a dashpot, a springpot or a relaxation.

Right answers to a wrong spectrum.
"""
MODEL = BASES["fractional-kelvin"]
MISFIT = (0.01, 0.15)
"""Relative rms error of the wrong base alone.

With a worse one nobody would go on, a better one would be right.
"""


def _modes(s: Complex, p: Real) -> Complex:
    return p[0] + sum(p[i] * s * p[i + 1] / (1.0 + s * p[i + 1]) for i in range(1, p.size, 2))


def _two_pots(s: Complex, p: Real) -> Complex:
    first, second = p[1] * s ** p[2], p[4] * s ** p[5]
    return p[0] * first / (p[0] + first) + p[3] * second / (p[3] + second)


def _skewed(s: Complex, p: Real) -> Complex:
    return p[0] + p[1] * (1.0 - (1.0 + (s * p[2]) ** p[3]) ** -p[4])


def _truths(rng: np.random.Generator) -> tuple[Base, ...]:
    """True networks that take turns.

    Several relaxation times, two springpots, a skewed spectrum, small networks.
    """
    count = int(rng.integers(3, 6))
    names = ("ke", *(f"{letter}{i}" for i in range(count) for letter in ("k", "tau")))
    modes = Base(
        "modes",
        names,
        ("log",) * len(names),
        _modes,
        lambda g, k, tau: (
            k,
            *np.ravel([(k * log_uniform(g, 0.05, 0.5), tau()) for _ in range(count)]).tolist(),
        ),
    )
    pots = Base(
        "two-pots",
        ("k1", "c1", "a1", "k2", "c2", "a2"),
        ("log", "log", "order") * 2,
        _two_pots,
        lambda g, k, tau: (
            k,
            k * tau() ** (a := float(g.uniform(0.5, 0.9))),
            a,
            (k2 := k * log_uniform(g, 0.1, 10.0)),
            k2 * tau() ** (b := float(g.uniform(0.3, 0.9))),
            b,
        ),
    )
    skewed = Base(
        "skewed",
        ("ke", "k", "tau", "a", "b"),
        ("log", "log", "log", "order", "order"),
        _skewed,
        lambda g, k, tau: (
            k,
            k * log_uniform(g, 3.0, 40.0),
            tau(),
            float(g.uniform(0.4, 0.9)),
            float(g.uniform(0.3, 0.9)),
        ),
    )
    return (
        modes,
        pots,
        skewed,
        *(BASES[name] for name in ("fractional-zener", "fractional-kelvin4")),
    )


def wrong_base(seed: int, rng: np.random.Generator) -> Drawn:
    """One case; what stands beside the wrong spectrum takes turns."""
    beside = BESIDE[seed % len(BESIDE)]
    design = pick_design(rng) if beside in ("alone", "rig") else "field"
    sweep = draw_sweep(rng, design, 1, strain=False)
    truths = _truths(rng)
    base = truths[seed // len(BESIDE) % len(truths)]
    network, theta = draw_base(rng, sweep, base)
    believed = Network(MODEL, network.law, reference=network.reference)
    level = log_uniform(rng, 0.002, 0.01)
    bare = network.stiffness(sweep, theta)
    start, misfit = _best_start(believed, sweep, bare, theta[len(base.parameters) :])
    if not MISFIT[0] <= misfit <= MISFIT[1]:
        raise NotVisible
    k, names, details = bare, (), {}
    if beside == "temperature":
        believed, start, names = replace(believed, law=None), start[: len(MODEL.parameters)], SHIFTS
    elif beside != "alone":
        k, names, details = _hidden_beside(rng, sweep, network, theta, beside, level)
    sigma = level * np.abs(k)
    reduced = sweep.omega if believed.law is None else network.reduced(sweep, theta)
    left = material_loss(reduced, k, sigma)
    if beside != "alone" and left < CLEAR[0]:
        raise NotVisible
    law = "" if believed.law is None else f" + {believed.law.name}"
    return Drawn(
        seed=seed,
        stratum="wrong-base",
        detail=beside,
        kind="base",
        model=MODEL.name + law,
        sweep=sweep,
        K=k + sigma * white(rng, k.size),
        K_true=k,
        floor=float(np.sqrt(2.0) * level),
        right=(*MATERIAL, *names),
        chi2=refit(believed, start, sweep, k, sigma, 150)[1],
        parameters=details | {"relative": level},
        network=base.name,
        material="material" + law,
        material_chi2=left,
        material_right=names,
    )


def _best_start(believed: Network, sweep: Sweep, k: Complex, law: Real) -> tuple[Real, float]:
    """The wrong base fitted to the bare truth from three orders, and its relative error."""
    low, w = float(np.min(np.abs(k))), float(np.exp(np.mean(np.log(sweep.omega))))
    fits = []
    for order in (0.2, 0.5, 0.8):
        rough = np.array([0.5 * low, float(np.median(np.abs(k))) / w**order, order])
        fits.append(refit(believed, np.concatenate([rough, law]), sweep, k, np.abs(k), 150))
    theta, left = min(fits, key=lambda fit: fit[1])
    return theta, float(np.sqrt(left / len(sweep)))


def _hidden_beside(
    rng: np.random.Generator, sweep: Sweep, network: Network, theta: Real, beside: str, level: float
) -> tuple[Complex, tuple[str, ...], dict[str, float]]:
    """Hide one effect at the size at which the best material leaves a clear chi-square."""
    names = [
        n
        for n in (RIG if beside == "rig" else AMPLITUDE)
        if not EFFECTS[n].needs or sweep.amplitude is not None
    ]
    name = str(rng.choice(names))
    plan = hide(rng, sweep, network, theta, [name])
    target, reduced = log_uniform(rng, *CLEAR), network.reduced(sweep, theta)
    scale = 1.0
    for _ in range(12):
        with np.errstate(all="ignore"):
            k = plan.network.stiffness(sweep, plan.at(scale))
        if (
            not np.all(np.isfinite(k))
            or np.max(np.abs(k / plan.network.stiffness(sweep, plan.at(0.0)) - 1.0)) > 1.5
        ):
            raise NotVisible
        left = material_loss(reduced, k, level * np.abs(k))
        if 0.8 < left / target < 1.25:
            return k, (name,), plan.values(name, plan.at(scale))
        scale *= float(np.clip(np.sqrt(target / max(left, 1e-9)), 0.1, 10.0))
    raise NotVisible


def material_loss(omega: Real, k: Complex, sigma: Real, a_decade: int = 6) -> float:
    """Chi-square left of ``k`` by the best spring, dashpot and non-negative Maxwell elements."""
    low, high = np.log10(omega.min()) - 2.0, np.log10(omega.max()) + 2.0
    rates = 10.0 ** np.linspace(low, high, int(a_decade * (high - low)) + 1)
    s = 1j * omega[:, None]
    basis = np.hstack([np.ones_like(s), s, s / (s + rates[None, :])])
    matrix = np.vstack([basis.real / sigma[:, None], basis.imag / sigma[:, None]])
    scale = np.linalg.norm(matrix, axis=0)
    return float(nnls(matrix / scale, whiten(k, sigma), maxiter=50 * scale.size)[1] ** 2)
