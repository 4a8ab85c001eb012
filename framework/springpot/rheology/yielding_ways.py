"""A spring that yields gradually, along any course of its displacement.

Bouc and Wen's element (see `hysteresis`) knows no rate: along one straight way, its force z counted
in the direction of the motion, dz / da = g(z) with a = k |x| / F. Here g is 1 - z^n where the force
holds against the motion and 1 + (2 beta - 1) |z|^n where it goes with it, so that the way from
nothing to z is one function Phi(z), an integral of 1/g, for all ways: z follows from Phi's inverse,
and its derivatives by n and beta from those of Phi. Phi is worked out by Gauss's rule on a grid
that is fine where z^n is not smooth, and read between by cubics of its exact slopes.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from ..numerics import SMALLEST
from .points import Real

CELLS = 160
"""On either side of no force; the cubics between are good to 1e-6 for n from 0.5 to 8."""
GRADED = 3.0
"""Power by which the cells are the finer the nearer to no force, where z^n has a kink."""
YIELDED = 30.0
"""Of -ln(1 - z), from which z is one but for rounding."""
NODES, WEIGHTS = np.polynomial.legendre.leggauss(5)


class Ways(NamedTuple):
    """The way to a force and back, by q: z where it is negative, else -ln(1 - z).

    Attributes
    ----------
    way, place : CubicHermiteSpline
        Phi by q, and q by Phi.
    by_n, by_beta : CubicHermiteSpline
        Derivatives of Phi at the same z, by q.
    """

    way: CubicHermiteSpline
    place: CubicHermiteSpline
    by_n: CubicHermiteSpline
    by_beta: CubicHermiteSpline


def _slopes(q: Real, n: float, beta: float) -> tuple[Real, Real, Real, Real]:
    """1/g, the derivatives of that by n and beta, and dz / dq."""
    ahead = q > 0.0
    size = np.where(ahead, -np.expm1(-np.abs(q)), np.abs(q))
    log_size = np.log(np.maximum(size, SMALLEST))
    power = np.exp(n * log_size)
    share = np.where(ahead, -1.0, 2.0 * beta - 1.0)
    g = np.where(ahead, -np.expm1(n * log_size), 1.0 + share * power)
    g = np.maximum(g, SMALLEST)
    by_n = -share * power * log_size / g**2
    by_beta = np.where(ahead, 0.0, -2.0 * power / g**2)
    return 1.0 / g, by_n, by_beta, np.where(ahead, np.exp(-np.abs(q)), 1.0)


@lru_cache(maxsize=8)
def ways(n: float, beta: float) -> Ways:
    """Phi and its derivatives for one sharpness and one hysteretic share."""
    graded = (np.arange(CELLS + 1) / CELLS) ** GRADED
    q = np.concatenate([-graded[::-1], YIELDED * graded[1:]])
    half = 0.5 * np.diff(q)
    inner = q[:-1, None] + half[:, None] * (1.0 + NODES)
    *slopes, stretch = _slopes(inner, n, beta)
    *ends, at_ends = _slopes(q, n, beta)
    splines = []
    for each, end in zip(slopes, ends, strict=True):
        cells = ((each * stretch) @ WEIGHTS) * half
        value = np.concatenate([[0.0], np.cumsum(cells)])
        splines.append((value - value[CELLS], end * at_ends))
    (way, rate), by_n, by_beta = splines
    return Ways(
        CubicHermiteSpline(q, way, rate),
        CubicHermiteSpline(way, q, 1.0 / rate),
        CubicHermiteSpline(q, *by_n),
        CubicHermiteSpline(q, *by_beta),
    )


def yielding_force(
    x: Real, k: float, force: float, n: float, beta: float
) -> tuple[Real, tuple[Real, ...]]:
    """The force (m,) of the element that was at rest at x[0], and its derivatives by all four.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology.yielding_ways import yielding_force
    >>> value, _ = yielding_force(np.array([0.0, 1e-3, 9.0, 8.999]), 5.0, 1.0, 1.0, 0.5)
    >>> value.round(4)
    array([0.   , 0.005, 1.   , 0.995])
    """
    table, z, by = ways(n, beta), np.zeros(len(x)), np.zeros((4, len(x)))
    steps = np.diff(x)
    directions = np.sign(steps)
    for begin, end in _ways_of(directions):
        sign = 1.0 if directions[begin:end].sum() > 0.0 else -1.0
        rows = slice(begin + 1, end + 1)
        way = np.cumsum(np.abs(steps[begin:end]))
        z[rows], by[:, rows] = _along(table, sign, z[begin], by[:, begin], way, (k, force, n, beta))
    return force * z, (force * by[0], z + force * by[1], force * by[2], force * by[3])


def yielding_step(
    before: float, way: float, k: float, force: float, n: float, beta: float
) -> float:
    """The force after one more straight way."""
    sign = -1.0 if way < 0.0 else 1.0
    length = np.array([abs(way)])
    z, _ = _along(ways(n, beta), sign, before / force, np.zeros(4), length, (k, force, n, beta))
    return force * float(z[0])


def _ways_of(directions: Real) -> list[tuple[int, int]]:
    """First and last knot of each way in one direction; where it rests, it goes on as it went."""
    moving = np.flatnonzero(directions)
    turns = moving[1:][directions[moving[1:]] != directions[moving[:-1]]]
    ends = [0, *turns.tolist(), len(directions)]
    return list(pairwise(ends))


def _along(
    table: Ways,
    sign: float,
    before: float,
    by_before: Real,
    way: Real,
    theta: tuple[float, float, float, float],
) -> tuple[Real, Real]:
    """The force over F (m,) along one way, and its derivatives (4, m) by all four parameters."""
    k, force, n, beta = theta
    start = sign * before
    q_start = start if start < 0.0 else float(-np.log1p(-min(start, 1.0 - SMALLEST)))
    q_start = min(q_start, YIELDED)
    reached = table.way(q_start) + k * way / force
    q = np.clip(table.place(np.minimum(reached, table.place.x[-1])), -1.0, YIELDED)
    z = np.where(q > 0.0, -np.expm1(-np.maximum(q, 0.0)), q)
    g_start = 1.0 / _slopes(np.array([q_start]), n, beta)[0][0]
    moved = np.outer(sign * by_before / g_start, np.ones(len(way)))
    moved[0] += way / force
    moved[1] -= k * way / force**2
    moved[2] -= table.by_n(q) - table.by_n(q_start)
    moved[3] -= table.by_beta(q) - table.by_beta(q_start)
    return sign * z, sign * moved / _slopes(q, n, beta)[0]
