"""Responses in time, by numerical inversion of Laplace transforms.

Nothing here knows how springpot computes them.

K(s) of each material is written out; relaxation is the inverse transform of K/s, creep that of 1/(s
K), and any history on even samples is a sum of responses to ramps. Inversion by Euler summation
(Abate & Whitt 2006, doi:10.1287/ijoc.1050.0137), of as many terms as it takes until what swings is
behind: good to nine digits for what is smooth or swings up to 250 times.
"""

from __future__ import annotations

from collections.abc import Callable
from math import comb
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Real: TypeAlias = NDArray[np.float64]
Stiffness: TypeAlias = Callable[[Any], Any]

TERMS = 15
"""Over which the sum is averaged: the error is 10^(-0.6 M), and rounding grows as 10^(M/3)."""

WHOLE = 500
"""Terms before these, two for each time that the function swings until t."""


def _weights() -> tuple[NDArray[np.complex128], Real]:
    k = np.arange(WHOLE + TERMS + 1)
    nodes = TERMS * np.log(10.0) / 3.0 + 1j * np.pi * k
    share = np.ones(len(k))
    share[0] = 0.5
    of_averages = np.array([comb(TERMS, i) for i in range(TERMS + 1)]) / 2.0**TERMS
    share[WHOLE:] = np.cumsum(of_averages[::-1])[::-1]
    return nodes, 10.0 ** (TERMS / 3.0) * (-1.0) ** k * share


NODES, WEIGHTS = _weights()


def inverse(transform: Stiffness, t: Real) -> Real:
    """The function (n,) of t > 0 whose Laplace transform is given."""
    values = transform(NODES / t[:, None])
    found: Real = (values.real @ WEIGHTS) / t
    return found


def relaxation(stiffness: Stiffness, t: Real) -> Real:
    """Force after a unit step of the displacement."""
    return inverse(lambda s: stiffness(s) / s, t)


def creep(stiffness: Stiffness, t: Real) -> Real:
    """Displacement after a unit step of the force."""
    return inverse(lambda s: 1.0 / (s * stiffness(s)), t)


def to_history(stiffness: Stiffness, t: Real, x: Real) -> Real:
    """Force for a displacement on even samples that begins at rest, straight between them."""
    step = t[1] - t[0]
    ramp = np.concatenate(
        [[0.0], inverse(lambda s: stiffness(s) / s**2, step * np.arange(1, len(t)))]
    )
    bends = np.diff(np.diff(x, prepend=x[0]) / step, append=0.0)
    found: Real = np.convolve(bends, ramp)[: len(t)]
    return found


# --- materials: K(s), written out


def material(name: str, theta: dict[str, float]) -> Stiffness:
    """K(s) of a named model."""
    p = theta
    known: dict[str, Stiffness] = {
        "springpot": lambda s: p["c"] * s ** p["alpha"],
        "kelvin": lambda s: p["k"] + p["c"] * s,
        "maxwell": lambda s: p["k"] * p["c"] * s / (p["k"] + p["c"] * s),
        "zener": lambda s: p["k1"] + p["k2"] * p["c"] * s / (p["k2"] + p["c"] * s),
        "fractional-kelvin": lambda s: p["k"] + p["c"] * s ** p["alpha"],
        "fractional-maxwell": lambda s: 1.0 / (1.0 / p["k"] + s ** -p["alpha"] / p["c"]),
        "fractional-zener": lambda s: p["k1"] + 1.0 / (1.0 / p["k2"] + s ** -p["alpha"] / p["c"]),
    }
    return known[name]


# --- what is not linear, sample after sample


def played(x: Real, reach: float) -> Real:
    """The far end of a joint with play, one sample after the other."""
    end, there = x[0], np.empty(len(x))
    for i, here in enumerate(x.tolist()):
        end = min(max(end, here - reach), here + reach)
        there[i] = end
    return there


def clock(pace: Callable[[Real], Real], t: Real) -> Real:
    """Integral of a pace from 0 to t (n,), by Simpson's rule on a grid finer where t is short."""
    grid = np.concatenate([[0.0], np.geomspace(1e-4 * t[0], t[-1], 20001)])
    middle = 0.5 * (grid[1:] + grid[:-1])
    parts = np.diff(grid) * (pace(grid[1:]) + 4.0 * pace(middle) + pace(grid[:-1])) / 6.0
    found: Real = np.interp(t, grid, np.concatenate([[0.0], np.cumsum(parts)]))
    return found
