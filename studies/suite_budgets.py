"""Who is ahead at 50, 200, 1,000, 8,000 and 100,000 evaluations, and where they overtake.

    python studies/suite_budgets.py [--every 3] [--repeats 2] [--last 5] [--workers 2] [--out DIR]

Question: does the answer to "which optimiser?" hang on the budget? Measure: mean ranks, and the
share of trials at the target, over every third problem of springpot-60, among them a record, a
step, a joint test and a population. What would answer it: the same order at all five. Each budget
is a race of its own: a method that plans its budget (a swarm, a shrinking population) is told the
one that it has, and is not read off a longer run. `native` is not among them, and DFO-LS, COBYQA
and their like are left out for what 100,000 evaluations cost there, and so are tests in time from
8,000 on and three sweeps at 100,000. At 8,000 trials of suite_race are taken over.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from paper.asking import asking
from paper.draw import COLOURS, can_draw, logarithmic, sheet
from springpot import plugins
from springpot.benchmark import Findings, Store, Study, Table, run_study, save_table, store_path
from springpot.benchmark.archive import Archive, take_over
from springpot.benchmark.comparison import MeanRanks, rank
from springpot.benchmark.runner import provenance
from springpot.benchmark.statistics import Interval, wilson_over
from springpot.report.page import Entry
from suite import ROOT, SUITE, sweeps

NAME = "suite_budgets"
BUDGETS = (50, 200, 1000, 8000, 100_000)
DEAR = ("nist-four-modes", "maxwell-7", "bouc-wen")
"""Sweeps that are left out at the longest budget, where trials of them take a minute."""
LONG = 8000
"""Evaluations from which tests in time are left out, of which a trial costs a hundred sweeps."""
RACE = ROOT / "results" / "suite_race" / "suite_race.zip"
RIVALS = (
    *("least-squares", "least-squares-alternating", "nlopt-lbfgs", "minuit-migrad"),
    *("nlopt-nelder-mead", "dual-annealing", "cma-es", "bipop-cma-es", "l-shade", "minion-jso"),
    *("minion-arrde", "differential-evolution", "nlopt-crs", "spso-2011", "pso-paper"),
    *("random-search", "auto"),
)


def problems(budget: int, every: int) -> list[str]:
    """What is raced on at a budget: the last of every so many, fewer where an evaluation counts."""
    names = [each.name for each in plugins().find("suite", SUITE).problems][every - 1 :: every]
    cheap = sorted(set(names) & set(sweeps()), key=names.index)
    last = [name for name in cheap if name.partition("/")[2] not in DEAR]
    return {LONG: cheap, BUDGETS[-1]: last}.get(budget, names)


def study(budget: int, every: int, repeats: int) -> Study:
    """The race at one budget."""
    return Study(
        f"{NAME}_{budget}",
        datasets=problems(budget, every),
        models=["own"],
        objectives=["own"],
        optimisers=RIVALS,
        repetitions=repeats,
        budget=budget,
        stop_at_target=True,
    )


def raced(race: Study, workers: int | None, out: Path) -> Findings:
    """What came of the race at one budget; what stood before is not run again."""
    path = store_path(race, out)
    published = Archive.read(RACE)
    if race.budget == int(published.facts["budget"]):
        with Store(path, write=True) as store:
            store.register(plan := race.plan(), provenance(plan))
            take_over(store, published)
    run_study(race, workers, out=out, quiet=True, tables=False)
    with Store(path) as store:
        return Findings.of(store)


def ranked(findings: Findings, names: Sequence[str]) -> MeanRanks:
    """Ranks over these problems at the whole budget."""
    scale = findings.scale
    races = [race for race in findings.races if race.problem.dataset in names]
    return rank("all", races, len(scale.marks) - 1, scale)


def success(findings: Findings, label: str) -> Interval | None:
    """Share of an optimiser's trials that reached the target."""
    return wilson_over([s.hits for s in findings.scores if s.cell.label == label])


def ranks_table(found: Mapping[int, Findings], ranks: Mapping[int, MeanRanks]) -> Table:
    """Mean rank and success of each optimiser at each budget, the best at the last first."""
    last = ranks[BUDGETS[-1]]
    rows: list[tuple[Entry, ...]] = []
    for label in (last.labels[i] for i in np.argsort(last.means, kind="stable")):
        places = [ranks[b].ranks[ranks[b].labels.index(label)] for b in BUDGETS]
        rows.append((label, *places, *(success(found[b], label) for b in BUDGETS)))
    columns = (
        "optimiser",
        *(f"mean rank, {budget}" for budget in BUDGETS),
        *(f"success, {budget}" for budget in BUDGETS),
    )
    first = ranks[BUDGETS[0]]
    note = (
        f"Mean ranks over {first.blocks} problems, at {LONG} evaluations over the"
        f" {ranks[LONG].blocks} sweeps among them, at {BUDGETS[-1]} over {last.blocks} of these,"
        " with bootstrap 95 % intervals over problems; success with those for further problems like"
        " these."
        " Each budget was raced by itself. Archived are the trials of suite_race alone; the study"
        " runs the others anew, from its seeds."
    )
    return Table("Ranks at five budgets", columns, rows, note)


