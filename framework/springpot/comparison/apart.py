"""Rows of several tests in one table, where no model follows all of them: which test to begin with."""

from __future__ import annotations

from springpot.diagnosis.leftover import column_behind
from springpot.diagnosis.refit import Refit
from springpot.measurement import largest_test, tests_together


def one_test_of(found: Refit) -> tuple[str, str]:
    """How to choose the rows of one test, such as ``current=0.5``, and why; both empty where the rows are of one.

    Parameters
    ----------
    found : Refit
        The best model, which leaves more than noise.
    """
    data, column = found.data.raw, column_behind(found.frame())
    # Before what only tells rows apart: with this one the misfit goes.
    if column is not None:
        return column.one_test, column.says
    names = tests_together(data)
    if not names:
        return "", ""
    one_test = largest_test(data, names[0])
    why = f"rows of several tests stand together, told apart by {names[0]}; choose one by '@{one_test}'"
    return one_test, why
