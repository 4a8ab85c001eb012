"""Noise with a memory: of first order, where each number shares a part with the one before it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .numerics import SMALLEST, Real

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
    >>> from springpot.memory import autocorrelation_time
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
