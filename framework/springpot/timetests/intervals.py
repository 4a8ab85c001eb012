"""Intervals of a fit to tests in time beyond those of its slopes: profiles, simulated tests."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from springpot.distributions import ends_of_draws, student
from springpot.identification.fitting import RESAMPLES
from springpot.identification.intervals import Path, Profile, beside_endless
from springpot.identification.leastsquares import Evaluate, Rows, levenberg_marquardt, one_by_one
from springpot.identification.result import Identification
from springpot.identification.value import LOST
from springpot.misfit.residuals_of_tests import TestPart
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL

from .exponentials import UnfollowedError, quick_parts
from .native import Minimum, TimeSearch


def with_intervals(
    result: Identification, search: TimeSearch, found: Minimum, kind: str, seed: int
) -> Identification:
    """The result with the ends of its intervals, where these are not those of the slopes alone.

    Parameters
    ----------
    result : Identification
        With those of the slopes.
    search, found
        Where it comes from.
    kind : str
        ``slopes`` leaves them as they are, and ``jacobian`` where all parameters have an end;
        ``profile`` and ``bootstrap`` are those of `springpot.identify`.
    seed : int
        Of simulated noise.
    """
    endless = result.high > LOST * np.maximum(result.low, 0.0)
    detail = any(parameter.detail for parameter in result.model.parameters)
    if kind == "slopes" or (kind == "jacobian" and (detail or not endless.any())):
        return result
    valley = _Valley.of(search, found)
    if kind == "jacobian":
        low, high = valley.beside_endless(result)
        return replace(result, low=low, high=high)
    if kind == "profile":
        told = valley.profiled(result)
        low, high = np.array([(each.low, each.high) for each in told]).T
        return replace(result, low=low, high=high, verdicts=tuple(each.verdict for each in told))
    below, above = valley.simulated(np.random.default_rng([seed, 1]))
    return replace(result, low=below, high=above)


def beside_limits(fit: Identification, parts: Sequence[TestPart]) -> Identification:
    """A fit whose intervals hold also where a parameter without an end is elsewhere.

    Parameters
    ----------
    fit : Identification
        With the intervals of the slopes.
    parts : sequence of TestPart
        To what it was fitted.
    """
    search = TimeSearch(fit.model, parts, fit.reference, [fit.theta], thorough=False)
    at = search.coordinates.u(fit.theta, search.size)
    return with_intervals(fit, search, Minimum(at, parts, (), 0, True), "jacobian", 0)


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
            weight.append(np.full(len(value), part.beside(value, len(u)) ** -0.5))
        return cls(plain, parts, u, np.concatenate(weight))

    def at(self, u: Real) -> tuple[Real, Real]:
        """Residuals (m,) and their slopes (p, m) at u (p,), of unit variance."""
        value, slopes = self.search.guarded(self.parts, u, False)
        return value * self.weight, slopes * self.weight

    @property
    def evaluate(self) -> Evaluate:
        """The same at many places."""
        return one_by_one(self.at)

    @property
    def quantile(self) -> float:
        """Standard deviations to the end of an interval."""
        return student(INTERVAL, max(len(self.weight) - len(self.u), 1))

    def paths(self, u: Real) -> list[Path]:
        """One along each parameter from a best fit u (p,) on."""
        return [Path(self.search.coordinates, u, i, self.evaluate) for i in range(len(u))]

    def beside_endless(self, result: Identification) -> tuple[Real, Real]:
        """Intervals by the slopes, also where a parameter without an end is elsewhere."""
        return beside_endless(self.paths(self.u), self.quantile**2, result.low, result.high)

    def profiled(self, result: Identification) -> list[Profile]:
        """Of each parameter: ends where the objective has risen by the quantile's square."""
        quantile = self.quantile
        # By fixed exponentials the bottom lies a little aside.
        best = levenberg_marquardt(self.evaluate, self.u[None], *self.search.coordinates.bounds)
        u, cost = best.u[0], float(best.cost[0])
        return [
            path.profile(self._step(result, path.i, quantile), cost, quantile**2)
            for path in self.paths(u)
        ]

    def _step(self, result: Identification, i: int, quantile: float) -> float:
        """A standard deviation of coordinate i by the slopes."""
        low, high = self.search.coordinates.u(
            np.array([result.low, result.high]), self.search.size
        )[:, i]
        return float(0.5 * (high - low) / quantile)

    def simulated(self, rng: np.random.Generator) -> Real:
        """Quantiles (2, p) of fits to tests that the model has given, with their noise."""
        whole, _ = self.at(self.u)
        # Of a test that the model foretells, the residual is that of its noise alone.
        drawn = rng.standard_normal((RESAMPLES, len(whole)))

        def evaluate(u: Real, rows: Rows) -> tuple[Real, Real]:
            value, slopes = self.evaluate(u, rows)
            return value - whole - drawn[rows], slopes

        starts = np.tile(self.u, (RESAMPLES, 1))
        fits = levenberg_marquardt(evaluate, starts, *self.search.coordinates.bounds)
        return ends_of_draws(np.array([self.search.theta(u) for u in fits.u]), INTERVAL)
