"""Two optimisers that share a budget, told from the archived trials of each alone.

    python studies/suite_portfolio.py

Question: does a schedule of two optimisers, which looks at nothing, come as near to the quickest
optimiser of each problem of springpot-60 as `auto` does, and how near could any schedule come?
Measure: as in suite_repeated. The first has the run to itself for a while, and then a share of it
beside the second; both go on where they were. A trial of the two together meets the target where
one of the first or one of the second would have. What would answer it: the schedule that is best on
one half of the problems, on the other; beside it the one that is best there by hindsight, which
nothing that looks at no feature can pass.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from paper.asking import asking
from springpot.benchmark import Table, save_table
from springpot.benchmark.statistics import expected_running_time
from springpot.rheology import Real
from suite_repeated import (
    ALONE,
    BUDGET,
    CHOICE,
    FAILED,
    FOLDER,
    PUBLISHED,
    RACE,
    Trials,
    archived,
    halves,
    interval,
    least,
)

ALONE_FOR = (50, 100, 200, 400, 800, 1600)
"""Evaluations that the first has for itself."""
SHARES = (0.5, 0.67, 0.8, 0.9)
"""Of what follows, those of the first."""


@dataclass(frozen=True)
class Schedule:
    """The first alone, and then the second beside it.

    Parameters
    ----------
    alone : int
        Evaluations that the first has for itself.
    share : float
        Of those that follow, the first's.
    second : str
        Who has the others.
    """

    alone: int
    share: float
    second: str

    def time(self, first: Real, second: Real) -> float:
        """Expected running time of both, from the evaluations at which each alone arrives."""
        late = self.alone + (first - self.alone) / self.share
        own = np.where(first <= self.alone, first, late)
        other = self.alone + second / (1.0 - self.share)
        # Each trial of the one may go with each of the other.
        hits = np.minimum(own[:, None], other).ravel()
        hits = np.where(hits <= BUDGET, hits, np.inf)
        return min(expected_running_time(hits, np.full(len(hits), BUDGET)), FAILED * BUDGET)


def logs(race: Trials, more: Trials, problems: list[str], schedules: list[Schedule]) -> Real:
    """Logarithms of their times over the virtual best's (problems, schedules)."""
    rows = []
    for problem in problems:
        known = race[problem] | more.get(problem, {})
        best = least(more.get(problem, race[problem]))
        first = known[ALONE][0]
        rows.append([each.time(first, known[each.second][0]) / best for each in schedules])
    return np.log(rows)


def table(race: Trials, more: Trials) -> Table:
    """The schedule that one half chooses, on both, and what hindsight would have chosen."""
    names = [name for name in next(iter(race.values())) if name not in (CHOICE, ALONE)]
    schedules = [Schedule(*each) for each in product(ALONE_FOR, SHARES, names)]
    half, unseen = halves()
    learnt, other = (logs(race, more, problems, schedules) for problems in (half, unseen))
    chosen, luckiest = (int(np.argmin(each.mean(axis=0))) for each in (learnt, other))
    # By all problems but one, on that one.
    others = [np.argmin(np.delete(learnt, i, axis=0).mean(axis=0)) for i in range(len(half))]
    left_out = learnt[np.arange(len(half)), others]
    rows = [
        (what, each.alone, each.share, each.second, *map(interval, map(np.exp, values)))
        for what, each, values in (
            ("learnt", schedules[chosen], (left_out, other[:, chosen])),
            ("hindsight", schedules[luckiest], (learnt[:, luckiest], other[:, luckiest])),
        )
    ]
    own = [expected_running_time(*more[p][CHOICE]) / least(more[p]) for p in unseen]
    ahead = other[:, chosen] - np.log(own)
    error = ahead.std(ddof=1) / np.sqrt(len(ahead))
    note = (
        f"Expected running time over that of the virtual best. {ALONE} has the run to itself for so"
        " many evaluations, and then this share of it beside the second. Learnt: the best on the"
        f" {len(half)} problems that rules are learnt from, where each is judged by the schedule of"
        f" the others; hindsight: the best of {len(schedules)} on the {len(unseen)} unseen ones,"
        f" which nobody could know. There the schedule takes {np.exp(ahead.mean()):.2f} times what"
        f" {CHOICE} does, with a standard error of {100 * error:.0f} %."
    )
    columns = ("schedule", "alone", "share", "second", "learnt from", "unseen")
    return Table("Two that share a budget", columns, rows, note)


def main() -> None:
    """Tell."""
    whole = table(archived(RACE), archived(PUBLISHED))
    save_table(asking(__doc__, whole), FOLDER, "portfolio")


if __name__ == "__main__":
    main()
