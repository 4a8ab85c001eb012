"""The effects that may be hidden, typed from the literature, and how their parameters are drawn.

An effect maps the stiffness of what is inside it to that of what the instrument sees: ``(K, s,
sweep, p) -> K``. ``layer`` puts two effects in physical order, from the specimen outwards:

====== ============================================== =============================
layer  what                                           frequency it sees
====== ============================================== =============================
0      linear material beside or behind the base      reduced, omega a_T
1      vertical shift of the material                 -
2      amplitude-dependent and rate-independent parts  laboratory (fixed in Hz)
3      shear wave in the specimen                     laboratory
4      mount in series                                -
5      moving mass                                    laboratory
6      measurement chain                              laboratory
====== ============================================== =============================

So a solvent dashpot, a relaxation mode, a slip film and extra springpots move with temperature like
the base; masses, delays, phase errors, resonances and friction stay fixed. Temperature laws and
self-heating act on omega itself. Amplitude-dependent parts are never combined with series ones,
where a describing function would not be exact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import gamma, pi, sqrt

import numpy as np

from hidden_effects.bases import Complex, Real, Sweep


@dataclass(frozen=True)
class Scene:
    """What a draw may look at: the sweep, the undisturbed response and the reduced frequencies."""

    sweep: Sweep
    stiffness: Complex
    reduced: Real

    @property
    def k(self) -> float:
        """A typical stiffness."""
        return float(np.exp(np.mean(np.log(np.abs(self.stiffness)))))

    @property
    def w(self) -> float:
        """A typical reduced frequency."""
        return float(np.exp(np.mean(np.log(self.reduced))))

    @property
    def top(self) -> float:
        """The highest laboratory frequency."""
        return float(self.sweep.omega.max())

    def tau(self, rng: np.random.Generator) -> float:
        """A time inside the inner 70 % of the window of reduced frequencies."""
        low, high = np.log(self.reduced.min()), np.log(self.reduced.max())
        return float(np.exp(-rng.uniform(low + 0.15 * (high - low), high - 0.15 * (high - low))))

    def gap(self, rng: np.random.Generator) -> float:
        """An amplitude inside the measured ones."""
        x = amplitude(self.sweep)
        return float(np.exp(rng.uniform(np.log(x.min() * 1.1), np.log(x.max() * 0.9))))


Stage = Callable[[Complex, Complex, Sweep, Real], Complex]
Draw = Callable[[np.random.Generator, Scene], tuple[float, ...]]


@dataclass(frozen=True)
class Effect:
    """A hidden effect; its first parameter is its size, the rest are drawn and kept."""

    name: str
    layer: int
    parameters: tuple[str, ...]
    kinds: tuple[str, ...]
    apply: Stage
    draw: Draw
    needs: str = ""
    series: bool = False
    signs: bool = False


def amplitude(sweep: Sweep) -> Real:
    """The amplitudes, which must be there."""
    if sweep.amplitude is None:
        raise ValueError("this effect needs amplitudes")
    return sweep.amplitude


# --- parallel: added to K
def _spring(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    return k + p[0]


def _dashpot(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    return k + p[0] * s


def _springpot(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    return k + p[0] * s ** p[1]


def _mode(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    return k + p[0] * (s * p[1]) / (1.0 + s * p[1])


def _mass(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    return k + p[0] * s * s


def _hysteretic(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    return k + 1j * p[0]


def _friction(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    return k + 4j * p[0] / (pi * amplitude(x))


def _jenkins(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    # Spring p0 behind a slider that gives way at displacement p1; below it the spring is all there
    # is.
    rho = np.minimum(p[1] / amplitude(x), 1.0)
    beta = np.arccos(1.0 - 2.0 * rho)
    return k + p[0] / pi * (beta - 0.5 * np.sin(2.0 * beta)) + 4j / pi * p[0] * rho * (1.0 - rho)


def _power_damper(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    a = float(p[1])
    first = 2.0 / sqrt(pi) * gamma(1.0 + 0.5 * a) / gamma(1.5 + 0.5 * a)
    return k + 1j * p[0] * first * s.imag**a * amplitude(x) ** (a - 1.0)


def _cubic(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    return k + 0.75 * p[0] * amplitude(x) ** 2


def _dead_zone(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    r = np.minimum(p[1] / amplitude(x), 1.0)
    return k + p[0] * (1.0 - 2.0 / pi * (np.arcsin(r) + r * np.sqrt(1.0 - r * r)))


def _payne(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    # Kraus: p0 network stiffness that breaks, p1 its peak loss over p0, p2 critical amplitude, p3
    # exponent m.
    r = (amplitude(x) / p[2]) ** p[3]
    return k + p[0] * (1.0 + 2j * p[1] * r) / (1.0 + r * r)


# --- series: added to 1/K (sizes are compliances)
def _mount(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    return k / (1.0 + p[0] * k)


def _film(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    return k / (1.0 + p[0] * k / s)


def _series_pot(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    return k / (1.0 + p[0] * k / s ** p[1])


# --- chain: factors on K
def _delay(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    return k * np.exp(-s * p[0])


def _phase(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    return k * np.exp(1j * p[0])


def _resonance(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    # p0 = 1/omega_r^2, p1 = damping ratio, in the force channel.
    return k / (1.0 + s * s * p[0] + 2.0 * p[1] * s * sqrt(abs(p[0])))


def _specimen(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    # Shear wave, force taken at the moving side: z cot z with z = k h, z^2 = omega^2 M / K (M = rho
    # A h).
    z = np.sqrt(-p[0] * s * s / k)
    thin = np.abs(z) < 1e-7
    z = np.where(thin, 1.0, z)
    return k * np.where(thin, 1.0, z / np.tan(z))


def _vertical(k: Complex, s: Complex, x: Sweep, p: Real) -> Complex:
    # Rubber-like: (T/Tr)^n in absolute temperature with Tr = 20 degC; n = 1 is the entropic law.
    assert x.temperature is not None
    return k * ((x.temperature + 273.15) / 293.15) ** p[0]


LOG, ORDER, SIGNED = "log", "order", "signed"


def _far_order(rng: np.random.Generator) -> float:
    return float(rng.uniform(0.1, 0.9))


def _exponent(rng: np.random.Generator) -> float:
    # Sub-linear (seismic) or quadratic-like (orifice) dampers; 1 would be a dashpot, 0 is friction.
    return float(rng.uniform(0.25, 0.7) if rng.random() < 0.6 else rng.uniform(1.4, 2.0))


# First-guess sizes disturb the response by about a per cent; the case scales them to its target
# afterwards.
_LIBRARY = (
    Effect("parallel-spring", 0, ("k",), (LOG,), _spring, lambda g, v: (0.01 * v.k,)),
    Effect("parallel-dashpot", 0, ("c",), (LOG,), _dashpot, lambda g, v: (0.01 * v.k / v.w,)),
    Effect(
        "parallel-springpot",
        0,
        ("c", "alpha"),
        (LOG, ORDER),
        _springpot,
        lambda g, v: (0.01 * v.k / v.w ** (a := _far_order(g)), a),
    ),
    Effect(
        "relaxation-mode", 0, ("k", "tau"), (LOG, LOG), _mode, lambda g, v: (0.02 * v.k, v.tau(g))
    ),
    Effect("inertia", 5, ("m",), (LOG,), _mass, lambda g, v: (0.01 * v.k / v.top**2,)),
    Effect("hysteretic-loss", 2, ("h",), (LOG,), _hysteretic, lambda g, v: (0.01 * v.k,)),
    Effect(
        "series-spring", 4, ("compliance",), (LOG,), _mount, lambda g, v: (0.01 / v.k,), series=True
    ),
    Effect(
        "series-dashpot",
        0,
        ("fluidity",),
        (LOG,),
        _film,
        lambda g, v: (0.01 * v.w / v.k,),
        series=True,
    ),
    Effect(
        "series-springpot",
        0,
        ("compliance", "alpha"),
        (LOG, ORDER),
        _series_pot,
        lambda g, v: (0.01 * v.w ** (a := _far_order(g)) / v.k, a),
        series=True,
    ),
    Effect("time-delay", 6, ("tau",), (SIGNED,), _delay, lambda g, v: (0.01 / v.top,), signs=True),
    Effect("phase-error", 6, ("phi",), (SIGNED,), _phase, lambda g, v: (0.01,), signs=True),
    Effect(
        "fixture-resonance",
        6,
        ("inverse_square_omega_r", "zeta"),
        (LOG, LOG),
        _resonance,
        lambda g, v: (0.01 / v.top**2, float(g.uniform(0.005, 0.08))),
    ),
    Effect(
        "specimen-inertia", 3, ("mass",), (LOG,), _specimen, lambda g, v: (0.02 * v.k / v.top**2,)
    ),
    Effect(
        "friction",
        2,
        ("force",),
        (LOG,),
        _friction,
        lambda g, v: (0.01 * v.k * float(np.median(amplitude(v.sweep))),),
        needs="amplitude",
    ),
    Effect(
        "power-law-damper",
        2,
        ("c", "exponent"),
        (LOG, "exponent"),
        _power_damper,
        lambda g, v: (
            0.01
            * v.k
            * (x := float(np.median(amplitude(v.sweep))))
            / (x * v.w) ** (a := _exponent(g)),
            a,
        ),
        needs="amplitude",
    ),
    Effect(
        "elasto-sliding",
        2,
        ("k", "slip"),
        (LOG, LOG),
        _jenkins,
        lambda g, v: (0.02 * v.k, v.gap(g)),
        needs="field",
    ),
    Effect(
        "cubic-stiffness",
        2,
        ("k3",),
        (SIGNED,),
        _cubic,
        lambda g, v: (0.01 * v.k / float(amplitude(v.sweep).max()) ** 2,),
        needs="field",
        signs=True,
    ),
    Effect(
        "dead-zone",
        2,
        ("k", "gap"),
        (LOG, LOG),
        _dead_zone,
        lambda g, v: (0.02 * v.k, v.gap(g)),
        needs="field",
    ),
    Effect(
        "payne",
        2,
        ("k", "loss", "critical", "m"),
        (LOG, LOG, LOG, LOG),
        _payne,
        lambda g, v: (0.02 * v.k, float(g.uniform(0.1, 0.4)), v.gap(g), float(g.uniform(0.5, 0.7))),
        needs="field",
    ),
    Effect(
        "vertical-shift",
        1,
        ("n",),
        (SIGNED,),
        _vertical,
        lambda g, v: (0.1,),
        needs="field",
        signs=True,
    ),
)
EFFECTS = {e.name: e for e in _LIBRARY}
NONLINEAR = {
    "friction",
    "power-law-damper",
    "elasto-sliding",
    "cubic-stiffness",
    "dead-zone",
    "payne",
}
