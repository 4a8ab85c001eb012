"""How finely the values of a column were written, and times that only their digits make uneven."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.points import Real

from ..numerics import ALIKE, FEWEST

MOST_DIGITS = 9
"""Digits from which a value counts as written in full: single precision has seven."""
EVEN = 0.01
"""Relative spread of the steps of time below which samples are evenly spaced."""
MOST_LEVELS = 0.25
"""Share of the samples up to which their values are few: a channel of coarse digits."""
ZEROS = 8
"""Places of the zero between two digits that are tried: nobody knows where it lies."""


def rounding_step(values: Real) -> Real:
    """How far apart the next values lie that could have been written in place of each; shape (n,).

    A column is written with so many decimals, or with so many significant digits, or both, or it
    was read in steps of a converter: the coarsest counts. Zero where the values carry all the
    digits of a number.

    Parameters
    ----------
    values : ndarray, shape (n,)
        One column of a file.

    Examples
    --------
    >>> import numpy as np
    >>> rounding_step(np.array([1.5, 12.25])).tolist()
    [0.01, 0.01]
    >>> rounding_step(0.0731 * np.array([21.0, 22.0, 21.0, 24.0, 22.0, 24.0])).round(4).tolist()
    [0.0731, 0.0731, 0.0731, 0.0731, 0.0731, 0.0731]
    """
    size = np.abs(values[values != 0.0])
    if len(size) == 0:
        return np.zeros(len(values))
    decimals = _fewest(np.zeros(len(size)), size)
    # Zero has no first digit: it is taken to be written as the smallest value beside it is.
    exponent = np.floor(np.log10(np.maximum(np.abs(values), size.min())))
    digits = _fewest(np.floor(np.log10(size)), size)
    step = np.full(len(values), _converter(values))
    if decimals is not None:
        step = np.maximum(step, 10.0**decimals)
    if digits is not None:
        step = np.maximum(step, 10.0 ** (exponent + digits))
    return step


def _converter(values: Real) -> float:
    """The step of a converter, of which all values (n,) are multiples; zero for most columns.

    Its values come again: half of them at least are among the others.
    """
    levels = np.unique(values)
    if len(levels) < FEWEST or 2 * len(levels) > len(values):
        return 0.0
    step = float(np.min(np.diff(levels)))
    off = levels / step - np.round(levels / step)
    return step if np.all(np.abs(off) <= EVEN) else 0.0


def _fewest(exponent: Real, size: Real) -> int | None:
    """The largest number which with exponents (n,) gives powers of ten that divide all values (n,).

    None where only a full number's digits do.
    """
    # The coarsest first: all finer powers divide the values as well.
    powers = np.arange(12.0, -MOST_DIGITS, -1.0)
    # What does not divide the first few does not divide all.
    few = slice(8)
    for power in powers[_divide(exponent[few], size[few], powers)]:
        if _divide(exponent, size, power[None])[0]:
            steps = size / 10.0 ** (exponent + power)
            return int(power) if np.max(steps) < 10.0**MOST_DIGITS else None
    return None


def _divide(exponent: Real, size: Real, powers: Real) -> NDArray[np.bool_]:
    """Which of some powers of ten (m,) divide all values (n,) with their exponents; shape (m,)."""
    steps = size / 10.0 ** (exponent + powers[:, None])
    whole: NDArray[np.bool_] = np.all(np.abs(steps - np.round(steps)) <= ALIKE * steps, axis=1)
    return whole


def even_clock(clock: Real) -> Real:
    """Times (n,) as they were sampled: evenly, where only their digits say otherwise.

    Written times are off by up to half of their last digit, and a mass would feel each such jump.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement.rounding import even_clock
    >>> even_clock(np.array([0.0, 0.333, 0.667, 1.0])).round(5).tolist()
    [0.0, 0.3334, 0.6668, 1.0002]
    >>> even_clock(np.array([0.0, 0.333, 0.7, 1.0])).tolist()
    [0.0, 0.333, 0.7, 1.0]
    """
    if len(clock) < FEWEST:
        return clock
    number = np.arange(len(clock)) - 0.5 * (len(clock) - 1)
    step = float(number @ clock) / float(number @ number)
    # The first stays: where a test begins at nothing, nothing was rounded.
    even = clock[0] + step * np.arange(len(clock))
    digit = rounding_step(clock)
    # Of digits as coarse as the steps nobody knows whether a sample is missing.
    if np.any(np.abs(clock - even) > digit) or not 2.0 * float(digit.max()) < step:
        return clock
    return np.asarray(even, dtype=float)


def is_even(time: Real) -> bool:
    """Whether times (n,) are evenly spaced."""
    steps = np.diff(time)
    return bool(np.ptp(steps) < EVEN * float(np.mean(steps)))


def digit_of(values: Real) -> float:
    """The step in which a channel was written or read; 0 where it has more than a few values.

    Parameters
    ----------
    values : ndarray, shape (n,)
        The channel, sample by sample.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement.rounding import digit_of
    >>> digit_of(np.round(np.sin(np.arange(100.0)) / 0.25) * 0.25)
    0.25
    """
    levels = np.unique(values)
    if not FEWEST <= len(levels) <= MOST_LEVELS * len(values):
        return 0.0
    # What rises fast leaves values out: their distance is the step where no digits tell it.
    return float(np.median(rounding_step(values))) or float(np.median(np.diff(levels)))


def shared_rounding(noise: Real, step: Real) -> Real:
    """Error (n,) that rounding to a step leaves alike in all repeats of a value.

    Noise much smaller than the step is rounded the same way each time: what repeats scatter by says
    nothing of that error, and their mean keeps it. Noise of half a step and more makes rounding
    another error each time. Of a value anywhere within its step the mean over the noise is off by a
    Fourier series, whose terms the noise damps (Widrow and Kollar, Quantization Noise, 2008).

    Parameters
    ----------
    noise : ndarray, shape (n,)
        Standard deviation before anything was rounded.
    step : ndarray, shape (n,)
        To which the values were rounded; 0 where they carry all digits.

    Returns
    -------
    ndarray, shape (n,)
        Standard deviation, at most step / sqrt(12).

    Examples
    --------
    >>> shared_rounding(np.array([0.0, 0.3, 1.0]), np.ones(3)).round(3).tolist()
    [0.288, 0.038, 0.0]
    """
    order = np.arange(1.0, 100.0)[:, None]
    share = noise / np.where(step > 0.0, step, np.inf)
    terms = np.exp(-((2.0 * np.pi * order * share) ** 2)) / (2.0 * (np.pi * order) ** 2)
    return np.asarray(step * np.sqrt(np.sum(terms, axis=0)), dtype=float)


def noise_before_rounding(squares: Real, dof: Real, step: Real, size: Real) -> float:
    """Noise over a size (n,) of repeats that were then rounded to a step (n,).

    Parameters
    ----------
    squares, dof : ndarray, shape (n,)
        Sums of squares of written repeats about their means, and degrees of freedom behind them.
    step, size : ndarray, shape (n,)
        To which they were rounded, and what the noise is proportional to.
    """

    def excess(level: float) -> float:
        noise = level * size
        # As much of the rounding as is not shared is scatter too.
        scatter = noise**2 + step**2 / 12.0 - shared_rounding(noise, step) ** 2
        return float(np.sum(dof * scatter / size**2) - np.sum(squares / size**2))

    low, high = 0.0, float(np.sqrt(np.sum(squares / size**2) / max(np.sum(dof), 1.0)))
    # To a thousandth of what they scatter by.
    for _ in range(10):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if excess(middle) > 0.0 else (middle, high)
    return high


def roundings(exact: Real, written: Real) -> Real:
    """Errors (ZEROS, n) of exact values (n,) that are written to the digit of others.

    One row for each place of the zero between two digits; no row where there is no digit.
    """
    digit = digit_of(written)
    if digit == 0.0:
        return np.zeros((0, len(exact)))
    moved = exact + digit * ((np.arange(ZEROS) + 0.5) / ZEROS - 0.5)[:, None]
    return np.asarray(digit * np.round(moved / digit) - moved, dtype=float)
