"""The recorder is what an optimiser sees of a run.

It evaluates, counts and ends, and nothing in it can be set.

The record itself is a `Ledger`, to which a recorder holds no reference: its doors are functions
that close over it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf
from typing import Any, TypeVar

import numpy as np

from springpot.rheology.points import Real

from .ledger import BudgetSpent, Diary, Ledger, LedgerGroup
from .problem import Searched

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
        "_problem",
        "_residual_batch",
        "_residuals",
        "_told",
        "_value",
    )

    _value: Callable[[Real], float]
    _batch: Callable[[Real, Real | None], Real]
    _gradient: Callable[[Real], tuple[float, Real]]
    _residuals: Callable[[Real], tuple[Real, Real]]
    _residual_batch: Callable[[Real], tuple[Real, Real]]
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
        self._residuals, self._residual_batch = (
            _door(ledger.residuals),
            _door(ledger.residual_batch),
        )
        self._batch = lambda x, factor: ledger.batch(x, factor)
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
