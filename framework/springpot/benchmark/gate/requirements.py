"""What a study requires of every cell, whatever was before: success, right parameters, time."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from math import inf

import numpy as np

from springpot.benchmark.rows import TrialRow
from springpot.benchmark.statistics import bands
from springpot.benchmark.store import Store
from springpot.benchmark.trial import relative_error
from springpot.format_numbers import number

from .baseline import Baseline, Goal, cell_key, cells_of, problem_key, reached

MOST = 0.5
"""Share of trials that must meet a requirement where the study names none."""


def broken(store: Store, baseline: Baseline) -> Iterator[tuple[str, str]]:
    """Cells of a store that do not meet what its study requires, each with a sentence.

    Parameters
    ----------
    store : Store
        The trials.
    baseline : Baseline
        What is right: targets, and parameters where no truth is known.
    """
    required: dict[str, float] = json.loads(store.facts().get("requirements", "{}"))
    for cell, rows in cells_of(store):
        goal = baseline.goals.get(problem_key(cell.problem))
        # A problem that is new has nothing yet that is right.
        if goal is None:
            continue
        for words in _broken(rows, goal, required):
            yield cell_key(cell), words


def _broken(rows: Sequence[TrialRow], goal: Goal, required: Mapping[str, float]) -> Iterator[str]:
    share = required.get("min_success", MOST)
    if "min_success" in required:
        count = reached(rows, goal)
        if count < share * len(rows):
            yield f"reached the target in {count} of {len(rows)} trials: min_success is {share:g}"
    if "max_parameter_error" in required:
        limit = required["max_parameter_error"]
        error = _at(share, [_error(row, goal.parameters) for row in rows])
        # Also what is no number is no success.
        if not error <= limit:
            yield (
                f"{_off(error, share)}: max_parameter_error is"
                f" {limit:g}{_moved(rows, goal.parameters)}"
            )
    if "max_seconds" in required:
        limit = required["max_seconds"]
        spent = _at(share, [_seconds(row) for row in rows])
        if not spent <= limit:
            most = f"{100 * share:.0f} % of its trials"
            yield f"took {number(spent, 3)} s, which {most} keep to: max_seconds is {limit:g}"


def _at(share: float, values: Sequence[float]) -> float:
    """What this share of the values does not exceed."""
    return float(bands(np.array(values), (share,))[0])


def _error(row: TrialRow, right: Mapping[str, float]) -> float:
    """Largest relative error of a parameter; infinite of a trial that failed."""
    if row.theta.keys() != right.keys() or not right:
        return inf
    return relative_error(
        np.array([row.theta[name] for name in right]), np.array(list(right.values()))
    )


def _seconds(row: TrialRow) -> float:
    if row.status.failed:
        return inf
    return row.seconds


def _off(error: float, share: float) -> str:
    most = f"{100 * share:.0f} % of its trials"
    if np.isfinite(error):
        return f"has parameters that are off by up to {error:.3g} in {most}"
    return f"found no parameters in {most}"


def _moved(rows: Sequence[TrialRow], right: Mapping[str, float]) -> str:
    """Parameters of the best trial beside what is right."""
    sound = [row for row in rows if row.best is not None and row.theta.keys() == right.keys()]
    if not sound:
        return ""
    best = min(sound, key=lambda row: row.best or 0.0)
    moved = [
        f"{name} {number(best.theta[name])} for {number(value)}" for name, value in right.items()
    ]
    return f" (its best trial: {', '.join(moved)})"
