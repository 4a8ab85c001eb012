"""The recorder is what an optimiser sees of a run.

It evaluates, counts, keeps the best and ends the run: what a library claims of itself is not asked.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import TypeAlias

import numpy as np

from springpot.errors import LONGEST_REASON
from springpot.rheology.points import Real

from .problem import Searched

Diary: TypeAlias = list[tuple[Real, Real | None]]
"""Points (d,) or (m, d) with penalty factors (m,), in the order of evaluation."""


class BudgetSpent(BaseException):
    """Ends a run; not an `Exception`, so that a library's own handlers do not swallow it."""


class Recorder:
    """Counts every evaluation, keeps the best point and its trace, and ends the run at the budget.

    Points are moved into the parameters' own limits (a stiffness is positive, an order at most one)
    before they are evaluated, not into the search box: the paper's swarm may leave it. A value that
    is not a number is counted, is never the best, and reaches the optimiser as infinity.

    Parameters
    ----------
    problem : Problem, or whatever else can be searched
        What is minimised.
    budget : int
        Evaluations allowed; none beyond it is made or recorded.
    target : float
        The run ends once the objective is this small.
    diary : list, optional
        Gets every point in the order of evaluation, with its penalty; see `all_points`.
    start : ndarray, shape (d,), optional
        The race's common first point.

    Attributes
    ----------
    lower, upper : ndarray, shape (d,)
        Corners of the box that bounded optimisers keep to.
    evaluations, gradients, batched : int
        Points evaluated, how many of them with a derivative, and how many in calls for several at
        once.
    best : float
        Smallest objective seen, infinite before the first finite value.
    improvements : list of (int, float)
        Evaluation number and objective at every improvement.
    remarks : list of str
        What the optimiser has to say of its run.
    limit : int
        Evaluations at which the run ends: of the budget, or those made when the target is met.
    """

    def __init__(
        self,
        problem: Searched,
        budget: int,
        target: float = -inf,
        diary: Diary | None = None,
        start: Real | None = None,
    ) -> None:
        self.problem, self.budget, self.target, self.diary = problem, budget, target, diary
        # Copies: what an optimiser does to them in place must not reach another run.
        self.lower, self.upper = problem.lower.copy(), problem.upper.copy()
        self.evaluations = self.gradients = self.batched = 0
        self.best = inf
        self.remarks: list[str] = []
        # One comparison guards the hot path.
        self.limit = budget
        self._best_x: Real = np.empty(0)
        self.improvements: list[tuple[int, float]] = []
        self._start = start
        self._lowest, self._highest = problem.space.lowest, problem.space.highest
        # Looked up once: it is called at every evaluation of most optimisers.
        self._evaluate = problem.evaluate

    @property
    def dimension(self) -> int:
        """Number of searched parameters."""
        return self.problem.dimension

    @property
    def start(self) -> Real | None:
        """Search point (d,) that all optimisers of the race begin at, evaluated already.

        None where each begins as it likes.
        """
        if self._start is None:
            return None
        return self._start.copy()

    def first(self, own: Real) -> Real:
        """The search point (d,) to begin at: the race's first, and later on one's own."""
        start = self.start
        # Once only: whoever starts anew begins elsewhere.
        if start is None or self.evaluations > 1:
            return own
        return start

    @property
    def best_x(self) -> Real:
        """Where it was best, shape (d,); empty before the first finite value."""
        # A copy: the record must not change under an optimiser's hands.
        return self._best_x.copy()

    @property
    def trace(self) -> list[tuple[int, float]]:
        """Evaluation number and objective at every improvement, a copy."""
        return list(self.improvements)

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
        return self.limit - self.evaluations

    def remark(self, text: str) -> None:
        """Say something of the run in one line, such as why it goes on as it does."""
        self.remarks.append(" ".join(str(text).split())[:LONGEST_REASON])

    def __call__(self, x: Real) -> float:
        """Objective at one point, shape (d,).

        Raises
        ------
        BudgetSpent
            If the run has ended; this holds for all that follow.
        """
        if self.evaluations >= self.limit:
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
        values: Real = _stacked([self], np.asarray(x, dtype=float)[None], factor)[0]
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

    def misfit(self, x: Real) -> Real:
        """Residuals (2n,) alone at one point: an evaluation without a derivative."""
        point = self._admitted(x)
        residual = self.problem.residuals(point)
        self._note_single(point, float(residual @ residual))
        return residual

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
        if self.evaluations >= self.limit:
            raise BudgetSpent
        return np.minimum(np.maximum(x, self._lowest), self._highest)

    def _note_derivative(self, point: Real, value: float) -> None:
        self.gradients += 1
        self._note_single(point, value)

    def _note_single(self, point: Real, value: float) -> None:
        self.evaluations += 1
        if self.diary is not None:
            self.diary.append((point, None))
        if value < self.best:
            self._improve(point, value)

    def _improve(self, point: Real, value: float) -> None:
        self.improvements.append((self.evaluations, value))
        self.enter_best(point)

    def enter_best(self, point: Real) -> None:
        """Take `point` (d,) for the place of the last improvement in the trace."""
        self.best, self._best_x = self.improvements[-1][1], point.copy()
        if self.best <= self.target:
            self.limit = self.evaluations


