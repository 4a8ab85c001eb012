"""Spectra of noise that remembers more than the sample before, and tests of a motion.

A channel that swings, a filter, a mean over a few samples and 1/f noise beside white leave such.
They are read from the continuum of a residual's spectrum: from medians over neighbouring
frequencies and over stretches of the record, which neither lines nor single events move, and
without the slowest half waves, in which the misfit of a model lies. What these hold beyond the
continuation is no noise. A drift as steep as a random walk is none either: nothing smooth would be
missed beside it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import f_sf, gamma_sf, normal_sf
from springpot.measurement.course import answer_to_unfelt
from springpot.measurement.imposed import imposed_noise
from springpot.measurement.instrument import digit_of, is_even
from springpot.measurement.steady_start import cycles_of
from springpot.measurement.timenoise import FEWEST as FEWEST_OF_SCATTER, ORDER
from springpot.measurement.timetest import TimeTest
from springpot.rheology.points import Real

from ..numerics import DEVIATIONS, MEDIAN_WORTH, NORMAL, SMALLEST, non_negative, projected_out

SLOWEST = 16
"""Half waves along a record in which there may be a misfit, and nothing is read of the noise."""
FEWEST = 8 * SLOWEST
"""Samples below which what is left of the spectrum tells no more than a first-order memory."""
STRETCHES = 4
"""Parts of a record, in more than half of which noise is as it is in all."""
AROUND = 5
"""Neighbouring frequencies of whose powers in all stretches the median is taken."""
ORDERS = 8
"""Cosines of a spectrum's logarithm at most: a mean over five samples is followed by as many."""
LEVEL = 4
"""Samples on either side of a jump at least: two that are off by chance are none yet."""
UPPER = 0.25
"""Share of the highest frequency above which there is noise alone.

A misfit spans eight samples or more.
"""
WORTH = 0.15
"""Share of the samples that the median of their differences is worth: by 600 simulated channels of
100 to 3,000."""
FEWEST_OF_NOISE = 100
"""Samples below which the noise of a channel is not told."""
HEARD = 0.05
"""Share of the response's own noise below which nobody hears it."""


@dataclass(frozen=True)
class Colour:
    """A spectrum whose logarithm is a sum of cosines, which may rise to slow ones as one over f.

    A few cosines follow a channel that rings, a filter and a mean over a few samples alike, and
    none of them changes within the few half waves of a misfit (Bloomfield 1973,
    doi:10.1093/biomet/60.2.217).

    Attributes
    ----------
    variance : float
        Of what is new with each sample.
    cosines : tuple of float
        Of the logarithm, that of one radian a sample first.
    corner : float
        Frequency, in radians a sample, below which there is more 1/f noise than other; endless
        where there is no other, zero without any.
    beside : ndarray, shape (n,), optional
        What else there is, over what is new with each sample: of a record's cosine transform.
    """

    variance: float
    cosines: tuple[float, ...]
    corner: float
    beside: Real | None = field(default=None, compare=False)

    @classmethod
    def of_memory(cls, size: float, memory: float, beside: Real) -> Colour:
        """Noise of a size that remembers the sample before, and something else of a variance (n,).

        The logarithm of such a spectrum is a sum of cosines that die away as its memory does.
        """
        order = np.arange(1, ORDERS + 1)
        new = size**2 * (1.0 - memory**2)
        cosines = tuple((2.0 * memory**order / order).tolist())
        return cls(new, cosines, 0.0, beside / new)

    @property
    def count(self) -> int:
        """Numbers beside its size."""
        # What is beside it is known, and all of its cosines follow from one memory.
        if self.beside is not None:
            return 1
        return len(self.cosines) + (self.corner > 0.0)

    def spectrum(self, omega: Real) -> Real:
        """Variance at frequencies (n,) of the cosine transform of a record."""
        power = self.shape(_cosines(omega), _rise(omega, self.corner))
        if self.beside is None:
            return power
        known = frequencies(len(self.beside))
        return power + self.variance * np.interp(omega, known, self.beside)

    def shape(self, cosines: Real, rise: Real) -> Real:
        """The same by the cosines (n, c) of these frequencies, and what 1/f noise adds there."""
        shape = np.exp(cosines[:, 1 : len(self.cosines) + 1] @ np.array(self.cosines))
        return np.asarray(self.variance * shape * rise, dtype=np.float64)


