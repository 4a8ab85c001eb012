"""The accuracy baseline: a small file, made to be read and to be compared line by line."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite
from pathlib import Path
from typing import Any

import numpy as np

from springpot.benchmark.rows import CellRow, ProblemRow, TrialRow
from springpot.benchmark.statistics import hitting_time, target_value
from springpot.benchmark.store import Store
from springpot.errors import DataError, StudyError
from springpot.files import write_text
from springpot.inputs import json_of, text_in
from springpot.rheology.points import Real

from .difference import Successes

SCHEMA = "springpot.baseline/2"
EVALUATIONS, ERROR = "evaluations", "error"
"""What is compared: evaluations to the target, or the final error where most trials miss it."""
ROUNDING = 1e-12
"""Final errors below are rounding."""
SEPARATOR = " | "


@dataclass(frozen=True)
class Goal:
    """Between which objectives a problem's trials are judged.

    Parameters
    ----------
    best : float
        At the truth, or the best known; its error is zero.
    reference : float
        At the centre of the box or without any response, whose error is one; it tells whether the
        problem is still the same.
    target : float
        What a trial must reach.
    parameters : mapping of str to float
        Element parameters that are right: the true ones, or those of the best trial where no truth
        is known. Empty if all trials failed.
    """

    best: float
    reference: float
    target: float
    parameters: Mapping[str, float]


@dataclass(frozen=True)
class Sample:
    """The costs of one cell's trials.

    Parameters
    ----------
    measure : str
        ``evaluations`` to the target, or final ``error`` as a part of the reference's.
    values : tuple of float
        One for each trial, rising; infinite if it missed or failed.
    reached : int
        Trials that reached the target.
    """

    measure: str
    values: tuple[float, ...]
    reached: int

    @property
    def successes(self) -> Successes:
        """Those that reached the target, of all."""
        return Successes(self.reached, len(self.values))

    def array(self) -> Real:
        """The values (n,)."""
        return np.array(self.values)


@dataclass(frozen=True)
class Baseline:
    """Costs of every cell of a study, as they were.

    Parameters
    ----------
    study, script : str
        Name, and path of the script where it is known.
    settings : dict of str to number
        Budget, repetitions, seed and target.
    goals : dict of str to Goal
        By ``data set | model | objective``.
    samples : dict of str to Sample
        By the same and ``| optimiser``.
    """

    study: str
    script: str
    settings: dict[str, float | int | None]
    goals: dict[str, Goal]
    samples: dict[str, Sample]

    def to_text(self) -> str:
        """JSON with sorted keys and a line for each cell."""
        head = {
            "schema": SCHEMA,
            "study": self.study,
            "script": self.script,
            "settings": self.settings,
        }
        goals = {key: vars(goal) for key, goal in self.goals.items()}
        cells = {}
        for key, sample in self.samples.items():
            cells[key] = {
                sample.measure: [_plain(value) for value in sample.values],
                "reached": sample.reached,
            }
        # Put together here, for a line to each cell: a comparison of two versions shows which
        # changed.
        lines = [f'  "{key}": {json.dumps(value, sort_keys=True)},' for key, value in head.items()]
        lines += [
            '  "problems": {',
            *_entries(goals),
            "  },",
            '  "cells": {',
            *_entries(cells),
            "  }",
        ]
        return "\n".join(["{", *lines, "}"]) + "\n"

    def write(self, path: Path) -> Path:
        """Replace the file at `path`, whose folder is made if it is missing."""
        path.parent.mkdir(parents=True, exist_ok=True)
        return write_text(path, self.to_text())


def _entries(entries: dict[str, Any]) -> list[str]:
    lines = [
        f"    {json.dumps(key, ensure_ascii=False)}: {json.dumps(entries[key])},"
        for key in sorted(entries)
    ]
    # JSON has no comma after the last one.
    if lines:
        lines[-1] = lines[-1].removesuffix(",")
    return lines


def _plain(value: float) -> float | int | None:
    # JSON has no word for infinity.
    if not isfinite(value):
        return None
    if value == int(value):
        return int(value)
    # Four digits, as the file is made to be read and compared line by line.
    return float(f"{value:.4g}")


def read_baseline(path: Path) -> Baseline:
    """The baseline at `path`.

    Raises
    ------
    StudyError
        If there is none or it cannot be read.
    """
    try:
        text = text_in(path)
    except DataError as error:
        raise StudyError(
            f"there is no baseline {path} ({error}): make it with springpot regression update"
            " STUDY.py and commit it"
        ) from None
    try:
        content = json_of(text, finite=True)
        if content["schema"] != SCHEMA:
            raise StudyError(
                f"{path} has schema {content['schema']}, not {SCHEMA}: make it again with"
                " regression update"
            )
        goals = {key: Goal(**goal) for key, goal in content["problems"].items()}
        samples = {key: _sample(cell) for key, cell in content["cells"].items()}
        return Baseline(content["study"], content["script"], content["settings"], goals, samples)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise StudyError(
            f"{path} is no accuracy baseline ({error}): make it again with regression update"
        ) from None


def _sample(cell: dict[str, Any]) -> Sample:
    # A cell has one measure: more would leave it open which of them is compared.
    [measure] = cell.keys() - {"reached"}
    return Sample(measure, tuple(_number(value) for value in cell[measure]), int(cell["reached"]))


def _number(value: float | None) -> float:
    """What `_plain` gave, with infinity back in its place."""
    if value is None:
        return inf
    return float(value)


def baseline_of(store: Store, script: str = "") -> Baseline:
    """The baseline that a store's trials make."""
    facts, bests = store.facts(), store.bests()
    fraction = float(facts["target"])
    right = _right_parameters(store)
    goals: dict[str, Goal] = {}
    samples: dict[str, Sample] = {}
    for cell, rows in cells_of(store):
        problem = cell.problem
        # Where the truth is known it is the measure: what the study's other optimisers find then
        # does not matter.
        best = problem.known
        if best is None:
            best = bests.get(problem.id, inf)
        target = best
        if isfinite(best):
            target = target_value(best, problem.reference, fraction)
        known = right.get(problem.id, {})
        goal = goals.setdefault(problem_key(problem), Goal(best, problem.reference, target, known))
        measure = EVALUATIONS
        # Where most trials miss the target its median is infinite, and no change of it could be
        # seen.
        if 2 * reached(rows, goal) < len(rows):
            measure = ERROR
        samples[cell_key(cell)] = _sampled(rows, goal, measure)
    settings = {
        key: _plain(float(facts[key])) for key in ("budget", "repetitions", "seed", "target")
    }
    return Baseline(facts["name"], script, settings, goals, samples)


