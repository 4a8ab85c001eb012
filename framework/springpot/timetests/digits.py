"""Records of few digits: rounding repeats itself where the signal does, as noise does not."""

from __future__ import annotations

import numpy as np

from springpot.rheology.points import Real

MOST_LEVELS = 0.25
"""Share of the samples up to which their values are few: a channel of coarse digits."""
FEWEST_LEVELS = 3
"""Values of a channel at least from which its digit can be told."""
ZEROS = 8
"""Places of the zero between two digits that are tried: nobody knows where it lies."""


def digit_of(values: Real) -> float:
    """The step between neighbouring values of a channel; 0 where it has more than a few.

    Parameters
    ----------
    values : ndarray, shape (n,)
        The channel, sample by sample.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.timetests.digits import digit_of
    >>> digit_of(np.round(np.sin(np.arange(100.0)) / 0.25) * 0.25)
    0.25
    """
    levels = np.unique(values)
    if not FEWEST_LEVELS <= len(levels) <= MOST_LEVELS * len(values):
        return 0.0
    return float(np.median(np.diff(levels)))


def roundings(exact: Real, digit: float) -> Real:
    """Errors (ZEROS, n) of exact values (n,) that are written to a digit.

    One row for each place of the zero between two digits; no row where there is no digit.
    """
    if digit == 0.0:
        return np.zeros((0, len(exact)))
    moved = exact + digit * ((np.arange(ZEROS) + 0.5) / ZEROS - 0.5)[:, None]
    return np.asarray(digit * np.round(moved / digit) - moved, dtype=float)
