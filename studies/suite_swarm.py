"""The paper's swarm on springpot-60, in all the ways in which its text can be read.

    springpot run studies/suite_swarm.py [--workers 2]

The paper leaves open whether its random numbers are a matrix or a scalar, where the inertia begins
and ends, and how hard velocities are clamped. Each reading is raced; the rivals are the archived
trials of `suite_race`, which are not run again.
"""

from __future__ import annotations

from pathlib import Path

from paper.asking import asked
from springpot import plugins
from springpot.benchmark import Findings, Study, Table, save_table
from springpot.benchmark.archive import opened
from springpot.benchmark.comparison import MeanRanks, races_of, rank
from springpot.benchmark.statistics import wilson_over
from springpot.report.page import Entry
from springpot_plugins.optimisers.swarm import PaperSwarm, ScalarSwarm
from suite import SUITE, sweeps

ARCHIVE = Path(__file__).parents[1] / "results" / "suite_race" / "suite_race.zip"
SCHEDULES = ((0.9, 0.2), (0.9, 0.9), (0.729, 0.729), (1.0, 0.0), (1.2, 0.4), (0.7, 0.4))
"""First and last inertia; the default, 0.9 to 0.4, is the seventh."""
READINGS = {
    "pso-paper": PaperSwarm(),
    "scalar": ScalarSwarm(),
    **{
        f"inertia {first:g} to {last:g}": PaperSwarm(inertia_first=first, inertia_last=last)
        for first, last in SCHEDULES
    },
    "clamp 0.5": PaperSwarm(clamp=0.5),
    "no clamp": PaperSwarm(clamp=1e6),
    "global": PaperSwarm(neighbourhood="global"),
    "scalar, no clamp": ScalarSwarm(clamp=1e6),
}
AGAINST = ("differential-evolution", "l-shade", "cma-es", "nlopt-nelder-mead")
"""Rivals that know no derivatives, each reading against each."""
HALVES = {"easy half": ("easy",), "hard half": ("hard", "deceptive")}


def finish(path: Path, folder: Path) -> None:
    """Write the table of the readings."""
    with opened(path, ARCHIVE) as store:
        findings = Findings.of(store)
    save_table(asked(study, readings(findings)), folder, "readings")


def readings(findings: Findings) -> Table:
    """Success of each reading, and how it stands against the rivals."""
    measured = plugins().find("suite", SUITE).measured

    def share(label: str, half: str) -> Entry:
        return wilson_over(
            [
                scores.hits
                for scores in findings.scores
                if scores.cell.label == label
                and measured[scores.cell.problem.dataset].part in HALVES[half]
            ]
        )

    ranked = {label: _against(findings, label) for label in READINGS}
    order = sorted(READINGS, key=lambda label: float(ranked[label].means[0]))
    rows: list[tuple[Entry, ...]] = []
    for label in order:
        own = ranked[label]
        cells: list[Entry] = []
        for rival in AGAINST:
            i = own.labels.index(rival)
            better, equal, worse = own.posterior[0, i] if own.posterior is not None else (0, 0, 0)
            cells.append(f"{better:.2f} / {equal:.2f} / {worse:.2f}{_star(own, i)}")
        rows.append((label, *(share(label, half) for half in HALVES), own.ranks[0], *cells))
    columns = ("reading", *HALVES, f"mean rank among {len(AGAINST) + 1}", *AGAINST)
    budget = findings.scale.budget
    note = (
        f"Share of trials at the target by {budget} evaluations, with a 95 % interval for further"
        " problems like these; mean rank of the reading and the four rivals over every second sweep"
        " of the suite. Against each rival: the probability that the reading is better, equal in"
        " practice and worse on a"
        " further problem like these (Bayesian signed rank); an asterisk: told apart by Wilcoxon's"
        " test over problems, adjusted by Holm. The rivals' trials are those of suite_race.zip."
    )
    return Table("The paper's swarm as it can be read", columns, rows, note)


def _against(findings: Findings, label: str) -> MeanRanks:
    """Ranks of a reading, which comes first, among the rivals."""
    chosen = [s for s in findings.scores if s.cell.label in (label, *AGAINST)]
    chosen.sort(key=lambda scores: scores.cell.label != label)
    scale = findings.scale
    return rank("all", races_of(chosen), len(scale.marks) - 1, scale)


def _star(ranked: MeanRanks, i: int) -> str:
    return "*" if ranked.told(0, i) else ""


study = Study(
    "suite_swarm",
    datasets=sweeps()[::2],
    models=["own"],
    objectives=["own"],
    optimisers=list(READINGS.items()),
    repetitions=2,
    budget=8000,
    stop_at_target=True,
    asks=(
        "Does any reading of the paper's swarm identify these problems as well as other"
        " methods without derivatives do?",
        "Share of trials at the target by 8,000 evaluations on both halves of the suite; mean"
        " ranks and Bayesian signed-rank probabilities against four rivals, problems as blocks.",
        "A reading that is probably better or equal in practice (0.95) than a rival answers yes"
        " for that rival; one that is probably worse than all four in every reading answers no.",
    ),
    finish=finish,
)

if __name__ == "__main__":
    study.main()
