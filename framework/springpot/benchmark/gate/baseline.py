"""The accuracy baseline: a small file, made to be read and to be compared line by line.

Whether costs rose or successes became fewer, by tests that know when they could never tell.

The rule for costs is that of airspeed velocity: Mann and Whitney's test where the samples are large
enough to ever be significant, otherwise whether the intervals of the medians' stand-ins overlap.
Successes are counted and compared by Boschloo's exact test.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from math import exp, inf, isfinite, log, sqrt
from pathlib import Path
from typing import Any

import numpy as np

from springpot.distributions import student
from springpot.errors import DataError, StudyError
from springpot.files import json_of, text_in, write_text
from springpot.rheology.points import Real
from springpot.writing import suggested

from ...numerics import ROUNDING
from ..plan import ProblemRow
from ..statistics import hitting_time, holm, least_mann_whitney, pooled_ranks, target_value
from ..store import Store
from ..summary import CellRow, TrialRow

LEVEL = 0.01
"""Chance of a false alarm anywhere in a study whose optimisers did not change.

It holds each time that their samples are drawn anew: by another seed, another order of random
numbers, another rounding. The same code draws the same.
"""
FACTOR = 1.1
"""Costs that grew by less are no regression, however certain."""
TABLES = 250**2
"""Outcomes of two groups up to which Boschloo's test takes less than half a second.

