"""What the accuracy gate sees, and how often it is wrong.

Drawn samples, judged as ``regression check`` judges them.

    python studies/gate_power.py [--draws 200] [--out results/gate]

Question: which losses does the accuracy gate see, and how often does it fail where nothing changed?
Measure: the share of draws in which it fails, by what changed and by trials of a cell. What would
answer it: with 20 trials, 80 % of the draws in which one optimiser lost a fifth of its trials on
three problems, and at most 1 % of those in which nothing changed.

Hitting times are lognormal, with a standard deviation of 0.25 of their logarithm; that of a trial
that does not succeed is infinite. Six cells each time. Every entry has a random stream of its own,
named by the row and the trials, so that it can be drawn again alone.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from paper.asking import asking
from springpot.benchmark import Interval, Table, save_table
from springpot.benchmark.gate.baseline import (
    EVALUATIONS,
    FACTOR,
    LEVEL,
    SEPARATOR,
    Baseline,
    Sample,
)
from springpot.benchmark.gate.regression import changes_since
from springpot.benchmark.plan import stream_of
from springpot.benchmark.statistics import wilson
from springpot.report.page import Entry

TRIALS = (20, 40, 60, 80)
SPREAD = 0.25
QUIET = 3
"""How many times more draws where nothing changed: alarms are rare."""


@dataclass(frozen=True)
class Scene:
    """What changed between two runs of a study of six cells.

    Parameters
    ----------
    optimisers : int
        Over which the six cells are divided; each has as many problems.
    changed : int
        Cells that changed, all of the first optimiser.
    before, after : float
        Rate of success of every cell, and of those that changed.
    factor : float
        By which the changed cells' evaluations rose.
    """

    optimisers: int
    changed: int
    before: float = 1.0
    after: float = 1.0
    factor: float = 1.0

    def __str__(self) -> str:
        if not self.changed:
            return f"nothing, success {100 * self.before:.0f} %, {self.optimisers} optimisers"
        what = f"success {100 * self.before:.0f} -> {100 * self.after:.0f} %"
        if self.factor > 1:
            what = f"evaluations x{self.factor:g}"
        if self.changed == 1:
            return f"{what} in one cell of 6"
        return f"{what} of one optimiser on all its {self.changed} problems"


SCENES = (
    *(Scene(3, 1, after=rate) for rate in (0.9, 0.8, 0.65, 0.5)),
    *(Scene(6 // cells, cells, after=0.8) for cells in (2, 3, 6)),
    *(Scene(3, 1, factor=factor) for factor in (1.2, 1.3, 1.5, 2.0)),
    Scene(3, 0),
    Scene(3, 0, before=0.8, after=0.8),
    Scene(1, 0, before=0.8, after=0.8),
)


def sample(rate: float, factor: float, trials: int, rng: np.random.Generator) -> Sample:
    """One cell's trials."""
    times = factor * np.exp(SPREAD * rng.standard_normal(trials))
    times[rng.random(trials) >= rate] = np.inf
    return Sample(EVALUATIONS, tuple(np.sort(times).tolist()), int(np.isfinite(times).sum()))


def fails(scene: Scene, trials: int, rng: np.random.Generator) -> bool:
    """Whether the gate fails in one draw."""
    problems = 6 // scene.optimisers
    before, after = {}, {}
    for cell in range(6):
        key = SEPARATOR.join(
            (f"data-{cell % problems}", "model", "objective", f"optimiser-{cell // problems}")
        )
        rate, factor = scene.before, 1.0
        if cell < scene.changed:
            rate, factor = scene.after, scene.factor
        before[key] = sample(scene.before, 1.0, trials, rng)
        after[key] = sample(rate, factor, trials, rng)
    return any(
        change.worse
        for change in changes_since(Baseline("", "", {}, {}, before), after, LEVEL, FACTOR)
    )


def share_seen(scene: Scene, trials: int, draws: int) -> Interval:
    """Share of draws in which the gate fails."""
    rng = np.random.default_rng(stream_of(0, "gate power", str(scene), trials))
    share = wilson(sum(fails(scene, trials, rng) for _ in range(draws)), draws)
    assert share is not None
    return share


def power(draws: int) -> Table:
    """Share of draws in which the gate fails, by what changed and trials of a cell."""
    rows: list[tuple[Entry, ...]] = []
    for scene in SCENES:
        repeats = draws if scene.changed else QUIET * draws
        shares = [share_seen(scene, trials, repeats) for trials in TRIALS]
        rows.append((str(scene), repeats, *shares))
        print(rows[-1][0], *(f"{share.value:.3f}" for share in shares), flush=True)
    note = (
        f"Share of draws in which `springpot regression check` fails at its level of {LEVEL:g},"
        " with Wilson's 95 % interval. Of the rows in which nothing changed it is the rate of"
        " false alarms, each time that all samples are drawn anew. Lognormal evaluations to the"
        f" target, standard deviation of the logarithm {SPREAD:g}."
    )
    return Table(
        "What the gate sees",
        ("what changed", "draws", *(f"{n} trials" for n in TRIALS)),
        rows,
        note,
    )


def main() -> int:
    """Draw and write the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--draws", type=int, default=200, help="draws of each entry")
    parser.add_argument(
        "--out", type=Path, default=Path("results/gate"), help="folder of the table"
    )
    given = parser.parse_args()
    # A path that cannot be written is told before time is spent on the draws.
    given.out.mkdir(parents=True, exist_ok=True)
    save_table(asking(__doc__, power(given.draws)), given.out, "power", ("md", "csv"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
