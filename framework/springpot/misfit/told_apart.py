"""Whether data tell two explanations apart that both leave no more than noise.

A sum of log-likelihoods grows with every sample, so that of two laws, neither of them exact, one
always wins beyond doubt in the end. What speaks against that is the scatter of its own terms: if
the lead comes and goes along the record, another record may give it to the other law.
"""

from __future__ import annotations

from collections.abc import Iterable

from springpot.rheology.points import Real

from ..numerics import TWO_DEVIATIONS


def told_apart(residuals: Iterable[tuple[Real, Real]]) -> bool:
    """Whether one explanation is better than another beyond the scatter of its lead.

    The test of Vuong (1989, doi:10.2307/1912557) at 5 %: the sum of the differences of the samples'
    log-likelihoods against its own standard deviation. That is of terms with a memory, and about
    zero, as the two are as good as each other where it is asked: about their mean few samples
    would tell apart too often.

    Parameters
    ----------
    residuals : iterable of tuple of ndarray
        Of each test what the one and the other leave (n,), over the noise and free of its memory.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.misfit.told_apart import told_apart
    >>> noise, wave = np.random.default_rng(1).normal(size=200), np.sin(0.1 * np.arange(200))
    >>> told_apart([(noise, noise + wave)]), told_apart([(noise, noise + 0.2 * wave)])
    (True, False)
    """
    lead = varied = 0.0
    for one, other in residuals:
        terms = other**2 - one**2
        lead += float(terms.sum())
        varied += variance_of_sum(terms)
    return lead**2 > TWO_DEVIATIONS * varied


def variance_of_sum(terms: Real) -> float:
    """Variance of the sum of terms (n,) of mean zero, of which neighbours may be alike.

    By Newey and West (1987, doi:10.2307/1913610), up to the lag of their rule of 1994
    (doi:10.2307/2297912).
    """
    n = len(terms)
    variance, most = float(terms @ terms), int(4.0 * (n / 100.0) ** (2.0 / 9.0))
    for lag in range(1, min(most, n - 1) + 1):
        variance += 2.0 * (1.0 - lag / (most + 1.0)) * float(terms[lag:] @ terms[:-lag])
    return variance
