"""Which optimiser to take where an evaluation costs 50 ms and there are 10 to 200 of them.

    python studies/expensive.py [--repeats 2] [--every 8] [--out results/expensive]

Question: does a surrogate pay where evaluations are few and several can be made at once? Measure:
mean ranks over every eighth problem of springpot-60 after 10, 20, 50, 100 and 200 evaluations, and
by the times in which four workers make as many. What would answer it: the surrogate first by time
at 50 evaluations, its own time below that of an evaluation.

Writes expensive.md and expensive.csv. Optimisers of libraries that are absent are left out, and
named. The surrogate ends at 100 evaluations: its own time grows with their third power. No
evaluation is archived: all are made anew, from their seeds.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from paper.asking import asking
from springpot import plugins
from springpot.benchmark import Study, save_table
from springpot.benchmark.expensive import MARKS, PacedRun, Site, expensive_table, paced_run
from springpot.benchmark.plan import problem_of
from springpot.errors import ModelError

SUITE = "springpot-60"
NAMES = (
    *("bayesian-ei", "random-search", "cma-es", "bipop-cma-es", "pso-paper", "l-shade"),
    *("differential-evolution", "dual-annealing", "nlopt-nelder-mead", "nlopt-bobyqa", "cobyqa"),
    *("dfo-bobyqa", "dfo-ls", "minuit-migrad", "nlopt-direct-l", "nlopt-lbfgs"),
    *("least-squares", "least-squares-alternating"),
)
LIMITS = {"bayesian-ei": 100}
"""Evaluations at which an optimiser is stopped whose own time grows faster than their number."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Race all and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=2)
    parser.add_argument("--every", type=int, default=8, help="take every so manieth problem")
    parser.add_argument("--out", type=Path, default=Path("results/expensive"))
    parser.add_argument("names", nargs="*", default=NAMES)
    given = parser.parse_args(arguments)
    plan = Study("expensive", [SUITE], ["own"], ["own"], ["random-search"], budget=MARKS[-1]).plan()
    problems = [
        problem_of(case.source, case.source.model_of(case.model), case.objective)
        for case in plan.cases[:: given.every]
    ]
    site, courses = Site(), dict[str, list[list[PacedRun]]]()
    for name in given.names:
        try:
            optimiser = plugins().find("optimiser", name)()
        except ModelError as absent:
            print(f"left out: {name}: {absent}")
            continue
        budget = LIMITS.get(name, MARKS[-1])
        courses[name] = [
            [paced_run(optimiser, problem, budget, site, 1, i, r) for r in range(given.repeats)]
            for i, problem in enumerate(problems)
        ]
        print(name, flush=True)
    given.out.mkdir(parents=True, exist_ok=True)
    whole = asking(__doc__, expensive_table(courses, site))
    for path in save_table(whole, given.out, "expensive", ("md", "csv")):
        print(path)


if __name__ == "__main__":
    main()
