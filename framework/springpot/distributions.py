"""Chances and quantiles of the usual distributions, by the special functions of SciPy.

And noise with a memory of first order, where each number shares a part with the one before it.

``scipy.stats`` holds the same, and takes most of a second to import: as long as a whole diagnosis
of thirty points.

Examples
--------
>>> from springpot.distributions import chi2_sf, f_sf
>>> round(float(chi2_sf(3.841, 1)), 3), round(float(f_sf(4.965, 1, 10)), 3)
(0.05, 0.05)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

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

from .numerics import SMALLEST, Real

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


Rows: TypeAlias = NDArray[np.int64] | slice


LIKENESS = 0.98
"""Largest correlation of neighbouring residuals that is believed.

Beyond, a record would be worth no sample at all.
"""


class Links(NamedTuple):
    """Which numbers remember one before them.

    Attributes
    ----------
    later, earlier : ndarray of int, shape (m,), or slice
        These, and those before them; of a single line, as a record is, slices.
    """

    later: Rows = slice(1, None)
    earlier: Rows = slice(None, -1)

    @classmethod
    def along(cls, lines: Sequence[NDArray[np.int64]]) -> Links:
        """Of lines of these rows."""
        return cls(*(np.concatenate([rows[k:][: len(rows) - 1] for rows in lines]) for k in (1, 0)))

    @classmethod
    def of_parts(cls, lines: Sequence[NDArray[np.int64]], count: int) -> Links:
        """Of lines of these points in each of the two parts of `count` points."""
        return cls.along([rows + k for k in (0, count) for rows in lines])

    @classmethod
    def of_levels(cls, omega: Real, number: NDArray[np.int64]) -> Links:
        """Of two parts of points (n,), level by level, rising in frequency."""
        order = np.lexsort((omega, number))
        lines = np.split(order, np.flatnonzero(np.diff(number[order])) + 1)
        return cls.of_parts(lines, len(omega))


LINE = Links()
"""Those of numbers that all follow one another."""


def effective_share(memory: float) -> float:
    """Independent numbers that each one is worth to the mean, or to slow curves.

    By so much less than the mean power of such noise is its power at slow waves. Of squares, whose
    correlation is the square of that of the numbers, so much for the square of the memory.
    """
    return (1.0 - memory) / (1.0 + memory)


def autocorrelation_time(residual: Any, links: Links = LINE) -> float:
    """Numbers of a residual (m,) that make up one independent one.

    For a first-order autoregression with the correlation r of neighbours that is (1 + r) / (1 - r)
    (Bayley & Hammersley 1946, doi:10.2307/2983560).

    Examples
    --------
    >>> from springpot.distributions import autocorrelation_time
    >>> round(autocorrelation_time([1.0, 1.0, -1.0, -1.0, 1.0, 1.0]), 2)
    1.5
    """
    rows = np.asarray(residual)
    power, together = float(np.mean(rows**2)), rows[links.later] * rows[links.earlier]
    if len(rows) < 4 or power == 0.0 or not len(together):
        return 1.0
    # Misses that alternate would claim more than one independent number a sample.
    return 1.0 / effective_share(float(np.clip(np.mean(together) / power, 0.0, LIKENESS)))


def spectrum_of(omega: Real, size: float, memory: float) -> Real:
    """Variance (n,) of noise of a size at frequencies in radians a number."""
    return size**2 * (1.0 - memory**2) / (1.0 + memory**2 - 2.0 * memory * np.cos(omega))


def prewhitened(values: Any, memory: float, links: Links = LINE) -> Any:
    """Values (n, ...) of which each has lost what it remembers of the one before it.

    Noise of this memory keeps its size.
    """
    new = values.copy()
    told = values[links.later] - memory * values[links.earlier]
    new[links.later] = told / np.sqrt(1.0 - memory**2)
    return new


def autoregressive(new: Any, memory: float) -> Any:
    """Noise (..., n) of one line by what is new with each number, of the same size."""
    noise = new.copy()
    noise[..., 1:] *= np.sqrt(1.0 - memory**2)
    return _summed(noise, memory)


def _summed(faded: Any, memory: float) -> Any:
    """Values (..., n) and all before them, each faded once a step; in their place."""
    # What faded by one step is added, then by two of these, by four and so on.
    step, share = 1, memory
    while step < faded.shape[-1] and share > np.finfo(faded.dtype).eps:
        faded[..., step:] += share * faded[..., :-step]
        step, share = 2 * step, share**2
    return faded


def covariance_along(columns: Real, memory: float, lines: Sequence[NDArray[np.int64]]) -> Real:
    """Covariance (q, q) of the sums over such noise of size one times columns (n, q).

    What is in none of the lines is noise by itself.
    """
    alone = np.ones(len(columns), dtype=np.bool_)
    alone[np.concatenate(lines)] = False
    whole: Real = columns[alone].T @ columns[alone]
    for rows in lines:
        # By all that remembers it each new number counts.
        new = _summed(columns[rows[::-1]].T, memory)
        new[:, :-1] *= np.sqrt(1.0 - memory**2)
        whole += new @ new.T
    return whole


def deviance(columns: Real, memory: float, links: Links) -> tuple[float, Real]:
    """Minus twice the log-likelihood of a memory, and what is new with each number (n,).

    Of what curves leave of the last of some columns (n, q + 1), the others being these curves
    (Harville 1977, doi:10.1080/01621459.1977.10480998).
    """
    basis, sizes = np.linalg.qr(prewhitened(columns, memory, links))
    size = np.abs(np.diag(sizes)) + SMALLEST
    free = len(columns) - len(size) + 1
    logs = 2.0 * (free * np.log(size[-1]) + np.sum(np.log(size[:-1])))
    linked = len(columns[links.later])
    return float(logs + linked * np.log1p(-(memory**2))), basis[:, -1] * size[-1]


class FittedMemory(NamedTuple):
    """What a residual tells of the memory of its noise.

    Attributes
    ----------
    memory : float
        The likeliest one, but for what is longer than a longest.
    new : ndarray, shape (n,)
        What is new with each number, of the size of the noise.
    free : int
        Numbers that nothing follows.
    gain : float
        Twice the logarithm of how much likelier it is than white noise, less the price of a number
        by the Bayesian information criterion.
    likeliest : float
        The likeliest one of all.
    """

    memory: float
    new: Real
    free: int
    gain: float
    likeliest: float


def fitted_memory(columns: Real, links: Links, longest: float) -> FittedMemory:
    """The memory of what curves leave of the last of such columns (n, q + 1)."""
    from scipy.optimize import minimize_scalar

    likeliest = float(minimize_scalar(lambda m: deviance(columns, m, links)[0], bounds=(0, 1)).x)
    memory, free = min(likeliest, longest), len(columns) - columns.shape[1] + 1
    cost, new = deviance(columns, memory, links)
    gain = deviance(columns, 0.0, links)[0] - cost - float(np.log(max(free, 1)))
    return FittedMemory(memory, new, free, gain, likeliest)
