"""Frequencies at which the hum of the mains may land in a measurement."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.points import Real

MAINS = (50.0, 60.0)
"""Frequencies of the mains in Hz."""
HARMONICS = (1.0, 2.0, 3.0)
"""Multiples of the mains at which one point may be hum and nothing else."""
MULTIPLES = (1.0 / 3.0, 0.5, *HARMONICS)
"""At which hum lands at all: there, and at tests one of whose own harmonics is the mains."""
NEAR = 0.015
"""Relative distance from a mains multiple at which hum leaks into a sinusoid of ten periods."""


def near_mains(frequency: Real, multiples: Sequence[float] = MULTIPLES) -> NDArray[np.bool_]:
    """Whether frequencies (n,) in Hz are as near to a multiple of the mains as its hum is seen.

    Shape (n,).

    Examples
    --------
    >>> import numpy as np
    >>> from .mains_hum import near_mains
    >>> near_mains(np.array([25.1, 40.0, 50.2]))
    array([ True, False,  True])
    """
    lines = np.outer(MAINS, multiples).ravel()
    near: NDArray[np.bool_] = np.any(np.abs(frequency[:, None] / lines - 1.0) < NEAR, axis=1)
    return near
