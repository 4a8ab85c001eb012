"""Whether the record of a run contradicts itself or the problem.

What another process can still check.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .problem import Searched
from .runs import Run

AGREE, ROUNDING = 1e-9, 1e-12
"""Roots of two sums of squares are the same within this share of them and this share of the
problem's own size: stacked and single evaluations differ in their last bits, 1e-16 of |K| in a
residual, and a model may lose four digits of them.
"""


def miscounted(evaluations: int, gradients: int, batched: int, budget: int) -> str:
    """What is wrong with the counts of a run, or nothing."""
    if not 1 <= evaluations <= budget:
        return f"its record counts {evaluations} evaluations of {budget}"
    if not 0 <= max(gradients, batched) <= evaluations:
        return "its record counts more evaluations of one kind than of all"
    return ""


def mistraced(numbers: ArrayLike, values: ArrayLike, evaluations: int, best: float) -> str:
    """What is wrong with a trace of improvements (n,), or nothing."""
    at, improvements = np.asarray(numbers), np.asarray(values)
    rising = at[0] >= 1 and at[-1] <= evaluations and np.all(np.diff(at) > 0)
    if not (rising and np.all(np.diff(improvements) < 0)):
        return "its trace contradicts its count of evaluations"
    # Not but for rounding: both are one number that was written down twice.
    if improvements[-1] != best:
        return "its best value is not the last of its trace"
    return ""


def same(claimed: float | None, evaluated: float, size: float) -> bool:
    """Whether two sums of squares agree but for rounding, `size` being that of the data."""
    if claimed is None:
        return False
    # By their roots, the sizes of residuals: squares near zero would agree by no share of
    # themselves.
    one, other, own = (
        np.sqrt(claimed),
        np.sqrt(evaluated),
        float(np.nan_to_num(np.sqrt(size), posinf=0.0)),
    )
    return bool(abs(one - other) <= AGREE * other + ROUNDING * own)


def contradiction(run: Run, problem: Searched, budget: int) -> str:
    """What is wrong with a run that claims to have come to something, or nothing."""
    numbers, values = zip(*run.trace, strict=True)
    wrong = miscounted(run.evaluations, run.gradients, run.batched, budget)
    wrong = wrong or mistraced(numbers, values, run.evaluations, run.best)
    if wrong:
        return wrong
    with np.errstate(all="ignore"):
        evaluated = float(problem.evaluate(run.point)) * run.factor
        size = float(problem.evaluate(0.5 * (problem.lower + problem.upper)))
    if not same(run.best, evaluated, size):
        return f"its best point has the objective {evaluated:.6g}, not {run.best:.6g}"
    return ""
