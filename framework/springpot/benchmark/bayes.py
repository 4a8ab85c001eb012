"""How probable it is that one optimiser is better in practice, beside whether it can be told.

The Bayesian signed-rank test of Benavoli and others (2014, ICML; 2017, JMLR 18:1-36).
"""

from __future__ import annotations

import numpy as np

from springpot.rheology.points import Real

from .plan import stream_of

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
    n = gaps.shape[1]
    # The same weights for all pairs, and from the number of problems only: no table hangs on
    # another.
    rng = np.random.default_rng(stream_of(0, "signed rank", n))
    weights = rng.dirichlet([PRIOR, *[1.0] * n], DRAWS)
    found = np.empty((len(gaps), 3))
    for row, gap in zip(found, np.column_stack([np.zeros(len(gaps)), gaps]), strict=True):
        means = 0.5 * (gap[:, None] + gap)
        regions = means < -rope, np.abs(means) <= rope, means > rope
        shares = np.stack([np.sum(weights @ region * weights, axis=1) for region in regions])
        row[:] = np.bincount(shares.argmax(axis=0), minlength=3) / DRAWS
    return found
