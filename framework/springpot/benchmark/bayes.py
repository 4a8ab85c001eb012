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
AT_ONCE = 1 << 21
"""Numbers that are in memory at once: 16 MiB."""
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
    gaps = np.column_stack([np.zeros(len(gaps)), gaps])
    # Each mean of two once; that of a and b is that of b and a.
    first, second = np.triu_indices(n + 1)
    means = 0.5 * (gaps[:, first] + gaps[:, second])
    times = np.where(first == second, 1.0, 2.0)
    sides = np.concatenate([times * (means < -rope), times * (means > rope)]).T
    counts = np.zeros((3, len(gaps)))
    for own in np.array_split(weights, 1 + len(weights) * len(first) // AT_ONCE):
        below, above = np.split(own[:, first] * own[:, second] @ sides, 2, axis=1)
        most = np.stack([below, 1.0 - below - above, above]).argmax(axis=0)
        counts += np.stack([(most == region).sum(axis=0) for region in range(3)])
    found: Real = counts.T / DRAWS
    return found
