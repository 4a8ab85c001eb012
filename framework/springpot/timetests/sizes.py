"""One size for many numbers."""

from __future__ import annotations

import numpy as np

from springpot.rheology.points import Real


def rms(values: Real) -> float:
    """Root mean square of values (n,)."""
    return float(np.sqrt(np.mean(values**2)))
