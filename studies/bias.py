"""Which optimisers prefer the centre of the box, or its edges, whatever the problem is.

    python studies/bias.py [--runs 60] [--budget 500]

Question: which optimisers without derivatives would find an optimum more readily in the centre of
the box, or at its edges, than elsewhere? Measure: where the best of a flat objective lies, and how
well one landscape is solved with its optimum moved, p adjusted by Holm for all of them. What would
answer it: a place that is preferred on the flat objective; none seen is no proof of none.

No data are fitted: a flat objective of random numbers shows where a search likes to be, and one
landscape with its optimum moved to the centre and into corners what that is worth. Writes
results/bias/bias.md and its plot.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from paper.asking import asking
from paper.draw import COLOURS, INK, can_draw, legend_above, sheet
from springpot import plugins
from springpot.benchmark import save_table
from springpot.benchmark.traits import TRIED, Bias, bias_of, bias_table
from springpot.errors import ModelError
from springpot.identification import Optimiser

NAMES = (
    *("random-search", "pso-paper", "spso-2011", "cma-es", "bipop-cma-es", "l-shade"),
    *("differential-evolution", "dual-annealing", "nlopt-crs", "nlopt-isres", "nlopt-esch"),
    *("nlopt-mlsl", "nlopt-sbplx", "nlopt-bobyqa", "nlopt-nelder-mead", "nlopt-direct-l"),
    *("scipy-direct", "minion-lshade", "minion-jso", "minion-arrde", "minion-spso-2011"),
    *("pymoo-pso", "pymoo-de"),
)
"""Those without derivatives; COBYQA and Py-BOBYQA take a hundred times as long as most of them."""


def draw(tested: Sequence[Bias], folder: Path) -> None:
    """Where the best points of the flat objective lie, and what a moved optimum changes."""
    with sheet(folder, "bias", 9.8, 0.38 * len(tested) + 1.6) as page:
        flat, moved = page.subplots(1, 2, sharey=True, width_ratios=(3, 1))
        rows = list(enumerate(reversed(tested)))
        for row, bias in rows:
            # Side by side within its row: points that fall together are still seen.
            places = bias.found.ravel()
            heights = row + 0.32 * np.linspace(-1.0, 1.0, len(places))
            flat.plot(places, heights, ".", markersize=2.5, color=COLOURS[0], alpha=0.6)
        flat.set(
            yticks=[row for row, _ in rows],
            yticklabels=[bias.label for _, bias in rows],
            xlabel="coordinate of the best of random numbers, in the box",
            xlim=(-0.01, 1.01),
        )
        for edge in (0.25, 0.75):
            flat.axvline(edge, color=INK, linewidth=0.6, linestyle=":")
        for i, (place, marker) in enumerate((("the centre", "D"), ("a corner", "s"))):
            chances = [bias.chances(place.split()[1]) for _, bias in rows]
            style = {"color": COLOURS[i + 1], "linestyle": "none", "label": f"in {place}"}
            moved.plot(chances, range(len(rows)), marker=marker, **style)
        moved.axvline(0.5, color=INK, linewidth=0.6, linestyle=":")
        moved.set(xlabel="chance to end lower", xlim=(-0.04, 1.04))
        legend_above(
            page,
            moved,
            "Left: without bias it lies anywhere. Right: optimum moved, one half without bias",
        )


def installed(names: Sequence[str]) -> Iterator[Optimiser]:
    """Those whose library is here; the others are told."""
    for name in names:
        try:
            yield plugins().find("optimiser", name)()
        except ModelError as error:
            print(f"left out: {error}", file=sys.stderr)


def main(arguments: Sequence[str] | None = None) -> None:
    """Test all and write what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=TRIED.runs)
    parser.add_argument("--budget", type=int, default=TRIED.budget)
    parser.add_argument("--out", type=Path, default=Path("results/bias"))
    parser.add_argument("names", nargs="*", default=NAMES)
    given = parser.parse_args(arguments)
    tested = [
        bias_of(optimiser, runs=given.runs, budget=given.budget)
        for optimiser in installed(given.names)
    ]
    table = bias_table(f"{TRIED.dimension} parameters, {given.budget} evaluations", tested)
    given.out.mkdir(parents=True, exist_ok=True)
    for path in save_table(asking(__doc__, table), given.out, "bias", ("md", "csv")):
        print(path)
    if can_draw(given.out):
        draw(tested, given.out)


if __name__ == "__main__":
    main()
