"""Twenty problems that a thousand descents of four kinds miss: drawn, measured, and raced.

    python studies/suite_rugged.py           draws and measures springpot-rugged-20
    springpot run studies/suite_rugged.py    races on it
    python studies/suite_rugged.py again     looks for lower objectives where trials of it ended

Of springpot-hard-20 `auto` reaches 98 % of the targets: that no descent arrives was measured there
by one kind of descent, from starts of one scale. Here sweeps without further columns go up to
500 Hz, where delays last for cycles and a specimen has many waves. A problem has eight parameters
or more and is kept if none of 1,024 descents arrives, by logarithms and by the parameters
themselves, from points that are uniform in the box and uniform by logarithms. That is several times
what 8,000 evaluations pay for, so that whoever only descends again and again seldom arrives; no
trial of a race has a part in it. Raced are `auto`, the ten that reached most targets on the hard
half of springpot-60, and the paper's swarm.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from drawn_problems import SWEEPS, searched
from paper.asking import asked
from springpot.benchmark import Findings, Store, Study, save_table, store_path
from springpot.benchmark.traits import descents, uniform
from springpot.identification import BudgetSpent, Recorder
from springpot.identification.problem import SpecimenProblem
from springpot.measurement import DataSet
from springpot.rheology import Real
from springpot_plugins.optimisers.descents import LeastSquares, Misfit
from suite import sized
from suite_hard import PARTS, goal_of, make, measure
from suite_race import by_part

SUITE = "springpot-rugged-20"
SEED, MANY = 61, 8
PROTOCOLS = {**SWEEPS, "plain": {"hertz": [0.05, 500.0, 24]}}
"""Sweeps, of which those without further columns go to ten times the usual frequency."""
EACH, AT_ONCE = 256, 16
"""Descents of each of the four kinds, and how many of them are made side by side."""
LONGEST, TOLERANCE = 300, 1e-6
"""Evaluations of a descent by the parameters themselves, and the change that ends it."""
RIVALS = (
    *("auto", "least-squares-alternating", "least-squares", "optimagic-scipy-truncated-newton"),
    *("dfo-ls", "optimagic-scipy-slsqp", "ipop-cma-es", "minuit-migrad", "nlopt-lbfgs", "cma-es"),
    *("minion-arrde", "pso-paper"),
)


def demanding(told: Mapping[str, Any]) -> bool:
    """Whether a problem is a sweep of many parameters."""
    return len(told["truth"]) >= MANY and told["tests"][0] in PROTOCOLS


def rugged(told: Mapping[str, Any], known: DataSet) -> bool:
    """Whether a problem is demanding and missed by descents of every kind."""
    if not demanding(told):
        return False
    problem = searched(known)
    goal = goal_of(known, problem)
    return not any(least <= goal for least in ends(problem, goal))


def ends(problem: SpecimenProblem, goal: float) -> Iterator[float]:
    """The least objectives of some descents after others, the quickest kinds first."""
    starts = [uniform(problem, EACH, 4), sized(problem, uniform(problem, EACH, 5))]
    pieces = [each[i : i + AT_ONCE] for i in range(0, EACH, AT_ONCE) for each in starts]
    for points in pieces:
        yield float(np.nanmin(descents(problem, points)[1]))
    for points in pieces:
        yield min(by_parameters(problem, start, goal) for start in points)


def by_parameters(problem: SpecimenProblem, start: Real, goal: float) -> float:
    """The least objective of a descent whose steps are of the parameters themselves."""
    run = Recorder(problem, LONGEST, goal)
    try:
        with np.errstate(all="ignore"):
            LeastSquares(tolerance=TOLERANCE).descend(Misfit(run, logarithmic=False), start)
    except BudgetSpent:
        pass  # it has had its evaluations, or is there
    return run.best


def ended(path: Path) -> dict[str, list[Mapping[str, float]]]:
    """Where the trials on each problem ended."""
    found: dict[str, list[Mapping[str, float]]] = {}
    with Store(path) as store:
        for cell, trials in store.raced():
            found.setdefault(cell.problem.dataset, []).extend(trial.theta for trial in trials)
    return found


def finish(path: Path, folder: Path) -> None:
    """Write the table by the parts of the suite."""
    with Store(path) as store:
        findings = Findings.of(store)
    table = asked(study, by_part(findings, SUITE, PARTS, "suite"))
    save_table(table, folder, "parts", ("md", "csv"))


study = Study(
    "suite_rugged",
    datasets=[SUITE],
    models=["own"],
    objectives=["own"],
    optimisers=RIVALS,
    repetitions=2,
    budget=8000,
    stop_at_target=True,
    asks=(
        "Does anybody reach 95 % of the targets on problems that a thousand descents of four kinds"
        " miss?",
        "Share of trials within a millionth of the way to the best known value by 8,000"
        " evaluations, with its interval: of `auto`, the ten that come first on the hard half"
        " of springpot-60, and the paper's swarm.",
        "More than 95 %: the suite is too easy to tell the best apart. No more: it tells them"
        " apart, and where all miss is what the next one has to learn.",
    ),
    finish=finish,
)

if __name__ == "__main__":
    if "again" in sys.argv:
        measure(SUITE, ended(store_path(study)))
    else:
        make(SUITE, "suite_rugged", SEED, rugged, PROTOCOLS)
