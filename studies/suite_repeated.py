"""More trials of those that came near the best on springpot-60, so that others judge than chose.

    python studies/suite_repeated.py
    python studies/suite_repeated.py auto      where `auto` has other rules than before

Runs what its archive lacks, beside that of suite_race, and writes archive, tables and the
figures of docs/optimisers.md.

Question: the virtual best of suite_race is the least of 45 means of two trials each, part of which
is luck. How near does the choice come to the optimiser that is quickest on a problem indeed?
Measure: who came within three times of the second quickest there runs eight trials more, and so
does `auto`; its expected running time over that of the best, as a geometric mean over the problems
from which nothing was learnt. The best is told twice: as the least of the means of the eight, of
which luck still is a part, and as the one that four of them choose and the other four judge, which
pays for what four trials do not tell. What would answer it: at most 1.25 by both.

Left out of the half that rules are learnt from are its tests in time, of which a trial costs a
hundred of the others.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import numpy as np

from paper.asking import asking
from springpot import plugins
from springpot.benchmark import Store, Study, Table, save_table
from springpot.benchmark.archive import Archive, take_over, write_archive
from springpot.benchmark.plan import Plan
from springpot.benchmark.runner import make_engine, provenance
from springpot.benchmark.statistics import Interval, expected_running_time, goal_of, hitting_time
from springpot.benchmark.trial import unpack
from springpot.rheology import Real
from suite import SUITE, sweeps
from suite_race import RIVALS

ROOT = Path(__file__).parents[1]
RESULTS, PAGE = ROOT / "results", ROOT / "docs" / "optimisers.md"
RACE = RESULTS / "suite_race" / "suite_race.zip"
FOLDER = RESULTS / "suite_repeated"
PUBLISHED = FOLDER / "suite_repeated.zip"
BUDGET = 8000
CHOICE, ALONE = "auto", "least-squares-alternating"
"""The choice, and the best that needs none."""
NEAR = 3.0
"""Times the second least running time of the race within which an optimiser runs once more.

