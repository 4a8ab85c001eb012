"""The audit: what a trial's process claims, checked in one that runs no optimiser."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np

from springpot.identification.record import AGREE, miscounted, mistraced, same

from .plan import Plan, Task
from .trace import unpack
from .trial import Bench, Status, TrialResult, failure

KEPT = 256
"""Problems that are kept ready: a study of more builds them again, each in about a millisecond."""


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
        """The results, those that contradict themselves or the problem replaced by failures."""
        if [(r.cell, r.repetition) for r in results] != [(task.cell, r) for r in task.repetitions]:
            return failure(task, Status.CHANGED, "its process answered for other trials")
        return [self._checked(result) for result in results]

    def _checked(self, result: TrialResult) -> TrialResult:
        # A failure claims nothing that could be checked.
        if result.status.failed:
            return result
        # What comes from a process that ran an optimiser may be of any kind: no error of it may end
        # the study.
        try:
            complaint = self._complaint(result)
        except Exception as error:
            complaint = f"its record cannot be read: {type(error).__name__}: {error}"
        if not complaint:
            return result
        return failure(
            Task(result.cell, (result.repetition,)), Status.CHANGED, complaint, result.seconds
        )[0]

    def _complaint(self, result: TrialResult) -> str:
        # The cheap ones first; the last evaluates the objective.
        numbers, values = unpack(result.trace)
        return (
            miscounted(result.evaluations, result.gradients, result.batched, self._plan.budget)
            or mistraced(numbers, values, result.evaluations, float(result.best or 0.0))
            or self._false_value(result)
        )

    def _false_value(self, result: TrialResult) -> str:
        """Whether the best point has the value that is claimed."""
        case = self._plan.cases[self._plan.cells[result.cell].case]
        bench = self._bench(self._plan.cells[result.cell].case)
        judged = bench.judged(np.array(result.point))
        if not _equal(judged.theta, result.theta):
            return "its parameters are not those of its best point"
        if not same(result.best, judged.best * result.factor, case.reference):
            return f"its best point has the objective {judged.best:.6g}, not {result.best:.6g}"
        if judged.oracle is not None and not same(result.oracle, judged.oracle, case.reference):
            return "its noise-free objective is not that of its best point"
        return ""


def _equal(own: Mapping[str, float], claimed: Mapping[str, float] | None) -> bool:
    """Whether parameters agree but for rounding."""
    if claimed is None or own.keys() != claimed.keys():
        return False
    return bool(
        np.allclose(
            list(own.values()), list(claimed.values()), rtol=AGREE, atol=0.0, equal_nan=True
        )
    )