def colour_of(residual: Real, memories: Real) -> Colour | None:
    """The colour of the noise in a residual (n,); None where a first-order memory is as likely.

    Parameters
    ----------
    residual : ndarray, shape (n,)
        Sample after sample.
    memories : ndarray
        Those of first order that it is compared with.
    """
    if len(residual) < FEWEST:
        return None
    omega, level = _continuum(residual)
    if not level.min() > 0.0:
        return None
    first = SLOWEST // STRETCHES + 1
    beyond, level = omega[first:], level[first:]
    worth = MEDIAN_WORTH * STRETCHES * len(level)
    price = float(np.log(worth))
    shapes = 1.0 / np.abs(1.0 - memories[:, None] * np.exp(-1j * beyond)) ** 2
    plain = min(_cost(level, shape, worth) for shape in shapes) + price
    best, found = min(_cost(level, np.ones(len(level)), worth), plain), None
    cosines = _cosines(beyond)
    basis, triangle = np.linalg.qr(cosines)
    for corner in _corners(len(residual)):
        rise = _rise(beyond, corner)
        for colour in _exponentials(basis.T @ np.log(level / rise), triangle, corner):
            shape = colour.shape(cosines, rise)
            cost = _cost(level, shape, worth) + colour.count * price
            if colour.count and cost < best:
                best, scale = cost, float(np.mean(level / shape))
                found = replace(colour, variance=scale * colour.variance)
    return found


