"""The ledger owns the truth about a run: what was evaluated, what was best.

No optimiser is given a reference to it, only a `Recorder`, which asks it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf
from typing import TypeAlias

import numpy as np

from springpot.rheology.points import Real

from .problem import Searched

Diary: TypeAlias = list[tuple[Real, Real | None]]
"""Points (d,) or (m, d) with penalty factors (m,), in the order of evaluation."""


class BudgetSpent(BaseException):
    """Ends a run; not an `Exception`, so that a library's own handlers do not swallow it."""


@dataclass(eq=False)
class Ledger:
    """The truth about a run.

    See `springpot.identification.Recorder` for what it does and its parameters.

    Attributes
    ----------
    evaluations, gradients, batched : int
        Points evaluated, how many of them with a derivative, and how many in calls for several at
        once.
    best, best_x : float, ndarray
        Smallest objective seen and where, shape (d,); empty before the first finite value.
    best_factor : float
        Penalty that is in it.
    trace : list of (int, float)
        Evaluation number and objective at every improvement.
    """

    problem: Searched
    budget: int
    target: float = -inf
    diary: Diary | None = None
    evaluations: int = field(default=0, init=False)
    gradients: int = field(default=0, init=False)
    batched: int = field(default=0, init=False)
    best: float = field(default=inf, init=False)
    best_x: Real = field(default_factory=lambda: np.empty(0), init=False)
    best_factor: float = field(default=1.0, init=False)
    trace: list[tuple[int, float]] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        self._lowest, self._highest = self.problem.space.lowest, self.problem.space.highest
        # Looked up once: it is called at every evaluation of most optimisers.
        self._evaluate = self.problem.evaluate
        # Falls to the evaluations made when the target is met, so that one comparison guards the
        # hot path.
        self._limit = self.budget

    @property
    def spent(self) -> bool:
        """Whether the budget is used up."""
        return self.evaluations >= self.budget

    @property
    def met(self) -> bool:
        """Whether the target is reached."""
        return self.best <= self.target

    @property
    def left(self) -> int:
        """Evaluations still allowed."""
        return self._limit - self.evaluations

    def value(self, x: Real) -> float:
        """Objective at one point, shape (d,)."""
        if self.evaluations >= self._limit:
            raise BudgetSpent
        # Not by `np.clip`, which takes more than twice as long, at every evaluation of a search.
        point = np.minimum(np.maximum(x, self._lowest), self._highest)
        value = float(self._evaluate(point))
        # After it: an evaluation that fails is none, and its optimiser is told of the fault.
        self.evaluations += 1
        if self.diary is not None:
            self.diary.append((point, None))
        if value < self.best:
            self._improve(point, value)
        # What is no number compares with nothing: infinity is the worst to every optimiser.
        if value != value:
            return inf
        return value

    def batch(self, x: Real, factor: Real | None = None) -> Real:
        """Objective (m,) at points (m, d); those beyond the budget are not evaluated but infinite.

        Parameters
        ----------
        x : ndarray, shape (m, d)
            Points.
        factor : ndarray, shape (m,), optional
            Penalty by which each value is multiplied before it is recorded.
        """
        if factor is not None:
            factor = factor[None]
        values: Real = LedgerGroup([self]).batch(np.asarray(x, dtype=float)[None], factor)[0]
        return values

    def gradient(self, x: Real) -> tuple[float, Real]:
        """Objective and its exact gradient (d,) at one point; one evaluation."""
        point = self._admitted(x)
        raw, slope = self.problem.gradient(point)
        value = float(raw)
        self._note_derivative(point, value)
        if value != value:
            value = inf
        return value, slope

    def residuals(self, x: Real) -> tuple[Real, Real]:
        """Residuals (2n,) and their exact Jacobian (2n, d) at one point; one evaluation."""
        point = self._admitted(x)
        residual, jacobian = self.problem.residuals_and_jacobian(point)
        self._note_derivative(point, float(residual @ residual))
        return residual, jacobian

    def residual_batch(self, x: Real) -> tuple[Real, Real]:
        """Residuals (m, 2n) and their exact Jacobian (m, 2n, d) at points (m, d); m evaluations.

        Rows beyond the budget are not evaluated: their residuals are infinite, their derivatives
        zero.
        """
        points = self._admitted(np.asarray(x, dtype=float))
        # The last call of a run may ask for more than is left: what fits is evaluated, and the rest
        # is told as none.
        allowed = min(len(points), self.left)
        residual, jacobian = self.problem.residuals_and_jacobian(points[:allowed])
        values = np.einsum("ij,ij->i", residual, residual)
        self.gradients += allowed
        _note([self], points[None, :allowed], values[None], [allowed])
        missing = len(points) - allowed
        return (
            np.concatenate([residual, np.full((missing, residual.shape[1]), inf)]),
            np.concatenate([jacobian, np.zeros((missing, *jacobian.shape[1:]))]),
        )

    def _admitted(self, x: Real) -> Real:
        if self.evaluations >= self._limit:
            raise BudgetSpent
        return np.minimum(np.maximum(x, self._lowest), self._highest)

    def _note_derivative(self, point: Real, value: float) -> None:
        self.evaluations += 1
        self.gradients += 1
        if self.diary is not None:
            self.diary.append((point, None))
        if value < self.best:
            self._improve(point, value)

    def _improve(self, point: Real, value: float) -> None:
        self.trace.append((self.evaluations, value))
        self.enter_best(point)

    def enter_best(self, point: Real, factor: float = 1.0) -> None:
        """Take `point` (d,) for the place of the last improvement in the trace."""
        self.best, self.best_x, self.best_factor = self.trace[-1][1], point.copy(), factor
        if self.best <= self.target:
            self._limit = self.evaluations