Step = tuple[int, int, MeanRanks, MeanRanks]
"""Two budgets, and the ranks at both over the same problems."""


def steps(found: Mapping[int, Findings], every: int) -> Iterator[Step]:
    """From each budget to the next, over what is raced on at both."""
    for before, after in pairwise(BUDGETS):
        names = problems(after, every)
        yield before, after, ranked(found[before], names), ranked(found[after], names)


def overtaken(steps: Iterable[Step]) -> Iterator[tuple[int, int, str, str, float, float]]:
    """Who overtakes whom from one budget to the next, and their ranks after it."""
    for before, after, first, then in steps:
        for slow in first.labels:
            for fast in first.labels:
                was = [float(first.means[first.labels.index(each)]) for each in (slow, fast)]
                now = [float(then.means[then.labels.index(each)]) for each in (slow, fast)]
                if was[0] > was[1] and now[0] < now[1]:
                    yield before, after, slow, fast, now[0], now[1]


def crossings_table(steps: Iterable[Step]) -> Table:
    """Every pair whose order changes between two budgets, the widest change first."""
    found = sorted(overtaken(steps), key=lambda each: (each[0], each[4] - each[5]))
    rows = [tuple(each) for each in found]
    pairs = len(RIVALS) * (len(RIVALS) - 1) // 2
    counts = ", ".join(
        f"{sum(row[1] == after for row in rows)} up to {after}" for after in BUDGETS[1:]
    )
    columns = ("from", "to", "overtakes", "whom", "its rank then", "the other's")
    note = f"Of {pairs} pairs change their order: {counts}."
    return Table("Where they cross", columns, rows, note)


def draw(ranks: Mapping[int, MeanRanks], folder: Path) -> None:
    """Mean ranks against the budget, every line named where it begins."""
    means = {
        label: [float(ranks[b].means[ranks[b].labels.index(label)]) for b in BUDGETS]
        for label in RIVALS
    }
    order = sorted(RIVALS, key=lambda label: means[label][0])
    heights = apart([means[label][0] for label in order], 0.62)
    with sheet(folder, NAME, 8.2, 5.4) as page:
        axes = page.subplots()
        for i, (label, height) in enumerate(zip(order, heights, strict=True)):
            # Best first: neighbours at the left differ in colour, those of one colour in dashes.
            colour, dashes = COLOURS[i % len(COLOURS)], ("-", "--", ":")[i // len(COLOURS)]
            axes.plot(BUDGETS, means[label], color=colour, linestyle=dashes, marker="o")
            axes.plot([34, BUDGETS[0]], [height, means[label][0]], color=colour, linewidth=0.6)
            axes.text(32, height, label, color=colour, ha="right", va="center")
        logarithmic(axes, "x")
        axes.set(xlabel="evaluations", ylabel="mean rank (1: best)", xlim=(34, 1.2 * BUDGETS[-1]))
        axes.yaxis.tick_right()
        axes.yaxis.set_label_position("right")
        axes.spines[["left", "right"]].set_visible(False)
        axes.invert_yaxis()
        axes.set_title("Ranks at five budgets, springpot-60", loc="left")


def apart(values: Sequence[float], least: float) -> list[float]:
    """Rising values, moved as far that neighbours are apart, those in a crowd about its middle."""
    crowds: list[list[float]] = []
    for value in values:
        crowds.append([value])
        # Two crowds that touch are one.
        while len(crowds) > 1 and _top(crowds[-2], least) + least > _bottom(crowds[-1], least):
            crowds[-2:] = [crowds[-2] + crowds[-1]]
    return [_bottom(crowd, least) + least * i for crowd in crowds for i in range(len(crowd))]


def _bottom(crowd: Sequence[float], least: float) -> float:
    return float(np.mean(crowd)) - 0.5 * least * (len(crowd) - 1)


def _top(crowd: Sequence[float], least: float) -> float:
    return float(np.mean(crowd)) + 0.5 * least * (len(crowd) - 1)


def main(arguments: Sequence[str] | None = None) -> None:
    """Race at every budget, go on where it stopped, and write tables and figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--every", type=int, default=3, help="take every so manieth problem")
    parser.add_argument("--repeats", type=int, default=2)
    parser.add_argument("--last", type=int, default=5, help="repetitions at the longest")
    parser.add_argument("--workers", type=int)
    parser.add_argument("--out", type=Path, default=Path("results"))
    given = parser.parse_args(arguments)
    found: dict[int, Findings] = {}
    for budget in BUDGETS:
        repeats = given.last if budget == BUDGETS[-1] else given.repeats
        race = study(budget, given.every, repeats)
        found[budget] = raced(race, given.workers, given.out)
    ranks = {budget: ranked(found[budget], problems(budget, given.every)) for budget in BUDGETS}
    folder = given.out / NAME
    folder.mkdir(parents=True, exist_ok=True)
    for table, name in (
        (asking(__doc__, ranks_table(found, ranks)), "ranks_by_budget"),
        (crossings_table(steps(found, given.every)), "crossings"),
    ):
        for path in save_table(table, folder, name, ("md", "csv")):
            print(path)
    if can_draw(folder):
        draw(ranks, folder)


if __name__ == "__main__":
    main()
