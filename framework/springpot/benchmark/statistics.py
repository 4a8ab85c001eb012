"""Statistics of an optimiser comparison: pure functions of arrays read from the store.

A trial that failed or missed its target has an infinite running time; it is never given a number.
How probable it is that one optimiser is better in practice is told beside whether it can be told,
by the Bayesian signed-rank test of Benavoli and others (2014, ICML; 2017, JMLR 18:1-36).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import comb, factorial, fsum, inf, sqrt
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import chi2_sf, normal_quantile, student
from springpot.numerics import AT_ONCE, ROUNDING
from springpot.report.page import Interval as Interval
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL

from .plan import stream_of

Numbers = TypeVar("Numbers", float, Real)

EXACT = 50
"""Differing blocks up to which the signed-rank test is exact."""


def wilson(successes: int, trials: int) -> Interval | None:
    """Success rate with Wilson's score interval (1927, doi:10.1080/01621459.1927.10502953)."""
    if trials == 0:
        return None
    return _score(successes / trials, trials)


def _score(rate: float, trials: float) -> Interval:
    """Wilson's interval of a rate among so many independent trials, whole or not."""
    z = float(normal_quantile(0.5 + 0.5 * INTERVAL))
    scale = 1.0 + z * z / trials
    # Wilson's interval and not rate plus and minus: this one has a width even where all trials
    # succeed.
    centre = (rate + z * z / (2 * trials)) / scale
    half = z / scale * sqrt(rate * (1 - rate) / trials + z * z / (4 * trials * trials))
    # At the ends the interval touches 0 and 1 exactly, which rounding would miss.
    low, high = centre - half, centre + half
    if rate == 0.0:
        low = 0.0
    if rate == 1.0:
        high = 1.0
    return Interval(rate, low, high)


def wilson_over(problems: Sequence[Real]) -> Interval | None:
    """Success rate, the mean over problems, with an interval for further problems like these.

    Trials of one problem mostly end alike, so that they are no independent ones: Wilson's interval
    is taken with as many as would have the variance that the problems show, fewer by what so few of
    them know of it (Korn and Graubard 1998, Survey Methodology 24:193-201). Of 20 problems drawn at
    random, two trials each, it holds the mean of all such in 96 to 98 of 100 draws, where Wilson's
    of the trials does in 77 to 97 and a bootstrap over problems in 47 to 96; of 5, 50 trials each,
    in 94 to 99, where these do in 1 to 61 and 18 to 92.

    Parameters
    ----------
    problems : sequence of ndarray, shape (trials,)
        Hitting times of each problem's trials, infinite where missed. Of a single problem the
        trials are counted, which speaks of it alone.

    Returns
    -------
    Interval or None
        None without a trial.
    """
    hits = [np.isfinite(each) for each in problems if len(each)]
    trials = sum(map(len, hits))
    if len(hits) < 2:
        return wilson(sum(int(each.sum()) for each in hits), trials)
    shares = np.array([each.mean() for each in hits])
    # 49 of 50 are then 0.98, as they are when counted.
    rate, blocks = fsum(shares) / len(shares), float(len(shares))
    # If nobody ever misses, or all do, all trials of a problem may as well be one.
    if rate in (0.0, 1.0):
        return _score(rate, blocks)
    z, variance = float(normal_quantile(0.5 + 0.5 * INTERVAL)), float(shares.var(ddof=1)) / blocks
    worth = min(rate * (1.0 - rate) / variance, trials) if variance else trials
    found = _score(rate, worth * (z / student(INTERVAL, blocks - 1)) ** 2)
    # One miss must not tell more than none: it would where it shows that trials do differ.
    low, high = min(found.low, _score(1.0, blocks).low), max(found.high, _score(0.0, blocks).high)
    return Interval(rate, low, high)


def target_value(best: Numbers, reference: Numbers, fraction: float) -> Numbers:
    """Objective that counts as success (Moré and Wild): best + fraction (reference - best)."""
    return best + fraction * (reference - best)


