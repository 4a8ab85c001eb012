"""The problems of springpot-60 measured: their best known values, features and parts.

    python studies/suite.py            measures them all, which takes some minutes
    python studies/suite.py --page     writes docs/suite.md and its map from what was measured

What it writes beside the suite's description (``springpot-60.csv``) is what
``springpot list suites springpot-60`` shows.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from paper.draw import COLOURS, INK, MARKERS, can_draw, legend_above, sheet
from springpot import plugins
from springpot.benchmark import Study
from springpot.benchmark.plan import Plan, RaceCase, problem_of, reference_of
from springpot.benchmark.traits import (
    Features,
    descents,
    features_of,
    parts_of,
    uniform,
)
from springpot.identification.native import BoundedDescent
from springpot.identification.problem import Problem, SpecimenProblem
from springpot.identification.recorder import Recorder
from springpot.measurement import DataSet, Measured, Measurement
from springpot.rheology import Real

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.text import Text

SUITE, TARGET = "springpot-60", 1e-6
DRAWN = ("springpot-hard-20", "springpot-rugged-20")
"""Suites that a seed draws."""
ROUNDING = 1e-12
STARTS = 200
"""Descents among which the least objective is looked for, half of them from even orders of size."""
ROOT = Path(__file__).parents[1]
SUITES = ROOT / "plugins/springpot_plugins/suites"
PAGE, IMAGES = ROOT / "docs" / "suite.md", ROOT / "docs" / "images"
PARTS = ("easy", "hard", "deceptive")


def sweeps() -> list[str]:
    """The problems without tests in time, of which a trial costs a hundred of the others."""
    return [
        each.name
        for each in plugins().find("suite", SUITE).problems
        if all(isinstance(test, Measurement) for test in each.tests())
    ]


def plan(suite: str = SUITE) -> Plan:
    """All problems, each with its own model and objective."""
    return Study("suite", [suite], ["own"], ["own"], ["random-search"]).plan()


def best_known(problem: SpecimenProblem, told: Sequence[Real]) -> tuple[Real, float]:
    """The least objective that any of many descents in the box ends at, and where (d,).

    Some of them from points (d,) of which something is told.
    """
    low, high = problem.lower, problem.upper
    # As many from all orders of size alike, in which small parameters are found.
    starts = [uniform(problem, STARTS // 2, 2), sized(problem, uniform(problem, STARTS // 2, 3))]
    starts += [np.clip(each, low, high)[None] for each in told]
    points, ends = descents(problem, np.concatenate(starts))
    if isinstance(problem, Problem):
        with np.errstate(all="ignore"):
            descent = BoundedDescent(Recorder(problem, 10**9))
            more = descent.from_scan(np.random.default_rng(0), 16)
        points, ends = np.concatenate([points, more[0]]), np.concatenate([ends, more[1]])
    first = int(np.nanargmin(ends))
    return points[first], float(ends[first])


def sized(problem: SpecimenProblem, points: Real) -> Real:
    """The same points (s, d) of the box by the logarithms of its positive parameters."""
    low, high = problem.lower, problem.upper
    share = (points - low) / (high - low)
    return np.where(low > 0.0, np.abs(low) ** (1.0 - share) * high**share, points)


def measured(case: RaceCase, ends: Sequence[Mapping[str, float]] = ()) -> tuple[float, Features]:
    """Best known objective of a problem, looked for where trials ended too, and its features."""
    source = case.source
    model = source.model_of(case.model)
    problem = problem_of(source, model, case.objective)
    told = [each for each in (source.truth, *ends) if set(each) == set(model.names)]
    starts = [problem.space.from_theta(model.vector(dict(each))) for each in told]
    optimum, best = best_known(problem, starts)
    target = best + TARGET * (reference_of(problem) - best)
    return best, features_of(problem, optimum, best, target)


def main() -> None:
    """Measure all, and write the table."""
    found = {case.source.name: measured(case) for case in plan().cases}
    write(SUITE, found, parts_of({name: features for name, (_, features) in found.items()}))


def write(
    suite: str, found: Mapping[str, tuple[float, Features]], parts: Mapping[str, str]
) -> None:
    """Write what was measured beside a suite's description."""
    with (SUITES / f"{suite}.csv").open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(["problem", "best", "part", *(each.name for each in fields(Features))])
        for name, (best, features) in found.items():
            numbers = (f"{value:.4g}" for value in features.to_dict().values())
            table.writerow([name, repr(best), parts[name], *numbers])


MADE = "\n## The parts\n"
"""From here on docs/suite.md is made; what stands above is written by hand."""


