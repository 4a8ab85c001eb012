"""All optimisers on all models.

Artificial data without noise, with 1 % and 2 %, and two measured fluids.

    springpot run studies/optimiser_comparison.py [--repeats 50] [--budget 8000] [--workers 2]

Every trial gets the same budget, the same problem in the paper's search form and box, and for each
repetition the same random stream whatever the optimiser. A trial ends when it has reached the
target (see the note of the summary) or spent its budget. The second measured fluid needs the
package rheopy-rheodata; without it, a set from SPRINGPOT_DATA is taken, or none, and the ranking
says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle, product
from pathlib import Path

import numpy as np

from paper.asking import asked
from paper.draw import COLOURS, INK, can_draw, legend_above, logarithmic, sheet
from paper.published import MODELS
from paper.results import available
from springpot import plugins
from springpot.benchmark import Store, Study, Table, save_table
from springpot.benchmark.robustness import OF_ITS_OWN
from springpot.benchmark.statistics import (
    Interval,
    ecdf,
    hitting_time,
    median,
    target_value,
    wilson_over,
)
from springpot.report.page import Entry

NIST = "nist-srm2491@temperature=20"
OTHERS = ("rheodata-linear-polymer-frequency-sweep", "mitmaps-saos")
SECOND = [name for name in OTHERS if available(name)][:1]
CLASSES = {"exact": "", "1 % noise": "-noise1", "2 % noise": "-noise2"}
ARTIFICIAL = {
    f"artificial-{model}{suffix}": label for label, suffix in CLASSES.items() for model in MODELS
}
LABELS = ARTIFICIAL | {NIST: "NIST fluid"} | dict.fromkeys(SECOND, "polymer in water")
"""Class of every data set."""


@dataclass(frozen=True)
class Finish:
    """One trial of the race.

    Parameters
    ----------
    problem : int
        Number of its problem in the store.
    label : str
        Class of its data.
    hit : float
        Evaluations to the target, infinite if it was missed.
    seconds : float
        Processor time of the optimiser in a trial of so many evaluations run alone.
    """

    problem: int
    label: str
    hit: float
    seconds: float


def finish(path: Path, folder: Path) -> None:
    """Write the ranking, the times and two figures."""
    race = trials_of(path)
    save_table(asked(study, ranking(race)), folder, "ranking")
    save_table(times(race), folder, "timing_by_optimiser")
    if can_draw(folder):
        draw_success(race, folder)
        draw_progress(race, folder)


def trials_of(path: Path) -> dict[str, list[Finish]]:
    """Trials by optimiser; one that failed has missed the target."""
    race: dict[str, list[Finish]] = {}
    with Store(path) as store:
        target, bests = float(store.facts()["target"]), store.bests()
        for cell, rows in store.raced():
            problem = cell.problem
            goal = target_value(bests.get(problem.id, np.inf), problem.reference, target)
            kept = race.setdefault(cell.label, [])
            # Of those flown together some were run alone as well: an evaluation of the others costs
            # as much.
            each = median(
                np.array([row.processor / row.evaluations for row in rows if row.processor])
            )
            for row in rows:
                reached = row.best is not None and row.best <= goal
                hit = hitting_time(*row.improvements(), goal) if reached else np.inf
                alone = row.evaluations * (each or 0.0) if row.processor is None else row.processor
                kept.append(Finish(problem.id, LABELS[problem.dataset], hit, alone))
    return race


def success(trials: Sequence[Finish], label: str | None = None) -> tuple[int, int]:
    """Trials that reached the target, and all of them, of one class or of all."""
    hits = [trial.hit for trial in trials if label in (None, trial.label)]
    return int(np.isfinite(hits).sum()), len(hits)


def share(trials: Sequence[Finish], label: str | None = None) -> Interval | None:
    """Share of trials that reached the target, of one class or of all."""
    by_problem: dict[int, list[float]] = {}
    for trial in trials:
        if label in (None, trial.label):
            by_problem.setdefault(trial.problem, []).append(trial.hit)
    return wilson_over([np.array(hits) for hits in by_problem.values()])


def order(race: dict[str, list[Finish]]) -> list[str]:
    """Optimisers by success, then by evaluations.

    Those that reach the target most often and soonest first.
    """
    cost = {name: sum(min(trial.hit, 1e9) for trial in trials) for name, trials in race.items()}
    return sorted(
        race, key=lambda name: (-success(race[name])[0] / max(len(race[name]), 1), cost[name], name)
    )


def classes() -> list[str]:
    """Classes of data in order."""
    return list(dict.fromkeys(LABELS.values()))


def ranking(race: dict[str, list[Finish]]) -> Table:
    """Success rate of every optimiser, in all and by class of data, and evaluations to target."""
    rows: list[tuple[Entry, ...]] = []
    for name in order(race):
        trials = race[name]
        rates = (share(trials, label) for label in classes())
        hits = np.array([trial.hit for trial in trials])
        rows.append((name, len(trials), share(trials), *rates, median(hits)))
    note = (
        "Share of trials that reached the target, over all five models, with a 95 % interval for"
        " further problems like these; median of the evaluations to the target, infinite if fewer"
        " than half of the trials reached it. The cells are in the summary, times in"
        " timing_by_optimiser. DIRECT knows no chance: one run of it stands for its repetitions."
    )
    if not SECOND:
        note += (
            " The second measured fluid is not installed here and was left out: pip install"
            " springpot[data]."
        )
    columns = ("optimiser", "trials", "all", *classes(), "evaluations to target")
    return Table("Optimisers by success", columns, rows, f"{note} {OF_ITS_OWN['native']}")


def times(race: dict[str, list[Finish]]) -> Table:
    """Time of a trial and expected time to the target with restarts."""
    rows: list[tuple[Entry, ...]] = []
    for name in order(race):
        seconds = np.array([trial.seconds for trial in race[name]])
        count = success(race[name])[0]
        rows.append(
            (name, median(1e3 * seconds), 1e3 * float(seconds.sum()) / count if count else np.inf)
        )
    columns = ("optimiser", "median time of a trial [ms]", "expected time to target [ms]")
    note = (
        "Processor time of the optimiser itself, of one trial run alone, until the target or the"
        " end of the budget. Expected: all time spent over the number of successes. No two runs"
        " give the same."
    )
    return Table("Optimisers: time", columns, rows, f"{note} {OF_ITS_OWN['native']}")


def draw_success(race: dict[str, list[Finish]], folder: Path) -> None:
    """Success rates by class of data, as numbers on a coloured grid."""
    names = order(race)
    counts = [[success(race[name], label) for label in classes()] for name in names]
    rates = np.array([[100.0 * hits / max(n, 1) for hits, n in row] for row in counts])
    with sheet(folder, "success", 7.4, 6.6) as page:
        axes = page.subplots()
        axes.imshow(rates, cmap="Blues", vmin=0, vmax=130, aspect="auto")
        for i, j in np.ndindex(rates.shape):
            colour = "white" if rates[i, j] > 75 else INK
            axes.text(
                j, i, f"{rates[i, j]:.0f}", ha="center", va="center", color=colour, fontsize=9
            )
        axes.set(xticks=range(len(classes())), yticks=range(len(names)))
        axes.set_xticklabels(classes())
        axes.set_yticklabels(names)
        axes.grid(visible=False)
        axes.set_title("Trials that reached the target [%]")


def draw_progress(race: dict[str, list[Finish]], folder: Path) -> None:
    """Share of trials that have reached the target, against evaluations."""
    grid = np.geomspace(1, 1e4, 300)
    with sheet(folder, "progress", 8.6, 5.6) as page:
        axes = page.subplots()
        # However many optimisers are installed, the looks never run out.
        looks = cycle(product(("-", "--", ":", "-."), COLOURS))
        for name, (line, colour) in zip(order(race), looks, strict=False):
            hits = np.array([trial.hit for trial in race[name]])
            axes.plot(grid, 100.0 * ecdf(hits, grid), line, color=colour, label=name)
        logarithmic(axes, "x")
        axes.set(
            xlabel="evaluations", ylabel="trials at the target [%]", xlim=(1, 1e4), ylim=(0, 102)
        )
        legend_above(page, axes, "Progress over all problems", columns=4)


study = Study(
    "optimiser_comparison",
    datasets=list(LABELS),
    models={NIST: list(MODELS)} | {name: list(MODELS) for name in SECOND},
    objectives=["paper"],
    optimisers=plugins().names("optimiser"),
    repetitions=50,
    budget=8000,
    stop_at_target=True,
    asks=(
        "Which optimiser arrives on the paper's five models, with which budget, and does noise or"
        " measured data change that?",
        "Share of trials at a millionth of the way to the optimum, evaluations to it, and mean"
        " ranks with problems as blocks, at 100, 500, 2,000 and 8,000 evaluations.",
        "An optimiser whose share is 100 % in every class of data at a budget, with its interval;"
        " an order only where a test over problems, adjusted by Holm, tells two apart.",
    ),
    finish=finish,
)

if __name__ == "__main__":
    study.main()
