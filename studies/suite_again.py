"""`auto` again on the hard problems, with other random numbers and five times as many trials.

    springpot run studies/suite_again.py [--workers 2]

In suite_race and suite_hard it had two trials on each problem, of one seed.
"""

from __future__ import annotations

from pathlib import Path

from paper.asking import asked
from springpot import plugins
from springpot.benchmark import Findings, Store, Study, Table, save_table
from springpot.benchmark.statistics import wilson_over
from suite_hard import SUITE as DRAWN
from suite_race import PARTS, SUITE

HARD = PARTS["hard half"]
HALVES = {
    suite: [
        name for name, told in plugins().find("suite", suite).measured.items() if told.part in HARD
    ]
    for suite in (SUITE, DRAWN)
}
"""Hard and deceptive problems of both suites."""


def finish(path: Path, folder: Path) -> None:
    """Write the shares on both suites."""
    with Store(path) as store:
        findings = Findings.of(store, scored=True)
    save_table(asked(study, shares(findings)), folder, "again", ("md", "csv"))


def shares(findings: Findings) -> Table:
    """Share of trials at the target on each suite, and on how many of its problems some miss."""
    hits = {scores.cell.problem.dataset: scores.hits for scores in findings.scores}
    rows = []
    for suite, names in HALVES.items():
        own = [hits[name] for name in names if name in hits]
        missed = sum(bool((each == float("inf")).any()) for each in own)
        rows.append((suite, len(own), sum(map(len, own)), wilson_over(own), missed))
    note = (
        f"Share of the trials of `auto` at the target within {findings.scale.budget} evaluations,"
        " with a 95 % interval for further problems like these, and on how many problems some of"
        " its trials miss; on the hard and deceptive problems of each suite."
    )
    columns = ("suite", "problems", "trials", "at the target", "problems with misses")
    return Table("auto again, with other random numbers", columns, rows, note)


study = Study(
    "suite_again",
    datasets=[name for names in HALVES.values() for name in names],
    models=["own"],
    objectives=["own"],
    optimisers=["auto"],
    repetitions=10,
    budget=8000,
    seed=2,
    stop_at_target=True,
    asks=(
        "Two trials of one seed on each problem put `auto` at 100 % on the hard half of"
        " springpot-60 and at 98 % on springpot-hard-20. Was that luck?",
        "Share of ten trials of another seed on each problem that end at the target by 8,000"
        " evaluations.",
        "Both above 95 %: what was said holds. If one is not, this figure is the one to be quoted.",
    ),
    finish=finish,
)

if __name__ == "__main__":
    study.main()
