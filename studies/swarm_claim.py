"""How the paper's swarm ranks at 500, 2,000, 8,000 and 40,000 evaluations, on exact and noisy data.

    springpot run studies/swarm_claim.py [--repeats 10] [--workers 2]

Every optimiser runs once with 40,000 evaluations; what it had found by 500, 2,000 and 8,000 is read
off its trace. Only the swarm plans its whole budget, by the fall of its inertia: for the two
smallest budgets it races with a schedule of that length. At 8,000 it is the paper's swarm, at
40,000 the paper's group of five, one after another. All trials end at the target, beyond which
nothing counts.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from paper.asking import asked
from paper.draw import COLOURS, INK, can_draw, legend_above, logarithmic, sheet
from paper.published import MODELS
from springpot.benchmark import Findings, Store, Study, Table, save_table
from springpot.benchmark.comparison import MeanRanks, races_of, rank
from springpot.benchmark.robustness import OF_ITS_OWN
from springpot.benchmark.statistics import Interval, wilson_over
from springpot.report.page import Entry
from springpot_plugins.optimisers.swarm import PaperSwarm

SWARM = "pso-paper"
SHORT = {500: f"{SWARM}-500", 2000: f"{SWARM}-2000"}
"""Swarms whose schedule fits a smaller budget."""

CLASSES = {"exact": ("",), "noisy": ("-noise1", "-noise2")}
RIVALS = (
    *("native", "least-squares", "cma-es", "differential-evolution", "dual-annealing"),
    *("nlopt-crs", "nlopt-isres", "nlopt-esch", "nlopt-direct-l", "nlopt-mlsl"),
    *("nlopt-sbplx", "nlopt-bobyqa", "nlopt-nelder-mead", "nlopt-lbfgs", "random-search"),
)
SHOWN = (
    "native",
    "least-squares",
    "cma-es",
    "differential-evolution",
    "nlopt-crs",
    "nlopt-mlsl",
    SWARM,
)
"""Optimisers that the figure names."""


def short_swarm(budget: int) -> PaperSwarm:
    """The swarm whose inertia falls to its end within a budget."""
    return PaperSwarm(instances=budget // PaperSwarm().particles - 1)


def finish(path: Path, folder: Path) -> None:
    """Write the ranks, one table for reading and one with all the numbers."""
    with Store(path) as store:
        findings = Findings.of(store)
    found = {
        (name, k): ranking(findings, name, k)
        for name in CLASSES
        for k in range(len(findings.scale.marks))
    }
    save_table(asked(study, overview(findings, found)), folder, "swarm_overview")
    save_table(details(findings, found), folder, "swarm_ranks")
    if can_draw(folder):
        draw_ranks(findings, found, folder)


def swarm_at(budget: int) -> str:
    """Label of the swarm that races at a budget."""
    return SHORT.get(budget, SWARM)


def ranking(findings: Findings, name: str, mark: int) -> MeanRanks:
    """Ranks over the problems of one class, with the swarm of that budget only."""
    swarm = swarm_at(findings.scale.marks[mark])
    data = {f"artificial-{model}{suffix}" for model in MODELS for suffix in CLASSES[name]}
    chosen = [
        scores
        for scores in findings.scores
        if scores.cell.problem.dataset in data and scores.cell.label in (swarm, *RIVALS)
    ]
    return rank(name, races_of(chosen), mark, findings.scale)


def success(findings: Findings, name: str, label: str, budget: int) -> Interval | None:
    """Share of an optimiser's trials that reached the target within a budget."""
    data = {f"artificial-{model}{suffix}" for model in MODELS for suffix in CLASSES[name]}
    cells = [s for s in findings.scores if s.cell.label == label and s.cell.problem.dataset in data]
    return wilson_over([np.where(s.hits <= budget, s.hits, np.inf) for s in cells])


def overview(findings: Findings, found: dict[tuple[str, int], MeanRanks]) -> Table:
    """Place by mean rank and success, one row for each optimiser."""
    marks = findings.scale.marks
    rows: list[tuple[Entry, ...]] = []
    for label in (SWARM, *RIVALS):
        cells = [
            _place(findings, found[name, k], label) for name in CLASSES for k in range(len(marks))
        ]
        rows.append((label, *cells))
    rows.sort(key=lambda row: np.mean([float(str(cell).split(".")[0]) for cell in row[1:]]))
    columns = ("optimiser", *(f"{name}, {mark}" for name in CLASSES for mark in marks))
    note = (
        f"Place of {len(RIVALS) + 1} by mean rank of what was reached, and the share of trials that"
        f" reached the target (excess {findings.scale.target:g}); an asterisk: told from {SWARM} by"
        f" Wilcoxon's test over problems, adjusted by Holm{_doubts(found)}. Exact: 5 models; noisy:"
        f" the same with 1 % and with 2 % noise of eq. (53). {OF_ITS_OWN['native']}"
    )
    return Table("The paper's swarm among others", columns, rows, note)


