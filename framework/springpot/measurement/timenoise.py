"""The noise of a signal against time, from the signal itself, and single samples that stray.

Divided differences of the fourth order do not see what is smooth, at any sampling: what is left is
noise. It is told apart into a constant part (the resolution of a transducer) and one in proportion
to the signal. Gasser, Sroka & Jennen-Steinmetz 1986, doi:10.1093/biomet/73.3.625, with a higher
order. Where it plainly goes otherwise, as where late samples are means over longer times, it is
what it is found to be at each size of the signal.

A model is not asked: fourth differences see neither what is smooth nor what the specimen does
slowly, and a sample that is off by itself leaves its own pattern in the five that hold it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.numerics import (
    ALIKE,
    FOURTH_WORTH,
    MEDIAN_WORTH,
    NEGLIGIBLE,
    NORMAL,
    REWEIGHTINGS,
    ROUNDING,
    SMALLEST,
    TWO_DEVIATIONS,
    non_negative,
    rms,
)
from springpot.rheology.points import STEADY, Real
from springpot.writing import SHOWN

from ..thresholds import OUTLIERS, SEARCH, SIGNALS
from .course import FEWEST as FEWEST_OF_LEVEL
from .instrument import rounding_step
from .measurement import Measurement
from .timetest import TimeTest

ORDER = 4
"""Of the differences: a cubic leaves nothing, and noise in five neighbours makes one number."""
FEWEST = 12
"""Samples below which the scatter tells nothing: then `ASSUMED` stands."""
ASSUMED = 0.01
"""Relative noise where there are too few samples: rheometers state 1 to 2 %."""
WIDE = 3.0
"""Ratio of the largest to the smallest signal from which a constant part can be told from a
proportional one.
"""
BINS = 12
"""Levels of the signal at most, at each of which the scatter is told."""
DOUBTED = 0.05
"""Chance of noises as unlike as several tests', below which they are not held to be one."""


@dataclass(frozen=True, eq=False)
class SignalNoise:
    """Noise of a signal.

    Attributes
    ----------
    sd : ndarray, shape (n,)
        Standard deviation of each sample.
    absolute, relative : float
        Its constant part in the unit of the signal, and its share of the signal, as near as these
        come to it.
    estimated : bool
        Whether the signal told it; otherwise one per cent is assumed.
    worth : float
        Independent numbers that tell its size.
    """

    sd: Real
    absolute: float
    relative: float
    estimated: bool
    worth: float = 0.0

    @property
    def floor(self) -> float:
        """Root mean square of the noise."""
        return rms(self.sd)


def noise_of(test: TimeTest, misfit: Real | None = None, *, all_noise: bool = False) -> SignalNoise:
    """The noise of a test's response.

    Parameters
    ----------
    test : TimeTest
        The test.
    misfit : ndarray, shape (n,), optional
        What a good model leaves of the response, in which corners of the signal are no scatter any
        more.
    all_noise : bool
        Whether the misfit is noise and nothing else: then its size itself tells, and not what
        neighbours differ by, which takes three times the samples.

    Returns
    -------
    SignalNoise
        White noise only: what drifts slowly is no scatter, and stays in the residual.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import TimeTest, noise_of
    >>> t = np.geomspace(0.1, 100.0, 400)
    >>> scatter = np.random.default_rng(1).normal(size=400)
    >>> round(noise_of(TimeTest.of_relaxation(t, t**-0.3 * (1 + 0.02 * scatter))).relative, 3)
    0.02
    """
    size = _smooth(np.abs(test.response))
    if len(test) < FEWEST:
        # A tenth beside the share, or there would be no noise where the signal crosses zero.
        absolute = 0.1 * ASSUMED * float(np.abs(test.response).max())
        return SignalNoise(np.hypot(ASSUMED * size, absolute), absolute, ASSUMED, False)
    if misfit is not None and all_noise:
        return _noise(test, _two_parts(misfit, size, MEDIAN_WORTH))
    return _noise(test, _two_parts(*_told_by(test, misfit), MEDIAN_WORTH * FOURTH_WORTH))


