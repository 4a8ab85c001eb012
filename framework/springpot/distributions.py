"""Chances and quantiles of the usual distributions, by the special functions of SciPy.

``scipy.stats`` holds the same, and takes most of a second to import: as long as a whole diagnosis
of thirty points.

Examples
--------
>>> from springpot.distributions import chi2_sf, f_sf
>>> round(float(chi2_sf(3.841, 1)), 3), round(float(f_sf(4.965, 1, 10)), 3)
(0.05, 0.05)
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import (
    betaln,
    chdtrc,
    fdtrc,
    fdtri,
    gammaincc,
    gammaincinv,
    ndtr,
    ndtri,
    stdtr,
    stdtrit,
)

Chance: TypeAlias = NDArray[np.float64] | Any


def chi2_sf(value: ArrayLike, dof: ArrayLike) -> Chance:
    """Chance that chi-square with `dof` degrees of freedom exceeds `value`."""
    return chdtrc(dof, value)


def chi2_quantile(chance: ArrayLike, dof: ArrayLike) -> Chance:
    """Value below which chi-square with `dof` degrees of freedom lies with this chance."""
    return 2.0 * gammaincinv(np.asarray(dof) / 2.0, chance)


def f_sf(value: ArrayLike, first: ArrayLike, second: ArrayLike) -> Chance:
    """Chance that a ratio of variances exceeds `value`.

    Its variances have `first` and `second` degrees of freedom.
    """
    return fdtrc(first, second, value)


def f_quantile(chance: ArrayLike, first: ArrayLike, second: ArrayLike) -> Chance:
    """Value below which that ratio lies with this chance."""
    return fdtri(first, second, chance)


def f_log_density(value: ArrayLike, first: float, second: float) -> Chance:
    """Logarithm of the density of that ratio, at values above zero."""
    x = np.asarray(value, dtype=np.float64)
    half, other = 0.5 * first, 0.5 * second
    # In logarithms from the start: of many degrees of freedom the beta function itself underflows.
    scale = half * np.log(first / second) - betaln(half, other)
    return scale + (half - 1.0) * np.log(x) - (half + other) * np.log1p(first / second * x)


def gamma_sf(value: ArrayLike, shape: ArrayLike) -> Chance:
    """Chance that a sum of `shape` exponentials of mean one exceeds `value`."""
    return gammaincc(shape, value)


def normal_quantile(chance: ArrayLike) -> Chance:
    """Value below which a standard normal number lies with this chance."""
    return ndtri(chance)


def normal_sf(value: ArrayLike) -> Chance:
    """Chance that a standard normal number exceeds `value`."""
    # The other tail, not 1 - ndtr(value): that is nothing but rounding from eight standard
    # deviations on.
    return ndtr(-np.asarray(value))


def normal_score(value: ArrayLike, dof: float) -> Chance:
    """Standard normal number that is as rare as a value of a Student's t of variance one.

    Parameters
    ----------
    value : array_like
        Values of variance one.
    dof : float
        Their degrees of freedom, more than two; endless of normal ones.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.distributions import normal_score
    >>> [round(float(normal_score(6.0, dof)), 2) for dof in (3.0, 4.0, np.inf)]
    [3.11, 3.27, 6.0]
    """
    x = np.asarray(value, dtype=np.float64)
    if np.isinf(dof):
        return x
    # By the lower tail, as the upper one is nothing but rounding far out.
    return -np.sign(x) * ndtri(stdtr(dof, -np.abs(x) * np.sqrt(dof / (dof - 2.0))))


def student(level: float, dof: float) -> float:
    """Two-sided quantile of Student's t.

    ``level`` of the distribution lies within plus and minus this value.
    """
    if dof <= 0:
        return float("inf")
    return float(stdtrit(dof, 0.5 * (1.0 + level)))


def ends_of_draws(drawn: NDArray[np.float64], level: float) -> NDArray[np.float64]:
    """Two quantiles (2, p) of draws (d, p): ``level`` of them lie between, as many on each side."""
    tail = 50.0 * (1.0 - level)
    return np.asarray(np.percentile(drawn, [tail, 100.0 - tail], axis=0))


def f_sum_sf(value: float, k: NDArray[np.float64], nu: NDArray[np.float64]) -> float:
    """Chance that a sum of k F(k, nu) is larger: squares, each in units of a variance of its own.

    By the one F distribution of the same mean and variance (Satterthwaite's way,
    doi:10.2307/3002019).

    Parameters
    ----------
    value : float
        The sum.
    k, nu : ndarray, shape (m,)
        Degrees of freedom of each term, above and below; nu > 4.
    """
    whole = float(k.sum())
    mean = float(np.sum(k * nu / (nu - 2.0)))
    variance = float(np.sum(2.0 * k * nu**2 * (k + nu - 2.0) / ((nu - 2.0) ** 2 * (nu - 4.0))))
    # A chi-square varies by twice its mean's square over `whole`: as F it has no end below.
    spread, below = whole * variance / mean**2, 1e9
    if spread > 2.0:
        below = min((2.0 * whole - 4.0 + 4.0 * spread) / (spread - 2.0), below)
    return float(f_sf(value / mean * below / (below - 2.0), whole, below))