def _doubts(found: dict[tuple[str, int], MeanRanks]) -> str:
    """Why there are no asterisks, where there can be none."""
    doubts = dict.fromkeys(ranked.doubt for ranked in found.values() if ranked.doubt)
    return "".join(f"; {doubt} {len(RIVALS) + 1} optimisers apart" for doubt in doubts)


def _place(findings: Findings, ranked: MeanRanks, label: str) -> str:
    own = swarm_at(ranked.budget)
    label = own if label == SWARM else label
    i, swarm = ranked.labels.index(label), ranked.labels.index(own)
    place = 1 + int((ranked.means < ranked.means[i]).sum())
    rate = success(findings, ranked.scope, label, ranked.budget)
    told = "*" if ranked.told(i, swarm) else ""
    return f"{place}.{told} {100 * rate.value:.0f} %" if rate else f"{place}.{told}"


def details(findings: Findings, found: dict[tuple[str, int], MeanRanks]) -> Table:
    """Mean ranks, success, and the chance that the swarm ends below each rival."""
    rows: list[tuple[Entry, ...]] = []
    for (name, _), ranked in found.items():
        swarm = ranked.labels.index(swarm_at(ranked.budget))
        for i in np.argsort(ranked.means, kind="stable"):
            label = ranked.labels[i]
            against = (
                (None, None)
                if i == swarm
                else (float(ranked.chances[swarm, i]), float(ranked.p[swarm, i]))
            )
            rate = success(findings, name, label, ranked.budget)
            rows.append(
                (
                    name,
                    ranked.budget,
                    label,
                    rate,
                    ranked.ranks[i],
                    *against,
                    f"{ranked.blocks} {ranked.unit}",
                )
            )
    columns = (
        *("data", "budget", "optimiser", "success", "mean rank"),
        *("swarm ends below", "p (Wilcoxon, Holm)", "blocks"),
    )
    note = (
        "Success with a 95 % interval for further problems like these; mean rank with a bootstrap"
        " 95 % interval over problems, or their range where they are too"
        f" few{_doubts(found)}. Swarm ends below: chance that a trial of the swarm is better than"
        " one of this optimiser on the same"
        f" problem at that budget, ties by half (A12). {OF_ITS_OWN['native']}"
    )
    return Table("The paper's swarm: ranks", columns, rows, note)


def draw_ranks(findings: Findings, found: dict[tuple[str, int], MeanRanks], folder: Path) -> None:
    """Mean ranks against the budget; some rivals by colour, the others in grey."""
    marks = findings.scale.marks
    with sheet(folder, "swarm_ranks", 8.6, 4.6) as page:
        panels = page.subplots(1, len(CLASSES), sharey=True)
        for axes, name in zip(panels, CLASSES, strict=True):
            for label in (*RIVALS, SWARM):
                means = [_mean_rank(found[name, k], label) for k in range(len(marks))]
                if label in SHOWN:
                    style = {"color": COLOURS[SHOWN.index(label)], "marker": "o", "label": label}
                else:
                    style = {"color": "0.8", "zorder": 1}
                axes.plot(
                    marks,
                    means,
                    **(style | {"color": INK, "linewidth": 2.6} if label == SWARM else style),
                )
            logarithmic(axes, "x")
            axes.set(xlabel="evaluations", title=name)
        panels[0].set(ylabel="mean rank (1: best)")
        panels[0].invert_yaxis()
        legend_above(page, panels[0], "The paper's swarm among others, five models", columns=4)


def _mean_rank(ranked: MeanRanks, label: str) -> float:
    return float(
        ranked.means[ranked.labels.index(swarm_at(ranked.budget) if label == SWARM else label)]
    )


study = Study(
    "swarm_claim",
    datasets=[
        f"artificial-{model}{suffix}"
        for suffixes in CLASSES.values()
        for suffix in suffixes
        for model in MODELS
    ],
    models=["own"],
    objectives=["paper"],
    optimisers=[SWARM, *((label, short_swarm(budget)) for budget, label in SHORT.items()), *RIVALS],
    repetitions=10,
    budget=40_000,
    stop_at_target=True,
    asks=(
        "The paper takes a particle swarm and compares it with nothing: would another optimiser"
        " have done better with as many evaluations?",
        "Share of trials at the target and mean ranks at 500, 2,000, 8,000 and 40,000 evaluations,"
        " exact and noisy data apart, each swarm with a schedule of that length.",
        "An optimiser that ranks above the swarm at every budget and is told from it by Wilcoxon's"
        " test over problems; without that the shares on these problems stand alone.",
    ),
    finish=finish,
)

if __name__ == "__main__":
    study.main()
