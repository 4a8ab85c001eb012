"""Pictures of a study: profiles, shares of targets, anytime curves, critical differences.

Which optimiser to use if nothing is known of the problem.

One sentence over all problems of a study.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, floor
from typing import TYPE_CHECKING

import numpy as np

from springpot.rheology.points import Real
from springpot.writing import Html, joined, number, tag

from .comparison import OVER_ALL, CellScores, MeanRanks, ProblemRace, profiles
from .plot import Dot, Pen, PlotAxis, Ranked, StepLine, critical_differences, key, plot, scatter
from .statistics import Interval, cliques, expected_running_time, wilson_over

if TYPE_CHECKING:
    from .standings import Findings


BANDS = 3
"""Optimisers whose quartiles are drawn on a problem; more would hide each other."""


def figure(picture: Html, caption: str) -> Html:
    """A picture with what it shows."""
    return tag("figure", picture, tag("figcaption", caption))


def diagram(ranking: MeanRanks) -> Html:
    """Critical differences of a ranking."""
    order = np.argsort(ranking.means, kind="stable")
    rows = []
    for i in order:
        rank = ranking.ranks[i]
        rows.append(Ranked(ranking.labels[i], rank.value, rank.low, rank.high))
    width = "95 % interval"
    if not ranking.decided:
        width = f"their range ({ranking.doubt})"
    return figure(
        critical_differences(
            rows, cliques(ranking.means, ranking.p), f"mean ranks at {ranking.budget} evaluations"
        ),
        f"{ranking.budget} evaluations: mean rank over {ranking.blocks} {ranking.unit}, {width}; a"
        " bar at the right joins those that cannot be told apart",
    )


def attained(races: Sequence[ProblemRace]) -> list[tuple[str, Real]]:
    """Share of trials and targets reached along the grid, over some races, by optimiser.

    Best first.
    """
    labels = races[0].labels
    mean = [np.mean([race.cells[i].attained for race in races], axis=0) for i in range(len(labels))]
    rows = sorted(zip(labels, mean, strict=True), key=lambda row: -float(row[1].mean()))
    return [(label, np.asarray(share)) for label, share in rows]


class Pens:
    """One pen for each optimiser, the same in all pictures.

    Parameters
    ----------
    labels : sequence of str
        Optimisers, best first: the first seven get the clearest lines, those behind 21 grey ones.
    """

    def __init__(self, labels: Sequence[str]) -> None:
        self._pens = {label: Pen(i) for i, label in enumerate(labels)}

    def __getitem__(self, label: str) -> Pen:
        return self._pens[label]

    def key(self) -> Html:
        """What the lines mean."""
        return key(list(self._pens), list(self._pens.values()))


def distribution(
    findings: Findings, races: Sequence[ProblemRace], pens: Pens, caption: str
) -> Html:
    """Share of trials and targets reached against evaluations."""
    x, grid = _evaluations(findings)
    lines = [StepLine(label, grid, share, pens[label]) for label, share in attained(races)]
    y = PlotAxis("share of trials and targets", 0.0, 1.0)
    return figure(plot(lines, x, y, caption), caption)


def _evaluations(findings: Findings) -> tuple[PlotAxis, Real]:
    """The axis of all pictures along a race, and where they have values."""
    x = PlotAxis("evaluations", 1.0, float(findings.scale.budget), logarithmic=True)
    return x, findings.scale.grid.astype(float)


def profile_figures(findings: Findings, pens: Pens) -> Iterator[Html]:
    """Data profile and performance profile of all problems."""
    races = findings.races
    # So far the curve of the smallest problem reaches: those of larger ones end before.
    smallest = min(race.dimension for race in races) + 1
    budgets = np.geomspace(1.0, findings.scale.budget / smallest, 160)
    ratios = np.geomspace(1.0, 1000.0, 160)
    profile = profiles(races, budgets, ratios)
    order = np.argsort(-profile.data.mean(axis=1), kind="stable")
    for name, label, along, shares, says in (
        (
            "data profile",
            "evaluations / (d + 1)",
            budgets,
            profile.data,
            f"share of trials that reached the target {findings.scale.target:g}, d parameters",
        ),
        (
            "performance profile",
            "evaluations / those of the best",
            ratios,
            profile.performance,
            "share of trials at the target within this multiple of the best optimiser's"
            " evaluations",
        ),
    ):
        labels = [profile.labels[i] for i in order]
        lines = [
            StepLine(own, along, share, pens[own])
            for own, share in zip(labels, shares[order], strict=True)
        ]
        x = PlotAxis(label, 1.0, float(along[-1]), logarithmic=True)
        y = PlotAxis("share of trials", 0.0, 1.0)
        yield figure(plot(lines, x, y, name), f"{name.capitalize()}: {says}")


def progress(findings: Findings, race: ProblemRace, pens: Pens) -> Iterator[Html]:
    """Anytime curves on one problem: the excess, and on noisy data the noise-free error too."""
    target = findings.scale.target
    # The axis reaches the highest median, and one at least: that is where every search begins.
    top = 1.0
    for scores in race.cells:
        median = scores.curve[1]
        top = float(median[np.isfinite(median)].max(initial=top))
    y = PlotAxis("excess, median", target, max(10.0 * target, top), logarithmic=True)
    yield _curves(findings, race, pens, [s.curve for s in race.cells], y, "Excess with quartiles")
    clean = [scores.clean for scores in race.cells]
    known = [curve for curve in clean if curve is not None]
    if known:
        values = np.concatenate([curve[1] for curve in known])
        values = values[np.isfinite(values) & (values > 0)]
        y = PlotAxis(
            "noise-free objective, median",
            float(values.min()),
            float(values.max()),
            logarithmic=True,
        )
        # Curves go by the place of their optimiser: one that has none keeps its place, and no line
        # is drawn.
        empty = np.full((3, len(findings.scale.grid)), np.inf)
        filled = []
        for curve in clean:
            if curve is None:
                curve = empty
            filled.append(curve)
        yield _curves(
            findings, race, pens, filled, y, "The same points against the data without their noise"
        )


def _curves(
    findings: Findings,
    race: ProblemRace,
    pens: Pens,
    curves: Sequence[Real],
    y: PlotAxis,
    caption: str,
) -> Html:
    x, grid = _evaluations(findings)
    best = sorted(range(len(curves)), key=lambda i: _area(race.cells[i], findings.scale.target))
    lines = []
    for n, i in enumerate(best):
        label, band = race.labels[i], None
        if n < BANDS:
            band = curves[i][[0, 2]]
        lines.append(StepLine(label, grid, curves[i][1], pens[label], band))
    return figure(
        plot(lines, x, y, f"{caption}, {race.problem.model} on {race.problem.dataset}"),
        f"{caption}",
    )


def _area(scores: CellScores, target: float) -> float:
    """Mean logarithm of the median excess along the grid: small where a curve falls early."""
    # Below the target the excess no longer counts; 1e9 stands for an endless one.
    return float(np.mean(np.log(np.clip(scores.curve[1], target, 1e9))))


def accuracy_against_time(findings: Findings, pens: Pens) -> Html:
    """How near each optimiser comes, and what its time is.

    A small point for each problem, a large one for all.

    Named are those that no other beats in both: the choice is among them.
    """
    seconds = {summary.cell.id: summary.processor for summary in findings.summaries}
    target = findings.scale.target
    places: dict[str, list[tuple[float, float, str]]] = {}
    for race in findings.races:
        for label, scores in zip(race.labels, race.cells, strict=True):
            spent, excess = seconds[scores.cell.id], float(scores.curve[1][-1])
            # Where every trial failed there is no time.
            if spent:
                name = f"{label}, {race.problem.model} on {race.problem.dataset}"
                places.setdefault(label, []).append((spent, min(max(excess, target), 1.0), name))
    middle = {}
    for label, of_problems in places.items():
        coordinates = [(x, y) for x, y, _ in of_problems]
        middle[label] = np.median(coordinates, axis=0)
    dots = []
    for label, of_problems in places.items():
        dots += [Dot(name, x, y, pens[label]) for x, y, name in of_problems]
    for label, (x, y) in middle.items():
        # Faster and nearer at once: whoever is beaten in both is nobody's choice.
        beaten = any(a <= x and b <= y and (a, b) != (x, y) for a, b in middle.values())
        written = ""
        if not beaten:
            written = label
        dots.append(
            Dot(f"{label}, median of {len(places[label])}", x, y, pens[label], True, written)
        )
    times = np.array([dot.x for dot in dots])
    across = PlotAxis(
        "processor time of a trial alone, median [s]",
        0.8 * float(times.min()),
        1.25 * float(times.max()),
        True,
    )
    caption = (
        f"Excess at {findings.scale.budget} evaluations against time: down is nearer, left is"
        " faster; the large points are medians over the problems, and those with a name are beaten"
        " by none in both"
    )
    picture = scatter(
        dots, across, PlotAxis("excess, median", target, 1.0, True), "accuracy against time"
    )
    return figure(picture, caption)


def pair(figures: Iterator[Html] | Sequence[Html]) -> Html:
    """Figures side by side where there is room."""
    return tag("div", joined(figures), class_="pair")


@dataclass(frozen=True)
class Pool:
    """Which optimiser to use if nothing is known of the problem.

    As a `Choice`, but over all of them.
    """

    ranking: MeanRanks
    label: str
    success: Interval
    running_time: float
    alike: tuple[str, ...]


def pools(findings: Findings) -> list[Pool]:
    """The choice over all problems at every budget."""
    return [_pool(findings, ranking) for ranking in findings.rankings if ranking.scope == OVER_ALL]


def _pool(findings: Findings, ranking: MeanRanks) -> Pool:
    """The cheapest of the optimisers that cannot be told from the first in rank."""
    budget, best = ranking.budget, int(np.argmin(ranking.means))
    names = (ranking.labels[best], *ranking.alike(best))
    costs: dict[str, float] = {}
    shares: dict[str, Interval] = {}
    for name in names:
        i = ranking.labels.index(name)
        # A target reached after this budget is not reached for one who can afford no more.
        each = [race.of_one(i, "hits") for race in findings.races]
        hits = [np.where(own <= budget, own, np.inf) for own in each]
        spent = np.concatenate([race.of_one(i, "spent") for race in findings.races])
        share = wilson_over(hits)
        assert share is not None
        paid = np.minimum(spent, budget)
        costs[name], shares[name] = expected_running_time(np.concatenate(hits), paid), share
    # Among those that are alike the cost decides.
    first, *others = sorted(names, key=lambda name: costs[name])
    return Pool(ranking, first, shares[first], costs[first], tuple(others))


def with_gradients(findings: Findings) -> set[str]:
    """Optimisers that evaluate gradients."""
    return {summary.cell.label for summary in findings.summaries if summary.gradients}


def verdict(findings: Findings, pool: Pool) -> Iterator[Html]:
    """The sentence at the top of a report."""
    budget, ranking = findings.scale.budget, pool.ranking
    # No name at all: one that is named is taken, whatever is said beside it.
    if not ranking.decided:
        yield joined([_too_few(ranking)])
        return
    which = "Whichever of these problems it is"
    if len(findings.races) == 1:
        which = "For this problem"
    yield joined([f"{which}, with {budget} evaluations, use "])
    yield tag("b", pool.label)
    # Whoever has none of the model cannot follow the advice.
    if pool.label in with_gradients(findings):
        yield joined([", which takes derivatives of the model"])
    yield joined([f": it reached the target in {share_text(pool.success)} of its trials here"])
    if len(findings.races) > 1:
        yield joined([" (the interval is for further problems like these)"])
    if np.isfinite(pool.running_time):
        yield joined(
            [f", after {number(pool.running_time, 3)} evaluations on average, restarts included"]
        )
    if pool.alike:
        yield joined([f". Not told from it, and dearer: {_and(pool.alike)}."])
    else:
        chance = max(float(ranking.p[ranking.labels.index(pool.label), j]) for j in _others(pool))
        over = f"{ranking.blocks} {ranking.unit}"
        yield joined(
            [
                f". All others rank lower (p up to {number(chance, 2)} over {over}, adjusted by"
                " Holm)."
            ]
        )


def _others(pool: Pool) -> list[int]:
    return [j for j, label in enumerate(pool.ranking.labels) if label != pool.label]


def _too_few(ranking: MeanRanks) -> str:
    """What a ranking of too few blocks can say: that it can say nothing, and by how much."""
    text = (
        f"{ranking.doubt} {len(ranking.labels)} optimisers apart: the least p-value that they can"
        f" give, adjusted for all pairs, is {number(ranking.least, 2)}."
    )
    # One problem says nothing of the next, but much of itself.
    if len(ranking.races) > 1:
        text += " What holds on each of them is told below."
    return text


def _and(names: Sequence[str]) -> str:
    if len(names) == 1:
        return names[0]
    return f"{', '.join(names[:-1])} and {names[-1]}"


def share_text(rate: Interval | None) -> str:
    """A share with its interval, in per cent."""
    if rate is None:
        return "-"
    # Outwards: 99.7 % is not yet all.
    return f"{_whole(rate.value)} % [{floor(100 * rate.low)}, {ceil(100 * rate.high)}]"


def _whole(share: float) -> str:
    """A share in per cent; 0 and 100 only where it is."""
    if 0.0 < share < 1.0:
        return str(min(max(round(100 * share), 1), 99))
    return f"{100 * share:.0f}"
