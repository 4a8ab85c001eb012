"""Intervals of a fit of tests in time: by slopes, by profiles, and by fits of simulated tests."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import ends_of_draws, student
from springpot.errors import SpringpotError
from springpot.identification.fitting import RESAMPLES
from springpot.identification.held_material import ends_of_amounts
from springpot.identification.intervals import (
    Path,
    Profile,
    beside_endless,
    inverse_of,
    off_their_slopes,
)
from springpot.identification.leastsquares import Rows, levenberg_marquardt
from springpot.identification.result import Identification
from springpot.identification.value import LOST
from springpot.misfit.residuals_of_tests import Residual, TestPart
from springpot.numerics import NEGLIGIBLE
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL, VERDICT

from .exponentials import QuickPart, UnfollowedError, quick_parts
from .material import MaterialSearch, beside_effects, coordinates_around, spectrum_of
from .native import Minimum, TimeSearch, after_many_cycles


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
    if kind == "slopes":
        return result
    valley = _Valley.of(search, found)
    if kind == "jacobian":
        low, high = valley.where_slopes_tell(result)
        return replace(result, low=low, high=high)
    if kind == "profile":
        told = valley.profiled(result)
        low, high = _ends_of(told)
        return replace(result, low=low, high=high, verdicts=tuple(each.verdict for each in told))
    below, above = valley.simulated(np.random.default_rng([seed, 1]))
    return replace(result, low=below, high=above)


@dataclass(frozen=True, eq=False)
class MaterialTangent:
    """Tests by the lines of a material and those of a lattice that carry nothing, near a fit.

    Attributes
    ----------
    search : MaterialSearch
        With all these lines, K_e, c and what each carries among its weights.
    u : ndarray, shape (q,)
        Coordinates of the effects.
    """

    search: MaterialSearch
    u: Real

    @classmethod
    def of(
        cls, model: Model, theta: Real, parts: Sequence[TestPart], reference: float
    ) -> MaterialTangent:
        """At the parameters (p,) of a fit, in the noise that it leaves; see `spectral`."""
        lines = spectrum_of(model, theta)
        own = theta[2 + len(lines.rates) :]
        parts = [
            part.with_scale(part.scale * np.sqrt(part.beside(left, len(theta))))
            for part in parts
            for left in [part.residual(model, theta, reference).value]
        ]
        around = coordinates_around(model, TimeSearch(model, parts, reference, thorough=False))
        search = MaterialSearch(model, parts, reference, around, lines, own)
        return cls(search, around.u(own.copy(), search.size))

    @cached_property
    def _slopes(self) -> tuple[Real, Real, Real]:
        """Residuals (n,) and their derivatives by the weights (n, w) and by u (n, q)."""
        return self.search.slopes(self.search.weights, self.u)

    @property
    def carries(self) -> NDArray[np.bool_]:
        """Which of K_e, c and the lines (w,) are there."""
        return self.search.weights > 0.0

    def ends_of_amounts(self, quantile: float) -> Sequence[tuple[float, float]]:
        """Intervals of K_e and c, as wide as other lines leave them; none of tests not linear.

        The quantile is what lies between the value and an end, in standard deviations.
        """
        # Under a load that was imposed a test is not linear in the weights.
        if not self.search.linear:
            return []
        value, by_weights, by_u = self._slopes
        columns = beside_effects(by_u, by_weights)
        target = beside_effects(by_u, by_weights @ self.search.weights - value)
        return ends_of_amounts(columns, target, 2 * [quantile**2])

    @property
    def leanings(self) -> Real:
        """Moves (w + q, b) of all parameters where what carries nothing carries something.

        Of each by what raises the sum of squares by one, all that carries making up for it. The sum
        rises from the first: the lines were chosen so that none of these is wanted.
        """
        value, by_weights, by_u = self._slopes
        carries, count = self.carries, int(np.count_nonzero(self.carries))
        asked = np.flatnonzero(~carries)
        if not self.search.linear:
            # Under a load a dashpot of no weight gives way at once: its slope there tells nothing.
            asked = asked[asked != 1]
        others = np.concatenate([by_weights[:, carries], by_u], axis=1)
        lines = by_weights[:, asked]
        made_up = np.linalg.lstsq(others, lines, rcond=1e-8)[0]
        left = lines - others @ made_up
        squares, rise = np.sum(left**2, axis=0), np.maximum(value @ left, 0.0)
        # What all others can make up for tells nothing of this one.
        told = squares > NEGLIGIBLE * np.sum(lines**2, axis=0)
        squares, rise = squares[told], rise[told]
        amount = 1.0 / (rise + np.sqrt(rise**2 + squares))
        taken = made_up[:, told] * amount
        turn = self.search.coordinates.slopes(self.search.own(self.u), self.search.size)
        moves = np.zeros((len(carries) + len(self.u), len(amount)))
        moves[np.flatnonzero(carries)] = -taken[:count]
        moves[len(carries) :] = -turn @ taken[count:]
        moves[asked[told], np.arange(len(amount))] = amount
        return moves


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

    As in the covariance: samples whose misses are alike count once. What exponentials miss at the
    minimum they miss about it too.
    """

    search: TimeSearch
    parts: Sequence[TestPart]
    whole: Sequence[TestPart]
    u: Real

    @classmethod
    def of(cls, search: TimeSearch, found: Minimum) -> _Valley:
        plain = copy(search)
        plain.coordinates = replace(search.coordinates, pairs=())
        u = plain.coordinates.u(search.theta(found.u).copy(), plain.size)
        parts = quick_parts([after_many_cycles(each) for each in search.quickly(found.parts)])
        try:
            plain.residual(parts, u)
        # A mass that swings or a loss that is not causal is no sum of exponentials.
        except UnfollowedError:
            parts = [after_many_cycles(each) for each in found.parts]
        return cls(plain, parts, found.parts, u)

    @cached_property
    def weighed(self) -> tuple[Real, Real]:
        """What is taken off the residuals (m,) over the noise, and their weights (m,)."""
        aside, weight = [], []
        for part, whole in zip(self.parts, self.whole, strict=True):
            (value, _), (known, _) = (
                self.search.residual([each], self.u) for each in (part, whole)
            )
            # Some samples of a long record know how far others reach, not where all are best; one
            # that is taken to have gone on for longer, neither.
            other = len(value) < len(known) or after_many_cycles(whole) is not whole
            aside.append(value if other else value - known)
            weight.append(np.full(len(value), whole.beside(known, len(self.u)) ** -0.5))
        return np.concatenate(aside), np.concatenate(weight)

    def plainly(self, u: Real, _: Rows) -> tuple[Real, Real]:
        """Residuals (g, m) over the noise and their slopes (g, p, m) at each u (g, p)."""
        theta = np.array([self.search.theta(one) for one in u])
        found = zip(*(self._answers(part, theta) for part in self.parts), strict=True)
        values, slopes = [], []
        with np.errstate(all="ignore"):
            for at, each in zip(theta, found, strict=True):
                values.append(np.concatenate([one.value for one in each]))
                by_theta = np.concatenate([one.by_theta for one in each]).T.copy()
                slopes.append(self.search.coordinates.carry(by_theta, at, self.search.size))
        # What cannot be followed is endless, so that a step there is taken back.
        return np.nan_to_num(np.stack(values), nan=np.inf), np.nan_to_num(np.stack(slopes))

    def _answers(self, part: TestPart, theta: Real) -> Iterator[Residual]:
        model, reference = self.search.model, self.search.reference
        if isinstance(part, QuickPart):
            # Where one of them cannot be answered at all, each is asked by itself.
            with suppress(SpringpotError):
                yield from list(part.nearly(model, theta, reference, range(theta.shape[1])))
                return
        count = part.count()
        for one in theta:
            try:
                yield part.residual(model, one, reference)
            except SpringpotError:
                yield Residual(np.full(count, np.nan), np.zeros((count, len(one))))

    def evaluate(self, u: Real, rows: Rows) -> tuple[Real, Real]:
        """The same of unit variance, without what exponentials miss."""
        value, slopes = self.plainly(u, rows)
        aside, weight = self.weighed
        return (value - aside) * weight, slopes * weight

    @property
    def left(self) -> Real:
        """Residuals (m,) at the minimum."""
        left: Real = self.evaluate(self.u[None], np.arange(1))[0][0]
        return left

    @property
    def quantile(self) -> float:
        """Standard deviations to the end of an interval."""
        return student(INTERVAL, max(len(self.weighed[0]) - len(self.u), 1))

    def paths(self) -> list[Path]:
        """One along each parameter."""
        count = len(self.u)
        return [Path(self.search.coordinates, self.u, i, self.evaluate) for i in range(count)]

    def where_slopes_tell(self, result: Identification) -> tuple[Real, Real]:
        """Intervals by the slopes, by profiles where the valley is bent.

        Also where a parameter without an end is elsewhere.
        """
        low, high = result.low, result.high
        # What a wrong model leaves is no scatter that a rise of the objective could be told by.
        at_noise = all(row.over_floor <= VERDICT.agrees for row in result.parts)
        if at_noise and self._bent(result):
            low, high = _ends_of(self.profiled(result))
        if not np.any(high > LOST * np.maximum(low, 0.0)):
            return low, high
        return beside_endless(self.paths(), self.quantile**2, low, high)

    def _bent(self, result: Identification) -> bool:
        """Whether to the ends of an interval the objective rises otherwise than by its slopes."""
        at, low, high = self.search.coordinates, result.low, result.high
        rows = np.flatnonzero(np.isfinite(high - low) & ~(at.log & (high > LOST * low)))
        reach = self._reach(result)[rows]
        _, [slopes] = self.plainly(self.u[None], np.arange(1))
        covariance = inverse_of(slopes @ slopes.T)
        steps = covariance[rows] * (reach / np.diag(covariance)[rows])[:, None]
        return bool(off_their_slopes(self.plainly, self.u, steps, at.bounds).any())

    def profiled(self, result: Identification) -> list[Profile]:
        """Of each parameter: ends where the objective has risen by the quantile's square."""
        quantile, cost = self.quantile, float(np.sum(self.left**2))
        steps = (self._reach(result) / quantile).tolist()
        return [
            path.profile(step, cost, quantile**2)
            for path, step in zip(self.paths(), steps, strict=True)
        ]

    def _reach(self, result: Identification) -> Real:
        """Half of each interval by the slopes, in coordinates (p,)."""
        ends = self.search.coordinates.u(np.array([result.low, result.high]), self.search.size)
        half: Real = 0.5 * (ends[1] - ends[0])
        return half

    def simulated(self, rng: np.random.Generator) -> Real:
        """Quantiles (2, p) of fits to tests that the model has given, with their noise."""
        whole = self.left
        # Of a test that the model foretells, the residual is that of its noise alone.
        drawn = rng.standard_normal((RESAMPLES, len(whole)))

        def evaluate(u: Real, rows: Rows) -> tuple[Real, Real]:
            value, slopes = self.evaluate(u, rows)
            return value - whole - drawn[rows], slopes

        starts = np.tile(self.u, (RESAMPLES, 1))
        fits = levenberg_marquardt(evaluate, starts, *self.search.coordinates.bounds)
        return ends_of_draws(np.array([self.search.theta(u) for u in fits.u]), INTERVAL)


def _ends_of(told: Sequence[Profile]) -> tuple[Real, Real]:
    low, high = np.array([(each.low, each.high) for each in told]).T
    return low, high