class LedgerGroup:
    """Ledgers of one problem whose points are evaluated in one stacked call.

    It lets a batched optimiser carry all repetitions of a cell side by side; each run records what
    it would alone.

    Parameters
    ----------
    ledgers : sequence of Ledger
        One for each run, all of the same problem.
    """

    def __init__(self, ledgers: Sequence[Ledger]) -> None:
        self.ledgers = tuple(ledgers)
        self.problem = self.ledgers[0].problem

    def batch(self, x: Real, factor: Real | None = None) -> Real:
        """Objective (runs, m) at points (runs, m, d).

        Infinite and not evaluated where a run has ended.

        Parameters
        ----------
        x : ndarray, shape (runs, m, d)
            The same number of points for every run.
        factor : ndarray, shape (runs, m), optional
            Penalty by which each value is multiplied before it is recorded.

        Raises
        ------
        BudgetSpent
            If every run has ended.
        """
        m = x.shape[1]
        left = [ledger.left for ledger in self.ledgers]
        allowed = [m] * len(left)
        if min(left) < m:  # in all calls but the last ones every run may evaluate all its points
            allowed = [min(m, count) for count in left]
        if max(allowed) <= 0:
            raise BudgetSpent
        points = np.minimum(np.maximum(x, self.problem.space.lowest), self.problem.space.highest)
        values = self._evaluate(points, allowed, m)
        if factor is not None:
            values = values * factor
        _note(self.ledgers, points, values, allowed, factor)
        return values

    def _evaluate(self, points: Real, allowed: list[int], m: int) -> Real:
        if min(allowed) == m:
            # A single run is spared the cost of a leading axis.
            if len(points) == 1:
                return self.problem.evaluate(points[0])[None]
            return self.problem.evaluate(points)
        chosen = np.arange(m) < np.array(allowed)[:, None]
        values = np.full(chosen.shape, inf)
        values[chosen] = self.problem.evaluate(points[chosen])
        return values


def _note(
    ledgers: Sequence[Ledger],
    points: Real,
    values: Real,
    allowed: list[int],
    factor: Real | None = None,
) -> None:
    """Let each count what it was allowed and note, in order, what improves on its best.

    Values that are no numbers become infinite, in place.
    """
    bests, lowest = np.array([ledger.best for ledger in ledgers]), values.min(axis=1)
    # The least of a row tells whether one of it is no number: the whole row is searched only then.
    if np.isnan(lowest).any():
        values[np.isnan(values)] = inf
        lowest = values.min(axis=1)
    rows = np.flatnonzero(lowest < bests)
    if rows.size:  # late in a run most calls improve on nothing
        _trace(ledgers, values[rows], bests[rows], rows.tolist())
    for ledger, count in zip(ledgers, allowed, strict=True):
        if count > 0:
            ledger.evaluations += count
            ledger.batched += count
    if ledgers[0].diary is not None:
        _write_down(ledgers, points, allowed, factor)
    if rows.size:
        # The first of equal values, as one after the other would have had it.
        columns = values[rows].argmin(axis=1)
        factors = [1.0] * len(rows)
        if factor is not None:
            factors = factor[rows, columns].tolist()
        for i, point, own in zip(rows.tolist(), points[rows, columns], factors, strict=True):
            ledgers[i].enter_best(point, own)


def _write_down(
    ledgers: Sequence[Ledger], points: Real, allowed: list[int], factor: Real | None
) -> None:
    """Append what each was allowed to its diary."""
    for i, (ledger, count) in enumerate(zip(ledgers, allowed, strict=True)):
        if ledger.diary is None:
            continue
        made = max(count, 0)
        penalties = None
        if factor is not None:
            penalties = factor[i, :made]
        ledger.diary.append((points[i, :made], penalties))


def _trace(ledgers: Sequence[Ledger], values: Real, bests: Real, rows: list[int]) -> None:
    """Append to the traces of ledgers what improves on their best among new values (rows, m)."""
    # What was best before each new value, the values of this call that come before it included.
    before = np.empty_like(values)
    before[:, 0] = bests
    np.minimum.accumulate(values[:, :-1], axis=1, out=before[:, 1:])
    np.minimum(before, bests[:, None], out=before)
    run, step = np.nonzero(values < before)
    for i, column, value in zip(
        run.tolist(), step.tolist(), values[run, step].tolist(), strict=True
    ):
        ledger = ledgers[rows[i]]
        ledger.trace.append((ledger.evaluations + column + 1, value))


def all_points(diary: Diary, dimension: int) -> tuple[Real, Real]:
    """Points (n, d) and penalty factors (n,) of a diary, row i being evaluation i + 1."""
    # Begun with nothing, as of no pages at all there would be nothing to join.
    points, factors = [np.empty((0, dimension))], [np.empty(0)]
    for page, factor in diary:
        page = np.atleast_2d(page)
        if factor is None:
            factor = np.ones(len(page))
        points.append(page)
        factors.append(factor)
    return np.concatenate(points), np.concatenate(factors)