class RecorderGroup:
    """Recorders of one problem whose points are evaluated in one stacked call.

    It lets a batched optimiser carry all repetitions of a cell side by side; each run records what
    it would alone.

    Parameters
    ----------
    recorders : sequence of Recorder
        One for each run, all of the same problem.
    """

    def __init__(self, recorders: Sequence[Recorder]) -> None:
        self.recorders = tuple(recorders)
        self.problem = self.recorders[0].problem

    def __len__(self) -> int:
        return len(self.recorders)

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
        if len(self.recorders) > 1:
            return _stacked(self.recorders, x, factor)
        # By its own door: it may be of another kind, whose evaluations take time on a clock.
        own = None
        if factor is not None:
            own = factor[0]
        return self.recorders[0].batch(x[0], own)[None]


def _stacked(recorders: Sequence[Recorder], x: Real, factor: Real | None) -> Real:
    """Objective (runs, m) at points (runs, m, d) in one call, noted by the recorder of each run."""
    m, space = x.shape[1], recorders[0].problem.space
    # Not by `left`, whose call takes twice as long, fifty times a step.
    left = [each.limit - each.evaluations for each in recorders]
    allowed = [m] * len(left)
    if min(left) < m:  # in all calls but the last ones every run may evaluate all its points
        allowed = [min(m, count) for count in left]
    if max(allowed) <= 0:
        raise BudgetSpent
    points = np.minimum(np.maximum(x, space.lowest), space.highest)
    values = _evaluated(recorders[0].problem, points, allowed)
    if factor is not None:
        values = values * factor
    _note(recorders, points, values, allowed, factor)
    return values


def _evaluated(problem: Searched, points: Real, allowed: list[int]) -> Real:
    """Objective at points (runs, m, d); infinite and not evaluated beyond what a run is allowed."""
    m = points.shape[1]
    if min(allowed) == m:
        # A single run is spared the cost of a leading axis.
        if len(points) == 1:
            return problem.evaluate(points[0])[None]
        return problem.evaluate(points)
    chosen = np.arange(m) < np.array(allowed)[:, None]
    values = np.full(chosen.shape, inf)
    values[chosen] = problem.evaluate(points[chosen])
    return values


def _note(
    recorders: Sequence[Recorder],
    points: Real,
    values: Real,
    allowed: list[int],
    factor: Real | None = None,
) -> None:
    """Let each count what it was allowed and note, in order, what improves on its best.

    Values that are no numbers become infinite, in place.
    """
    bests, lowest = np.array([recorder.best for recorder in recorders]), values.min(axis=1)
    # The least of a row tells whether one of it is no number: the whole row is searched only then.
    if np.isnan(lowest).any():
        values[np.isnan(values)] = inf
        lowest = values.min(axis=1)
    rows = np.flatnonzero(lowest < bests)
    if rows.size:  # late in a run most calls improve on nothing
        _trace(recorders, values[rows], bests[rows], rows.tolist())
    for recorder, count in zip(recorders, allowed, strict=True):
        if count > 0:
            recorder.evaluations += count
            recorder.batched += count
    if recorders[0].diary is not None:
        _write_down(recorders, points, allowed, factor)
    if rows.size:
        # The first of equal values, as one after the other would have had it.
        columns = values[rows].argmin(axis=1)
        for i, point in zip(rows.tolist(), points[rows, columns], strict=True):
            recorders[i].enter_best(point)


def _write_down(
    recorders: Sequence[Recorder], points: Real, allowed: list[int], factor: Real | None
) -> None:
    """Append what each was allowed to its diary."""
    for i, (recorder, count) in enumerate(zip(recorders, allowed, strict=True)):
        if recorder.diary is None:
            continue
        made = max(count, 0)
        penalties = None
        if factor is not None:
            penalties = factor[i, :made]
        recorder.diary.append((points[i, :made], penalties))


def _trace(recorders: Sequence[Recorder], values: Real, bests: Real, rows: list[int]) -> None:
    """Append to the traces of recorders what improves on their best among new values (rows, m)."""
    # What was best before each new value, the values of this call that come before it included.
    before = np.empty_like(values)
    before[:, 0] = bests
    np.minimum.accumulate(values[:, :-1], axis=1, out=before[:, 1:])
    np.minimum(before, bests[:, None], out=before)
    run, step = np.nonzero(values < before)
    for i, column, value in zip(
        run.tolist(), step.tolist(), values[run, step].tolist(), strict=True
    ):
        recorder = recorders[rows[i]]
        recorder.improvements.append((recorder.evaluations + column + 1, value))


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
