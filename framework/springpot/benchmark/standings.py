"""Tables of a comparison: choices, ranks, pairs, profiles, progress."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .comparison import OVER_ALL, Choice, Ranking, profiles
from .scores import CellScores, Race, Scale
from .statistics import Interval
from .tables import Entry, Table

SIMPLEX = (10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 10_000.0)
RATIOS = (1.0, 2.0, 5.0, 10.0, 30.0, 100.0)
WHERE = ("model", "data set", "objective")


def _where(race: Race) -> tuple[Entry, ...]:
    return race.problem.model, race.problem.dataset, race.problem.objective


def choice_table(name: str, chosen: Sequence[Choice], target: float) -> Table:
    """Which optimiser to use for each model, data set and budget."""
    rows = [
        (
            *(*_where(c.race), c.budget, c.label or "none: all trials failed"),
            *(c.success, c.running_time, c.excess),
            *(", ".join(c.alike) or None, c.runner_up, c.chance),
        )
        for c in chosen
    ]
    columns = (
        *(*WHERE, "budget", "use", "success", "expected running time", "excess"),
        *("as good", "next", "chance against next"),
    )
    return Table(
        f"{name}: which optimiser to use", columns, rows, CHOICE_NOTE.format(target=f"{target:g}")
    )


CHOICE_NOTE = (
    "Use: of the optimisers that no other beats for certain at this budget, the one with the fewest"
    " evaluations to the target; as good: the others of these, the cheapest first. Excess: (f -"
    " f_best) / (g - f_best), median; success: excess at most {target} within the budget, with"
    " Wilson's 95 % interval. Told apart by Mann and Whitney's test over repetitions, adjusted by"
    " Holm, at 5 %. Next: the best of those that are worse for certain; chance: that a trial of the"
    " choice ends below one of the next, ties by half (A12). At a budget below the study's, trials"
    " are judged by what they had found by then. An evaluation with its gradient counts as one: see"
    " the table of times."
)


def rank_table(name: str, rankings_shown: Sequence[Ranking]) -> Table:
    """Mean ranks over problems, with their certainty."""
    rows: list[tuple[Entry, ...]] = []
    for ranking in rankings_shown:
        for i in np.argsort(ranking.means, kind="stable"):
            alike = ranking.doubt or ", ".join(ranking.alike(int(i)))
            rows.append(
                (
                    *(ranking.scope, ranking.budget, ranking.labels[i], ranking.ranks[i]),
                    *(alike or None, f"{ranking.blocks} {ranking.unit}"),
                    *(ranking.least, _or_none(ranking.p_all)),
                )
            )
    columns = (
        "problems",
        "budget",
        "optimiser",
        "mean rank",
        "not told from",
        "blocks",
        "least p",
        "p of Friedman",
    )
    note = (
        "Rank by the excess reached at the budget, no better than the target counted, 1 being best;"
        " with a bootstrap 95 % interval over problems, or their range where they are too few to"
        " tell any two optimisers apart. Not told from: Wilcoxon's signed-rank test over problems,"
        " adjusted by Holm for all pairs, above 5 %; least p: the smallest that so many problems"
        " can give, if all of them agree. Of a single problem the trials are ranked and tested"
        " (Mann and Whitney), which says nothing of another."
    )
    return Table(f"{name}: ranks", columns, rows, note)


def pair_table(name: str, rankings_shown: Sequence[Ranking]) -> Table:
    """All pairs over all problems: effect sizes with adjusted p-values."""
    rows: list[tuple[Entry, ...]] = []
    for ranking in (each for each in rankings_shown if each.scope == OVER_ALL):
        order = np.argsort(ranking.means, kind="stable")
        for place, i in enumerate(order):
            # Each pair once, the better by rank first: the chance then mostly lies above one half.
            for j in order[place + 1 :]:
                p = float(ranking.p[i, j])
                verdict = ranking.doubt or "no"
                if ranking.told(int(i), int(j)):
                    verdict = "yes"
                rows.append(
                    (
                        ranking.budget,
                        ranking.labels[i],
                        ranking.labels[j],
                        float(ranking.chances[i, j]),
                        p,
                        verdict,
                    )
                )
    columns = ("budget", "optimiser", "against", "chance to end below", "p (Holm)", "told apart")
    note = (
        "Chance: that a trial of the optimiser ends below one of the other on the same problem at"
        " that budget, ties by half (A12, Vargha and Delaney), mean over problems; from 0.56, 0.64"
        " and 0.71 on it is called small, medium and large. p: as in the table of ranks."
    )
    return Table(f"{name}: pairs", columns, rows, note)


def profile_table(name: str, races: Sequence[Race], scale: Scale) -> Table:
    """Data and performance profiles as numbers."""
    simplex = np.array(SIMPLEX)
    head = tuple(f"{s:g} (d+1)" for s in SIMPLEX) + tuple(f"{r:g} x best" for r in RATIOS)
    rows: list[tuple[Entry, ...]] = []
    if races:
        shares = profiles(races, simplex, np.array(RATIOS))
        # By the area under the data profile: who solves more, and sooner, stands higher.
        order = np.argsort(-shares.data.sum(axis=1), kind="stable")
        rows = [
            (shares.labels[i], *map(float, shares.data[i]), *map(float, shares.performance[i]))
            for i in order
        ]
    note = (
        f"Share of trials with an excess of at most {scale.target:g} within so many evaluations:"
        " multiples of d + 1, d being the number of parameters (data profile, More and Wild), and"
        " of the evaluations of the best optimiser on the same problem and repetition (performance"
        " profile, Dolan and More). Failures and misses never count as solved."
    )
    return Table(f"{name}: profiles", ("optimiser", *head), rows, note)


def progress_table(name: str, scores: Sequence[CellScores], scale: Scale) -> Table:
    """Anytime curves as numbers.

    Quartiles of the excess, and the share of targets reached, at each mark.
    """
    # The marks are among the grid: nothing is interpolated.
    places = np.searchsorted(scale.grid, scale.marks)
    rows: list[tuple[Entry, ...]] = []
    for s in scores:
        problem = s.cell.problem
        low, middle, high = s.curve[:, places]
        excess = [Interval(*map(float, each)) for each in zip(middle, low, high, strict=True)]
        reached = map(float, s.attained[places])
        rows.append(
            (problem.dataset, problem.model, problem.objective, s.cell.label, *excess, *reached)
        )
    columns = (
        *("data set", "model", "objective", "optimiser"),
        *(f"excess at {mark}" for mark in scale.marks),
        *(f"targets at {mark}" for mark in scale.marks),
    )
    note = (
        "Excess: median with quartiles over all trials, infinite for a failed one. Targets: share"
        f" of all trials and {len(scale.targets)} targets, excesses from 0.3 to that of the study"
        " in half decades, reached by then."
    )
    return Table(f"{name}: progress", columns, rows, note)


def _or_none(value: float) -> float | None:
    # Of fewer than three optimisers there is no such test.
    if np.isnan(value):
        return None
    return value
