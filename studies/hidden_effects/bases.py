"""Base models and temperature laws as plain complex functions of s = i omega."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import log
from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[Any]
Complex = NDArray[Any]

GAS = 8.314462618
KELVIN = 273.15


@dataclass(frozen=True)
class Sweep:
    """Where the specimen was measured: one entry per row, in measuring order.

    ``omega`` is in rad/s, ``temperature`` in degC, ``amplitude`` in mm or strain; ``repeat`` counts
    from 1.
    """

    omega: Real
    temperature: Real | None = None
    amplitude: Real | None = None
    repeat: NDArray[np.int64] | None = None

    def __len__(self) -> int:
        return self.omega.size

    def series(self) -> NDArray[np.int64]:
        """Number the sweeps: rows of equal temperature, amplitude and repeat share a number."""
        blank = np.zeros(len(self))
        columns = [
            blank if c is None else c for c in (self.temperature, self.amplitude, self.repeat)
        ]
        return (
            np.unique(np.column_stack(columns), axis=0, return_inverse=True)[1]
            .reshape(-1)
            .astype(np.int64)
        )


@dataclass(frozen=True)
class Base:
    """A model of the specimen.

    ``kinds`` says per parameter how it is fitted: "log", "order" or "signed".
    """

    name: str
    parameters: tuple[str, ...]
    kinds: tuple[str, ...]
    stiffness: Callable[[Complex, Real], Complex]
    draw: Callable[[np.random.Generator, float, Callable[[], float]], tuple[float, ...]]


def springs_in_series(*parts: Complex) -> Complex:
    """Add compliances."""
    return 1.0 / sum(1.0 / part for part in parts)


def _springpot(s: Complex, p: Real) -> Complex:
    return p[0] * s ** p[1]


def _kelvin(s: Complex, p: Real) -> Complex:
    return p[0] + p[1] * s


def _maxwell(s: Complex, p: Real) -> Complex:
    return p[0] * p[1] * s / (p[0] + p[1] * s)


def _zener(s: Complex, p: Real) -> Complex:
    return p[0] + _maxwell(s, p[1:])


def _burgers(s: Complex, p: Real) -> Complex:
    return springs_in_series(_maxwell(s, p[:2]), _kelvin(s, p[2:]))


def _fractional_kelvin(s: Complex, p: Real) -> Complex:
    return p[0] + p[1] * s ** p[2]


def _fractional_maxwell(s: Complex, p: Real) -> Complex:
    pot = p[1] * s ** p[2]
    return p[0] * pot / (p[0] + pot)


def _fractional_zener(s: Complex, p: Real) -> Complex:
    return p[0] + _fractional_maxwell(s, p[1:])


def _fractional_kelvin4(s: Complex, p: Real) -> Complex:
    return springs_in_series(p[0] + 0.0 * s, _fractional_kelvin(s, p[1:]))


def _order(rng: np.random.Generator) -> float:
    return float(rng.uniform(0.2, 0.9))


def _ratio(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(log(low), log(high))))


# Every draw takes the generator, a modulus k and a sampler of relaxation times tau inside the
# measured window.
def _draw_springpot(
    rng: np.random.Generator, k: float, tau: Callable[[], float]
) -> tuple[float, ...]:
    a = _order(rng)
    return k * tau() ** a, a


def _draw_fractional(
    rng: np.random.Generator, k: float, tau: Callable[[], float]
) -> tuple[float, ...]:
    a = _order(rng)
    return k, k * tau() ** a, a


def _draw_fractional4(
    rng: np.random.Generator, k: float, tau: Callable[[], float]
) -> tuple[float, ...]:
    k1, a = k * _ratio(rng, 3.0, 40.0), _order(rng)
    return k, k1, k1 * tau() ** a, a


def _draw_kelvin4(
    rng: np.random.Generator, k: float, tau: Callable[[], float]
) -> tuple[float, ...]:
    a, soft = _order(rng), _ratio(rng, 3.0, 40.0)
    return k * soft, k, k * soft * tau() ** a, a


def _draw_classical(
    rng: np.random.Generator, k: float, tau: Callable[[], float]
) -> tuple[float, ...]:
    return k, k * tau()


def _draw_zener(rng: np.random.Generator, k: float, tau: Callable[[], float]) -> tuple[float, ...]:
    k1 = k * _ratio(rng, 2.0, 20.0)
    return k, k1, k1 * tau()


def _draw_burgers(
    rng: np.random.Generator, k: float, tau: Callable[[], float]
) -> tuple[float, ...]:
    k2 = k * _ratio(rng, 0.3, 3.0)
    fast, slow = sorted((tau(), tau()))
    return k, k * slow, k2, k2 * fast


BASES = {
    base.name: base
    for base in (
        Base("springpot", ("c", "alpha"), ("log", "order"), _springpot, _draw_springpot),
        Base("kelvin", ("k", "c"), ("log",) * 2, _kelvin, _draw_classical),
        Base("maxwell", ("k", "c"), ("log",) * 2, _maxwell, _draw_classical),
        Base("zener", ("ke", "k", "c"), ("log",) * 3, _zener, _draw_zener),
        Base("burgers", ("k1", "c1", "k2", "c2"), ("log",) * 4, _burgers, _draw_burgers),
        Base(
            "fractional-kelvin",
            ("k", "c", "alpha"),
            ("log", "log", "order"),
            _fractional_kelvin,
            _draw_fractional,
        ),
        Base(
            "fractional-maxwell",
            ("k", "c", "alpha"),
            ("log", "log", "order"),
            _fractional_maxwell,
            _draw_fractional,
        ),
        Base(
            "fractional-zener",
            ("ke", "k", "c", "alpha"),
            ("log", "log", "log", "order"),
            _fractional_zener,
            _draw_fractional4,
        ),
        Base(
            "fractional-kelvin4",
            ("k0", "k", "c", "alpha"),
            ("log", "log", "log", "order"),
            _fractional_kelvin4,
            _draw_kelvin4,
        ),
    )
}
BASE_WEIGHTS = {
    "springpot": 2.0,
    "fractional-kelvin": 3.0,
    "fractional-maxwell": 3.0,
    "fractional-zener": 3.0,
    "fractional-kelvin4": 2.0,
    "zener": 1.5,
    "maxwell": 1.0,
    "kelvin": 1.5,
    "burgers": 1.0,
}


@dataclass(frozen=True)
class Law:
    """A temperature shift: ``log_shift(T, Tr, p)`` is ln a_T, so that K is taken at omega a_T."""

    name: str
    parameters: tuple[str, ...]
    log_shift: Callable[[Real, float, Real], Real]


def _arrhenius(t: Real, tr: float, p: Real) -> Real:
    return p[0] / GAS * (1.0 / (t + KELVIN) - 1.0 / (tr + KELVIN))


def _wlf(t: Real, tr: float, p: Real) -> Real:
    return -log(10.0) * p[0] * (t - tr) / (p[1] + t - tr)


LAWS = {
    "arrhenius-shift": Law("arrhenius-shift", ("Ea",), _arrhenius),
    "wlf-shift": Law("wlf-shift", ("C1", "C2"), _wlf),
}
