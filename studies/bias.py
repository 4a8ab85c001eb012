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
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from paper.asking import asking
from paper.draw import COLOURS, INK, can_draw, sheet
from springpot import plugins
from springpot.benchmark import save_table
from springpot.benchmark.bias import BUDGET, DIMENSION, RUNS, Bias, bias_of, bias_table

NAMES = (
    *("random-search", "pso-paper", "spso-2011", "cma-es", "bipop-cma-es", "l-shade"),
    *("differential-evolution", "dual-annealing", "nlopt-crs", "nlopt-isres", "nlopt-esch"),
    *("nlopt-mlsl", "nlopt-sbplx", "nlopt-bobyqa", "nlopt-nelder-mead", "nlopt-direct-l"),
    "scipy-direct",
)
"""Those without derivatives; COBYQA takes a hundred times as long as any of them."""


def draw(tested: Sequence[Bias], folder: Path) -> None:
    """Where the best points of the flat objective lie, all coordinates of a run together."""
    with sheet(folder, "bias", 8.6, 0.42 * len(tested) + 1.4) as page:
        axes = page.subplots()
        for row, bias in enumerate(reversed(tested)):
            # Side by side within its row: points that fall together are still seen.
            places = bias.found.ravel()
            heights = row + 0.32 * np.linspace(-1.0, 1.0, len(places))
            axes.plot(places, heights, ".", markersize=2.5, color=COLOURS[0], alpha=0.6)
        axes.set(
            yticks=range(len(tested)),
            yticklabels=[bias.label for bias in reversed(tested)],
            xlabel="coordinate of the best point, in the box",
            xlim=(-0.01, 1.01),
        )
        for edge in (0.25, 0.75):
            axes.axvline(edge, color=INK, linewidth=0.6, linestyle=":")
        axes.set_title("Best of random numbers: without bias it lies anywhere")


def main(arguments: Sequence[str] | None = None) -> None:
    """Test all and write what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=RUNS)
    parser.add_argument("--budget", type=int, default=BUDGET)
    parser.add_argument("--out", type=Path, default=Path("results/bias"))
    parser.add_argument("names", nargs="*", default=NAMES)
    given = parser.parse_args(arguments)
    tested = [
        bias_of(plugins().find("optimiser", name)(), runs=given.runs, budget=given.budget)
        for name in given.names
    ]
    table = bias_table(f"{DIMENSION} parameters, {given.budget} evaluations", tested)
    given.out.mkdir(parents=True, exist_ok=True)
    for path in save_table(asking(__doc__, table), given.out, "bias", ("md", "csv")):
        print(path)
    if can_draw(given.out):
        draw(tested, given.out)


if __name__ == "__main__":
    main()
