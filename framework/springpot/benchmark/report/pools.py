"""Which optimiser to use if nothing is known of the problem.

One sentence over all problems of a study.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, floor

import numpy as np

from springpot.benchmark.comparison import OVER_ALL, Ranking
from springpot.benchmark.findings import Findings
from springpot.benchmark.statistics import Interval, expected_running_time, wilson
from springpot.format_numbers import number
from springpot.markup import Html, joined, tag


@dataclass(frozen=True)
class Pool:
    """Which optimiser to use if nothing is known of the problem.

    As a `Choice`, but over all of them.
    """

    ranking: Ranking
    label: str
    success: Interval
    running_time: float
    alike: tuple[str, ...]


def pools(findings: Findings) -> list[Pool]:
    """The choice over all problems at every budget."""
    return [_pool(findings, ranking) for ranking in findings.rankings if ranking.scope == OVER_ALL]


def _pool(findings: Findings, ranking: Ranking) -> Pool:
    """The cheapest of the optimisers that cannot be told from the first in rank."""
    budget, best = ranking.budget, int(np.argmin(ranking.means))
    names = (ranking.labels[best], *ranking.alike(best))
    costs: dict[str, float] = {}
    shares: dict[str, Interval] = {}
    for name in names:
        i = ranking.labels.index(name)
        hits = np.concatenate([race.hits[i] for race in findings.races])
        spent = np.minimum(np.concatenate([race.spent[i] for race in findings.races]), budget)
        # A target reached after this budget is not reached for one who can afford no more.
        hits = np.where(hits <= budget, hits, np.inf)
        share = wilson(int(np.isfinite(hits).sum()), len(hits))
        assert share is not None
        costs[name], shares[name] = expected_running_time(hits, spent), share
    # Among those that are alike the cost decides.
    first, *others = sorted(names, key=lambda name: costs[name])
    return Pool(ranking, first, shares[first], costs[first], tuple(others))


def verdict(findings: Findings, pool: Pool) -> Iterator[Html]:
    """The sentence at the top of a report."""
    budget, ranking = findings.scale.budget, pool.ranking
    # No name at all: one that is named is taken, whatever is said beside it.
    if not ranking.decided:
        yield joined([_too_few(ranking)])
        return
    knowing = "Knowing nothing of the problem"
    if len(findings.races) == 1:
        knowing = "For this problem"
    yield joined([f"{knowing}, with {budget} evaluations, use "])
    yield tag("b", pool.label)
    yield joined([f": it reached the target in {share_text(pool.success)} of its trials here"])
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


def _too_few(ranking: Ranking) -> str:
    """What a ranking of too few blocks can say: that it can say nothing, and by how much."""
    text = (
        f"{ranking.doubt} {len(ranking.labels)} optimisers apart: the least p-value that they can"
        f" give, adjusted for all pairs, is {number(ranking.least, 2)}."
    )
    # One problem says nothing of the next, but much of itself.
    if len(ranking.reached) > 1:
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
