"""The audit: what a trial's process claims, checked in one that runs no optimiser."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from .plan import Plan, Task
from .trace import unpack
from .trial import Bench, Status, TrialResult, failure

KEPT = 256
"""Problems that are kept ready: a study of more builds them again, each in about a millisecond."""
AGREE, ROUNDING = 1e-9, 1e-12
"""Roots of two sums of squares are the same within this share of them and this share of the problem's own size:
stacked and single evaluations differ in their last bits, 1e-16 of |K| in a residual, and a model may lose four
digits of them."""


class Audit:
    """Checks the results of a study's trials.

    Parameters
    ----------
    plan : Plan
        The study.
    """

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self._bench = lru_cache(KEPT)(lambda case: Bench(plan.cases[case]))

    def __call__(self, task: Task, results: Sequence[TrialResult]) -> list[TrialResult]:
        """The results as they are, or failures in the place of those that contradict themselves or the problem."""
        if [(r.cell, r.repetition) for r in results] != [(task.cell, r) for r in task.repetitions]:
            return failure(task, Status.CHANGED, "its process answered for other trials")
        return [self._checked(result) for result in results]

    def _checked(self, result: TrialResult) -> TrialResult:
        if result.status.failed:
            return result
        try:
            complaint = self._complaint(result)
        except Exception as error:
            complaint = f"its record cannot be read: {type(error).__name__}: {error}"
        if not complaint:
            return result
        return failure(Task(result.cell, (result.repetition,)), Status.CHANGED, complaint, result.seconds)[0]

    def _complaint(self, result: TrialResult) -> str:
        if not 1 <= result.evaluations <= self._plan.budget:
            return f"its record counts {result.evaluations} evaluations of {self._plan.budget}"
        if not 0 <= max(result.gradients, result.batched) <= result.evaluations:
            return "its record counts more evaluations of one kind than of all"
        numbers, values = unpack(result.trace)
        rising = numbers[0] >= 1 and numbers[-1] <= result.evaluations and np.all(np.diff(numbers) > 0)
        if not (rising and np.all(np.diff(values) < 0)):
            return "its trace contradicts its count of evaluations"
        if values[-1] != result.best:
            return "its best value is not the last of its trace"
        return self._false_value(result)

    def _false_value(self, result: TrialResult) -> str:
        """Whether the best point has the value that is claimed."""
        case = self._plan.cases[self._plan.cells[result.cell].case]
        bench = self._bench(self._plan.cells[result.cell].case)
        judged = bench.judged(np.array(result.point))
        if not _equal(judged.theta, result.theta):
            return "its parameters are not those of its best point"
        size = float(np.nan_to_num(np.sqrt(case.reference), posinf=0.0))
        if not _same(result.best, judged.best * result.factor, size):
            return f"its best point has the objective {judged.best:.6g}, not {result.best:.6g}"
        if judged.oracle is not None and not _same(result.oracle, judged.oracle, size):
            return "its noise-free objective is not that of its best point"
        return ""


def _equal(found: dict[str, float], claimed: dict[str, float] | None) -> bool:
    """Whether parameters agree but for rounding."""
    if claimed is None or found.keys() != claimed.keys():
        return False
    return bool(np.allclose(list(found.values()), list(claimed.values()), rtol=AGREE, atol=0.0, equal_nan=True))


def _same(claimed: float | None, found: float, size: float) -> bool:
    """Whether two sums of squares agree but for rounding."""
    if claimed is None:
        return False
    one, other = np.sqrt(claimed), np.sqrt(found)
    return bool(abs(one - other) <= AGREE * other + ROUNDING * size)