Not the least, which two lucky trials may have.
"""
RACED, REPEATED = 2, 8
"""Trials of each in the race, and the further ones."""
FAILED = 10.0
"""Budgets that an optimiser is taken to need which never arrives."""
DRAWS = 20_000
"""Of the bootstrap over problems."""
ANEW = 500
"""Draws of all trials."""

Trials = Mapping[str, Mapping[str, tuple[Real, Real]]]
"""Evaluations at which trials met the target, and that they spent, by problem and optimiser."""

study = Study(
    "suite_repeated",
    datasets=[SUITE],
    models=["own"],
    objectives=["own"],
    optimisers=RIVALS,
    repetitions=RACED + REPEATED,
    budget=BUDGET,
    stop_at_target=True,
)


def archived(path: Path, suite: str = SUITE) -> dict[str, dict[str, tuple[Real, Real]]]:
    """The trials of an archive."""
    best = {each.name: each.best for each in plugins().find("suite", suite).problems}
    archive = Archive.read(path)
    target = float(archive.facts["target"])
    found: dict[str, dict[str, list[tuple[float, float]]]] = {}
    for trial in archive.trials(range(len(archive.cells))):
        cell = archive.cells[trial.cell]
        problem = archive.problems[cell.problem]
        goal = goal_of(problem.reference, best[problem.dataset], target)
        hit = np.inf
        if trial.best is not None and trial.best <= goal:
            hit = hitting_time(*unpack(trial.trace), goal)
        trials = found.setdefault(problem.dataset, {}).setdefault(cell.label, [])
        trials.append((hit, trial.evaluations))
    return {
        problem: {label: (np.array(each)[:, 0], np.array(each)[:, 1]) for label, each in of.items()}
        for problem, of in found.items()
    }


def halves() -> tuple[list[str], list[str]]:
    """The problems that are learnt from, and those that are not: every second of each part."""
    measured = plugins().find("suite", SUITE).measured
    parts: dict[str, list[str]] = {}
    for name, told in measured.items():
        parts.setdefault(told.part, []).append(name)
    learnt = [name for names in parts.values() for name in names[::2]]
    return learnt, [name for name in measured if name not in learnt]


def near(race: Trials) -> dict[str, list[str]]:
    """Who runs once more on each problem."""
    found, dear = {}, set(halves()[0]) - set(sweeps())
    for problem in (name for name in race if name not in dear):
        times = {name: expected_running_time(*each) for name, each in race[problem].items()}
        _, second, *_ = sorted(time for name, time in times.items() if name != CHOICE)
        found[problem] = [n for n, time in times.items() if n == CHOICE or time <= NEAR * second]
    return found


def wanted(who: Mapping[str, list[str]]) -> Plan:
    """The study of those alone."""
    plan = study.plan()
    chosen = [
        cell
        for cell in plan.cells
        if plan.entrants[cell.entrant].label in who.get(plan.cases[cell.case].source.name, ())
    ]
    return replace(plan, cells=tuple(replace(cell, index=i) for i, cell in enumerate(chosen)))


def run(anew: list[str]) -> None:
    """Run what is missing, and some optimisers anew, and write the archive."""
    plan, raced = wanted(near(archived(RACE))), set(range(RACED))
    with Store(FOLDER / f"{study.name}.sqlite", write=True) as store:
        numbers = store.register(plan, provenance(plan))
        if PUBLISHED.exists():
            take_over(store, Archive.read(PUBLISHED), anew)
        # The first two of each are those of the race.
        tasks = plan.tasks(lambda cell: store.finished(numbers[cell.index]) | raced)
        with closing(make_engine(plan, None, None, None).run(tasks)) as results:  # type: ignore[type-var]
            for each in results:
                store.add(each, numbers)
        write_archive(store, PUBLISHED, thin=True)


def least(trials: Mapping[str, tuple[Real, Real]]) -> float:
    """Running time of the quickest rival by all of its trials."""
    return min(expected_running_time(*each) for name, each in trials.items() if name != CHOICE)


def by_the_other(trials: Mapping[str, tuple[Real, Real]]) -> float:
    """Running time of the rival that is quickest by one half of the trials, by the other half."""
    rivals = [each for name, each in trials.items() if name != CHOICE]
    hits, spent = list[Real](), list[Real]()
    for own in (0, 1):
        times = [expected_running_time(h[own::2], s[own::2]) for h, s in rivals]
        chosen = rivals[int(np.argmin(times))]
        hits.append(chosen[0][1 - own :: 2])
        spent.append(chosen[1][1 - own :: 2])
    return min(expected_running_time(np.concatenate(hits), np.concatenate(spent)), FAILED * BUDGET)


def ratios(race: Trials, more: Trials, label: str, problems: list[str]) -> Real:
    """Running time over that of the best (problems, 3).

    By the two trials of the race, by the further ones, and by these with others to judge.
    """
    rows = []
    for problem in problems:
        # Who was far from the best has no more than the two.
        mine = more[problem].get(label, race[problem][label])
        times = [expected_running_time(*each) for each in (race[problem][label], mine, mine)]
        bests = [least(race[problem]), least(more[problem]), by_the_other(more[problem])]
        rows.append(np.minimum(times, FAILED * BUDGET) / bests)
    return np.array(rows)


def interval(values: Real) -> Interval:
    """Geometric mean (n,) with a bootstrap 95 % interval over problems."""
    logs = np.log(values)
    drawn = np.random.default_rng(0).integers(0, len(logs), (DRAWS, len(logs)))
    low, high = np.quantile(np.exp(logs[drawn].mean(axis=1)), [0.025, 0.975])
    return Interval(float(np.exp(logs.mean())), float(low), float(high))


def judged(race: Trials, more: Trials) -> Table:
    """The choice, and the best single optimiser, over the virtual best on both halves."""
    half, unseen = ([name for name in names if name in more] for names in halves())
    rows = [
        (
            label,
            *(interval(each) for each in ratios(race, more, label, half).T),
            *(interval(each) for each in ratios(race, more, label, unseen).T),
        )
        for label in (CHOICE, ALONE)
    ]
    ways = ("by the race", "by more trials", "by others")
    columns = (
        "optimiser",
        *(f"{part}, {way}" for part in ("learnt from", "unseen") for way in ways),
    )
    note = (
        "Expected running time over that of the virtual best, as geometric means with bootstrap"
        f" 95 % intervals over the {len(half)} problems that were learnt from and the"
        f" {len(unseen)} unseen ones. By the race: the least of means of {RACED} trials. By more"
        f" trials: the same of {REPEATED} others, of whoever came within {NEAR:g} times of the"
        " second quickest in the race. By others: chosen by one half of these and judged by the"
        f" other. Who never arrives is taken to need {FAILED:g} budgets."
    )
    return Table("The choice, judged by other trials", columns, rows, note)


def selector(race: Trials) -> Table:
    """Each optimiser of the race over the virtual best on both halves, by the race alone."""
    rows = []
    for label in next(iter(race.values())):
        means, missed = list[float](), 0
        for names in halves():
            found = [(race[name][label], least(race[name])) for name in names]
            times = [
                min(expected_running_time(*own), FAILED * BUDGET) / best
                for own, best in found
                if np.isfinite(best)
            ]
            means.append(float(np.exp(np.mean(np.log(times)))))
            missed = sum(not np.isfinite(own[0]).any() for own, best in found if np.isfinite(best))
        rows.append((label, *means, missed))
    rows.sort(key=lambda row: row[2])
    half, unseen = halves()
    note = (
        "Expected running time over that of the virtual best of each problem, as geometric means"
        f" over the half that was learnt from ({len(half)} problems) and the unseen one"
        f" ({len(unseen)}), without those that nobody solves; who never arrives is taken to need"
        f" {FAILED:g} budgets. Missed: unseen problems on which it never arrived."
    )
    columns = ("optimiser", "learnt from", "unseen", "missed")
    return Table("How near to the virtual best", columns, rows, note)


def by_problem(race: Trials, more: Trials) -> Table:
    """The same on each unseen problem, where most is lost first, and who is quickest there."""
    rows = []
    for problem in halves()[1]:
        own, alone = (ratios(race, more, label, [problem])[0] for label in (CHOICE, ALONE))
        times = {n: expected_running_time(*each) for n, each in more[problem].items()}
        first = min((name for name in times if name != CHOICE), key=lambda name: times[name])
        numbers = (*map(float, own), float(alone[1]))
        rows.append((problem.removeprefix(f"{SUITE}/"), *numbers, first, times[first]))
    rows.sort(key=lambda row: -row[2])
    ways = ("by the race", "by more trials", "by others")
    columns = ("problem", *(f"{CHOICE}, {way}" for way in ways), f"{ALONE}, by more trials")
    logs = np.log([row[2] for row in rows])
    without = np.exp((logs.sum() - logs) / (len(logs) - 1))
    note = (
        f"Expected running times as in judged. Without any one of these problems {CHOICE} stands"
        f" between {without.min():.2f} and {without.max():.2f} by more trials."
    )
    return Table(
        "Where it is lost", (*columns, "quickest", "its expected running time"), rows, note
    )


def drawn(trials: Mapping[str, tuple[Real, Real]], rng: np.random.Generator) -> tuple[float, float]:
    """What the best of all trials is told over, by as many drawn anew of everyone and of itself."""
    times = {name: expected_running_time(*each) for name, each in trials.items() if name != CHOICE}
    quickest = trials[min(times, key=lambda name: times[name])]

    def anew(each: tuple[Real, Real]) -> tuple[Real, Real]:
        rows = rng.integers(0, len(each[0]), len(each[0]))
        return each[0][rows], each[1][rows]

    others = {name: anew(trials[name]) for name in times}
    own = min(expected_running_time(*anew(quickest)), FAILED * BUDGET)
    return own / least(others), own / by_the_other(others)


def luck(more: Trials) -> Table:
    """The figures of a choice that is always right: what of the others' is noise."""
    rng, rows = np.random.default_rng(0), []
    for part, names in zip(("learnt from", "unseen"), halves(), strict=True):
        made = [[drawn(more[name], rng) for name in names if name in more] for _ in range(ANEW)]
        for way, each in zip(("more trials", "others"), np.log(made).mean(axis=1).T, strict=True):
            low, high = np.exp(np.quantile(each, [0.025, 0.975]))
            rows.append((part, way, Interval(float(np.exp(each.mean())), float(low), float(high))))
    note = (
        "Expected running time over that of the virtual best, as in judged, of a choice that is"
        f" the quickest by all {REPEATED} trials: these and its own drawn anew {ANEW} times, with"
        " the interval of the draws. What is above these figures is lost, and not noise."
    )
    return Table("A choice that is always right", ("problems", "judged by", "figure"), rows, note)


