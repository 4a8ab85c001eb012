"""Whether costs rose or successes became fewer, by tests that know when they could never tell.

The rule for costs is that of airspeed velocity: Mann and Whitney's test where the samples are large
enough to ever be significant, otherwise whether the intervals of the medians' stand-ins overlap.
Successes are counted and compared by Boschloo's exact test.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import exp, inf, log, sqrt

import numpy as np

from springpot.benchmark.statistics import holm, least_mann_whitney
from springpot.rheology.points import Real

LEVEL = 0.01
"""Chance of a false alarm anywhere in a study whose optimisers did not change.

It holds each time that their samples are drawn anew: by another seed, another order of random
numbers, another rounding. The same code draws the same.
"""
FACTOR = 1.1
"""Costs that grew by less are no regression, however certain."""
TABLES = 250**2
"""Outcomes of two groups up to which Boschloo's test takes less than half a second.

Where there are more, Fisher's,
which is never below it, hardly differs."""


@dataclass(frozen=True)
class Successes:
    """How many of some trials succeeded."""

    count: int
    trials: int

    @property
    def rate(self) -> float:
        """Their share."""
        return self.count / max(self.trials, 1)

    def __str__(self) -> str:
        return f"{self.count} of {self.trials} trials"


@dataclass(frozen=True)
class Verdict:
    """What became of one sample.

    Parameters
    ----------
    worse, better : bool
        Whether costs rose beyond the factor, or successes became fewer, with certainty; and the
        reverse.
    tested : bool
        Whether a test could ever have told; if not, intervals were compared, of costs.
    p : float
        Chance of this rise or fall without a change, adjusted for all samples; 1 where nothing was
        tested.
    """

    worse: bool
    better: bool
    tested: bool
    p: float


def verdicts(
    pairs: Sequence[tuple[Real, Real]],
    level: float = LEVEL,
    factor: float = FACTOR,
    counts: Sequence[tuple[Successes, Successes]] = (),
) -> list[Verdict]:
    """Judge costs and successes before and after, all together (Holm's step-down adjustment).

    Parameters
    ----------
    pairs : sequence of (ndarray, ndarray)
        Positive costs before (n,) and after (m,); infinite where a trial missed or failed.
    level : float
        Chance of a false alarm anywhere.
    factor : float
        Rise of costs that does not count yet.
    counts : sequence of (Successes, Successes)
        Before and after.

    Returns
    -------
    list of Verdict
        Of the pairs, then of the counts.
    """
    number = max(len(pairs) + len(counts), 1)
    least = [least_mann_whitney(len(before), len(after)) for before, after in pairs]
    least += [least_drop(before.trials, after.trials) for before, after in counts]
    tested = np.array(least) * number < level
    # Grown by the factor beforehand, so that a rise which is smaller is none.
    rises = [chance(before * factor, after) for before, after in pairs]
    falls = [chance(after * factor, before) for before, after in pairs]
    rises += [drop(before, after) for before, after in counts]
    falls += [drop(after, before) for before, after in counts]
    # What no test could ever tell apart takes its place, but nothing of the level.
    chances = zip(
        holm(np.where(tested, rises, 1.0)), holm(np.where(tested, falls, 1.0)), strict=True
    )
    judged = []
    for i, (rise, fall) in enumerate(chances):
        if tested[i] or i >= len(pairs):
            judged.append(
                Verdict(
                    bool(rise < level), bool(fall < level), bool(tested[i]), float(min(rise, fall))
                )
            )
        else:
            # Bonferroni's share: intervals have no p-values for Holm to order.
            (before, after), share = pairs[i], level / number
            worse, better = (
                apart(before * factor, after, share),
                apart(after * factor, before, share),
            )
            judged.append(Verdict(worse, better, False, 1.0))
    return judged


def drop(before: Successes, after: Successes) -> float:
    """One-sided p-value of Boschloo's exact test that `after` succeeds less often than `before`.

    Boschloo 1970, doi:10.1111/j.1467-9574.1970.tb00104.x. Exact without the margins that Fisher's
    test holds, which are not held here, and never above it.
    """
    # More than one half, and of no interest: there is no drop.
    if after.rate >= before.rate:
        return 1.0
    return _boschloo(after.count, after.trials, before.count, before.trials)


@cache
def _boschloo(low: int, of_low: int, high: int, of_high: int) -> float:
    from scipy.stats import boschloo_exact, fisher_exact

    test = boschloo_exact
    if of_low * of_high > TABLES:
        test = fisher_exact
    return float(test([[low, high], [of_low - low, of_high - high]], alternative="less").pvalue)


def least_drop(n: int, m: int) -> float:
    """Smallest p-value of Boschloo's test: all n trials before succeeded, and none of m after."""
    if not (n and m):
        return 1.0
    # Likeliest, without a change, where n of n + m succeed.
    return exp(n * log(n / (n + m)) + m * log(m / (n + m)))


def chance(before: Real, after: Real) -> float:
    """One-sided p-value of the Mann-Whitney test that `after` (m,) is larger than `before` (n,).

    Infinite values tie with one another above all others. Never below what so few values can tell,
    which the normal approximation of ties would be.
    """
    from scipy.stats import mannwhitneyu, rankdata

    # Of ranks instead of values: an infinite cost has a rank as any other.
    ranks = rankdata(np.concatenate([before, after]))
    # All alike: the variance that the test divides by would be zero.
    if np.ptp(ranks) == 0:
        return 1.0
    p = mannwhitneyu(ranks[len(before) :], ranks[: len(before)], alternative="greater").pvalue
    return max(float(p), least_mann_whitney(len(before), len(after)))


def apart(before: Real, after: Real, level: float) -> bool:
    """Whether the interval of `after` lies above that of `before`.

    Each misses the truth by chance `level`.
    """
    return interval(after, level)[0] > interval(before, level)[1]


def interval(values: Real, level: float) -> tuple[float, float]:
    """Student's interval of the mean logarithm of positive `values` (n,), as values.

    Unbounded from one value.

    With infinite values it is bounded below only, by the finite ones; if all are infinite it is
    infinity itself.
    """
    # Here and above: scipy.stats takes most of a second to import.
    from scipy.stats import t

    finite = np.log(values[np.isfinite(values)])
    if len(finite) == 0:
        # All missed: of one trial alone that tells nothing yet.
        if len(values) > 1:
            return inf, inf
        return 0.0, inf
    if len(finite) < 2:
        return 0.0, inf
    half = (
        float(t.isf(level / 2, len(finite) - 1)) * float(np.std(finite, ddof=1)) / sqrt(len(finite))
    )
    centre = float(np.mean(finite))
    # A trial that missed costs more than any number, so that there is no upper end.
    if len(finite) < len(values):
        return exp(centre - half), inf
    # Beyond 700 an exponential is no number.
    return exp(centre - half), exp(min(centre + half, 700.0))