def goal_of(reference: float, best: float, target: float) -> float:
    """Objective that counts as success; nothing does where no value is known."""
    if not np.isfinite(best):
        return -inf
    return target_value(best, reference, target)


def goals_of(references: Real, bests: Real, target: float) -> Real:
    """`goal_of` for each trial (n,)."""
    known = np.isfinite(bests)
    goals = target_value(np.where(known, bests, 0.0), references, target)
    return np.where(known, goals, -inf)


def hitting_time(evaluations: NDArray[np.int64], values: Real, target: float) -> float:
    """Evaluation at which a run first reached `target`, infinite if never.

    `values` (n,) fall strictly.
    """
    # A search in rising numbers: the values fall, so both are turned round.
    index = int(np.searchsorted(-values, -target, side="left"))
    if index == len(values):
        return inf
    return float(evaluations[index])


def expected_running_time(hits: Real, spent: Real) -> float:
    """Evaluations until success with restarts: all evaluations made over the number of successes.

    Parameters
    ----------
    hits : ndarray, shape (n,)
        Hitting times, infinite where missed.
    spent : ndarray, shape (n,)
        Evaluations of each trial.

    Returns
    -------
    float
        Infinite without a success (Hansen et al. 2021, doi:10.1080/10556788.2020.1808977).
    """
    return float(expected_running_times(hits, spent))


def expected_running_times(hits: Real, spent: Real) -> Real:
    """`expected_running_time` of each row of hits (..., n) and evaluations (..., n)."""
    success = np.isfinite(hits)
    total, counts = np.where(success, hits, spent).sum(axis=-1), success.sum(axis=-1)
    times: Real = np.divide(total, counts, out=np.full(counts.shape, inf), where=counts > 0)
    return times