@lru_cache(maxsize=16)
def without_scatter(test: TimeTest) -> Real:
    """The response of a test (n,) without most of its noise: where the specimen was.

    Each sample is where the parabola through its neighbours passes it, without the sample itself,
    so that its own error has no part in it. Windows of twice the width are taken as long as each
    allows for a value that all narrower ones do (Goldenshluger and Nemirovski 1997, Mathematical
    Methods of Statistics 6, 135). Corners stay.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import TimeTest
    >>> from springpot.measurement.timenoise import without_scatter
    >>> t = np.arange(1.0, 401.0)
    >>> noise = 0.01 * np.random.default_rng(1).normal(size=400)
    >>> test = TimeTest.of_relaxation(t, np.where(t < 200.0, 1.0, 2.0) + noise)
    >>> without_scatter(test)[[100, 300]].round(2)
    array([1., 2.])
    """
    value, n, noise = test.response, len(test), noise_of(test)
    if not noise.estimated:
        return value
    # As far as the largest of so many errors.
    largest = noise.sd * np.sqrt(2.0 * np.log(n))
    best, low, high = value, value - largest, value + largest
    allowed, half = np.ones(n, dtype=bool), 2
    while 2 * half < n and allowed.any():
        past, spread = _past_each(value, half)
        low = np.maximum(low, past - spread * largest)
        high = np.minimum(high, past + spread * largest)
        allowed &= low <= high
        best = np.where(allowed, past, best)
        half *= 2
    return best


def _past_each(value: Real, half: int) -> tuple[Real, Real]:
    """Where parabolas through 2 `half` neighbours pass each of a value (n,).

    And the standard deviation of that over those of the values.
    """
    places = np.linspace(-1.0, 1.0, 2 * half + 1)
    basis = np.linalg.qr(np.stack([places**0, places, places**2], axis=1))[0]
    first = basis @ (basis.T @ value[: len(places)])
    last = basis @ (basis.T @ value[-len(places) :])
    inside = _convolved(value, basis @ basis[half])[len(places) - 1 : len(value)]
    curve = np.concatenate([first[:half], inside, last[half + 1 :]])
    # What the value itself has of the curve through it too (Cook and Weisberg 1982).
    share = np.sum(basis**2, axis=1)
    own = np.full(len(value), share[half])
    own[:half], own[-half:] = share[:half], share[half + 1 :]
    return (curve - own * value) / (1.0 - own), np.sqrt(own / (1.0 - own))


def _convolved(value: Real, kernel: Real) -> Real:
    size = len(value) + len(kernel) - 1
    return np.fft.irfft(np.fft.rfft(value, size) * np.fft.rfft(kernel, size), size)


def noise_of_alike(tests: Sequence[TimeTest]) -> list[SignalNoise]:
    """The noise of each of several tests of one kind, which they tell together.

    A dozen samples know their noise to a factor of two. One instrument that does one thing again
    has one noise, unless the scatters are plainly unlike one another (Bartlett 1937,
    doi:10.1098/rspa.1937.0109): the test that is the most so then stands by itself.

    Parameters
    ----------
    tests : sequence of TimeTest
        Of one kind, their responses in one unit.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import TimeTest
    >>> from springpot.measurement.timenoise import noise_of_alike
    >>> draw, t = np.random.default_rng(1), np.geomspace(0.1, 100.0, 16)
    >>> signals = t**-0.3 * (1.0 + 0.02 * draw.normal(size=(20, 16)))
    >>> tests = [TimeTest.of_relaxation(t, signal) for signal in signals]
    >>> round(noise_of_alike(tests)[0].relative, 3)
    0.018
    """
    noises = [noise_of(test) for test in tests]
    alike = [i for i, noise in enumerate(noises) if noise.estimated]
    told = {i: _told_by(tests[i], None) for i in alike}
    while len(alike) > 1:
        scatters, levels = zip(*(told[i] for i in alike), strict=True)
        together = _two_parts(
            np.concatenate(scatters), np.concatenate(levels), MEDIAN_WORTH * FOURTH_WORTH
        )
        sizes = [np.median(np.abs(told[i][0]) / together.at(told[i][1])) for i in alike]
        unlike = _unlike(NORMAL * np.array(sizes), np.array([noises[i].worth for i in alike]))
        if unlike is None:
            for i in alike:
                noises[i] = _noise(tests[i], together)
            break
        alike.pop(unlike)
    return noises


