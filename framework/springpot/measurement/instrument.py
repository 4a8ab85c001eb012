"""What an instrument leaves in its numbers: digits, steps of time, and the hum of the mains.

How finely the values of a column were written, and times that only their digits make uneven. Hum
are lines of the periodogram that no motion of the specimen has: white noise has no lines; each
ordinate is held against those around it, as noise may have a memory, and the largest of m is known
(Fisher 1929, doi:10.1098/rspa.1929.0151).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.points import Real

from ..numerics import ALIKE, FEWEST, SMALLEST, vertex

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
    >>> from springpot.measurement.instrument import even_clock
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
    >>> from springpot.measurement.instrument import digit_of
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


MAINS = (50.0, 60.0)
"""Frequencies of the mains in Hz."""
HARMONICS = (1.0, 2.0, 3.0)
"""Multiples of the mains at which there may be hum and nothing else."""
MULTIPLES = (1.0 / 3.0, 0.5, *HARMONICS)
"""At which hum lands at all: there, and at tests one of whose own harmonics is the mains."""
NEAR = 0.015
"""Relative distance from a mains multiple at which hum leaks into a sinusoid of ten periods."""


class Line(NamedTuple):
    """How a line is looked for in the spectrum of a record."""

    taper: float
    """Share of the record that is faded at either end (Hann's window), lest what is slow leak."""
    fewest: int
    """Samples of a record in which a line is sought."""
    around: int
    """Ordinates on either side with which one is compared."""
    rare: float
    """Chance of noise alone below which the largest ordinate is a line."""
    wide: int
    """Ordinates on either side over which a line that falls between two of them is spread."""


LINE = Line(taper=0.5, fewest=200, around=20, rare=1e-6, wide=3)


class Hum(NamedTuple):
    """One line of the mains in a channel.

    Attributes
    ----------
    hertz : float
        Its frequency.
    size : float
        Its amplitude.
    course : ndarray, shape (n,)
        The line itself.
    """

    hertz: float
    size: float
    course: Real


def periodogram(residual: Real) -> tuple[Real, Real]:
    """Power of a residual (n,) at each of its frequencies, in radians a sample; its mean left out.

    Of white noise the power is its variance at each of them.
    """
    window = _faded(len(residual))
    turned = np.fft.rfft((residual - residual.mean()) * window)
    power = np.abs(turned) ** 2 / np.sum(window**2)
    return power[1:], 2.0 * np.pi * np.arange(1, len(power)) / len(residual)


def _faded(count: int) -> Real:
    """Weights (n,) that fade a record at both ends."""
    fade = max(1, int(LINE.taper * count))
    window = np.ones(count)
    window[:fade] = 0.5 - 0.5 * np.cos(np.pi * (np.arange(fade) + 0.5) / fade)
    window[-fade:] = window[:fade][::-1]
    return window


def over_neighbours(power: Real) -> Real:
    """Powers (m,) over what those around them say that noise has there."""
    around = np.lib.stride_tricks.sliding_window_view(
        np.pad(power, LINE.around, mode="reflect"), 2 * LINE.around + 1
    )
    # Of an exponential the median is ln 2 times the mean, and a line does not move it.
    return np.asarray(power / np.maximum(np.median(around, axis=1) / np.log(2.0), SMALLEST))


def at_mains(hertz: Real) -> NDArray[np.bool_]:
    """Whether frequencies (m,) of a record are of the mains, as near as it tells them apart."""
    mains = np.outer(MAINS, HARMONICS).ravel()
    near: NDArray[np.bool_] = np.min(np.abs(hertz[:, None] - mains), axis=1) <= 1.5 * hertz[0]
    return near


def near_mains(frequency: Real, multiples: Sequence[float] = MULTIPLES) -> NDArray[np.bool_]:
    """Whether frequencies (n,) in Hz are as near to a multiple of the mains as its hum is seen.

    Shape (n,).

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement.instrument import near_mains
    >>> near_mains(np.array([25.1, 40.0, 50.2]))
    array([ True, False,  True])
    """
    lines = np.outer(MAINS, multiples).ravel()
    near: NDArray[np.bool_] = np.any(np.abs(frequency[:, None] / lines - 1.0) < NEAR, axis=1)
    return near


def without_hum(
    response: Real, clock: Real, imposed: Real, unit: str
) -> tuple[Real, dict[str, str]]:
    """What a specimen answered (n,) without the hum of the mains, and what is told of that."""
    hums = hum_in(response, clock, imposed)
    if not hums:
        return response, {}
    lines = " and ".join(f"{hum.hertz:.3g} Hz ({hum.size:.2g} {unit})" for hum in hums)
    says = f"holds the hum of the mains, {lines} in amplitude: taken off"
    return response - sum(hum.course for hum in hums), {"hum": says}


def hum_in(response: Real, clock: Real, imposed: Real) -> list[Hum]:
    """The lines of the mains in what a specimen answered, where the motion has none of them.

    Parameters
    ----------
    response : ndarray, shape (n,)
        Sample after sample.
    clock, imposed : ndarray, shape (n,)
        Times of the samples in s, and what was imposed at them.

    Examples
    --------
    >>> t = np.arange(600) / 300.0
    >>> moved = np.sin(6.0 * t)
    >>> noise = 0.01 * np.random.default_rng(1).normal(size=600)
    >>> hum_in(np.sin(6.0 * t + 0.2) + noise, t, moved)
    []
    >>> (hum,) = hum_in(np.sin(6.0 * t + 0.2) + 0.1 * np.cos(314.0 * t) + noise, t, moved)
    >>> round(hum.hertz, 1), round(hum.size, 2)
    (50.0, 0.1)
    """
    found: list[Hum] = []
    if len(response) < LINE.fewest or not (np.isfinite(response).all() and is_even(clock)):
        return found
    # Two samples of a period at least: what is quicker is seen as something else.
    step = float(np.mean(np.diff(clock)))
    if 2.0 * step * MAINS[0] > 1.0:
        return found
    own, apart = of_a_motion(imposed)
    for _ in range(len(MAINS) * len(HARMONICS)):
        rest = response - sum(hum.course for hum in found)
        sought = np.where(own, 0.0, _ratios(rest, step, apart))
        top = int(np.argmax(sought))
        if len(sought) * np.exp(-sought[top]) > LINE.rare:
            break
        found.append(_fitted(rest, step, top))
    return found


def of_a_motion(imposed: Real) -> tuple[NDArray[np.bool_], int]:
    """Ordinates (m,) at which a motion (n,) may have lines, or what is made of it; and its own one.

    What a specimen makes of a motion is at sums of its frequencies, and the harmonics of the
    strongest one: the first of them may well stand alone.
    """
    power = periodogram(imposed)[0]
    number = np.arange(1.0, len(power) + 1.0)
    own = len(power) * np.exp(-over_neighbours(power)) < 1.0
    own = np.convolve(own, np.ones(2 * LINE.wide + 1), "same") > 0.0
    own |= number <= max(HARMONICS) * np.max(number[power > EVEN * power.max()], initial=0.0)
    top = int(np.argmax(power))
    # Where it lies between two ordinates, by a parabola.
    apart = number[top] + vertex(*np.log(np.maximum(np.pad(power, 1)[top : top + 3], SMALLEST)))
    order = np.round(number / apart)
    own |= (np.abs(number - order * apart) <= LINE.wide) & (order <= LINE.around)
    return own, top + 1


def _ratios(channel: Real, step: float, apart: int) -> Real:
    """How far the mains stands out of a channel (n,) at each ordinate; zero elsewhere.

    Also out of the harmonics of a motion beside it, so many ordinates `apart`: what a specimen
    makes of a motion is at all of them.
    """
    power, omega = periodogram(channel)
    ratio = over_neighbours(power)
    # Of several lines side by side none is the mains, nor of the harmonics of a motion: of these
    # the two next ones that its own lobe does not reach, as some motions have every other one.
    first = -(-2 * LINE.wide // apart)
    for away in (*range(2 * LINE.wide, LINE.around), first * apart, (first + 1) * apart):
        ratio[power < 2 * LINE.wide * _largest_beside(power, away)] = 0.0
    return np.where(at_mains(omega / (2.0 * np.pi * step)), ratio, 0.0)


def _largest_beside(power: Real, away: int) -> Real:
    """The largest of the powers (m,) so many ordinates away from each, on either side.

    What is quicker than a record shows is folded back, and so are those beside it.
    """
    around = np.pad(power, away + 1, mode="reflect")
    near = np.lib.stride_tricks.sliding_window_view(around, 3).max(axis=1)
    beside: Real = np.maximum(np.maximum(near[2 * away :], near[: len(power)]), SMALLEST)
    return beside


def _fitted(channel: Real, step: float, top: int) -> Hum:
    """The line that follows a channel (n,) best near one of its ordinates."""
    count = len(channel)
    # Faded twice, lest what is slow be followed.
    weights = _faded(count) ** 2
    left = weights * (channel - channel.mean())
    near = 2.0 * np.pi / count * (top + 1 + np.linspace(-1.0, 1.0, 6 * LINE.around + 1))
    waves = np.exp(1j * np.multiply.outer(near, np.arange(count)))
    omega = near[int(np.argmax(np.abs(waves @ left)))]
    wave = np.exp(1j * omega * np.arange(count))
    columns = np.stack([wave.real, wave.imag], axis=1)
    amounts = np.linalg.lstsq(weights[:, None] * columns, left, rcond=None)[0]
    return Hum(float(omega / (2.0 * np.pi * step)), float(np.hypot(*amounts)), columns @ amounts)
