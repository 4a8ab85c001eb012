"""What a baseline can see: the smallest change that its trials tell in most cases."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, sqrt

import numpy as np

from springpot.rheology.points import Real

from .difference import FACTOR, Successes, drop

POWER = 0.8
"""Share of cases in which a change shall be seen.

The usual one (Cohen 1988, Statistical Power Analysis).
"""


def least_rise(before: Real, share: float, factor: float = FACTOR) -> float:
    """Smallest factor of costs that so many trials after would show with the chance `POWER`.

    Infinite if none.

    Parameters
    ----------
    before : ndarray, shape (n,)
        Positive costs, infinite where missed.
    share : float
        Level of this one comparison.
    factor : float
        Rise that does not count yet.
    """
    from scipy.stats import norm

    n = len(before)
    # How often a cost after must exceed one before (Noether 1987,
    # doi:10.1080/01621459.1987.10478478).
    often = 0.5 + float(norm.isf(share) + norm.ppf(POWER)) * sqrt((2 * n + 1) / (12 * n * n))
    if often >= 1.0:
        return inf
    ratios = np.ones((n, n))
    with np.errstate(invalid="ignore"):
        np.divide(
            before[:, None],
            before,
            out=ratios,
            where=np.isfinite(before[:, None]) | np.isfinite(before),
        )
    return factor * float(np.quantile(ratios, often, method="higher"))


def least_drop_seen(before: Successes, share: float) -> float | None:
    """Highest rate of success after that so many trials would show with the chance `POWER`.

    None if none.

    Parameters
    ----------
    before : Successes
        Those of the baseline.
    share : float
        Level of this one comparison.
    """
    from scipy.stats import beta

    n = before.trials
    # The largest count that is still significant: the fewer, the surer.
    low, high = -1, before.count
    while high - low > 1:
        middle = (low + high) // 2
        if drop(before, Successes(middle, n)) < share:
            low = middle
        else:
            high = middle
    if low < 0:
        return None
    # The rate at which so few or fewer come with that chance (the binomial sum as an incomplete
    # beta function).
    return 1.0 - float(beta.ppf(POWER, n - low, low + 1))


def smallest_seen(
    costs: Sequence[Real],
    cells: Sequence[Successes],
    together: Successes,
    share: float,
    factor: float,
) -> str:
    """The smallest changes of one optimiser that a baseline shows, in words.

    Parameters
    ----------
    costs : sequence of ndarray, shape (n,) each
        Its costs on each problem.
    cells : sequence of Successes
        Its successes on each.
    together : Successes
        Over all of them.
    share, factor : float
        Level of one comparison and rise that does not count yet.
    """
    rises = [least_rise(each, share, factor) for each in costs]
    words = f"costs {_times(min(rises))}"
    if max(rises) > min(rises):
        words += f" to {_times(max(rises))}"
    words += f"; success {_falls(max(cells, key=lambda each: each.rate), share)} on one problem"
    if len(cells) > 1:
        words += f", {_falls(together, share)} over its {len(cells)}"
    return words


def _times(rise: float) -> str:
    if rise == inf:
        return "by no factor"
    return f"x{rise:.3g}"


def _falls(before: Successes, share: float) -> str:
    rate = least_drop_seen(before, share)
    if rate is None:
        return f"{100 * before.rate:.0f} % by no fall"
    # Downwards: what lies between is seen less often.
    return f"{100 * before.rate:.0f} -> {int(100 * rate)} %"