def _unlike(sizes: Real, worth: Real) -> int | None:
    """Which of several standard deviations (k,) is the least like the others, if any is."""
    from scipy.special import chdtrc

    power, count = sizes**2, float(worth.sum())
    if not np.all(power > 0.0):
        return int(np.argmin(power))
    ratio = power * count / float(worth @ power)
    apart = worth * (ratio - 1.0 - np.log(ratio))
    more = len(power) - 1
    correction = 1.0 + (float(np.sum(1.0 / worth)) - 1.0 / count) / (3.0 * more)
    if chdtrc(more, float(apart.sum()) / correction) > DOUBTED:
        return None
    return int(np.argmax(apart))


def _told_by(test: TimeTest, misfit: Real | None) -> tuple[Real, Real]:
    """Scatter of a test's signal, or of what a model leaves, and the size of the signal there."""
    level = _smooth(np.abs(test.response))
    signal = test.response
    if misfit is not None:
        signal = misfit
    scatter = fourth_differences(clock_of(test), signal)[0]
    level = level[ORDER // 2 : len(level) - ORDER // 2]
    telling = _moving(test)
    # A good model has followed the jumps already.
    if misfit is None:
        telling &= _without_jumps(test)
    if np.count_nonzero(telling) >= FEWEST:
        scatter, level = scatter[telling], level[telling]
    return scatter, level


def clock_of(test: TimeTest) -> Real:
    """Times (n,) by which a response is smooth: that to a step by the logarithm."""
    clock = test.time - test.start
    if test.after_step and clock[0] > 0.0:
        clock = np.log(clock)
    return clock


class _Levels(NamedTuple):
    """Variance of the noise (g,) at sizes (g,) of the signal, and the numbers it was told by."""

    size: Real
    power: Real
    worth: Real

    def cost(self, expected: Real) -> float:
        """Minus twice the logarithm of the likelihood of a variance, but for a constant."""
        return float(np.sum(self.worth * (np.log(expected) + self.power / expected)))

    def rule_out(self, cost: float) -> bool:
        """Whether parts of this cost are plainly not how the noise goes (likelihood ratio)."""
        from scipy.special import chdtri

        beyond = cost - self.cost(self.power)
        return len(self.size) > 2 and bool(beyond > chdtri(len(self.size) - 1, SIGNALS.ruled_out))

    def at(self, size: Real) -> Real:
        """Standard deviation at sizes (n,), by straight lines between the logarithms."""
        order = np.argsort(self.size)
        known, sd = self.size[order], 0.5 * np.log(self.power[order])
        with np.errstate(divide="ignore"):
            return np.asarray(np.exp(np.interp(np.log(size), np.log(known), sd)))


class _Parts(NamedTuple):
    """A constant and a proportional part of noise, the levels that rule both out, and its worth.

    Below the `lowest` level, `WIDE` below the last that tells of it, none is known to be smaller.
    It is `uneven` where it grows with the signal beyond doubt.
    """

    absolute: float
    relative: float
    levels: _Levels | None
    worth: float
    lowest: float = 0.0
    uneven: bool = False

    def at(self, size: Real) -> Real:
        """Standard deviation of signals of these sizes (n,)."""
        if self.levels is not None:
            return self.levels.at(size)
        told = self.relative * np.maximum(size, self.lowest)
        return np.maximum(np.hypot(told, self.absolute), SMALLEST)


def _noise(test: TimeTest, parts: _Parts) -> SignalNoise:
    """Noise of these parts for a test's signal."""
    size, least = _smooth(np.abs(test.response)), ALIKE * float(np.abs(test.response).max())
    absolute = max(parts.absolute, least)
    sd = np.hypot(parts.relative * np.maximum(size, parts.lowest), absolute)
    if test.kind == "history" and test.response.min() < 0.0 < test.response.max():
        # Where a loop crosses zero the rig is hardly quieter than elsewhere, and these few samples
        # must not outvote it; but noise that does grow is no misfit where it is largest.
        usual = rms(sd)
        sd = np.maximum(sd, 0.5 * usual) if parts.uneven else np.full(len(test), usual)
    elif parts.levels is not None:
        sd = np.maximum(parts.levels.at(size), least)
    # Digits that repeat show no scatter, and are off all the same (Widrow 1956,
    # doi:10.1109/TCT.1956.1086334). One value throughout tells of no digit.
    if np.ptp(test.response) > 0.0:
        sd = np.maximum(sd, rounding_step(test.response) / np.sqrt(12.0))
    return SignalNoise(sd, absolute, parts.relative, True, parts.worth)


def _without_jumps(test: TimeTest) -> NDArray[np.bool_]:
    """Which windows of five samples (n - 4,) see no jump of what was imposed."""
    first, last = test.time[: len(test) - ORDER, None], test.time[ORDER:, None]
    when = test.loading.jumps[0]
    smooth: NDArray[np.bool_] = ~np.any((when > first) & (when <= last), axis=1)
    return smooth


def _moving(test: TimeTest) -> NDArray[np.bool_]:
    """Which windows of five samples (n - 4,) hold more than one value.

    A channel at its limit, or printed digits that repeat, show no scatter, whatever the noise is:
    were such windows counted, a record that is clipped for half of its time would seem to be exact.
    """
    changes = np.diff(test.response) != 0.0
    windows = np.lib.stride_tricks.sliding_window_view(changes, ORDER)
    return np.asarray(windows.any(axis=1), dtype=bool)


def _smooth(size: Real) -> Real:
    """Running mean over five samples: the signal's size without most of its noise."""
    if len(size) < 5:
        return size
    padded = np.concatenate([size[:1], size[:1], size, size[-1:], size[-1:]])
    return np.convolve(padded, np.full(5, 0.2), mode="valid")


def fourth_differences(clock: Real, signal: Real) -> tuple[Real, Real]:
    """Divided differences (n - 4,) over five neighbours, white noise keeping its size.

    And the factors (n - 4, 5) of the neighbours.
    """
    u = np.lib.stride_tricks.sliding_window_view(clock, ORDER + 1)
    y = np.lib.stride_tricks.sliding_window_view(signal, ORDER + 1)
    u = (u - u[:, :1]) / (u[:, -1:] - u[:, :1])
    apart = u[:, :, None] - u[:, None, :] + np.eye(ORDER + 1)
    factors = 1.0 / apart.prod(axis=2)
    factors = factors / np.sqrt((factors**2).sum(axis=1, keepdims=True))
    return (factors * y).sum(axis=1), factors


def _two_parts(scatter: Real, level: Real, efficiency: float) -> _Parts:
    """Constant and proportional part of the noise; its levels, where these rule both out.

    From its robust size at each level of the signal, a sample of the scatter worth `efficiency`.

    Both are fitted only where one alone explains the levels plainly worse: a small part that is not
    there would otherwise be found by chance, and make the noise too large where the signal is
    small.
    """
    whole = efficiency * len(scatter)
    least = max(float(level.min()), ROUNDING * float(level.max()))
    if level.max() < WIDE * least:
        return _Parts(NORMAL * float(np.median(np.abs(scatter))), 0.0, None, whole)
    order = np.argsort(level)
    groups = np.array_split(order, min(BINS, max(2, len(order) // FEWEST_OF_LEVEL)))
    size = np.array([np.median(level[group]) for group in groups])
    spread = np.array([NORMAL * np.median(np.abs(scatter[group])) for group in groups])
    worth = efficiency * np.array([len(group) for group in groups])
    # Of groups without any scatter (printed digits that repeat) nothing is known.
    known = spread > 0.0
    if not known.any():
        return _Parts(0.0, 0.0, None, whole)
    columns = np.column_stack([np.ones_like(size), size**2])[known]
    # The square of an uncertain number is too large by its variance, 1/(2 n) of n independent ones.
    power = spread[known] ** 2 / (1.0 + 0.5 / worth[known])
    told = _Levels(size[known], power, worth[known])
    tried = [_fitted(columns * which, told) for which in ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0))]
    levels = None
    if told.rule_out(min(each[1] for each in tried)):
        levels = told
    alone, both = tried[:2], tried[2]
    parts, cost = map(np.array, zip(*alone, strict=True))
    # Both kinds at once only where the data plainly ask for it.
    if both[1] < cost.min() - TWO_DEVIATIONS:
        amounts = both[0]
    else:
        # Where they do not tell one from the other, the mean of what these say: else a few small
        # samples would count for all others.
        chance = np.exp(-0.5 * (cost - cost.min()))
        amounts = chance @ parts / chance.sum()
    absolute, relative = np.sqrt(amounts).tolist()
    uneven = bool(cost[0] - min(cost[1], both[1]) > SEARCH.decisive)
    return _Parts(absolute, relative, levels, whole, float(told.size[0]) / WIDE, uneven)


def _fitted(columns: Real, levels: _Levels) -> tuple[Real, float]:
    """Non-negative amounts of the columns, and minus twice the logarithm of their likelihood."""
    power, worth = levels.power, levels.worth
    expected, parts = power, np.zeros(columns.shape[1])
    for _ in range(REWEIGHTINGS):
        # Weighed by what is expected: by what was found, groups that are small by chance would
        # count for more.
        share = np.sqrt(worth) / expected
        parts, _ = non_negative(columns * share[:, None], power * share)
        expected = np.maximum(columns @ parts, NEGLIGIBLE * power)
    return parts, levels.cost(expected)


def relative_scatter(sweep: Measurement) -> float:
    """Relative noise of a sweep without standard deviations, from the scatter of neighbours.

    Sparse sweeps bend between their points, so that this is at most how large the noise is.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> from springpot.measurement.timenoise import relative_scatter
    >>> omega = np.geomspace(0.1, 10.0, 200)
    >>> scatter = np.random.default_rng(1).normal(size=(2, 200))
    >>> noise = np.exp(0.01 * (scatter[0] + 1j * scatter[1]))
    >>> sweep = Measurement(omega, (1j * omega) ** 0.5 * noise)
    >>> round(relative_scatter(sweep), 3)
    0.01
    """
    scatters = []
    for _, rows in sweep.sweeps():
        ordered = rows[np.argsort(sweep.omega[rows])]
        clock = np.log(sweep.omega[ordered])
        if len(ordered) <= ORDER or np.any(np.diff(clock) <= 0.0):
            continue
        turned = np.log(sweep.stiffness[ordered])
        scatters += [
            fourth_differences(clock, part)[0] for part in (turned.real, np.unwrap(turned.imag))
        ]
    if not scatters or sum(map(len, scatters)) < FEWEST - ORDER:
        return ASSUMED
    return max(NORMAL * float(np.median(np.abs(np.concatenate(scatters)))), ALIKE)


AROUND = 15
"""Samples on either side whose median tells how large the noise is there."""


@lru_cache(maxsize=256)
def strays(test: TimeTest) -> NDArray[np.int64]:
    """Indices of the samples of a response that stray from their neighbours, each by itself.

    Beyond what noise does once in `OUTLIERS.rare`; none where more than `OUTLIERS.most` do, as that
    is how the signal is. What was imposed at the same instant must not bend there: a mass at a
    corner of the motion feels a real blow.

    Parameters
    ----------
    test : TimeTest
        The test.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import TimeTest
    >>> from springpot.measurement.timenoise import strays
    >>> t = np.geomspace(0.1, 100.0, 60)
    >>> signal = t**-0.3 * (1.0 + 0.01 * np.random.default_rng(1).normal(size=60))
    >>> strays(TimeTest.of_relaxation(t, signal + 0.2 * (np.arange(60) == 30)))
    array([30])
    """
    from scipy.ndimage import maximum_filter

    none = np.union1d(np.array(sorted(test.aside), dtype=np.int64), stood_still(test))
    if not test.measured or len(test) < FEWEST + ORDER:
        return none
    clock = clock_of(test)
    imposed = np.interp(test.time, test.loading.time, test.loading.value)
    bends = _beyond(*_off(*fourth_differences(clock, imposed)))
    for at in np.searchsorted(test.time, test.loading.jumps[0]):
        bends[max(at - ORDER, 0) : at + ORDER] = True
    # What is found is taken off, as near a large stray a smaller one does not show; what is off
    # near that which is further off, and stays, is part of it.
    left, alone, more = test.response / noise_of(test).sd, bends & False, True
    while more:
        differences, factors = fourth_differences(clock, left)
        off, echo = _off(differences, factors)
        largest = maximum_filter(np.abs(off), 2 * ORDER + 1) == np.abs(off)
        found = np.flatnonzero(_beyond(off, echo) & largest & ~bends & ~alone)
        new = [i for i in found.tolist() if _by_itself(i, clock, differences, factors)]
        left[new] -= off[new]
        alone[new] = True
        if np.sum(alone) > OUTLIERS.most * len(test):
            return none
        more = len(new) > 0
    return np.union1d(none, np.flatnonzero(alone))


def stood_still(test: TimeTest) -> NDArray[np.int64]:
    """Indices of the samples that repeat the one before while the motion goes on, a single time.

    To the last digit, oftener than values of such digits do once in `OUTLIERS.rare`: the recorder
    kept a value. Not at nothing, where a specimen may be loose, nor at the ends of its range, where
    a channel has a limit.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import TimeTest
    >>> from springpot.measurement.timenoise import stood_still
    >>> t = np.arange(60) / 10.0
    >>> force = np.sin(t) + 0.01 * np.random.default_rng(1).normal(size=60)
    >>> force[31:35] = force[30]
    >>> stood_still(TimeTest.of_history(t, np.sin(t), force, "mm", "N"))
    array([31, 32, 33, 34])
    """
    none = np.zeros(0, dtype=np.int64)
    if not test.measured:
        return none
    same = np.diff(test.response, prepend=np.nan) == 0.0
    edges = np.flatnonzero(np.diff(same, prepend=False, append=False)).reshape(-1, 2)
    if len(edges) == 0:
        return none
    long = np.diff(edges)[:, 0]
    first, last = edges[int(np.argmax(long))].tolist()
    others = np.delete(long, int(np.argmax(long)))
    share = (1.0 + float(others.sum())) / len(test)
    kept = float(test.response[first])
    free = kept != 0.0 and test.response.min() < kept < test.response.max()
    moved = np.interp(test.time[[first - 1, last - 1]], test.loading.time, test.loading.value)
    moves = abs(float(moved[1] - moved[0])) > STEADY * float(np.abs(test.loading.value).max())
    alone = bool(np.all(2 * others < last - first))
    if not (free and moves and alone and len(test) * share ** (last - first) < OUTLIERS.rare):
        return none
    return np.arange(first, last)


def said_of_strays(test: TimeTest) -> str:
    """What is no part of the specimen's answer, in words; nothing of most tests.

    The hum of the mains, which samples stray and by how much, and when the recorder stood still.
    """
    still = stood_still(test)
    said = [_said_of_alone(test, np.setdiff1d(strays(test), still))]
    if "hum" in test.provenance:
        said.append(f"{test.name}: the {test.answered} {test.provenance['hum']}")
    if "motion" in test.provenance:
        said.append(f"{test.name}: the {test.control} is {test.provenance['motion']}")
    if len(still) == 0:
        return "; ".join(filter(None, said))
    span = f"{test.time[still[0] - 1]:.4g} to {test.time[still[-1]]:.4g} s"
    halt = (
        f"{test.name}: the {test.answered} stood still from {span} while the {test.control} moved:"
        f" {len(still)} samples left out"
    )
    return "; ".join(filter(None, [halt, *said]))


def _said_of_alone(test: TimeTest, rows: NDArray[np.int64]) -> str:
    """Which samples are off by themselves, and by how much."""
    if len(rows) == 0:
        return ""
    off = [test.aside.get(row, 0.0) for row in rows.tolist()]
    if len(test) >= FEWEST + ORDER:
        off += _off(*_over_noise(test))[0][rows].tolist()
    most = float(np.abs(off).max())
    named = ", ".join(f"{t:.4g}" for t in test.time[rows[:SHOWN]]) + (
        ", ..." if len(rows) > SHOWN else ""
    )
    if len(rows) == 1:
        return f"{test.name}: the sample at {named} s is off by {most:.2g} x the noise: left out"
    return (
        f"{test.name}: {len(rows)} samples are each off by up to {most:.2g} x the noise: left out"
        f" at {named} s"
    )


def _over_noise(test: TimeTest) -> tuple[Real, Real]:
    """Fourth differences of a response over its noise, with their factors."""
    return fourth_differences(clock_of(test), test.response / noise_of(test).sd)


def _around(rows: NDArray[np.int64], factors: Real) -> tuple[NDArray[np.int64], Real, Real]:
    """The five differences that hold each of some samples (m,), as (m, 5) indices.

    With their factors (m, 5, 9) of the samples around, and the covariance (m, 5, 5) that white
    noise gives them.
    """
    first = rows[:, None] + np.arange(-ORDER, 1)
    whole = np.zeros((len(rows), ORDER + 1, 2 * ORDER + 1))
    for k in range(ORDER + 1):
        whole[:, k, k : k + ORDER + 1] = factors[first[:, k]]
    covariance = whole @ whole.transpose(0, 2, 1)
    # Where samples lie unevenly one difference may say nearly the same as another.
    return first, whole, covariance + np.finfo(float).eps * np.eye(ORDER + 1)


def _off(differences: Real, factors: Real) -> tuple[Real, Real]:
    """By how much each sample (n,) is off, by the five differences that hold it.

    And how much of that (n, 9) one would be seen to be by which the others around it are off, and
    itself. By generalised least squares (Aitken 1935), as differences share samples: of white noise
    of size one it has a standard deviation of 1.16 then. At the ends, which fewer of them hold,
    nothing is said.
    """
    count = len(differences) + ORDER
    inside = np.arange(ORDER, count - ORDER)
    off, echo = np.zeros(count), np.zeros((count, 2 * ORDER + 1))
    first, whole, covariance = _around(inside, factors)
    pattern = whole[:, :, ORDER]
    weights = np.linalg.solve(covariance, pattern[..., None])[..., 0]
    weights /= np.sum(weights * pattern, axis=1)[:, None]
    off[inside] = np.sum(weights * differences[first], axis=1)
    echo[inside] = np.einsum("ij,ijk->ik", weights, whole)
    return off, echo


def _beyond(off: Real, echo: Real) -> NDArray[np.bool_]:
    """Which of these numbers (n,) are larger than the largest of so many of noise.

    Of the noise around them, where that is larger than elsewhere.
    """
    from scipy.special import ndtri

    most = -float(ndtri(0.5 * OUTLIERS.rare / len(off)))
    off, echo = off[ORDER : len(off) - ORDER], echo[ORDER : len(echo) - ORDER]
    number, sizes = np.arange(len(off))[:, None], np.abs(off)
    around = np.full(len(off), np.median(sizes))
    # Of the side that is noisier: where the noise grows at once there are no strays beyond.
    for first in (number - AROUND, number + 1):
        beside = np.clip(first, 0, max(len(off) - AROUND, 0)) + np.arange(min(AROUND, len(off)))
        # What a sample leaves in the differences of its neighbours is no noise.
        apart = number - beside
        shared = (np.abs(apart) <= ORDER) & (apart != 0)
        own = np.where(shared, echo[beside, np.clip(apart + ORDER, 0, 2 * ORDER)], 0.0)
        missed = np.abs(off[beside] - own * off[:, None])
        around = np.maximum(around, np.median(missed, axis=1))
    return np.pad(sizes > most * np.maximum(NORMAL * around, SMALLEST), ORDER)


def _by_itself(i: int, clock: Real, differences: Real, factors: Real) -> bool:
    """Whether a sample is off, and not the signal broken beside it: a corner, or a jump.

    Two corners at neighbouring samples are a corner between them, or a jump. What is off by itself
    leaves less than they do, though it has one number and they have two.
    """
    (first,), (whole,), (covariance,) = _around(np.array([i]), factors)
    white = np.linalg.inv(np.linalg.cholesky(covariance))
    told = white @ differences[first]

    def left(signals: Real) -> float:
        patterns = white @ whole @ signals[:, i - ORDER : i + ORDER + 1].T
        size = np.linalg.lstsq(patterns, told, rcond=None)[0]
        return float(np.sum((told - patterns @ size) ** 2))

    corners = np.maximum(clock - clock[i - 1 : i + 2, None], 0.0)
    one = (np.arange(len(clock)) == i).astype(float)
    return left(one[None]) < min(left(corners[:2]), left(corners[1:]))
