"""Whether a sample of costs got worse, by a test that knows when it could never tell.

The rule is that of airspeed velocity: Mann and Whitney's test where the samples are large enough to ever be
significant, otherwise whether the intervals of the medians' stand-ins overlap.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import comb, exp, inf, sqrt

import numpy as np

from springpot.benchmark.statistics import holm
from springpot.rheology import Real

LEVEL = 0.001
"""Chance of a false alarm anywhere in a study that did not change."""
FACTOR = 1.1
"""Costs that grew by less are no regression, however certain."""


@dataclass(frozen=True)
class Verdict:
    """What became of one sample.

    Parameters
    ----------
    worse, better : bool
        Whether costs rose, or fell, beyond the factor with certainty.
    tested : bool
        Whether a test could ever have told; if not, intervals were compared.
    p : float
        Chance of this rise or fall without a change, adjusted for all samples; 1 where nothing was tested.
    """

    worse: bool
    better: bool
    tested: bool
    p: float


def verdicts(pairs: Sequence[tuple[Real, Real]], level: float = LEVEL, factor: float = FACTOR) -> list[Verdict]:
    """Judge samples of costs before and after, all together (Holm's step-down adjustment).

    Parameters
    ----------
    pairs : sequence of (ndarray, ndarray)
        Positive costs before (n,) and after (m,); infinite where a trial missed or failed.
    level : float
        Chance of a false alarm anywhere.
    factor : float
        Rise that does not count yet.
    """
    count = max(len(pairs), 1)
    tested = [smallest_chance(len(before), len(after)) * count < level for before, after in pairs]
    # Grown by the factor beforehand, so that a rise which is smaller is none.
    rises = _adjusted(pairs, tested, lambda before, after: chance(before * factor, after))
    falls = _adjusted(pairs, tested, lambda before, after: chance(after * factor, before))
    judged = []
    for (before, after), test, rise, fall in zip(pairs, tested, rises, falls, strict=True):
        if test:
            judged.append(Verdict(bool(rise < level), bool(fall < level), True, float(min(rise, fall))))
        else:
            # Bonferroni's share: intervals have no p-values for Holm to order.
            share = level / count
            worse, better = apart(before * factor, after, share), apart(after * factor, before, share)
            judged.append(Verdict(worse, better, False, 1.0))
    return judged


def _adjusted(
    pairs: Sequence[tuple[Real, Real]], tested: Sequence[bool], test: Callable[[Real, Real], float]
) -> Real:
    raw = []
    for (before, after), can in zip(pairs, tested, strict=True):
        # A pair that no test could ever tell apart takes its place, but nothing of the level.
        chance_of_pair = 1.0
        if can:
            chance_of_pair = test(before, after)
        raw.append(chance_of_pair)
    return holm(np.array(raw))


def smallest_chance(n: int, m: int) -> float:
    """Smallest p-value that samples of n and m values can have, all of one above all of the other."""
    return 1.0 / comb(n + m, n)


def chance(before: Real, after: Real) -> float:
    """One-sided p-value of Mann and Whitney's test that values of `after` (m,) are larger than of `before` (n,).

    Infinite values tie with one another above all others.
    """
    from scipy.stats import mannwhitneyu, rankdata

    # Of ranks instead of values: an infinite cost has a rank as any other.
    ranks = rankdata(np.concatenate([before, after]))
    # All alike: the variance that the test divides by would be zero.
    if np.ptp(ranks) == 0:
        return 1.0
    return float(mannwhitneyu(ranks[len(before) :], ranks[: len(before)], alternative="greater").pvalue)


def apart(before: Real, after: Real, level: float) -> bool:
    """Whether the interval of `after` lies above that of `before`, both missing the truth by chance `level`."""
    return interval(after, level)[0] > interval(before, level)[1]


def interval(values: Real, level: float) -> tuple[float, float]:
    """Student's interval of the mean logarithm of positive `values` (n,), as values; unbounded from one value.

    With infinite values it is bounded below only, by the finite ones; if all are infinite it is infinity itself.
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
    half = float(t.isf(level / 2, len(finite) - 1)) * float(np.std(finite, ddof=1)) / sqrt(len(finite))
    centre = float(np.mean(finite))
    # A trial that missed costs more than any number, so that there is no upper end.
    if len(finite) < len(values):
        return exp(centre - half), inf
    # Beyond 700 an exponential is no number.
    return exp(centre - half), exp(min(centre + half, 700.0))