def cells_of(store: Store) -> Iterator[tuple[CellRow, list[TrialRow]]]:
    """Cells of a store's study with their trials.

    It may hold those of others that the study no longer has.
    """
    cells = {cell.id: cell for cell in store.cells()}
    for number, rows in store.trials():
        if number in cells:
            yield cells[number], rows


def _right_parameters(store: Store) -> dict[int, Mapping[str, float]]:
    """True parameters by number of the problem, or the best trial's where no truth is known."""
    right: dict[int, Mapping[str, float]] = {}
    least: dict[int, float] = {}
    for cell, rows in cells_of(store):
        problem = cell.problem
        if problem.known is not None:
            right[problem.id] = dict(problem.truth)
            continue
        for row in rows:
            if row.best is not None and row.best < least.get(problem.id, inf):
                least[problem.id], right[problem.id] = row.best, dict(row.theta)
    return right


def samples_like(store: Store, baseline: Baseline) -> dict[str, Sample]:
    """Samples of a store's cells, measured as the baseline measures them.

    Cells unknown to it are left out.

    Raises
    ------
    StudyError
        If a problem is no longer the one that the baseline is about.
    """
    samples: dict[str, Sample] = {}
    for cell, rows in cells_of(store):
        problem, key = cell.problem, cell_key(cell)
        if key not in baseline.samples:
            continue
        goal = baseline.goals[problem_key(problem)]
        # The objective at the reference hangs on data, objective and box alike: rounding apart, it
        # tells all three.
        if abs(problem.reference - goal.reference) > 1e-6 * abs(goal.reference):
            raise StudyError(
                f"the data, the objective or the box of {problem_key(problem)} changed since the"
                " baseline was made: make it again with regression update"
            )
        samples[key] = _sampled(rows, goal, baseline.samples[key].measure)
    return samples


def _sampled(rows: Sequence[TrialRow], goal: Goal, measure: str) -> Sample:
    return Sample(measure, tuple(np.sort(costs(rows, goal, measure)).tolist()), reached(rows, goal))


def reached(rows: Sequence[TrialRow], goal: Goal) -> int:
    """How many trials reached the target."""
    return sum(row.best is not None and row.best <= goal.target for row in rows)


def costs(rows: Sequence[TrialRow], goal: Goal, measure: str) -> Real:
    """Cost (n,) of each trial, infinite if it missed or failed."""
    cost = _error
    if measure == EVALUATIONS:
        cost = _hit
    return np.array([cost(row, goal) for row in rows])


def _hit(row: TrialRow, goal: Goal) -> float:
    if row.best is None or row.best > goal.target:
        return inf
    return hitting_time(*row.improvements(), goal.target)


def _error(row: TrialRow, goal: Goal) -> float:
    if row.best is None:
        return inf
    # Not below rounding: costs are compared by their logarithms.
    return max((row.best - goal.best) / (goal.reference - goal.best), ROUNDING)


def problem_key(problem: ProblemRow) -> str:
    """Data set, model and objective in one line."""
    return SEPARATOR.join((problem.dataset, problem.model, problem.objective))


def cell_key(cell: CellRow) -> str:
    """The same and the optimiser."""
    return SEPARATOR.join((problem_key(cell.problem), cell.label))