Where there are more, Fisher's,
which is never below it, hardly differs."""


@dataclass(frozen=True)
class Successes:
    """How many of some trials succeeded."""

    count: int
    trials: int

    @property
    def rate(self) -> float:
        """Their share."""
        return self.count / max(self.trials, 1)

    def __str__(self) -> str:
        return f"{self.count} of {self.trials} trials"


@dataclass(frozen=True)
class Verdict:
    """What became of one sample.

    Parameters
    ----------
    worse, better : bool
        Whether costs rose beyond the factor, or successes became fewer, with certainty; and the
        reverse.
    tested : bool
        Whether a test could ever have told; if not, intervals were compared, of costs.
    p : float
        Chance of this rise or fall without a change, adjusted for all samples; 1 where nothing was
        tested.
    """

    worse: bool
    better: bool
    tested: bool
    p: float


def verdicts(
    pairs: Sequence[tuple[Real, Real]],
    level: float = LEVEL,
    factor: float = FACTOR,
    counts: Sequence[tuple[Successes, Successes]] = (),
) -> list[Verdict]:
    """Judge costs and successes before and after, all together (Holm's step-down adjustment).

    Parameters
    ----------
    pairs : sequence of (ndarray, ndarray)
        Positive costs before (n,) and after (m,); infinite where a trial missed or failed.
    level : float
        Chance of a false alarm anywhere.
    factor : float
        Rise of costs that does not count yet.
    counts : sequence of (Successes, Successes)
        Before and after.

    Returns
    -------
    list of Verdict
        Of the pairs, then of the counts.
    """
    number = max(len(pairs) + len(counts), 1)
    least = [least_mann_whitney(len(before), len(after)) for before, after in pairs]
    least += [least_drop(before.trials, after.trials) for before, after in counts]
    tested = np.array(least) * number < level
    # Grown by the factor beforehand, so that a rise which is smaller is none.
    rises = [chance(before * factor, after) for before, after in pairs]
    falls = [chance(after * factor, before) for before, after in pairs]
    rises += [drop(before, after) for before, after in counts]
    falls += [drop(after, before) for before, after in counts]
    # What no test could ever tell apart takes its place, but nothing of the level.
    chances = zip(
        holm(np.where(tested, rises, 1.0)), holm(np.where(tested, falls, 1.0)), strict=True
    )
    judged = []
    for i, (rise, fall) in enumerate(chances):
        if tested[i] or i >= len(pairs):
            judged.append(
                Verdict(
                    bool(rise < level), bool(fall < level), bool(tested[i]), float(min(rise, fall))
                )
            )
        else:
            # Bonferroni's share: intervals have no p-values for Holm to order.
            (before, after), share = pairs[i], level / number
            worse, better = (
                apart(before * factor, after, share),
                apart(after * factor, before, share),
            )
            judged.append(Verdict(worse, better, False, 1.0))
    return judged


def drop(before: Successes, after: Successes) -> float:
    """One-sided p-value of Boschloo's exact test that `after` succeeds less often than `before`.

    Boschloo 1970, doi:10.1111/j.1467-9574.1970.tb00104.x. Exact without the margins that Fisher's
    test holds, which are not held here, and never above it.
    """
    # More than one half, and of no interest: there is no drop.
    if after.rate >= before.rate:
        return 1.0
    return _boschloo(after.count, after.trials, before.count, before.trials)


@cache
def _boschloo(low: int, of_low: int, high: int, of_high: int) -> float:
    from scipy.stats import boschloo_exact, fisher_exact

    test = boschloo_exact
    if of_low * of_high > TABLES:
        test = fisher_exact
    return float(test([[low, high], [of_low - low, of_high - high]], alternative="less").pvalue)


def least_drop(n: int, m: int) -> float:
    """Smallest p-value of Boschloo's test: all n trials before succeeded, and none of m after."""
    if not (n and m):
        return 1.0
    # Likeliest, without a change, where n of n + m succeed.
    return exp(n * log(n / (n + m)) + m * log(m / (n + m)))


def chance(before: Real, after: Real) -> float:
    """One-sided p-value of the Mann-Whitney test that `after` (m,) is larger than `before` (n,).

    Infinite values tie with one another above all others. Never below what so few values can tell,
    which the normal approximation of ties would be.
    """
    # Here and above: it takes most of a second to import.
    from scipy.stats import mannwhitneyu

    # Of ranks instead of values: an infinite cost has a rank as any other.
    ranks = pooled_ranks(np.concatenate([before, after]))
    # All alike: the variance that the test divides by would be zero.
    if np.ptp(ranks) == 0:
        return 1.0
    p = mannwhitneyu(ranks[len(before) :], ranks[: len(before)], alternative="greater").pvalue
    return max(float(p), least_mann_whitney(len(before), len(after)))


def apart(before: Real, after: Real, level: float) -> bool:
    """Whether the interval of `after` lies above that of `before`.

    Each misses the truth by chance `level`.
    """
    return interval(after, level)[0] > interval(before, level)[1]


def interval(values: Real, level: float) -> tuple[float, float]:
    """Student's interval of the mean logarithm of positive `values` (n,), as values.

    Unbounded from one value.

    With infinite values it is bounded below only, by the finite ones; if all are infinite it is
    infinity itself.
    """
    finite = np.log(values[np.isfinite(values)])
    if len(finite) == 0:
        # All missed: of one trial alone that tells nothing yet.
        if len(values) > 1:
            return inf, inf
        return 0.0, inf
    if len(finite) < 2:
        return 0.0, inf
    deviation = float(np.std(finite, ddof=1)) / sqrt(len(finite))
    half = student(1.0 - level, len(finite) - 1) * deviation
    centre = float(np.mean(finite))
    # A trial that missed costs more than any number, so that there is no upper end.
    if len(finite) < len(values):
        return exp(centre - half), inf
    # Beyond 700 an exponential is no number.
    return exp(centre - half), exp(min(centre + half, 700.0))


SCHEMA = "springpot.baseline/2"
EVALUATIONS, ERROR = "evaluations", "error"
"""What is compared: evaluations to the target, or the final error where most trials miss it."""
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
    if not path.exists():
        raise StudyError(
            f"there is no baseline {path}: make it with"
            f" {suggested('regression update', 'STUDY.py')} and commit it"
        )
    try:
        text = text_in(path)
    except DataError as error:
        raise StudyError(f"the baseline {error}") from None
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
    if "noise" in facts:
        raise StudyError(
            f"study {facts['name']} draws its noise anew: a gate needs the same data every time"
        )
    fraction = float(facts["target"])
    right = _right_parameters(store)
    goals: dict[str, Goal] = {}
    samples: dict[str, Sample] = {}
    for cell, rows in store.raced():
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


def _right_parameters(store: Store) -> dict[int, Mapping[str, float]]:
    """True parameters by number of the problem, or the best trial's where no truth is known."""
    right: dict[int, Mapping[str, float]] = {}
    least: dict[int, float] = {}
    for cell, rows in store.raced():
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
    for cell, rows in store.raced():
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
