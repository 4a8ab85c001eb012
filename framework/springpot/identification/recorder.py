"""The recorder is what an optimiser sees of a run.

It evaluates, counts and ends, and nothing in it can be set.

The record itself is a `Ledger`, to which a recorder holds no reference: its doors are functions
that close over it.

The ledger owns the truth about a run: what was evaluated, what was best.

No optimiser is given a reference to it, only a `Recorder`, which asks it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import Any, TypeAlias, TypeVar

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
    remarks : list of str
        What the optimiser has to say of its run.
    start : ndarray, shape (d,), or None
        The race's common first point.
    limit : int
        Evaluations at which the run ends: of the budget, or those made when the target is met.
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
    remarks: list[str] = field(default_factory=list, init=False)
    start: Real | None = field(default=None, init=False)
    limit: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self._lowest, self._highest = self.problem.space.lowest, self.problem.space.highest
        # Looked up once: it is called at every evaluation of most optimisers.
        self._evaluate = self.problem.evaluate
        # One comparison guards the hot path.
        self.limit = self.budget

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

    def value(self, x: Real) -> float:
        """Objective at one point, shape (d,)."""
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
        self.trace.append((self.evaluations, value))
        self.enter_best(point)

    def enter_best(self, point: Real, factor: float = 1.0) -> None:
        """Take `point` (d,) for the place of the last improvement in the trace."""
        self.best, self.best_x, self.best_factor = self.trace[-1][1], point.copy(), factor
        if self.best <= self.target:
            self.limit = self.evaluations


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
        # Not by `left`, whose call takes twice as long, fifty times a step.
        left = [ledger.limit - ledger.evaluations for ledger in self.ledgers]
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


T = TypeVar("T")


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
    """

    __slots__ = (
        "_batch",
        "_gradient",
        "_misfit",
        "_problem",
        "_remark",
        "_residual_batch",
        "_residuals",
        "_told",
        "_value",
    )

    _value: Callable[[Real], float]
    _batch: Callable[[Real, Real | None], Real]
    _gradient: Callable[[Real], tuple[float, Real]]
    _residuals: Callable[[Real], tuple[Real, Real]]
    _misfit: Callable[[Real], Real]
    _residual_batch: Callable[[Real], tuple[Real, Real]]
    _remark: Callable[[str], None]
    _told: Callable[[str], Any]

    def __init__(
        self, problem: Searched, budget: int, target: float = -inf, diary: Diary | None = None
    ) -> None:
        self._enter(Ledger(problem, budget, target, diary))

    @classmethod
    def of(cls, ledger: Ledger) -> Recorder:
        """The recorder of a ledger."""
        made = cls.__new__(cls)
        made._enter(ledger)
        return made

    def _enter(self, ledger: Ledger) -> None:
        self._problem = ledger.problem
        # The recorder holds no ledger: an optimiser could write into what it can reach.
        self._value, self._gradient = _door(ledger.value), _door(ledger.gradient)
        self._misfit = _door(ledger.misfit)
        self._residuals, self._residual_batch = (
            _door(ledger.residuals),
            _door(ledger.residual_batch),
        )
        self._batch = lambda x, factor: ledger.batch(x, factor)
        self._remark = lambda text: ledger.remarks.append(str(text))
        self._told = lambda what: getattr(ledger, what)

    @property
    def problem(self) -> Searched:
        """What is minimised."""
        return self._problem

    @property
    def dimension(self) -> int:
        """Number of searched parameters."""
        return self._problem.dimension

    @property
    def lower(self) -> Real:
        """Lower corner of the box that bounded optimisers keep to."""
        return self._problem.lower

    @property
    def upper(self) -> Real:
        """Upper corner of that box."""
        return self._problem.upper

    @property
    def budget(self) -> int:
        """Evaluations allowed."""
        return int(self._told("budget"))

    @property
    def start(self) -> Real | None:
        """Search point (d,) that all optimisers of the race begin at, evaluated already.

        None where each begins as it likes.
        """
        start: Real | None = self._told("start")
        if start is None:
            return None
        return start.copy()

    def first(self, own: Real) -> Real:
        """The search point (d,) to begin at: the race's first, and later on one's own."""
        start = self.start
        # Once only: whoever starts anew begins elsewhere.
        if start is None or self.evaluations > 1:
            return own
        return start

    @property
    def target(self) -> float:
        """Objective at which the run ends."""
        return float(self._told("target"))

    @property
    def evaluations(self) -> int:
        """Points evaluated."""
        return int(self._told("evaluations"))

    @property
    def gradients(self) -> int:
        """How many of them with a derivative."""
        return int(self._told("gradients"))

    @property
    def batched(self) -> int:
        """How many of them in calls for several at once."""
        return int(self._told("batched"))

    @property
    def best(self) -> float:
        """Smallest objective seen, infinite before the first finite value."""
        return float(self._told("best"))

    @property
    def best_x(self) -> Real:
        """Where, a copy of shape (d,); empty before the first finite value."""
        # A copy: the ledger's own must not change under an optimiser's hands.
        place: Real = self._told("best_x").copy()
        return place

    @property
    def trace(self) -> list[tuple[int, float]]:
        """Evaluation number and objective at every improvement, a copy."""
        # A list of its own: what an optimiser does with it must not change the record.
        return list(self._told("trace"))

    @property
    def spent(self) -> bool:
        """Whether the budget is used up."""
        return bool(self._told("spent"))

    @property
    def met(self) -> bool:
        """Whether the target is reached."""
        return bool(self._told("met"))

    @property
    def left(self) -> int:
        """Evaluations still allowed."""
        return int(self._told("left"))

    def remark(self, text: str) -> None:
        """Say something of the run in one line, such as why it goes on as it does."""
        self._remark(text)

    def __call__(self, x: Real) -> float:
        """Objective at one point, shape (d,).

        Raises
        ------
        BudgetSpent
            If the run has ended; this holds for all that follow.
        """
        return self._value(x)

    def batch(self, x: Real, factor: Real | None = None) -> Real:
        """Objective (m,) at points (m, d); those beyond the budget are not evaluated but infinite.

        Parameters
        ----------
        x : ndarray, shape (m, d)
            Points.
        factor : ndarray, shape (m,), optional
            Penalty by which each value is multiplied before it is recorded.
        """
        return self._batch(x, factor)

    def gradient(self, x: Real) -> tuple[float, Real]:
        """Objective and its exact gradient (d,) at one point; one evaluation."""
        return self._gradient(x)

    def residuals(self, x: Real) -> tuple[Real, Real]:
        """Residuals (2n,) and their exact Jacobian (2n, d) at one point; one evaluation."""
        return self._residuals(x)

    def misfit(self, x: Real) -> Real:
        """Residuals (2n,) alone at one point; one evaluation, without a derivative."""
        return self._misfit(x)

    def residual_batch(self, x: Real) -> tuple[Real, Real]:
        """Residuals (m, 2n) and their exact Jacobian (m, 2n, d) at points (m, d); m evaluations.

        Rows beyond the budget are not evaluated: their residuals are infinite, their derivatives
        zero.
        """
        return self._residual_batch(x)


