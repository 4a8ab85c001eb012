"""Data with something hidden, from textbook formulas written here by hand.

Nothing of the framework's elements is used, so that an error there cannot hide in the data.
Stiffness is in kN/m, amplitude in mm, temperature in degC. The noise beside a hidden effect is
chosen so that the best fit of the base model leaves a wanted noise-free chi-square, which alone
says how easy the effect is to see.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from springpot import Measurement, Units

GAS = 8.314462618e-3  # kJ/(mol K)
ZERO = 273.15
LEVEL = 0.01
"""Noise of storage and of loss, as a fraction of |K|."""


@dataclass(frozen=True, eq=False)
class Design:
    """Where is measured: one row for each point; `x` is an amplitude, `celsius` a temperature."""

    omega: np.ndarray
    x: np.ndarray | None = None
    celsius: np.ndarray | None = None

    @property
    def kelvin(self):
        return None if self.celsius is None else self.celsius + ZERO

    @property
    def reference(self):
        """The median temperature in kelvin."""
        return float(np.median(self.kelvin))


def design(points=40, low=0.1, high=100.0, amplitudes=(), temperatures=()):
    """All combinations of frequencies in Hz, amplitudes and temperatures."""
    omega = 2.0 * np.pi * np.geomspace(low, high, points)
    w, x, t = np.meshgrid(omega, amplitudes or [1.0], temperatures or [25.0], indexing="ij")
    return Design(w.ravel(), x.ravel() if amplitudes else None, t.ravel() if temperatures else None)


SWEEP = design(24)
AMPLITUDES = design(6, 0.3, 30.0, amplitudes=(0.2, 0.5, 1.0, 2.0))
BOTH = design(6, 0.3, 30.0, amplitudes=(0.3, 1.0, 2.0), temperatures=(5.0, 25.0, 45.0))
SLOW = design(6, 0.3, 5.0, amplitudes=(0.2, 0.5, 1.0, 2.0))
TEMPERATURES = design(6, temperatures=(-10.0, 10.0, 30.0, 50.0))


def kelvin(p, s):
    return p[0] + p[1] * s ** p[2]


def maxwell(p, s):
    return 1.0 / (1.0 / p[0] + 1.0 / (p[1] * s ** p[2]))


def zener(p, s):
    return p[0] + 1.0 / (1.0 / p[1] + 1.0 / (p[2] * s ** p[3]))


def arrhenius(energy, at):
    """The factor by which all times change from the median temperature."""
    return np.exp(energy / GAS * (1.0 / at.kelvin - 1.0 / at.reference))


@dataclass(frozen=True)
class Base:
    """A model as the user names it, the same by hand, and its parameters.

    Where `shifted`, Arrhenius is last.
    """

    name: str
    law: object
    truth: tuple
    shifted: bool = False

    def stiffness(self, p, at, ln_shift=0.0):
        s = 1j * at.omega * np.exp(ln_shift)
        if self.shifted:
            return self.law(p[:-1], s * arrhenius(p[-1], at))
        return self.law(p, s)


KELVIN = Base("fractional-kelvin", kelvin, (100.0, 40.0, 0.4))
MAXWELL = Base("fractional-maxwell", maxwell, (400.0, 60.0, 0.5))
ZENER = Base("fractional-zener", zener, (60.0, 400.0, 40.0, 0.5))
WARM_FLUID = Base(
    "fractional-maxwell + arrhenius-shift", maxwell, (400.0, 60.0, 0.5, 40.0), shifted=True
)
WARM = Base("fractional-kelvin + arrhenius-shift", kelvin, (100.0, 40.0, 0.4, 40.0), shifted=True)


def exact(base, at, effect=None, size=0.0):
    """Stiffness of the base, with an effect of some size."""
    if effect is None:
        return base.stiffness(base.truth, at)
    return EFFECTS[effect](base, at, size)


def left_over(base, at, stiffness, level=LEVEL):
    """Noise-free chi-square that the best base model leaves, from several starts."""
    sd = level * np.abs(stiffness)

    def residual(q):
        p = np.exp(q)
        p[_orders(base)] = np.minimum(p[_orders(base)], 1.0)
        off = (base.stiffness(p, at) - stiffness) / sd
        return np.r_[off.real, off.imag]

    truth = np.log(np.array(base.truth))
    top = np.full(len(truth), np.inf)
    top[_orders(base)] = 0.0
    starts = [truth, truth + 0.3 * np.where(np.arange(len(truth)) == _orders(base), -1.0, 1.0)]
    return min(
        2.0 * least_squares(residual, start, bounds=(-np.inf, top), x_scale=0.1).cost
        for start in starts
    )


def _orders(base):
    return len(base.truth) - 1 - base.shifted


def hidden(base, at, effect, chi2, seed=1, **given):
    """A measurement with an effect of usual size.

    Its noise is such that the base fit leaves `chi2` before noise.
    """
    stiffness = exact(base, at, effect, SIZES[effect])
    level = LEVEL * np.sqrt(left_over(base, at, stiffness) / chi2)
    return measured(at, stiffness, seed, level=level, **given)


def measured(at, stiffness, seed=1, level=LEVEL, known=True, said=None, just=False, **given):
    """A measurement with noise proportional to |K|.

    `said` is the level that the user believes in; `just` scales the draw so that its mean square is
    as said.
    """
    scatter = np.random.default_rng(seed).normal(size=(2, len(at.omega)))
    if just:
        scatter /= np.sqrt(np.mean(scatter**2))
    sd = (level if said is None else said) * np.abs(stiffness) * (1.0 + 1.0j) if known else None
    conditions = {"amplitude": at.x, "temperature": at.celsius}
    return Measurement(
        at.omega,
        stiffness + level * np.abs(stiffness) * (scatter[0] + 1j * scatter[1]),
        sd=sd,
        conditions={name: column for name, column in conditions.items() if column is not None},
        units=Units("kN/m", "mm"),
        **given,
    )


def parallel(added):
    return lambda base, at, size: base.stiffness(base.truth, at) + added(1j * at.omega, at, size)


def series(compliance):
    return lambda base, at, size: (
        1.0 / (1.0 / base.stiffness(base.truth, at) + compliance(1j * at.omega, at, size))
    )


def chain(factor):
    return lambda base, at, size: base.stiffness(base.truth, at) * factor(1j * at.omega, at, size)


def shift(ln_shift):
    return lambda base, at, size: base.stiffness(base.truth, at, ln_shift(at, size))


def jenkins(at, k, force):
    """Spring k that slips at a force: harmonic balance of the parallelogram it draws."""
    rho = np.minimum(force / (k * at.x), 1.0)
    beta = np.arccos(1.0 - 2.0 * rho)
    return k / np.pi * (beta - 0.5 * np.sin(2.0 * beta)) + 4j / np.pi * k * rho * (1.0 - rho)


def gap(at, k, b):
    """Spring k that touches only beyond b."""
    r = np.minimum(b / at.x, 1.0)
    return k * (1.0 - 2.0 / np.pi * (np.arcsin(r) + r * np.sqrt(1.0 - r**2))) + 0j


def play(at, b):
    """A joint of total play 2b that friction holds: motion passed on, over motion given."""
    ratio = np.minimum(2.0 * b / at.x / 2.0, 1.0)
    beta = np.arccos(1.0 - 2.0 * (1.0 - ratio))
    lag = 4.0 / np.pi * ratio * (1.0 - ratio)
    return (beta - 0.5 * np.sin(2.0 * beta)) / np.pi - 1j * lag


def kraus(at, h, xc=0.7, m=0.6):
    """A filler network of stiffness h that breaks up around the amplitude xc."""
    u = (at.x / xc) ** m
    return h / (1.0 + u**2) + 1j * 0.6 * h * u / (1.0 + u**2)


def speed_power(at, force, a):
    """Force * |x'|^a sgn x' by its first harmonic: the integral of |cos|^(a+1) by quadrature."""
    angle = (np.arange(20000) + 0.5) / 20000 * 2.0 * np.pi
    first = 2.0 * np.mean(np.abs(np.cos(angle)) ** (a + 1.0))
    return 1j * force * first * (at.omega * at.x) ** a / at.x


def heated(base, at, size):
    cold = base.stiffness(base.truth, at)
    return base.stiffness(base.truth, at, -size * at.omega * cold.imag * at.x**2)


def wave(moving):
    def stiffness(base, at, size):
        cold = base.stiffness(base.truth, at)
        kh = np.sqrt(size * at.omega**2 / cold)
        return cold * kh / (np.tan(kh) if moving else np.sin(kh))

    return stiffness


EFFECTS = {
    "parallel-spring": parallel(lambda s, at, p: p + 0 * s),
    "parallel-dashpot": parallel(lambda s, at, p: p * s),
    "parallel-springpot": parallel(lambda s, at, p: p * s**0.8),
    "relaxation-mode": parallel(lambda s, at, p: p * 0.05 * s / (1.0 + 0.05 * s)),
    "diffusion": parallel(
        lambda s, at, p: p * (1.0 - np.tanh(np.sqrt(0.05 * s)) / np.sqrt(0.05 * s))
    ),
    "hysteretic-loss": parallel(lambda s, at, p: 1j * p + 0 * s),
    "inertia": parallel(lambda s, at, p: p * s**2),
    "basset": parallel(lambda s, at, p: p * s**1.5),
    "series-spring": series(lambda s, at, p: p + 0 * s),
    "frame-resonance": series(lambda s, at, p: p / (1.0 + 0.1 * s / 300.0 + (s / 300.0) ** 2)),
    "series-dashpot": series(lambda s, at, p: p / s),
    "series-springpot": series(lambda s, at, p: p / s**0.7),
    "retardation-mode": series(lambda s, at, p: p / (1.0 + 0.05 * s)),
    "friction": parallel(lambda s, at, p: 4j * p / (np.pi * at.x)),
    "elasto-sliding": parallel(lambda s, at, p: jenkins(at, p, 0.5 * p)),
    "power-law-damper": parallel(lambda s, at, p: speed_power(at, p, 0.4)),
    "cubic-damping": parallel(lambda s, at, p: 0.75j * p * at.omega**3 * at.x**2),
    "dead-zone": parallel(lambda s, at, p: gap(at, p, 0.4)),
    "cubic-stiffness": parallel(lambda s, at, p: 0.75 * p * at.x**2 + 0j),
    "payne": parallel(lambda s, at, p: kraus(at, p)),
    "intrinsic-nonlinearity": chain(lambda s, at, p: 1.0 - p * at.x**2),
    "self-heating": heated,
    "backlash": chain(lambda s, at, p: play(at, p)),
    "crosstalk": parallel(lambda s, at, p: p * np.exp(0.8j) / at.x),
    "time-delay": chain(lambda s, at, p: np.exp(-s * p)),
    "phase-error": chain(lambda s, at, p: np.exp(1j * p) + 0 * s),
    "gain-error": chain(lambda s, at, p: 1.0 + p + 0 * s),
    "filter-mismatch": chain(lambda s, at, p: 1.0 / (1.0 + s * p)),
    "fixture-resonance": chain(lambda s, at, p: 1.0 / (1.0 + 0.1 * p * s + (p * s) ** 2)),
    "frequency-error": shift(lambda at, p: np.log1p(p)),
    "arrhenius-shift": shift(lambda at, p: np.log(arrhenius(p, at))),
    "wlf-shift": shift(
        lambda at, p: (
            -p * np.log(10.0) * (at.kelvin - at.reference) / (80.0 + at.kelvin - at.reference)
        )
    ),
    "vertical-shift": chain(lambda s, at, p: (at.kelvin / at.reference) ** p),
    "entropic-spring": parallel(lambda s, at, p: p * at.kelvin / at.reference + 0 * s),
    "arrhenius-dashpot": parallel(lambda s, at, p: p * s * arrhenius(60.0, at)),
    "arrhenius-springpot": parallel(lambda s, at, p: p * (s * arrhenius(90.0, at)) ** 0.6),
    "rig-drag": parallel(lambda s, at, p: p * s),
    "specimen-inertia": wave(moving=True),
    "specimen-inertia-fixed": wave(moving=False),
}
"""What each effect does to the stiffness of a base, by its size."""

SIZES = {
    "parallel-spring": 21.0,
    "parallel-dashpot": 0.27,
    "parallel-springpot": 2.7,
    "relaxation-mode": 49.0,
    "diffusion": 69.0,
    "hysteretic-loss": 9.1,
    "inertia": 2.2e-4,
    "basset": 5.5e-3,
    "series-spring": 5e-4,
    "frame-resonance": 7.8e-5,
    "series-dashpot": 7.5e-4,
    "series-springpot": 1.4e-3,
    "retardation-mode": 1.3e-3,
    "friction": 2.5,
    "elasto-sliding": 20.0,
    "power-law-damper": 2.0,
    "cubic-damping": 5e-4,
    "dead-zone": 25.0,
    "cubic-stiffness": 6.6,
    "payne": 27.0,
    "intrinsic-nonlinearity": 0.021,
    "self-heating": 4e-6,
    "backlash": 0.012,
    "crosstalk": 3.8,
    "time-delay": 2.5e-4,
    "phase-error": 0.043,
    "gain-error": 0.05,
    "filter-mismatch": 2.6e-4,
    "fixture-resonance": 6.3e-4,
    "frequency-error": 0.05,
    "arrhenius-shift": 4.5,
    "wlf-shift": 0.19,
    "vertical-shift": 0.46,
    "entropic-spring": 7.2,
    "arrhenius-dashpot": 0.03,
    "arrhenius-springpot": 1.05,
    "rig-drag": 0.12,
    "specimen-inertia": 6.4e-4,
    "specimen-inertia-fixed": 1.5e-3,
}
"""Sizes that leave a chi-square near 300 with one per cent noise on the designs of the tests."""
