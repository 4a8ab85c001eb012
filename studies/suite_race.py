"""Forty-five optimisers, and the choice among them, on the sixty problems of springpot-60.

`native` is not among them: it knows how a model is built, which no other is told. Left out for what
a trial of them costs are COBYQA, Py-BOBYQA, SHGO and NGOpt. A trial ends at the target, beyond
which nothing counts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from paper.asking import asked
from springpot import plugins
from springpot.benchmark import Findings, Store, Study, Table, save_table
from springpot.benchmark.comparison import CellScores
from springpot.benchmark.statistics import Interval, wilson_over
from springpot.benchmark.summary import CellSummary

SUITE = "springpot-60"
RIVALS = (
    *("least-squares", "dfo-ls", "nlopt-lbfgs", "basin-hopping", "minuit-migrad"),
    *("nlopt-mlsl", "nlopt-bobyqa", "nlopt-nelder-mead", "nlopt-sbplx", "dual-annealing"),
    *("cma-es", "bipop-cma-es", "differential-evolution", "l-shade", "minion-jso", "minion-arrde"),
    *("pso-paper", "least-squares-alternating", "auto"),
    *("optimagic-scipy-lbfgsb", "optimagic-scipy-ls-dogbox", "optimagic-scipy-slsqp"),
    *("minion-lshade", "minion-jade", "minion-lshade-cnepsin", "minion-imode"),
    *("minion-agsk", "minion-bipop-acma-es", "minion-spso-2011", "minion-dms-pso"),
    *("minion-j2020", "ipop-cma-es", "optimagic-scipy-truncated-newton"),
    *("optimagic-nlopt-ccsaq", "nlopt-direct-l", "scipy-direct"),
    *("nevergrad-tbpsa", "nevergrad-two-points-de", "nevergrad-one-plus-one"),
    *("pymoo-de", "pymoo-es", "pymoo-g3pcx", "pymoo-ga", "pymoo-pso"),
    *("minion-nl-shade-rsp", "minion-lsrtde"),
)
PARTS = {
    "easy half": ("easy",),
    "hard half": ("hard", "deceptive"),
    "hard": ("hard",),
    "deceptive": ("deceptive",),
}
CEILING = 0.95
"""Share of the trials on the hard half above which a suite no longer tells the best apart."""


def finish(path: Path, folder: Path) -> None:
    """Write the table by the parts of the suite."""
    with Store(path) as store:
        findings = Findings.of(store)
    save_table(asked(study, by_part(findings)), folder, "parts")


def by_part(
    findings: Findings,
    suite: str = SUITE,
    parts: Mapping[str, Sequence[str]] = PARTS,
    judging: str = "hard half",
) -> Table:
    """Share of trials at the target by part of the suite, the best on the judging one first."""
    measured, budget = plugins().find("suite", suite).measured, findings.scale.budget
    cells: dict[str, list[tuple[CellScores, float]]] = {}
    for scores, summary in zip(findings.scores, findings.summaries, strict=True):
        cells.setdefault(scores.cell.label, []).append((scores, dearer(scores, summary)))

    def share(label: str, part: str, charged: bool = False) -> Interval | None:
        return wilson_over(
            [
                np.where(scores.hits * (price if charged else 1.0) <= budget, scores.hits, np.inf)
                for scores, price in cells[label]
                if measured[scores.cell.problem.dataset].part in parts[part]
            ]
        )

    def judged(label: str) -> float:
        found = share(label, judging)
        return found.value if found else 0.0

    labels = sorted(cells, key=judged, reverse=True)
    rows = [
        (label, *(share(label, part) for part in parts), share(label, judging, charged=True))
        for label in labels
    ]
    most = judged(labels[0])
    verdict = (
        "No optimiser exceeds"
        if most <= CEILING
        else f"The suite is too easy for {labels[0]}, which exceeds"
    )
    note = (
        f"Share of trials that reached the target within {findings.scale.budget} evaluations, with"
        f" a 95 % interval for further problems like these. {verdict} {100 * CEILING:g} % on the"
        f" {judging}: the most is {100 * most:.0f} %, of {labels[0]}. The parts are told by"
        " measured features: docs/suite.md. An evaluation with its derivative counts as one; in the"
        " last column as d + 1, d being the number of parameters, what differences would take."
    )
    columns = ("optimiser", *parts, f"{judging}, a derivative as d more")
    return Table("By the parts of the suite", columns, rows, note)


def dearer(scores: CellScores, summary: CellSummary) -> float:
    """How many times as many evaluations it takes if each parameter's derivative counts as one."""
    if not summary.gradients or not summary.evaluations:
        return 1.0
    return 1.0 + scores.dimension * summary.gradients / summary.evaluations


study = Study(
    "suite_race",
    datasets=[SUITE],
    models=["own"],
    objectives=["own"],
    optimisers=RIVALS,
    repetitions=2,
    budget=8000,
    stop_at_target=True,
    asks=(
        "Which optimiser, told nothing of how a model is built, identifies viscoelastic models, and"
        " does that hang on what the problem is like?",
        "Share of trials within a millionth of the way to the best known value by 8,000"
        " evaluations, and the expected running time to it; mean ranks with problems as blocks; on"
        " the easy and the hard half of the suite, which measured features tell apart.",
        "One optimiser ahead on both halves, told from all others by Holm's test over problems."
        " If the halves have different winners, the answer is a choice by features. If anybody"
        " exceeds 95 % on the hard half, the suite is too easy to answer it.",
    ),
    finish=finish,
)

if __name__ == "__main__":
    study.main()