def _door(inside: Callable[[Real], T]) -> Callable[[Real], T]:
    """A plain function that does the same: a bound method would carry what it is bound to."""
    return lambda x: inside(x)


class RecorderGroup:
    """Recorders of one problem; in a study their points are evaluated in one stacked call.

    It lets a batched optimiser carry all repetitions of a cell side by side; each run records what
    it would alone.

    Parameters
    ----------
    recorders : sequence of Recorder
        One for each run, all of the same problem.
    """

    __slots__ = ("_batch", "_recorders")

    def __init__(self, recorders: Sequence[Recorder]) -> None:
        self._recorders = tuple(recorders)
        # Also for recorders that somebody else made, which have no ledgers to be stacked.
        self._batch: Callable[[Real, Real | None], Real] = self._one_by_one

    @classmethod
    def of(cls, ledgers: Sequence[Ledger]) -> RecorderGroup:
        """The recorders of ledgers."""
        made, group = cls([Recorder.of(ledger) for ledger in ledgers]), LedgerGroup(ledgers)
        made._batch = lambda x, factor: group.batch(x, factor)
        return made

    def __len__(self) -> int:
        return len(self._recorders)

    @property
    def recorders(self) -> tuple[Recorder, ...]:
        """One for each run."""
        return self._recorders

    @property
    def problem(self) -> Searched:
        """What all of them minimise."""
        # By construction all runs of a group have one problem.
        return self._recorders[0].problem

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
        return self._batch(x, factor)

    def _one_by_one(self, x: Real, factor: Real | None) -> Real:
        """The same without a stacked call."""
        if all(recorder.left <= 0 for recorder in self._recorders):
            raise BudgetSpent
        # A run that has ended stays at infinity: the others of its group go on.
        values = np.full(x.shape[:2], inf)
        for i, recorder in enumerate(self._recorders):
            if recorder.left > 0:
                penalties = None
                if factor is not None:
                    penalties = factor[i]
                values[i] = recorder.batch(x[i], penalties)
        return values