def running_time_interval(
    hits: Real, spent: Real, rng: np.random.Generator, draws: int = 1000
) -> Interval | None:
    """Expected running time with a percentile bootstrap interval over trials."""
    n = len(hits)
    if n == 0:
        return None
    success = np.isfinite(hits)
    # Whole trials are drawn, hits with what they spent: the two are not independent.
    trials = np.where(success, hits, spent) + 1j * success
    means = np.full(draws, inf)
    if not success.any():
        return Interval(inf, inf, inf)
    # In blocks, so that the table of draws stays within the processor's cache.
    rows = max(1, 2**15 // n)
    for first in range(0, draws, rows):
        block = means[first : first + rows]
        # Whole numbers, whose sums are the same in any order: the quickest is taken.
        sums = np.einsum("ij->i", trials.take(rng.integers(0, n, size=(len(block), n))))
        np.divide(sums.real, sums.imag, out=block, where=sums.imag > 0)
    # Nearest rank rather than interpolation, which has no meaning next to infinity.
    low, high = np.sort(means)[[int(0.025 * draws), int(np.ceil(0.975 * draws)) - 1]]
    return Interval(expected_running_time(hits, spent), float(low), float(high))


def median(values: Real) -> float | None:
    """Median in which infinite values count as the largest; None of nothing."""
    return medians(values[None])[0]


def medians(rows: Real) -> list[float | None]:
    """Median of what is known of each row (k, n); NaN is not.

    Infinite values count as the largest; None where nothing is known.
    """
    # NaN is sorted behind infinity: what is known comes first.
    ordered, known = np.sort(rows, axis=1), (~np.isnan(rows)).sum(axis=1)
    found: list[float | None] = []
    for row, count in zip(ordered, known.tolist(), strict=True):
        if not count:
            found.append(None)
            continue
        low, high = row[(count - 1) // 2], row[count // 2]
        # Two infinities have no mean.
        found.append(float(low) if low == high else float(0.5 * (low + high)))
    return found


def ecdf(times: Real, grid: Real) -> Real:
    """Share of `times` (any shape, infinite where missed) up to each value of `grid` (m,)."""
    ordered = np.sort(times, axis=None)
    return np.searchsorted(ordered, grid, side="right") / max(ordered.size, 1)


def performance_profile(costs: Real, ratios: Real) -> Real:
    """Share of problems solved within a multiple of the best cost.

    Dolan and Moré 2002, doi:10.1007/s101070100263.

    Parameters
    ----------
    costs : ndarray, shape (problems, solvers)
        Infinite where unsolved.
    ratios : ndarray, shape (m,)
        Multiples of the best solver's cost.

    Returns
    -------
    ndarray, shape (solvers, m)
    """
    # Of each problem by itself: no cost of one is compared with that of another.
    best = costs.min(axis=1, keepdims=True)
    relative = np.full(costs.shape, inf)
    np.divide(costs, best, out=relative, where=np.isfinite(costs) & np.isfinite(best))
    return np.array([ecdf(column, ratios) for column in relative.T])


def data_profile(costs: Real, dimensions: Real, budgets: Real) -> Real:
    """Share of problems solved within a budget of evaluations / (d + 1), in simplex gradients.

    Moré and Wild 2009.

    Parameters
    ----------
    costs : ndarray, shape (problems, solvers)
        Evaluations, infinite where unsolved.
    dimensions : ndarray, shape (problems,)
        Numbers of parameters.
    budgets : ndarray, shape (m,)
        In simplex gradients.

    Returns
    -------
    ndarray, shape (solvers, m)
    """
    simplex = costs / (dimensions[:, None] + 1.0)
    return np.array([ecdf(column, budgets) for column in simplex.T])


def ranked(rows: Real) -> Real:
    """Rank of each value (k, n) in its row, the smallest being 1; ties share the mean of theirs.

    As `scipy.stats.rankdata`, which takes most of a second to import.
    """
    places = np.empty(rows.shape)
    for row, place in zip(rows, places, strict=True):
        order = np.sort(row)
        below, up_to = (np.searchsorted(order, row, side) for side in ("left", "right"))
        place[:] = 0.5 * (below + up_to + 1)
    return places


def mean_ranks(scores: Real) -> Real:
    """Mean rank of each column of `scores` (blocks, treatments), the smallest score ranking 1.

    Ties share.
    """
    ranks: Real = ranked(scores).mean(axis=0)
    return ranks


def pooled_ranks(values: Real) -> Real:
    """Rank of each value among all of them, in their shape; infinite ones rank last."""
    return ranked(values.reshape(1, -1)).reshape(values.shape)


def friedman(scores: Real) -> tuple[float, float]:
    """Friedman's statistic and p-value of `scores` (blocks, treatments); infinite scores rank last.

    Where every block is one tie nothing differs. By the approximation of chi squared, but never
    below the chance that so few blocks agree in the order of all.
    """
    ranks, (blocks, treatments) = ranked(scores), scores.shape
    if not np.ptp(ranks):
        return 0.0, 1.0
    # Of the mean ranks, over the variance that ranks with these ties have by chance.
    statistic = blocks * (treatments - 1) * np.var(ranks.mean(axis=0)) / np.var(ranks)
    p = float(chi2_sf(statistic, treatments - 1))
    return float(statistic), max(p, 1 / factorial(treatments) ** (blocks - 1))


def wilcoxon_holm(scores: Real) -> Real:
    """Holm-adjusted p-values (k, k) of pairwise Wilcoxon signed-rank tests of k treatments.

    Over blocks: exact where up to 50 of them differ, ties or not (`sign_flips`), else by the normal
    approximation. Blocks in which a difference is not defined, both being infinite, count as ties.
    """
    first, second = np.triu_indices(scores.shape[1], 1)
    a, b = scores.T[first], scores.T[second]
    same = a == b
    gaps = np.clip(np.where(same, 0.0, a) - np.where(same, 0.0, b), -1e300, 1e300)
    p, few = np.empty(len(gaps)), np.count_nonzero(gaps, axis=1) <= EXACT
    p[few] = sign_flips(gaps[few])
    if not few.all():
        from scipy.special import ndtr

        # A sum of ranks whose signs are chance's: its variance is the sum of their squares. Zeros
        # have no sign here either: problems on which both arrive speak for nobody. scipy.stats has
        # the same, and takes most of a second to import.
        signed = np.sign(gaps[~few]) * ranked(np.abs(gaps[~few]))
        p[~few] = 2.0 * ndtr(-np.abs(signed.sum(axis=1)) / np.sqrt((signed**2).sum(axis=1)))
    return _square(holm(p), scores.shape[1])


def sign_flips(gaps: Real) -> Real:
    """Exact two-sided p-values (k,) of Wilcoxon's signed-rank test, one a row of `gaps` (k, n).

    Of all 2**n signs that chance could give these differences; ties share their rank and zeros keep
    theirs without a sign (Pratt 1959, doi:10.1080/01621459.1959.10501526). The normal approximation
    would be surer of tied differences than n blocks can ever be.
    """
    # Twice the ranks: of ties they are halves.
    ranks = np.rint(2 * ranked(np.abs(gaps))).astype(int)
    return np.array(
        [
            _sign_flip(row[gap != 0], row[gap > 0].sum())
            for row, gap in zip(ranks, gaps, strict=True)
        ]
    )


def _sign_flip(ranks: NDArray[np.int64], positive: int) -> float:
    """Two-sided chance of so extreme a sum of the positive ones of whole `ranks` (n,)."""
    total = int(ranks.sum())
    # Ways to each sum, rank by rank; 2**50 of them are whole numbers of a float still.
    ways = np.zeros(total + 1)
    ways[0] = 1.0
    for rank in ranks:
        ways[rank:] += ways[: total + 1 - rank].copy()
    least = min(positive, total - positive)
    return float(min(1.0, 2.0 * ways[: least + 1].sum() / ways.sum()))


def _square(p: Real, k: int) -> Real:
    """Symmetric table (k, k) of the p-values of all pairs, with 1 on the diagonal."""
    table = np.eye(k)
    first, second = np.triu_indices(k, 1)
    table[first, second] = table[second, first] = p
    return table


def least_signed_rank(blocks: int) -> float:
    """Smallest two-sided p-value of a signed-rank test over so many blocks.

    2 / 2**blocks, all of one sign.
    """
    return min(1.0, 2.0 ** (1 - blocks))


def least_mann_whitney(n: int, m: int) -> float:
    """Smallest one-sided p-value of Mann and Whitney's test, all of `n` values above all of `m`."""
    # Whole numbers divided, not floats: from some 500 trials on no float can hold the divisor.
    return 1 / comb(n + m, n)


def mann_whitney_holm(values: Real) -> Real:
    """`Pairings.p` of rows of `values` (k, n)."""
    return Pairings.of(values).p


def holm(p: Real) -> Real:
    """Holm's step-down adjustment of p-values (m,)."""
    order = np.argsort(p, kind="stable")
    # The smallest is multiplied by all, the next by one less; an adjusted one is never below that
    # before it.
    stepped = np.maximum.accumulate(p[order] * np.arange(len(p), 0, -1))
    adjusted = np.empty_like(stepped)
    adjusted[order] = np.minimum(stepped, 1.0)
    return adjusted


def cliques(ranks: Real, p: Real, alpha: float = 0.05) -> list[tuple[int, int]]:
    """Bars of a critical-difference diagram.

    Widest runs of neighbours in rank of whom no two differ.

    Parameters
    ----------
    ranks : ndarray, shape (k,)
        Mean ranks.
    p : ndarray, shape (k, k)
        Adjusted p-values of the pairs.
    alpha : float
        Level at which two differ.

    Returns
    -------
    list of (int, int)
        First and last place of each run, by rising rank (Demsar 2006, JMLR 7:1-30, with pairwise
        tests).
    """
    order = np.argsort(ranks, kind="stable")
    alike = p[np.ix_(order, order)] > alpha
    runs: list[tuple[int, int]] = []
    for first in range(len(order)):
        last = first
        while last + 1 < len(order) and alike[first : last + 1, last + 1].all():
            last += 1
        # A run that ends where the one before it did lies within that one.
        if last > first and (not runs or last > runs[-1][1]):
            runs.append((first, last))
    return runs


def bands(values: Real, shares: Sequence[float] = (0.25, 0.5, 0.75)) -> Real:
    """Quantiles (len(shares), ...) of `values` (n, ...).

    They are values themselves, as infinity allows no mean.
    """
    places = [max(0, int(np.ceil(share * len(values))) - 1) for share in shares]
    columns = values.reshape(len(values), -1)
    found = np.empty((len(places), columns.shape[1]))
    # Some columns at once, in a copy in which each lies together and that stays within the
    # processor's cache: a sort across memory takes several times as long.
    step = max(1, 2**15 // max(1, len(values)))
    for first in range(0, columns.shape[1], step):
        each = columns[:, first : first + step].T.copy()
        each.sort(axis=1)
        found[:, first : first + step] = each[:, places].T
    return found.reshape(-1, *values.shape[1:])


def mean_interval(values: Real, rng: np.random.Generator, draws: int = 1000) -> list[Interval]:
    """Mean of each column of `values` (blocks, k), percentile bootstrap interval over blocks."""
    n = len(values)
    means = np.empty((draws, values.shape[1]))
    # Some draws at once, as a table of all of them grows with the trials of a problem; eight by
    # eight, or a product ends in other last digits than that of all.
    rows = 8 * max(1, AT_ONCE // (8 * n))
    for first in range(0, draws, rows):
        own = means[first : first + rows]
        # How often each block is drawn is all that a mean asks: no table of draws is made.
        own[:] = rng.multinomial(n, np.full(n, 1.0 / n), size=len(own)) @ values / n
    return intervals(values.mean(axis=0), *np.quantile(means, [0.025, 0.975], axis=0))


def mean_range(values: Real) -> list[Interval]:
    """Mean of each column of `values` (blocks, k) with the range of its blocks."""
    return intervals(values.mean(axis=0), values.min(axis=0), values.max(axis=0))


def intervals(values: Real, low: Real, high: Real) -> list[Interval]:
    """An interval of each value (k,) and its ends."""
    return [Interval(*map(float, each)) for each in zip(values, low, high, strict=True)]


def a12(a: Real, b: Real) -> float:
    """Chance that a value of `a` is smaller than one of `b`, ties counting half.

    The effect size of Vargha and Delaney (2000) for costs: above one half `a` is better.
    """
    # Sorted once: pairs need not be compared one by one.
    ordered = np.sort(b)
    above = len(b) - np.searchsorted(ordered, a, side="right")
    equal = np.searchsorted(ordered, a, side="right") - np.searchsorted(ordered, a, side="left")
    return float((above + 0.5 * equal).sum() / (len(a) * len(b)))


@dataclass(frozen=True, eq=False)
class Pairings:
    """Each value of each of k rows against each value of every other, counted once for all tests.

    Parameters
    ----------
    wins : ndarray, shape (k, k)
        Pairs of a value of the row and one of the column of which the first is smaller, ties
        counting half.
    tied : ndarray, shape (k, k)
        Of the values of two rows together, t^3 summed over groups of t equal ones.
    each : int
        Values in a row.
    """

    wins: Real
    tied: Real
    each: int

    @classmethod
    def of(cls, values: Real) -> Pairings:
        """Those of rows of `values` (k, n), of which infinity is one like others."""
        ranks = np.unique(values, return_inverse=True)[1].reshape(values.shape)
        rows, levels = np.arange(len(ranks))[:, None], int(ranks.max()) + 1
        # Each row's levels behind those of the row before: all are counted at once.
        cells = (ranks + levels * rows).ravel()
        counts = np.bincount(cells, minlength=rows.size * levels).reshape(-1, levels).astype(float)
        below = np.cumsum(counts, axis=1) - 0.5 * counts
        # Of a group, t is the sum of two counts.
        squares = counts * counts
        cubes, squares = (squares * counts).sum(axis=1), squares @ counts.T
        tied = cubes[:, None] + cubes + 3.0 * (squares + squares.T)
        return cls(below @ counts.T, tied, values.shape[1])

    @cached_property
    def p(self) -> Real:
        """Holm-adjusted two-sided p-values (k, k) of Mann and Whitney's test.

        Mann and Whitney 1947, doi:10.1214/aoms/1177730491. By the normal approximation, but never
        below what so many values can tell at all.
        """
        from scipy.special import ndtr

        k, n = len(self.wins), self.each
        first, second = np.triu_indices(k, 1)
        if not len(first):
            return np.ones((k, k))
        ahead = np.abs((self.wins - 0.5 * n * n)[first, second])
        # Of t tied values t^3 - t is lost.
        tied = self.tied[first, second] - 2.0 * n
        variance = n * n / 12.0 * (2 * n + 1 - tied / (2 * n * (2 * n - 1)))
        # Where all values are one nothing differs.
        spread = np.sqrt(np.where(variance > 0.0, variance, np.inf))
        chances = np.minimum(2.0 * ndtr((0.5 - ahead) / spread), 1.0)
        return _square(holm(np.maximum(chances, 2 * least_mann_whitney(n, n))), k)


def mean_ranks_of(wins: Real, each: int) -> Real:
    """Means (k,) of the ranks of each row's values among all, by `Pairings.wins`."""
    ranks: Real = (wins.sum(axis=0) + 0.5 * each) / each
    return ranks


ROPE = 0.06
"""A12 within 0.5 plus and minus this is practical equivalence: below what Vargha and Delaney (2000)
call a small effect."""
PRIOR = 0.5
"""Weight of the prior's one observation, of no difference, as in the source."""
DRAWS = 4000
"""Of the posterior: probabilities are known to 0.008."""


def signed_rank_posterior(gaps: Real, rope: float = ROPE) -> Real:
    """Probabilities (m, 3) that each row is below, within and above the region of equivalence.

    Of a difference over further such problems: the share of draws from the posterior in which most
    of the mean of two differences lies there.

    Parameters
    ----------
    gaps : ndarray, shape (m, n)
        Differences on n problems, a row for each pair.
    rope : float
        Half of the region's width.
    """
    pairs, n = gaps.shape
    # What lies below is above where all signs are turned.
    sides = [_sorted_partners(sign * gaps, rope) for sign in (-1.0, 1.0)]
    whole, where = _most(gaps, rope)
    counts = np.zeros((pairs, 3))
    for weights in _weights(n):
        room, draws = np.empty((3, n + 2, weights.shape[1])), weights.shape[1]
        # Two differences of one region have their mean there: its chance is the square of what they
        # weigh, or more. Some pairs at once, as a table of all pairs and draws is large.
        some = [where[first : first + 99] for first in range(0, pairs, 99)]
        sure = np.concatenate([(w @ weights).min(axis=1) for w in some]) ** 2 > 0.5 + ROUNDING
        counts[sure, whole[sure]] += draws
        for pair in np.flatnonzero(~sure):
            below, above = (
                _chance_above(weights, order[pair], up_to[pair], room) for order, up_to in sides
            )
            chances = np.stack([below, 1.0 - below - above, above])
            counts[pair] += np.bincount(chances.argmax(axis=0), minlength=3)
    return counts / DRAWS


def _most(gaps: Real, rope: float) -> tuple[NDArray[np.int64], Real]:
    """The region (m,) that most of a row's differences are in, and which of them are (m, n + 1).

    The prior's zero is the first of these.
    """
    rows = np.column_stack([np.zeros(len(gaps)), gaps])
    regions = 1 + (rows > rope).astype(np.int64) - (rows < -rope)
    most = np.argmax([(regions == one).sum(axis=1) for one in range(3)], axis=0)
    return most, (regions == most[:, None]).astype(float)


def _weights(n: int) -> Iterator[Real]:
    """Draws from the posterior weights of the prior and n differences, (n + 1, d) some at once."""
    # The same for all pairs, and from the number of problems only: no table hangs on another.
    rng = np.random.default_rng(stream_of(0, "signed rank", n))
    # Beside them stand their sums in the order of a pair, and two rooms for what is picked.
    step = max(1, AT_ONCE // (4 * (n + 2)))
    for first in range(0, DRAWS, step):
        drawn = rng.dirichlet([PRIOR, *[1.0] * n], min(step, DRAWS - first))
        yield np.ascontiguousarray(drawn.T)


def _sorted_partners(gaps: Real, end: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Order (m, n + 1) of the prior's zero and n differences, rising, and partners (m, n + 1).

    With how many of its row, the first in that order, each has a mean of up to `end`: no table of
    all means of two is made. By halving what is left to look at, as the mean rises with the
    partner.
    """
    rows = np.column_stack([np.zeros(len(gaps)), gaps])
    order = np.argsort(rows, axis=1, kind="stable")
    rows = np.take_along_axis(rows, order, axis=1)
    first, last = np.zeros(rows.shape, np.int64), np.full(rows.shape, rows.shape[1])
    for _ in range(rows.shape[1].bit_length()):
        middle = (first + last) // 2
        partners = np.take_along_axis(rows, np.minimum(middle, rows.shape[1] - 1), axis=1)
        found = (0.5 * (rows + partners) <= end) & (middle < last)
        first, last = np.where(found, middle + 1, first), np.where(found, last, middle)
    return order, first


def _chance_above(
    weights: Real, order: NDArray[np.int64], up_to: NDArray[np.int64], room: Real
) -> Real:
    """Chances (d,) that a mean of two differences lies above an end.

    Parameters
    ----------
    weights : ndarray, shape (n, d)
        Of each difference, in d draws.
    order : ndarray of int, shape (n,)
        Of the differences, rising.
    up_to : ndarray of int, shape (n,)
        With how many of them each makes a mean that does not; falling.
    room : ndarray, shape (3, n + 1, d)
        Written over: taken anew for each pair it would cost more than what is done in it.
    """
    # Those from `first` on do with one another, and with some of those from `least` on.
    first, least = np.count_nonzero(up_to > np.arange(len(order))), up_to[-1]
    ordered, sums, picked = room
    high, low = ordered[first : len(order)], ordered[least:first]
    np.take(weights, order[first:], axis=0, out=high, mode="clip")
    total = high.sum(axis=0)
    chances: Real = total * total
    if not (len(high) and len(low)):
        return chances
    np.take(weights, order[least:first], axis=0, out=low, mode="clip")
    # Sums of the fewer, of which the others pick theirs: to make them takes longer.
    few, many, begin = low, high, np.minimum(up_to[first:], first) - least
    if len(high) < len(low):
        few, many, begin = high, low, up_to[least:first] - first
    # From the last on, row by row: numpy's running sum along columns takes several times as long.
    sums[len(few)] = 0.0
    for row in range(len(few) - 1, -1, -1):
        np.add(sums[row + 1], few[row], out=sums[row])
    np.take(sums, begin, axis=0, out=picked[: len(many)], mode="clip")
    chances += 2.0 * np.einsum("ij,ij->j", many, picked[: len(many)])
    return chances