TOLD = ("| the least of means of", "| the same of", "| chosen by")
"""How the lines of the page begin that tell of the unseen half, in the order of the table."""


def page(text: str, table: Table) -> str:
    """The page with the figures of `judged`."""
    for begins, *cells in zip(TOLD, *(row[-len(TOLD) :] for row in table.rows), strict=True):
        text = rewritten(text, begins, cells)
    return text


def rewritten(text: str, begins: str, cells: Sequence[Interval]) -> str:
    """A page with these figures in the line of a table that begins so."""
    lines = text.splitlines()
    (place,) = [i for i, line in enumerate(lines) if line.startswith(begins)]
    label = lines[place].split(" | ")[0]
    figures = (f"{each.value:.2f} [{each.low:.2f}, {each.high:.2f}]" for each in cells)
    lines[place] = " | ".join((label, *figures)) + " |"
    return "\n".join(lines) + "\n"


def main() -> None:
    """Run, and tell."""
    run(sys.argv[1:])
    more = archived(PUBLISHED)
    race = archived(RACE)
    table = judged(race, more)
    save_table(asking(__doc__, table), FOLDER, "judged")
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8"), table), encoding="utf-8")
    save_table(by_problem(race, more), FOLDER, "by_problem")
    save_table(luck(more), FOLDER, "luck")
    save_table(selector(race), RACE.parent, "selector")


if __name__ == "__main__":
    main()