def page() -> str:
    """docs/suite.md."""
    suite = plugins().find("suite", SUITE)
    text = PAGE.read_text(encoding="utf-8").partition(MADE)[0] + MADE
    for part in PARTS:
        rows = [p for p in suite.problems if suite.measured[p.name].part == part]
        text += f"\n### {part.capitalize()}: {len(rows)}\n\n{_table(rows, suite.measured)}"
    for name in DRAWN:
        drawn = plugins().find("suite", name)
        text += f"\n### Of {name}\n\n{_table(drawn.problems, drawn.measured)}"
    return text


def _table(problems: Sequence[DataSet], measured: Mapping[str, Measured]) -> str:
    text = "| problem | parameters | what it is |\n| --- | ---: | --- |\n"
    for each in problems:
        count = int(measured[each.name].features["parameters"])
        # One that was drawn is told by its model alone.
        says = f"`{each.model}`" if each.name.startswith(DRAWN) else each.summary
        text += f"| `{short(each.name)}` | {count} | {says} |\n"
    return text


def short(name: str) -> str:
    """A problem's name without its suite's."""
    return name.partition("/")[2]


def draw_map(folder: Path) -> None:
    """The problems in the plane of the first two principal components of their features."""
    measured = plugins().find("suite", SUITE).measured
    keys = [each.name for each in fields(Features)]
    table = np.array([[each.features[key] for key in keys] for each in measured.values()])
    scores = (table - table.mean(axis=0)) / table.std(axis=0)
    _, _, axes = np.linalg.svd(scores, full_matrices=False)
    # Which way an axis points is nobody's choice: hard is right, and up what has many parameters.
    signs = np.sign(axes[[0, 1], [keys.index("modality"), keys.index("parameters")]])
    plane = axes[:2] * signs[:, None]
    places = scores @ plane.T
    links = [f"suite/{short(name)}.html" for name in measured]
    with sheet(folder, SUITE, 9.2, 6.4, (".svg",)) as figure:
        ax = figure.subplots()
        for part, colour, marker in zip(PARTS, COLOURS, MARKERS, strict=False):
            here = [i for i, each in enumerate(measured.values()) if each.part == part]
            points = ax.scatter(*places[here].T, color=colour, marker=marker, label=part, s=34)
            points.set_urls([links[i] for i in here])
        told = []
        for key, arrow in zip(keys, 3.0 * plane.T, strict=True):
            ax.annotate("", arrow, (0.0, 0.0), arrowprops={"arrowstyle": "->", "color": "0.8"})
            told.append(ax.text(*(1.14 * arrow), key, color="0.45", fontsize=8, ha="center"))
        ax.set(xlabel="first principal component", ylabel="second principal component")
        legend_above(figure, ax, "The sixty problems by their measured features")
        _name(ax, [short(name) for name in measured], links, places, told)


AROUND = np.pi / 8.0 * np.arange(16.0)
AWAY = [(r * np.cos(a), r * np.sin(a)) for r in (6.0, 12.0, 20.0, 30.0, 42.0) for a in AROUND]
"""Where a name may stand beside its point, in points of print."""


def _name(
    ax: Axes, names: Sequence[str], links: Sequence[str], places: Real, told: Sequence[Text]
) -> None:
    """Write names beside their points, each at the nearest place where it hides nothing."""
    from matplotlib.text import Text
    from matplotlib.transforms import Bbox

    ax.figure.canvas.draw()
    taken = [text.get_window_extent() for text in told]
    taken += [Bbox.from_bounds(x - 5, y - 5, 10, 10) for x, y in ax.transData.transform(places)]
    # The crowded ones first, while there is room.
    apart = np.linalg.norm(places[:, None] - places, axis=2)
    for i in np.argsort(np.sort(apart, axis=1)[:, 1:4].sum(axis=1)):
        for away in AWAY:
            side = ("right", "center", "left")[1 + int(np.sign(np.round(away[0])))]
            note = ax.annotate(
                names[i],
                places[i],
                away,
                textcoords="offset points",
                fontsize=6,
                color=INK,
                ha=side,
                va="center",
                url=links[i],
                arrowprops={"arrowstyle": "-", "color": "0.6", "lw": 0.4, "shrinkB": 2},
            )
            # Only now does it know its place; its line may cross what it likes.
            note.get_window_extent()
            box = Text.get_window_extent(note)
            free = box.count_overlaps(taken) == 0 and ax.bbox.containsx(box.x1)
            if free and ax.bbox.containsx(box.x0):
                break
            note.remove()
        taken.append(box)


if __name__ == "__main__":
    if "--page" not in sys.argv:
        main()
    PAGE.write_text(page(), encoding="utf-8")
    if can_draw(IMAGES):
        draw_map(IMAGES)
