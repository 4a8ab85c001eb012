"""Pictures of a study: profiles, shares of targets, anytime curves, critical differences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from springpot.benchmark.comparison import Ranking, profiles
from springpot.benchmark.findings import Findings
from springpot.benchmark.scores import CellScores, Race
from springpot.benchmark.statistics import cliques
from springpot.markup import Html, joined, tag
from springpot.rheology.points import Real

from .plot import Dot, Line, Pen, Ranked, Scale, critical_differences, key, plot, scatter

BANDS = 3
"""Optimisers whose quartiles are drawn on a problem; more would hide each other."""

SHARE = Scale("share of trials", 0.0, 1.0)


def figure(picture: Html, caption: str) -> Html:
    """A picture with what it shows."""
    return tag("figure", picture, tag("figcaption", caption))


def diagram(ranking: Ranking) -> Html:
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


def attained(findings: Findings, races: Sequence[Race]) -> list[tuple[str, Real]]:
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
        Optimisers, best first: the first seven get the clearest lines.
    """

    def __init__(self, labels: Sequence[str]) -> None:
        self._pens = {label: Pen(i) for i, label in enumerate(labels)}

    def __getitem__(self, label: str) -> Pen:
        return self._pens[label]

    def key(self) -> Html:
        """What the lines mean."""
        return key(list(self._pens), list(self._pens.values()))


def distribution(findings: Findings, races: Sequence[Race], pens: Pens, caption: str) -> Html:
    """Share of trials and targets reached against evaluations."""
    x = Scale("evaluations", 1.0, float(findings.scale.budget), logarithmic=True)
    grid = findings.scale.grid.astype(float)
    lines = [Line(label, grid, share, pens[label]) for label, share in attained(findings, races)]
    return figure(plot(lines, x, Scale("share of trials and targets", 0.0, 1.0), caption), caption)


def profile_figures(findings: Findings, pens: Pens) -> Iterator[Html]:
    """Data profile and performance profile of all problems."""
    races = findings.races
    # So far the curve of the smallest problem reaches: those of larger ones end before.
    smallest = min(race.dimension for race in races) + 1
    budgets = np.geomspace(1.0, findings.scale.budget / smallest, 160)
    ratios = np.geomspace(1.0, 1000.0, 160)
    profile = profiles(races, budgets, ratios)
    order = np.argsort(-profile.data.mean(axis=1), kind="stable")
    target = f"{findings.scale.target:g}"
    yield figure(
        plot(
            [
                Line(profile.labels[i], budgets, profile.data[i], pens[profile.labels[i]])
                for i in order
            ],
            Scale("evaluations / (d + 1)", 1.0, float(budgets[-1]), logarithmic=True),
            SHARE,
            "data profile",
        ),
        f"Data profile: share of trials that reached the target {target}, d parameters",
    )
    yield figure(
        plot(
            [
                Line(profile.labels[i], ratios, profile.performance[i], pens[profile.labels[i]])
                for i in order
            ],
            Scale("evaluations / those of the best", 1.0, 1000.0, logarithmic=True),
            SHARE,
            "performance profile",
        ),
        "Performance profile: share of trials at the target within this multiple of the best"
        " optimiser's evaluations",
    )


def progress(findings: Findings, race: Race, pens: Pens) -> Iterator[Html]:
    """Anytime curves on one problem: the excess, and on noisy data the noise-free error too."""
    target = findings.scale.target
    # The axis reaches the highest median, and one at least: that is where every search begins.
    top = 1.0
    for scores in race.cells:
        median = scores.curve[1]
        top = max(top, float(median[np.isfinite(median)].max(initial=1.0)))
    y = Scale("excess, median", target, max(10.0 * target, top), logarithmic=True)
    yield _curves(findings, race, pens, [s.curve for s in race.cells], y, "Excess with quartiles")
    clean = [scores.clean for scores in race.cells]
    known = [curve for curve in clean if curve is not None]
    if known:
        values = np.concatenate([curve[1] for curve in known])
        values = values[np.isfinite(values) & (values > 0)]
        y = Scale(
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
    findings: Findings, race: Race, pens: Pens, curves: Sequence[Real], y: Scale, caption: str
) -> Html:
    x = Scale("evaluations", 1.0, float(findings.scale.budget), logarithmic=True)
    grid = findings.scale.grid.astype(float)
    best = sorted(range(len(curves)), key=lambda i: _area(race.cells[i], findings.scale.target))
    lines = []
    for n, i in enumerate(best):
        label, band = race.labels[i], None
        if n < BANDS:
            band = curves[i][[0, 2]]
        lines.append(Line(label, grid, curves[i][1], pens[label], band))
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
    across = Scale(
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
        dots, across, Scale("excess, median", target, 1.0, True), "accuracy against time"
    )
    return figure(picture, caption)


def pair(figures: Iterator[Html] | Sequence[Html]) -> Html:
    """Figures side by side where there is room."""
    return tag("div", joined(figures), class_="pair")
