"""The frequencies of writers that hand over a table of K, straight between its lines."""

from __future__ import annotations

import numpy as np

from springpot.rheology import Real
from springpot.solvers import Handoff

FEWEST = 8
"""Lines of a table at least, so that one of a narrow band is no straight line either."""


def frequencies(handoff: Handoff, per_decade: int) -> Real:
    """Angular frequencies (n,) over the whole of the band, equal steps of their logarithm."""
    low, high = np.log10(handoff.prony.band)
    steps = int(np.ceil(per_decade * (high - low)))
    return np.logspace(low, high, max(FEWEST, steps + 1))
