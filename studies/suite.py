"""The problems of springpot-60 measured: their best known values, features and parts.

    python studies/suite.py

What it writes beside the suite's description (``springpot-60.csv``) is what
``springpot list suites springpot-60`` shows and docs/suite.md tells. It takes some minutes.
"""

from __future__ import annotations

import csv
from dataclasses import fields
from pathlib import Path

import numpy as np

from springpot.benchmark import Study
from springpot.benchmark.cases import problem_of, reference_of
from springpot.benchmark.features import (
    AnyProblem,
    Features,
    descents,
    features_of,
    parts_of,
    uniform,
)
from springpot.benchmark.plan import Plan, RaceCase
from springpot.identification import Problem
from springpot.identification.native import BoundedDescent
from springpot.identification.recorder import Recorder
from springpot.rheology import Real

SUITE, TARGET = "springpot-60", 1e-6
STARTS = 200
"""Descents among which the least objective is looked for, half of them from even orders of size."""
TABLE = Path(__file__).parents[1] / "plugins/springpot_plugins/suites" / f"{SUITE}.csv"


def plan() -> Plan:
    """All problems, each with its own model and objective."""
    return Study("suite", [SUITE], ["own"], ["own"], ["random-search"]).plan()


def best_known(problem: AnyProblem, truth: Real | None) -> tuple[Real, float]:
    """The least objective that any of many descents in the box ends at, and where (d,)."""
    low, high = problem.lower, problem.upper
    starts = [uniform(problem, STARTS // 2, 2)]
    # As many from all orders of size alike, in which small parameters are found.
    share = (uniform(problem, STARTS // 2, 3) - low) / (high - low)
    positive = low > 0.0
    starts.append(np.where(positive, np.abs(low) ** (1.0 - share) * high**share, starts[0]))
    if truth is not None:
        starts.append(np.clip(truth, low, high)[None])
    points, ends = descents(problem, np.concatenate(starts))
    if isinstance(problem, Problem):
        with np.errstate(all="ignore"):
            descent = BoundedDescent(Recorder(problem, 10**9))
            more = descent.from_scan(np.random.default_rng(0), 16)
        points, ends = np.concatenate([points, more[0]]), np.concatenate([ends, more[1]])
    first = int(np.nanargmin(ends))
    return points[first], float(ends[first])


def measured(case: RaceCase) -> tuple[float, Features]:
    """Best known objective of a problem, and its features."""
    source = case.source
    model = source.model_of(case.model)
    problem = problem_of(source, model, case.objective)
    truth = None
    if set(source.truth) == set(model.names):
        truth = problem.space.from_theta(model.vector(dict(source.truth)))
    optimum, best = best_known(problem, truth)
    target = best + TARGET * (reference_of(problem) - best)
    return best, features_of(problem, optimum, best, target)


def main() -> None:
    """Measure all, and write the table."""
    found = {case.source.name: measured(case) for case in plan().cases}
    parts = parts_of({name: features for name, (_, features) in found.items()})
    with TABLE.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(["problem", "best", "part", *(each.name for each in fields(Features))])
        for name, (best, features) in found.items():
            numbers = (f"{value:.4g}" for value in features.to_dict().values())
            table.writerow([name, repr(best), parts[name], *numbers])


if __name__ == "__main__":
    main()
