"""Which optimiser to use if nothing is known of the problem: one sentence over all problems of a study."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from springpot.benchmark.comparison import OVER_ALL, Ranking
from springpot.benchmark.findings import Findings
from springpot.benchmark.statistics import Interval, expected_running_time, wilson
from springpot.digits import number
from springpot.markup import Html, joined, tag


@dataclass(frozen=True)
class Pool:
    """Which optimiser to use if nothing is known of the problem: as a `Choice`, but over all of them."""

    ranking: Ranking
    label: str
    success: Interval
    running_time: float
    alike: tuple[str, ...]


def pools(findings: Findings) -> list[Pool]:
    """The choice over all problems at every budget."""
    return [_pool(findings, ranking) for ranking in findings.rankings if ranking.scope == OVER_ALL]


def _pool(findings: Findings, ranking: Ranking) -> Pool:
    """The cheapest of the optimisers that can be told from the first neither in rank nor by their success."""
    budget, best = ranking.budget, int(np.argmin(ranking.means))
    # Where nothing is decided, nobody is worse than the first for certain.
    names = ranking.labels
    if ranking.decided:
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
    # Ranks over a few problems may hide that one of them misses the target more often.
    left = list(names)
    if ranking.decided:
        left = not_below(shares)
    # Among those that are alike the cost decides.
    first, *others = sorted(left, key=lambda name: costs[name])
    return Pool(ranking, first, shares[first], costs[first], tuple(others))


def not_below(shares: Mapping[str, Interval]) -> list[str]:
    """Optimisers whose success is not lower for certain than another's: ranks over a few problems tell little."""
    least = max(share.low for share in shares.values())
    return [name for name, share in shares.items() if share.high >= least]


def verdict(findings: Findings, pool: Pool) -> Iterator[Html]:
    """The sentence at the top of a report."""
    budget = findings.scale.budget
    # No name at all: one that is named is taken, whatever is said beside it.
    if not pool.ranking.decided:
        yield joined([f"There are too few trials to tell any two optimisers apart over all {budget} evaluations."])
        return
    yield joined([f"Knowing nothing of the problem, with {budget} evaluations, use "])
    yield tag("b", pool.label)
    yield joined([f": it reached the target in {share_text(pool.success)} of its trials"])
    if np.isfinite(pool.running_time):
        yield joined([f", after {number(pool.running_time, 3)} evaluations on average, restarts included"])
    if pool.alike:
        yield joined([f". As good, and dearer: {_and(pool.alike)}."])
    else:
        yield joined([". All others are worse for certain."])


def _and(names: Sequence[str]) -> str:
    if len(names) == 1:
        return names[0]
    return f"{', '.join(names[:-1])} and {names[-1]}"


def share_text(rate: Interval | None) -> str:
    """A share with its interval, in per cent."""
    if rate is None:
        return "-"
    low, high = 100 * rate.low, 100 * rate.high
    return f"{100 * rate.value:.0f} % [{low:.0f}, {high:.0f}]"