def _continuum(residual: Real) -> tuple[Real, Real]:
    """Frequencies (m,), in radians a sample, and the variance of what is no line at each of them.

    The smaller of two medians over neighbouring frequencies: that of the stretches of a record, as
    what happens once is in one of them alone, and that of the whole, in which a loop that comes by
    again is lines.
    """
    count = len(residual) // STRETCHES
    kept = residual[: STRETCHES * count]
    stretches = transformed(kept.reshape(STRETCHES, count)) ** 2
    whole = (transformed(kept) ** 2).reshape(count, STRETCHES).T
    levels = []
    for power in (stretches, whole):
        padded = np.pad(power, ((0, 0), (AROUND // 2, AROUND // 2)), mode="reflect")
        near = np.lib.stride_tricks.sliding_window_view(padded, AROUND, axis=1)
        # Over the median of the square of a normal number of variance one.
        levels.append(NORMAL**2 * np.median(near, axis=(0, 2)))
    return frequencies(count), np.minimum(*levels)


def transformed(values: Real, back: bool = False) -> Real:
    """The cosine transform of values (..., n), or the values of a transform."""
    from scipy.fft import dct, idct

    if back:
        return np.asarray(idct(values, norm="ortho"), dtype=np.float64)
    return np.asarray(dct(values, norm="ortho"), dtype=np.float64)


def frequencies(count: int) -> Real:
    """Those of a cosine transform of so many samples, in radians a sample."""
    return np.asarray(np.pi * np.arange(count) / count, dtype=np.float64)


def _rise(omega: Real, corner: float) -> Real:
    """Factor (n,) by which 1/f noise beside other makes it larger."""
    # Of the mean nothing is known but that it is slower than all else.
    slow = np.maximum(omega, 0.25 * omega[-1] / max(len(omega) - 1, 1))
    if np.isinf(corner):
        return np.asarray(np.pi / slow, dtype=np.float64)
    return np.asarray(1.0 + corner / slow, dtype=np.float64)


def _corners(count: int) -> Iterator[float]:
    """None, 1/f alone, and corners at which the rise is seen where a misfit does not reach."""
    yield 0.0
    yield np.inf
    corner = 0.5 * np.pi
    while corner >= 4.0 * SLOWEST * np.pi / count:
        yield corner
        corner *= 0.5


def _cost(level: Real, shape: Real, worth: float) -> float:
    """Minus twice the log-likelihood of powers (m,) by a shape (m,) of the best size."""
    return worth * float(np.mean(np.log(shape)) + np.log(np.mean(level / shape)))


def _exponentials(along: Real, triangle: Real, corner: float) -> Iterator[Colour]:
    """Those of each order that come nearest to a logarithm, by what its basis (c, c) has of it."""
    for count in range(1, ORDERS + 2):
        mean, *cosines = np.linalg.solve(triangle[:count, :count], along[:count]).tolist()
        yield Colour(float(np.exp(mean)), tuple(cosines), corner)


def _cosines(omega: Real) -> Real:
    """Of 0 to `ORDERS` times frequencies (n,)."""
    return np.cos(np.multiply.outer(omega, np.arange(ORDERS + 1)))


def fisher_test(
    rows: Real, sought: NDArray[np.bool_] | None = None, followed: float = 0.0
) -> tuple[float, float]:
    """Chance that of white noise (r, n) one period holds so large a share, and its frequency.

    In radians a sample. Of the largest of m ordinates, each a sum over the rows (Fisher 1929,
    doi:10.1098/rspa.1929.0151, by Bonferroni's inequality); between two whole periods a ripple
    falls into both. Where not all (n - 1,) are sought, the others count as noise. What a model has
    `followed` of the r n numbers is no longer there.
    """
    from scipy.special import betainc

    count, n = rows.shape
    whole = n * float(np.sum(rows**2))
    if n < FEWEST_OF_SCATTER or whole == 0.0:
        return 1.0, 0.0
    power = np.sum(np.abs(np.fft.rfft(rows, 2 * n, axis=1)[:, 1:-1]) ** 2, axis=0)
    sought = np.ones(n - 1, dtype=bool) if sought is None else sought
    top = int(np.argmax(np.where(sought, power, -1.0)))
    share = min(2.0 * float(power[top]) / whole, 1.0)
    # Each ordinate has 2 r of the r n degrees of freedom: a beta variable of r and r (n/2 - 1).
    others = max(0.5 * (count * n - followed) - count, 0.5)
    chance = np.count_nonzero(sought) * betainc(others, float(count), 1.0 - share)
    return float(min(1.0, chance)), np.pi * (top + 1) / n


def period_test(residual: Real, period: tuple[int, int]) -> tuple[float, Real]:
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
    >>> from springpot.misfit.coloured_noise import period_test
    >>> noise, t = np.random.default_rng(1).normal(size=200), np.arange(200)
    >>> wave = np.cos(0.1 * np.pi * t)
    >>> [round(period_test(each, (1, 20))[0], 3) for each in (noise, noise + wave)]
    [1.0, 0.0]
    """
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
    chances = count * np.exp(logs.min()), gamma_sf(-np.sum(logs), count)
    return float(min(2.0 * min(chances), 1.0)), rest


def step_test(residual: Real, steps: Sequence[int]) -> tuple[float, Real]:
    """Chance that noise bends as much behind each step of a load, and what does not (n,).

    Noise does not know when the load stepped. What a model misses of the answers to it, which begin
    at another height and die away, has the spectrum of noise with a memory. Told by ranks (Mann &
    Whitney 1947, doi:10.1214/aoms/1177730491), whatever the tails of the noise.

    Parameters
    ----------
    residual : ndarray, shape (n,)
        Of a record.
    steps : sequence of int
        As of `Imposed`.

    Examples
    --------
    >>> noise = np.random.default_rng(1).normal(size=60)
    >>> died_away = np.tile(900.0 / np.arange(1.0, 16.0), 4)
    >>> [round(step_test(each, (0, 15, 30, 45))[0], 4) for each in (noise, noise + died_away)]
    [0.8791, 0.0]
    """
    n, calm = len(residual), residual.copy()
    behind, others = np.zeros(n, dtype=bool), np.ones(n, dtype=bool)
    for row in steps:
        # The first sample behind a step tells of its instant alone, as all on the way of one that
        # takes several do.
        others[max(row - 1, 0) : row + 2 + LEVEL] = False
        behind[max(row - 1, 0) : row + 2] = False
        behind[row + 2 : row + 2 + LEVEL] = True
    behind[[0, -1]] = others[[0, -1]] = False
    bends = np.abs(np.diff(residual, 2, prepend=0.0, append=0.0))
    k, m = np.count_nonzero(behind), np.count_nonzero(others)
    if not min(k, m):
        return 1.0, residual
    above = np.searchsorted(np.sort(bends[others]), bends[behind])
    # Bends of neighbours share two samples: of white noise their sizes are correlated by 0.41.
    alike = 1.0 + 2.0 * 0.41 * (1.0 - 1.0 / LEVEL)
    score = (float(above.sum()) - 0.5 * k * m) / np.sqrt(alike * k * m * (k + m + 1.0) / 12.0)
    for row, last in pairwise([*steps, n]):
        first = min(row + 1, last) if row else row
        calm[row:first] = 0.0
        if last - first >= LEVEL:
            since = np.arange(first, last) - row + 1.0
            dying = np.linalg.qr(np.column_stack([np.ones_like(since), since, 1.0 / since]))[0]
            calm[first:last] = projected_out(residual[first:last], dying)
    return float(normal_sf(score)), calm


def motion_test(residual: Real, spectrum: Real, of_motion: tuple[Real, Real]) -> tuple[float, Real]:
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
        What a linear model may miss of the motion (n, p), and what else goes with it (n, q).
    """
    linear, powers = of_motion[0].shape[1], np.hstack(of_motion)
    every = np.column_stack([residual, powers])
    white = transformed(transformed(every.T) / np.sqrt(spectrum), back=True)
    basis = np.linalg.qr(white[1:].T)[0]
    left = projected_out(white[0], basis)
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
    return float(f_sf(explained / left, count - linear, n - count)), rest


class Imposed(NamedTuple):
    """What a channel that was imposed may leave its traces by in the noise of the other.

    Attributes
    ----------
    period : tuple of int
        Of the motion; see `period_test`. None of an uneven one.
    coarse : bool
        Whether it has few values: what a model makes of their rounding has lines.
    noise : float
        Of the channel, as large as it may well be; zero where the response's own drowns it.
    powers : tuple of ndarray
        As of `powers_of`, of an uneven one alone.
    steps : tuple of int
        The first sample behind each step of a load that was held before and after.
    unfelt : ndarray, shape (n,), optional
        Variance of what is answered to the error of a smooth motion, over that of the noise; see
        `answer_to_unfelt`.
    """

    period: tuple[int, int]
    coarse: bool
    noise: float
    powers: tuple[Real, Real] | None
    steps: tuple[int, ...] = ()
    unfelt: Real | None = None

    @classmethod
    def of(cls, test: TimeTest, stiffness: float, sd: Real) -> Imposed:
        """What was imposed in a test, whose response has noise (n,) of its own."""
        value, count, even = test.loading.recorded.value, len(test.time), is_even(test.time)
        noise, powers, unfelt = 0.0, None, None
        if test.loading.unfelt.noise > 0.0:
            unfelt = answer_to_unfelt(test.loading, test.time, test.response)
            unfelt = unfelt / float(np.mean(sd**2))
            if count == len(value) and float(np.mean(unfelt)) >= HEARD**2:
                noise = test.loading.unfelt.noise
        elif even and len(value) >= FEWEST_OF_NOISE:
            noise = _noise_above(test, stiffness, sd)
        if test.kind == "history" and even and FEWEST <= len(value) == count:
            powers = powers_of(value, noise > 0.0)
        after = np.unique([later for _, later, _ in test.loading.steps_between])
        steps = tuple(np.searchsorted(test.time, after).tolist())
        coarse = digit_of(value) > 0.0
        return cls(cycles_of(test.loading, count), coarse, noise, powers, steps, unfelt)


def _noise_above(test: TimeTest, stiffness: float, sd: Real) -> float:
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
