"""How far the data allow neighbouring levels to be shifted.

No further than their sweeps can overlap.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.points import Real

from .words import level_text

DECADE = float(np.log(10.0))


@dataclass(frozen=True, eq=False)
class Allowed:
    """Bounds of a shift that follow from what the sweeps have in common.

    Sweeps with moduli in common have reduced frequencies in common, as |K| rises with the
    frequency. So two neighbours of which that is true are at most so far apart that the end of the
    one meets the end of the other.

    Attributes
    ----------
    column : str
        The condition.
    levels : ndarray, shape (m,)
        Its levels.
    first, last : ndarray, shape (m,)
        Logarithms of the least and the largest frequency measured at each.
    overlaps : ndarray of bool, shape (m, m)
        Which surely have moduli in common, their vertical factors applied.
    """

    column: str
    levels: Real
    first: Real
    last: Real
    overlaps: NDArray[np.bool_]

    def broken_by(self, log_a: Real) -> str:
        """What shifts (m,) do that no material could; empty where they may be those of one."""
        if not np.all(np.isfinite(log_a)):
            return "is endless at a level that was measured"
        i = np.arange(len(self.levels) - 1)
        # Their reduced frequencies would leave a gap, the one way or the other.
        up = self.first[i] + log_a[i] - self.last[i + 1] - log_a[i + 1]
        down = self.first[i + 1] + log_a[i + 1] - self.last[i] - log_a[i]
        gap = np.where(self.overlaps[i, i + 1], np.maximum(up, down), 0.0)
        at = int(np.argmax(gap))
        if gap[at] <= 0.0:
            return ""
        apart = abs(log_a[at] - log_a[at + 1]) / DECADE
        cold, hot = (level_text(self.column, float(self.levels[k])) for k in (at, at + 1))
        wide = max(self.last[at] - self.first[at], self.last[at + 1] - self.first[at + 1]) / DECADE
        return (
            f"shifts {cold} and {hot} apart by {apart:.2g} decades, though their sweeps of"
            f" {wide:.2g} decades have moduli in common"
        )
