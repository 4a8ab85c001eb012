"""Traces that an imposed motion leaves in the noise of the response.

Noise neither repeats with the motion nor knows where the specimen is; but noise of the channel that
was imposed is answered by a model and was never felt by the specimen.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from springpot.measurement.imposed import imposed_noise
from springpot.measurement.rounding import digit_of, is_even
from springpot.measurement.steady_start import cycles_of
from springpot.measurement.timenoise import ORDER
from springpot.measurement.timetest import TimeTest
from springpot.rheology.points import Real

from ..numerics import DEVIATIONS, SMALLEST, non_negative
from .colour import FEWEST, transformed

WORTH = 0.15
"""Share of the samples that the median of their differences is worth: by 600 simulated channels of
100 to 3,000."""
FEWEST_OF_NOISE = 100
"""Samples below which the noise of a channel is not told."""
HEARD = 0.05
"""Share of the response's own noise below which nobody hears it."""


class Imposed(NamedTuple):
    """What a channel that was imposed may leave its traces by in the noise of the other.

    Attributes
    ----------
    period : tuple of int
        Of the motion; see `repeated`. None of an uneven one.
    coarse : bool
        Whether it has few values: what a model makes of their rounding has lines.
    noise : float
        Of the channel, as large as it may well be; zero where the response's own drowns it.
    powers : tuple of ndarray
        As of `powers_of`, of an uneven one alone.
    """

    period: tuple[int, int]
    coarse: bool
    noise: float
    powers: tuple[Real, Real] | None

    @classmethod
    def of(cls, test: TimeTest, stiffness: float, sd: Real) -> Imposed:
        """What was imposed in a test, whose response has noise (n,) of its own."""
        value, count, even = test.loading.recorded.value, len(test.time), is_even(test.time)
        noise, powers = 0.0, None
        if even and len(value) >= FEWEST_OF_NOISE:
            noise = _heard(test, stiffness, sd)
        if test.kind == "history" and even and FEWEST <= len(value) == count:
            powers = powers_of(value, noise > 0.0)
        return cls(cycles_of(test.loading, count), digit_of(value) > 0.0, noise, powers)


def _heard(test: TimeTest, stiffness: float, sd: Real) -> float:
    """The noise of the imposed channel, as large as it may well be.

    Zero where the response's own drowns it, or where they were not sampled together.
    """
    loading = test.loading.recorded
    if not np.array_equal(loading.time, test.time):
        return 0.0
    size, factor = imposed_noise(loading.value), stiffness
    if test.control == "force":
        factor = 1.0 / factor
    if size * factor < HEARD * float(np.median(sd)):
        return 0.0
    error = float(np.sqrt(2.0 / (WORTH * len(test.time))))
    return size * float(np.sqrt(1.0 + DEVIATIONS * error))


def powers_of(value: Real, noisy: bool) -> tuple[Real, Real]:
    """What a linear model may miss of a motion (n, p), and what else goes with it (n, q).

    Products of place and speed up to the third degree, by samples a little apart: of its noise a
    model has answered to the nearest ones, too. A linear model that answers to noise of the motion
    is fitted too soft, and misses as much of place, speed and acceleration (Fuller 1987,
    Measurement Error Models, chapter 1).

    Parameters
    ----------
    value : ndarray, shape (n,)
        The motion as it was read.
    noisy : bool
        Whether its noise is heard in the response; else a linear model has no excuse.
    """
    around = np.pad(value, ORDER, mode="edge")
    before, after = around[: -2 * ORDER], around[2 * ORDER :]
    place, speed, turning = (
        each / max(float(np.abs(each).max()), SMALLEST)
        for each in (value, after - before, after - 2.0 * value + before)
    )
    degrees = [(i, total - i) for total in (2, 3) for i in range(total + 1)]
    products = np.stack([place**i * speed**j for i, j in degrees], axis=1)
    if noisy:
        return np.stack([place, speed, turning], axis=1), products
    return np.zeros((len(value), 0)), np.column_stack([place, speed, products])


