"""Intervals of a fit to tests in time beyond those of its slopes: profiles, simulated tests."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from springpot.distributions import student
from springpot.identification.fitting import RESAMPLES
from springpot.identification.intervals import Path, Profile
from springpot.identification.leastsquares import Rows, levenberg_marquardt
from springpot.identification.result import Identification
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL

from .exponentials import UnfollowedError, quick_parts
from .native import Minimum, TimeSearch
from .residuals_of_tests import TestPart

FIRST = 1e-3
"""First step along a profile, in coordinates, where the slopes know none."""


def with_intervals(
    result: Identification, search: TimeSearch, found: Minimum, kind: str, seed: int
) -> Identification:
    """The result with the ends of its intervals by ``profile`` or ``bootstrap``.

    Parameters
    ----------
    result : Identification
        With those of the slopes.
    search, found
        Where it comes from.
    kind : str
        ``jacobian`` leaves them as they are.
    seed : int
        Of simulated noise.
    """
    if kind == "jacobian":
        return result
    valley = _Valley.of(search, found)
    if kind == "profile":
        low, high, verdicts = zip(*valley.profiled(result), strict=True)
        return replace(result, low=np.array(low), high=np.array(high), verdicts=verdicts)
    below, above = valley.simulated(np.random.default_rng([seed, 1]))
    return replace(result, low=below, high=above)


@dataclass(frozen=True, eq=False)
class _Valley:
    """The objective about a minimum, each test's residuals over what they scatter by.

    As in the covariance: samples whose misses are alike count once.
    """

    search: TimeSearch
    parts: Sequence[TestPart]
    u: Real
    weight: Real

    @classmethod
    def of(cls, search: TimeSearch, found: Minimum) -> _Valley:
        plain = copy(search)
        plain.coordinates = replace(search.coordinates, pairs=())
        u = plain.coordinates.u(search.theta(found.u).copy(), plain.size)
        parts: Sequence[TestPart] = quick_parts(found.parts)
        try:
            plain.residual(parts, u)
        # A mass that swings or a loss that is not causal is no sum of exponentials.
        except UnfollowedError:
            parts = found.parts
        weight = []
        for part in parts:
            value, _ = plain.residual([part], u)
            scatter = 1.0
            if len(value) > len(u):
                scatter = max(1.0, part.sampled(value))
            weight.append(np.full(len(value), scatter**-0.5))
        return cls(plain, parts, u, np.concatenate(weight))

    def at(self, u: Real) -> tuple[Real, Real]:
        """Residuals (m,) and their slopes (p, m) at u (p,), of unit variance."""
        value, slopes = self.search.guarded(self.parts, u, False)
        return value * self.weight, slopes * self.weight

    def evaluate(self, u: Real, rows: Rows) -> tuple[Real, Real]:
        """The same at many places (k, p)."""
        pairs = [self.at(one) for one in u]
        return np.stack([value for value, _ in pairs]), np.stack([slopes for _, slopes in pairs])

    def profiled(self, result: Identification) -> list[Profile]:
        """Of each parameter: ends where the objective has risen by the quantile's square."""
        quantile = student(INTERVAL, max(len(self.weight) - len(self.u), 1))
        low, high = self.search.coordinates.bounds
        # By fixed exponentials the bottom lies a little aside.
        best = levenberg_marquardt(self.evaluate, self.u[None], low, high)
        u, cost = best.u[0], float(best.cost[0])
        return [
            Path(self.search.coordinates, u, i, self.evaluate).profile(
                self._step(result, i, quantile), cost, quantile**2
            )
            for i in range(len(u))
        ]

    def _step(self, result: Identification, i: int, quantile: float) -> float:
        """A standard deviation of coordinate i by the slopes."""
        low, high = self.search.coordinates.u(
            np.array([result.low, result.high]), self.search.size
        )[:, i]
        step = 0.5 * (high - low) / quantile
        if not 0.0 < step < np.inf:
            return FIRST
        return float(step)

    def simulated(self, rng: np.random.Generator) -> tuple[Real, Real]:
        """Quantiles (p,) of fits to tests as the model would have given them, with their noise."""
        whole, _ = self.at(self.u)
        # Of a test that the model foretells, the residual is that of its noise alone.
        drawn = rng.standard_normal((RESAMPLES, len(whole)))

        def evaluate(u: Real, rows: Rows) -> tuple[Real, Real]:
            value, slopes = self.evaluate(u, rows)
            return value - whole - drawn[rows], slopes

        low, high = self.search.coordinates.bounds
        starts = np.tile(self.u, (RESAMPLES, 1))
        shape = starts.shape
        fits = levenberg_marquardt(
            evaluate, starts, np.broadcast_to(low, shape), np.broadcast_to(high, shape)
        )
        theta = np.array([self.search.theta(u) for u in fits.u])
        tail = 50.0 * (1.0 - INTERVAL)
        below, above = np.percentile(theta, [tail, 100.0 - tail], axis=0)
        return below, above
