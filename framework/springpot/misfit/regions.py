"""Where a residual may stand out: blocks of points to one side, and frequencies of the mains.

Along frequency, temperature and amplitude the block whose mean is furthest from nothing, in units
of its noise, is taken out, then the next one (a scan statistic, Kulldorff 1997,
doi:10.1080/03610929708831995). How far the furthest may be by chance is found from simulated noise
on the same grid, so that looking at many blocks invents nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from math import inf
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from springpot.distributions import chi2_quantile
from springpot.rheology.points import Real

from ..numerics import ROUNDING, SMALLEST

Rows: TypeAlias = NDArray[np.int64]
Span: TypeAlias = tuple[int, int]

MOST_BLOCKS = 12
"""Blocks taken out at most."""
WHOLE = 0.8
"""Share of its points that a block must still hold, lest it describe those already told of."""
DRAWS = 120
"""Simulated residuals; the tail beyond them is fitted."""
FEW = 12000
"""Points of all simulated residuals together up to which there are more of them.

A rough threshold errs much where
few points tell their own noise."""
SCALES = 2000
"""Values of the scale of the noise for which the chance of a residual is averaged."""


@dataclass(frozen=True, eq=False)
class MeasuredAxis:
    """One direction in which a measurement extends.

    Attributes
    ----------
    name : str
        ``frequency``, ``temperature`` or ``amplitude``.
    level : ndarray of int, shape (n,)
        Number of the interval that each point lies in, ascending.
    points_of_each : float
        Distinct values in one interval.
    """

    name: str
    level: Rows
    points_of_each: float = 1.0

    @property
    def count(self) -> int:
        """Number of intervals."""
        return int(self.level.max()) + 1


@dataclass(frozen=True, eq=False)
class Region:
    """A block of points.

    Attributes
    ----------
    spans : tuple of (int, int)
        First interval and the one after the last, along each axis.
    rows : ndarray of int
        Its points.
    sigma : float
        Mean of its residual in standard deviations of that mean, signed.
    """

    spans: tuple[Span, ...]
    rows: Rows
    sigma: float


class Blocks:
    """All blocks of a measurement.

    Parameters
    ----------
    axes : sequence of MeasuredAxis
        Directions in which it extends.
    """

    def __init__(self, axes: Sequence[MeasuredAxis]) -> None:
        self.axes = tuple(axes)
        self.shape = tuple(axis.count for axis in axes)
        self._cell = np.ravel_multi_index(tuple(axis.level for axis in axes), self.shape)
        self._ends = [
            np.triu_indices(count + 1, 1) for count in self.shape
        ]  # first interval, the one after the last
        self._count = self._sums(np.ones(len(self._cell)))
        # Costs of the axes add up, as chances of independent choices multiply.
        costs = [self._cost(axis) for axis in range(len(self.shape))]
        self._costs = np.asarray(reduce(np.add.outer, costs), dtype=np.float64)

    def _cost(self, axis: int) -> Real:
        """What it costs to name a part of an axis.

        Of blocks that tell as much the plainer one is taken.
        """
        first, stop = self._ends[axis]
        return np.where(stop - first == self.shape[axis], 0.0, 2.0 * np.log(len(first)))

    def _sums(self, values: Real) -> Real:
        """Sums of point values (..., n) over every block; shape (..., blocks of each axis)."""
        # By cumulative sums along each axis in turn: summed block by block every point would be
        # added many times.
        rows = values.reshape(-1, len(self._cell))
        size = int(np.prod(self.shape))
        cells = self._cell + size * np.arange(len(rows))[:, None]
        sums = np.bincount(cells.ravel(), rows.ravel(), size * len(rows))
        sums = sums.reshape(len(rows), *self.shape)
        for axis, (first, stop) in enumerate(self._ends, 1):
            before = np.zeros_like(np.take(sums, [0], axis=axis))
            summed = np.concatenate([before, np.cumsum(sums, axis=axis)], axis=axis)
            sums = np.take(summed, stop, axis=axis) - np.take(summed, first, axis=axis)
        return np.asarray(sums.reshape(*values.shape[:-1], *sums.shape[1:]), dtype=np.float64)

    def threshold(self, alarm: float, scale: Real | float, rng: np.random.Generator) -> float:
        """Deviations that the furthest block of pure noise exceeds with the chance `alarm`.

        In standard deviations.

        Parameters
        ----------
        alarm : float
            The chance.
        scale : ndarray, shape (m,), or float
            Equally likely values of estimated over true variance of the noise, see `scales`.
        rng : numpy.random.Generator
            For the noise.
        """
        n = len(self._cell)
        draws = max(DRAWS, FEW // n)
        # Of what holds no point nothing is far.
        root = np.sqrt(np.where(self._count > 0, self._count, np.inf))
        # As many at once as the memory beside a processor holds: 256 kB.
        at_once = max(1, 2**15 // self._count.size)
        most = [
            np.max(np.abs(self._sums(noise) / root).reshape(len(noise), -1), axis=1)
            for noise in np.split(rng.standard_normal((draws, n)), range(at_once, draws, at_once))
        ]
        return rare(np.concatenate(most), alarm, np.sqrt(scale))

    def regions(self, whitened: Real, threshold: float) -> list[Region]:
        """Blocks in which a residual is off, each point in one of them at most.

        Parameters
        ----------
        whitened : ndarray, shape (n,)
            The residual in units of its noise.
        threshold : float
            Standard deviations from which a block counts.
        """
        free = np.ones(len(whitened), dtype=bool)
        found: list[Region] = []
        # The furthest is taken out before the next is sought: every block that touches a large
        # misfit is off.
        for _ in range(MOST_BLOCKS):
            count = self._sums(free.astype(float))
            usable = (count > 0) & (count >= WHOLE * self._count)
            sigma = self._sums(np.where(free, whitened, 0.0)) / np.sqrt(np.maximum(count, 1.0))
            # The threshold is that of the plain mean, as simulated; the costs only choose among
            # blocks beyond it.
            worth = np.where(usable & (np.abs(sigma) > threshold), sigma**2 - self._costs, -np.inf)
            best = np.unravel_index(int(np.argmax(worth)), worth.shape)
            if worth[best] == -np.inf:
                break
            spans = tuple(
                (int(first[i]), int(stop[i]))
                for (first, stop), i in zip(self._ends, best, strict=True)
            )
            rows = self._rows(spans, free)
            found.append(Region(self._tight(rows), rows, float(sigma[best])))
            free[rows] = False
        return self._joined(found, whitened)

    def _rows(self, spans: Sequence[Span], free: NDArray[np.bool_]) -> Rows:
        inside = free.copy()
        for axis, (first, stop) in zip(self.axes, spans, strict=True):
            inside &= (axis.level >= first) & (axis.level < stop)
        return np.flatnonzero(inside)

    def _tight(self, rows: Rows) -> tuple[Span, ...]:
        """The smallest block around some points."""
        return tuple(
            (int(axis.level[rows].min()), int(axis.level[rows].max()) + 1) for axis in self.axes
        )

    def _joined(self, found: list[Region], whitened: Real) -> list[Region]:
        """Neighbouring blocks off to the same side and differing along one axis only are one."""
        # Of one broad misfit the furthest block is often a part, and the rest of it is found as the
        # next.
        for i, one in enumerate(found):
            for k in range(i):
                other = found[k]
                if one.sigma * other.sigma > 0 and _neighbours(one.spans, other.spans):
                    rows = np.union1d(one.rows, other.rows)
                    sigma = float(np.sum(whitened[rows]) / np.sqrt(len(rows)))
                    # From the start again: the joined block may touch one that neither of the two
                    # touched.
                    rest = [each for j, each in enumerate(found) if j not in (i, k)]
                    return self._joined([Region(self._tight(rows), rows, sigma), *rest], whitened)
        return found


def scales(dof: float) -> Real | float:
    """Equally likely values (SCALES,) of estimated over true variance, by degrees of freedom."""
    if dof == inf:
        return 1.0
    return np.asarray(
        chi2_quantile((np.arange(SCALES) + 0.5) / SCALES, dof) / dof, dtype=np.float64
    )


def rare(largest: Real, alarm: float, divisor: Real | float = 1.0) -> float:
    """The value that the largest of many, over a divisor, exceeds with the chance `alarm`.

    Parameters
    ----------
    largest : ndarray, shape (m,)
        Draws of the largest, whose tail follows Gumbel's law: a hundred draws do not reach it
        themselves.
    alarm : float
        The chance.
    divisor : ndarray, shape (k,), or float
        Equally likely values of what it is divided by. A scale from few degrees of freedom has a
        heavy tail, to which Gumbel's law would be blind.
    """
    # By moments, which have a closed form.
    width = max(float(np.std(largest)) * np.sqrt(6.0) / np.pi, SMALLEST)
    middle = float(np.mean(largest)) - width * np.euler_gamma
    undivided = middle - width * float(np.log(-np.log1p(-alarm)))
    low, high = undivided / float(np.max(divisor)), undivided / float(np.min(divisor))

    def above(value: float) -> float:
        with np.errstate(over="ignore"):
            mean_count = np.exp((middle - value * divisor) / width)
        return float(np.mean(-np.expm1(-mean_count))) - alarm

    # Where the scale is known there is nothing between the two.
    if high - low <= ROUNDING * abs(high):
        return float(low)
    return float(brentq(above, low, high))


def _neighbours(one: Sequence[Span], other: Sequence[Span]) -> bool:
    """Whether two blocks differ along one axis only, and touch there."""
    apart = [(a, b) for a, b in zip(one, other, strict=True) if a != b]
    return len(apart) == 1 and (
        apart[0][0][1] == apart[0][1][0] or apart[0][1][1] == apart[0][0][0]
    )