def with_the_motion(
    residual: Real, spectrum: Real, of_motion: tuple[Real, Real]
) -> tuple[float, Real]:
    """Chance that noise of some spectrum goes with a motion as a residual does, and the rest (n,).

    Noise does not know where the specimen is, whatever its spectrum: a force that goes by place and
    speed is known by them where it varies as quickly as noise.

    Parameters
    ----------
    residual : ndarray, shape (n,)
        Of a record.
    spectrum : ndarray, shape (n,)
        Variance of each number of the noise's cosine transform.
    of_motion : tuple of ndarray
        As of `powers_of`.
    """
    from scipy.special import fdtrc

    linear, powers = of_motion[0].shape[1], np.hstack(of_motion)
    every = np.column_stack([residual, powers])
    white = transformed(transformed(every.T) / np.sqrt(spectrum), back=True)
    basis = np.linalg.qr(white[1:].T)[0]
    left = white[0] - basis @ (basis.T @ white[0])
    # Noise may be larger where the specimen is far out or quick, and goes with nothing all the
    # same: its variance is a sum of squares of the powers (Breusch & Pagan 1979,
    # doi:10.2307/1911963). At least a quarter of the usual, so that no few samples tell all: of
    # simulated noise that grows with place or speed four records in a hundred at most are below
    # .01, and one below .001.
    squares = np.column_stack([np.ones(len(left)), powers**2])
    variance = squares @ non_negative(squares, left**2)[0]
    uneven = np.sqrt(np.maximum(variance / max(float(np.mean(variance)), SMALLEST), 0.25))
    basis, value = np.linalg.qr(white[1:].T / uneven[:, None])[0], white[0] / uneven
    followed = (basis.T @ value) ** 2
    n, count = basis.shape
    explained = float(np.sum(followed[linear:])) / (count - linear)
    left = max(float(value @ value - np.sum(followed)), SMALLEST) / (n - count)
    rest = residual - powers @ np.linalg.lstsq(powers, residual, rcond=None)[0]
    return float(fdtrc(count - linear, n - count, explained / left)), rest


def repeated(residual: Real, period: tuple[int, int]) -> tuple[float, Real]:
    """Chance that noise repeats with a motion as a residual does, and what does not repeat.

    Whatever its colour, noise has at the harmonics of a motion what it has between them, over
    which each of them is a variable of F; all of them together by Fisher (1925, Statistical
    Methods for Research Workers, section 21.1).

    Parameters
    ----------
    residual : ndarray, shape (n,)
        Of a record.
    period : tuple of int
        So many periods of what was imposed, and their samples.

    Returns
    -------
    tuple of float and ndarray, shape (m,)
        The chance, and the rest of as many whole periods.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.timetests.traces_of_motion import repeated
    >>> noise, t = np.random.default_rng(1).normal(size=200), np.arange(200)
    >>> wave = np.cos(0.1 * np.pi * t)
    >>> [round(repeated(each, (1, 20))[0], 3) for each in (noise, noise + wave)]
    [1.0, 0.0]
    """
    from scipy.special import gammaincc

    periods, lag = period
    n = len(residual) // lag * lag
    cycles = n // lag * periods
    transform = np.fft.rfft(residual[:n] - np.mean(residual[:n]))
    count = (n - 1) // 2 // cycles
    # Of two cycles the harmonics have nothing between them.
    beside = (cycles - 1) // 2
    if not count * beside:
        return 1.0, residual
    lines = cycles * np.arange(1, count + 1)
    away = np.concatenate([-np.arange(1, beside + 1), np.arange(1, beside + 1)])
    power = np.abs(transform) ** 2
    around = power[np.minimum(lines[:, None] + away, len(power) - 1)].mean(axis=1)
    worth = float(len(away))
    ratio = power[lines] / np.maximum(around, SMALLEST)
    # F of 2 and 2 m numbers has a closed form.
    logs = -worth * np.log1p(ratio / worth)
    transform[lines] = 0.0
    rest = np.fft.irfft(transform, n) * np.sqrt(n / (n - 2.0 * count))
    # One of them may stand out, or all may a little.
    chances = count * np.exp(logs.min()), gammaincc(count, -np.sum(logs))
    return float(min(2.0 * min(chances), 1.0)), rest
