"""Newton's method for many roots at once, each held between two ends of different sign."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .points import Real


def inside(newton: NDArray[np.inexact[Any]], low: Real, high: Real) -> Real:
    """The next places to look at, shape (n,).

    Newton's where it lies between the ends, else their middle.
    """
    # Newton ends in few steps, where it stays inside; half the interval always ends.
    places: Real = np.where((newton > low) & (newton < high), newton, 0.5 * (low + high))
    return places


def settled(moved: Real, u: Real, rounding: float) -> bool:
    """Whether no place has moved from `u` by more than rounding.

    A further step would change the last digits only.
    """
    return bool(np.all(np.abs(moved - u) <= rounding * (1.0 + np.abs(u))))
