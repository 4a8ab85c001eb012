"""A record of displacement and force as a test report takes it, and where its cycles begin and end.

A cycle begins where the displacement crosses its moving mean in the direction of the first motion.
A crossing counts once the displacement has gone on by half the amplitude: noise and drift that are
smaller than that make and lose none.

Values of a noisy channel at one moment (a turning point, a crossing, one side of a jump) are each a
least-squares fit to the samples around it. The window is as wide as the noise allows: it is halved
as long as what the fit leaves is more than noise.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import comb
from pathlib import Path, PurePath
from typing import NamedTuple

import numpy as np

from springpot.distributions import chi2_sf, normal_quantile
from springpot.errors import DataError
from springpot.measurement.from_signals import stiffness_unit
from springpot.measurement.reader import OpenQuestion, file_and_choice
from springpot.measurement.signals import harmonics_of
from springpot.measurement.steady import Signals, in_order
from springpot.measurement.timetest import TimeTest
from springpot.measurement.units import STRAIN_UNITS
from springpot.numerics import SMALLEST
from springpot.registry import open_in_time, open_signals
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL, SIGNALS


class CycleWindow(NamedTuple):
    """Of a cycle, in which a value and a slope are read."""

    share: float
    """Share of a cycle to either side: a sinusoid is a polynomial of degree four there to 2e-4."""
    smooth: int
    steep: int
    """Degrees of the polynomials for a value and for a slope."""
    moves: int
    """Times that a window is laid anew about what was found in it; the second moves it by
    rounding.
    """


WINDOW = CycleWindow(share=0.125, smooth=4, steep=5, moves=4)
EXPONENTS = (0.1, 1.0)
"""Powers of the speed by which a force can go; below the least it is friction."""


class Estimate(NamedTuple):
    """A number with its standard deviation."""

    value: float
    sd: float


class Turning(NamedTuple):
    """Where a displacement turns: when, how far, and how sure both are."""

    time: float
    time_sd: float
    way: Estimate


class Channel(NamedTuple):
    """Samples of one channel with the deviation of their noise."""

    time: Real
    value: Real
    noise: float

    def within(self, start: float, stop: float) -> tuple[Real, Real]:
        """Times and values of the samples in a part."""
        rows = slice(*np.searchsorted(self.time, [start, stop]).tolist())
        return self.time[rows], self.value[rows]


def noise_of(values: Real) -> float:
    """Standard deviation of the noise of a channel, from its fourth differences.

    These hold next to nothing of a motion that is sampled finely; the median passes over jumps.

    Examples
    --------
    >>> import numpy as np
    >>> phase = np.linspace(0.0, 60.0, 3000)
    >>> noise = 0.01 * np.random.default_rng(0).standard_normal(3000)
    >>> round(noise_of(np.sin(phase) + noise), 3)
    0.01
    """
    steps = np.abs(np.diff(values))
    gain = np.sqrt(comb(8, 4))
    spread = float(np.median(np.abs(np.diff(values, 4)))) / (normal_quantile(0.75) * gain)
    # The last digit of a channel is a noise too, and one that a median may not see.
    moved = steps[steps > 0.0]
    digit = float(moved.min()) / np.sqrt(12.0) if len(moved) else 0.0
    rounding = 4.0 * np.finfo(float).eps * float(np.max(np.abs(values)))
    return float(max(spread, digit, rounding))


class _Fit(NamedTuple):
    solution: Real
    covariance: Real
    fits: bool


def _least_squares(columns: Real, values: Real, noise: float) -> _Fit:
    """Coefficients, their covariance, and whether what is left is noise (chi-square)."""
    solution, *_ = np.linalg.lstsq(columns, values, rcond=None)
    left = float(np.sum((values - columns @ solution) ** 2)) / noise**2
    freedom = len(values) - columns.shape[1]
    covariance = noise**2 * np.linalg.pinv(columns.T @ columns)
    fits = freedom <= 0 or chi2_sf(left, freedom) > SIGNALS.ruled_out
    return _Fit(np.asarray(solution, dtype=float), np.asarray(covariance, dtype=float), bool(fits))


def _widths(width: float, enough: Callable[[float], bool]) -> Iterator[float]:
    """The width and its halves, as long as there are samples enough; always the first."""
    yield width
    while enough(0.5 * width):
        width *= 0.5
        yield width


def polynomial_at(
    channel: Channel, moment: float, width: float, degree: int, spare: int = 0
) -> _Fit:
    """Coefficients of powers of the time from a moment on, and their covariance.

    The value, the slope, half the second derivative, and so on, by the widest window that fits;
    whether one fits in which that many samples are left over.
    """

    def enough(half: float) -> bool:
        return len(channel.within(moment - half, moment + half)[0]) > degree + spare

    for half in _widths(width, enough):
        time, values = channel.within(moment - half, moment + half)
        # In units of the window, so that all columns are of one size.
        columns = np.vander((time - moment) / half, degree + 1, increasing=True)
        fit = _least_squares(columns, values, channel.noise)
        if fits := fit.fits and enough(half):
            break
    scale = half ** -np.arange(degree + 1.0)
    return _Fit(fit.solution * scale, fit.covariance * np.outer(scale, scale), fits)


def smooth_value(channel: Channel, moment: float, width: float) -> Estimate | None:
    """The value at a moment around which a channel is smooth; None beside a jump."""
    fit = polynomial_at(channel, moment, width, WINDOW.smooth, 1)
    if not fit.fits:
        return None
    return Estimate(float(fit.solution[0]), float(np.sqrt(fit.covariance[0, 0])))


def value_at(channel: Channel, moment: Estimate, width: float) -> Estimate:
    """The value at a moment that is itself known with a deviation."""
    solution, covariance, _ = polynomial_at(channel, moment.value, width, WINDOW.smooth)
    return Estimate(
        float(solution[0]), float(np.hypot(np.sqrt(covariance[0, 0]), solution[1] * moment.sd))
    )


def crossing(
    channel: Channel, guess: float, width: float, level: float
) -> tuple[Estimate, Estimate]:
    """When a channel crosses a level, and its slope there."""
    moment = guess
    for _ in range(WINDOW.moves):
        solution, covariance, _ = polynomial_at(channel, moment, width, WINDOW.steep)
        if solution[1] == 0.0:
            break
        # By less than the window: a flat piece, such as play, has no crossing of its own.
        step = (level - solution[0]) / solution[1]
        moment += float(np.clip(step, -0.5 * width, 0.5 * width))
    slope = Estimate(float(solution[1]), float(np.sqrt(covariance[1, 1])))
    return Estimate(
        moment, float(np.sqrt(covariance[0, 0]) / max(abs(slope.value), SMALLEST))
    ), slope


def turning_point(channel: Channel, guess: float, width: float, sign: float) -> Turning:
    """Where a channel is greatest (`sign` 1) or least (-1), near a guess."""
    moment = guess
    for _ in range(WINDOW.moves):
        solution, covariance, _ = polynomial_at(channel, moment, width, WINDOW.smooth)
        bend = 2.0 * solution[2]
        if sign * bend >= 0.0:
            break
        moment += float(np.clip(-solution[1] / bend, -0.5 * width, 0.5 * width))
    sharp = max(abs(2.0 * solution[2]), SMALLEST)
    step = float(np.clip(moment - guess, -width, width))
    way = Estimate(float(solution[0]), float(np.sqrt(covariance[0, 0])))
    return Turning(guess + step, float(np.sqrt(covariance[1, 1]) / sharp), way)


class _Shape(NamedTuple):
    """How a force may run through a turning point: columns (n, k), and what its value there is."""

    columns: Real
    at_turning: Real


def forces_at_turnings(turnings: Sequence[tuple[Channel, Turning]], width: float) -> list[Estimate]:
    """The force as a displacement reaches each of its turning points.

    A force may be smooth there (springs, dashpots), jump (friction: the value before counts), bend
    (yielding), or fall and rise as a power of the speed (dampers: the value at rest counts). One
    specimen does the same at all of them. What leaves no more than noise is weighed by its evidence
    (BIC); by how much the likely ones differ is part of the deviation.

    Parameters
    ----------
    turnings : sequence of (Channel, Turning)
        The force around each, and where the displacement turns.
    width : float
        Time to either side.
    """

    def enough(half: float) -> bool:
        return all(
            len(channel.within(each.time - half, each.time + half)[0]) > 2 * WINDOW.smooth + 2
            for channel, each in turnings
        )

    found = [Estimate(float("nan"), float("nan"))] * len(turnings)
    for half in _widths(width, enough):
        around = [_around(channel, each, half) for channel, each in turnings]
        if any(len(part.away) <= WINDOW.smooth + 2 for part in around):
            break
        tried = [_tried(part) for part in around]
        weights, fits = _weights(np.array([[each.weighed for each in row] for row in tried]))
        found = [_mixed([each.value for each in row], weights) for row in tried]
        if fits:
            break
    return found


class _Around(NamedTuple):
    """Samples around a turning point.

    Times are in units of the window, 0 at the turning point.
    """

    away: Real
    values: Real
    noise: float
    moment_sd: float


class _Tried(NamedTuple):
    """What a shape says at one turning point.

    Attributes
    ----------
    value : Estimate
        The force there.
    weighed : tuple of float
        Squares that are left over, their freedom, and the price of the parameters.
    """

    value: Estimate
    weighed: tuple[float, float, float]


def _around(channel: Channel, turning: Turning, half: float) -> _Around:
    time, values = channel.within(turning.time - half, turning.time + half)
    spacing = float(np.median(np.diff(time))) if len(time) > 1 else half
    # A sample so near to the turning point may be on either side of it.
    surely = float(normal_quantile(1.0 - 0.5 * SIGNALS.ruled_out))
    kept = np.abs(time - turning.time) > max(surely * turning.time_sd, 0.25 * spacing)
    away = (time[kept] - turning.time) / half
    return _Around(away, values[kept], channel.noise, turning.time_sd / half)


def _tried(part: _Around) -> list[_Tried]:
    """What each shape says."""
    power = _power_of(part.away, part.values)
    tried = []
    # Of a force that is steep there, what it is depends on when it turns.
    later = _shapes(part.away + part.moment_sd, power)
    for shape, moved in zip(_shapes(part.away, power), later, strict=True):
        fit = _least_squares(shape.columns, part.values, part.noise)
        value = float(shape.at_turning @ fit.solution)
        other, *_ = np.linalg.lstsq(moved.columns, part.values, rcond=None)
        shift = value - float(shape.at_turning @ other)
        sd = np.sqrt(shape.at_turning @ fit.covariance @ shape.at_turning + shift**2)
        left = float(np.sum((part.values - shape.columns @ fit.solution) ** 2)) / part.noise**2
        count = len(part.values)
        parameters = shape.columns.shape[1]
        price = parameters * np.log(count)
        tried.append(_Tried(Estimate(value, float(sd)), (left, float(count - parameters), price)))
    return tried


def _weights(weighed: Real) -> tuple[Real, bool]:
    """Weight of each shape by its evidence at all turning points, (m, shapes, 3).

    And whether one leaves only noise.
    """
    left, freedom, price = weighed.sum(axis=0).T
    fits = (freedom <= 0) | (chi2_sf(left, np.maximum(freedom, 1.0)) > SIGNALS.ruled_out)
    evidence = -0.5 * (left + price)
    if fits.any():
        evidence[~fits] = -np.inf
    weights = np.exp(evidence - evidence.max())
    weights /= weights.sum()
    # The fewest that are right together in 95 of 100 cases.
    likely = np.argsort(-weights)
    weights[likely[1:][np.cumsum(weights[likely])[:-1] >= INTERVAL]] = 0.0
    return weights / weights.sum(), bool(fits.any())


def _mixed(values: Sequence[Estimate], weights: Real) -> Estimate:
    """Mean and deviation of what several shapes say."""
    told, sds = np.array(values).T
    mean = float(weights @ told)
    return Estimate(mean, float(np.sqrt(weights @ (sds**2 + (told - mean) ** 2))))


def _shapes(away: Real, power: float) -> Iterator[_Shape]:
    """The shapes; times in units of the window, 0 at the turning point."""
    side = np.where(away < 0.0, 1.0, -1.0)
    size = np.maximum(np.abs(away), SMALLEST)
    one, two, four = np.ones_like(away), away**2, away**4
    yield _Shape(np.stack([one, away, two, away**3, four], axis=1), np.eye(5)[0])
    jump = np.array([1.0, 0.0, 0.0, 1.0, 0.0, 0.0])
    yield _Shape(np.stack([one, two, four, side], axis=1), jump[:4])
    yield _Shape(np.stack([one, two, four, side, side * size, side * size**3], axis=1), jump)
    before, after = away < 0.0, away > 0.0
    bent = [one, two * before, two * after, four * before, four * after]
    yield _Shape(np.stack(bent, axis=1), np.eye(5)[0])
    fallen = side * size**power
    # The power was fitted too: its column is the derivative by it.
    steep = [one, two, four, fallen, fallen * two, fallen * np.log(size)]
    yield _Shape(np.stack(steep, axis=1), np.eye(6)[0])


def _power_of(away: Real, values: Real) -> float:
    """The power of the time to the turning point by which the odd part of a force goes best."""
    from scipy.optimize import minimize_scalar

    side = np.where(away < 0.0, 1.0, -1.0)
    size = np.abs(away)
    even = np.stack([np.ones_like(away), away**2, away**4], axis=1)

    def left(power: float) -> float:
        fallen = side * size**power
        columns = np.column_stack([even, fallen, fallen * size**2])
        solution, *_ = np.linalg.lstsq(columns, values, rcond=None)
        return float(np.sum((values - columns @ solution) ** 2))

    return float(minimize_scalar(left, bounds=EXPONENTS, method="bounded").x)


@dataclass(frozen=True, eq=False)
class LoopRecord:
    """One test.

    Parameters
    ----------
    time : ndarray, shape (n,)
        In s, rising; numbers of the samples where the record has no clock.
    displacement, force : ndarray, shape (n,)
        The two channels, complete.
    displacement_unit, force_unit : str
        Their units; a strain is a share, ``-``.
    name : str
        Shown in tables.
    timed : bool
        Whether `time` is a time.
    temperature : ndarray, shape (n,), optional
        In degC.
    notes : tuple of str
        What a user should know of how it was read.
    """

    time: Real
    displacement: Real
    force: Real
    displacement_unit: str = "mm"
    force_unit: str = "N"
    name: str = "record"
    timed: bool = True
    temperature: Real | None = None
    notes: tuple[str, ...] = ()

    @classmethod
    def of(cls, signals: Signals, timed: bool = True) -> LoopRecord:
        """From signals as a reader gives them: in order, complete, a strain as a share.

        Raises
        ------
        DataError
            If too little is left, or the units make no stiffness.
        """
        mended = in_order(signals.time, signals.displacement, signals.force, signals.name)
        channels = np.column_stack([mended.time, mended.displacement, mended.force])
        # Of two samples at one time none is later: a slope between them would be infinite.
        known = np.isfinite(channels).all(axis=1)
        channels = channels[known]
        channels = channels[np.concatenate([[True], np.diff(channels[:, 0]) > 0.0])]
        clock, moved, pulled = channels.T.copy()
        unit = signals.displacement_unit
        stiffness_unit(unit, signals.force_unit)
        if unit in STRAIN_UNITS:
            moved, unit = moved * STRAIN_UNITS[unit], "-"
        told = tuple(text for key, text in signals.provenance.items() if key.startswith("note "))
        # That samples are counted in seconds is no news of a record without a clock.
        notes = (*(told if timed else ()), *mended.notes)
        name = PurePath(signals.name).stem
        return cls(clock, moved, pulled, unit, signals.force_unit, name, timed, None, notes)

    @property
    def units(self) -> dict[str, str]:
        """Units of what is made of the channels, by dimension."""
        way, force = self.displacement_unit, self.force_unit
        stiffness, energy, speed = f"{force}/{way}", f"{force} {way}", f"{way}/s"
        damping = f"{force} s/{way}"
        if way == "-":
            stiffness, energy, speed, damping = force, force, "1/s", f"{force} s"
        return {
            "displacement": way,
            "force": force,
            "stiffness": stiffness,
            "damping": damping,
            "energy": energy,
            "velocity": speed,
            "ratio": "-",
            "temperature": "degC",
            "frequency": "Hz",
        }


def read_record(spec: str | Path) -> LoopRecord:
    """The record that a user names, as ``springpot signals`` reads it.

    Parameters
    ----------
    spec : str or Path
        ``FILE``, or ``FILE?force=kN`` for what the file leaves open. A file of displacement and
        force without a time gives what needs none.

    Raises
    ------
    DataError
        If the file holds no such signals.
    """
    try:
        record = LoopRecord.of(open_signals(spec))
    except OpenQuestion as question:
        if [each.about for each in question.questions] != ["time"]:
            raise
        record = LoopRecord.of(open_signals(_counted(str(spec))), timed=False)
    return _with_temperature(record, spec)


def _counted(spec: str) -> str:
    """The same file with its samples counted for want of a clock."""
    answered = bool(file_and_choice(spec)[1].columns)
    return f"{spec}{',' if answered else '?'}rate=1[Hz]"


def _with_temperature(record: LoopRecord, spec: str | Path) -> LoopRecord:
    """The record with the temperature of each sample, where the file has a column of it."""
    if not record.timed:
        return record
    # Tests in time are read with all their conditions, by readers that are stricter: where these
    # refuse a file there is a record all the same, and no temperature.
    tests: tuple[object, ...] = ()
    with suppress(DataError):
        tests = open_in_time(spec)
    found = tests[0] if len(tests) == 1 else None
    if not isinstance(found, TimeTest) or found.temperature is None:
        return record
    warmth = np.full(len(record.time), found.temperature)
    if found.warmth is not None:
        warmth = np.interp(record.time, found.time, found.warmth)
    return replace(record, temperature=warmth)


@dataclass(frozen=True, eq=False)
class Found:
    """The cycles of a record.

    Parameters
    ----------
    bounds : tuple of Estimate
        Where cycles begin, and where the last one ends, one more than cycles.
    middles : tuple of Estimate
        The crossing in the middle of each.
    speeds : tuple of Estimate
        Greatest speed at these crossings, of beginning and middle of each cycle in turn.
    period : float
        Of the test as a whole.
    amplitude : float
        Of its steady part.
    notes : tuple of str
        What is left out.
    """

    bounds: tuple[Estimate, ...]
    middles: tuple[Estimate, ...]
    speeds: tuple[Estimate, ...]
    period: float
    amplitude: float
    notes: tuple[str, ...]


def find_cycles(record: LoopRecord) -> Found:
    """The whole cycles of a record.

    Raises
    ------
    DataError
        If nothing oscillates, or no cycle is whole.
    """
    test = harmonics_of(record.time, record.displacement, record.force, name=record.name)
    period = 2.0 * np.pi / test.omega
    # Rest before and after the motion has a mean of its own.
    part = test.start, test.stop
    seen = record.displacement - moving_mean(record.time, record.displacement, period, part)
    smooth = _box(seen, record.time, WINDOW.share * period)
    guesses, begins, ends = _crossings(record.time, smooth, test.amplitude)
    channel = Channel(record.time, seen, noise_of(record.displacement))
    found = [crossing(channel, guess, WINDOW.share * period, 0.0) for guess in guesses]
    if begins and guesses:
        found[0] = _from_rest(channel, guesses[0], period, 1.0) or found[0]
    if ends and len(guesses) > 1:
        found[-1] = _from_rest(channel, guesses[-1], period, -1.0) or found[-1]
    if len(found) < 3:
        raise DataError(
            f"{record.name}: no cycle is whole: the displacement crosses its mean"
            f" {len(found)} times, and a cycle takes three"
        )
    whole = (len(found) - 1) // 2
    bounds = tuple(moment for moment, _ in found[: 2 * whole + 1 : 2])
    middles = tuple(moment for moment, _ in found[1 : 2 * whole : 2])
    speeds = tuple(slope for _, slope in found[: 2 * whole])
    notes = []
    clock = "s" if record.timed else "samples"
    if not begins:
        notes.append(
            f"the record begins within a cycle: what comes before {bounds[0].value:.4g} {clock} is"
            " no whole one"
        )
    if not ends or len(found) > 2 * whole + 1:
        notes.append(
            f"the record ends within a cycle: what comes after {bounds[-1].value:.4g} {clock} is no"
            " whole one"
        )
    return Found(bounds, middles, speeds, period, test.amplitude, tuple(notes))


def moving_mean(time: Real, values: Real, period: float, part: tuple[float, float]) -> Real:
    """Mean over one period around each sample: it holds nothing of what repeats with the period.

    Outside of a part, that of the nearest period within it.
    """
    steps = np.diff(time)
    area = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * steps)])
    start, stop = max(part[0], time[0]), min(part[1], time[-1])
    half = 0.5 * min(period, stop - start)
    centre = np.clip(time, start + half, stop - half)
    upper = np.interp(centre + half, time, area)
    lower = np.interp(centre - half, time, area)
    return np.asarray((upper - lower) / (2.0 * half))


def _box(values: Real, time: Real, width: float) -> Real:
    """Mean over a window, which moves no crossing and lowers the noise by the samples in it."""
    reach = int(0.5 * width / np.median(np.diff(time)))
    area = np.concatenate([[0.0], np.cumsum(values)])
    places = np.arange(len(values))
    # Symmetric at the ends too: half a window would move a crossing.
    side = np.minimum(reach, np.minimum(places, len(values) - 1 - places))
    return np.asarray((area[places + side + 1] - area[places - side]) / (2 * side + 1))


def _crossings(time: Real, smooth: Real, amplitude: float) -> tuple[list[float], bool, bool]:
    """Moments of the crossings of zero, and whether the motion begins and ends with one."""
    far = np.flatnonzero(np.abs(smooth) > 0.5 * amplitude)
    if not len(far):
        return [], False, False
    turns = far[1:][np.diff(np.sign(smooth[far])) != 0.0]
    # A record that begins at rest or on its mean has its first crossing; one that begins elsewhere
    # begins within a cycle. The same of its end, read backwards.
    first = _last_zero(time, smooth, int(far[0]))
    last = _last_zero(-time[::-1], smooth[::-1], len(time) - 1 - int(far[-1]))
    between = [_last_zero(time, smooth, int(place)) for place in turns]
    end = None if last is None else -last
    moments = [moment for moment in (first, *between, end) if moment is not None]
    return moments, first is not None, last is not None


def _last_zero(time: Real, smooth: Real, place: int) -> float | None:
    """The last crossing of zero before a sample; the beginning where that is as near as that."""
    side = np.sign(smooth[place])
    behind = np.flatnonzero(side * smooth[:place] <= 0.0)
    if len(behind):
        last = int(behind[-1])
        share = smooth[last] / (smooth[last] - smooth[last + 1])
        return float(time[last] + share * (time[last + 1] - time[last]))
    if place < 2:
        return None
    # Straight through the first samples, back to zero by no more than two of them lie apart.
    few = slice(0, min(place, 4) + 1)
    slope, start = np.polyfit(time[few] - time[0], smooth[few], 1)
    if slope and abs(start / slope) <= 2.0 * (time[1] - time[0]):
        return float(time[0])
    return None


def _from_rest(
    channel: Channel, guess: float, period: float, side: float
) -> tuple[Estimate, Estimate] | None:
    """The crossing where motion begins (`side` 1) or ends (-1), from the samples in motion.

    None where there is no rest beside it.
    """
    blurred = 0.5 * WINDOW.share * period
    outside = guess - channel.time[0] if side > 0 else channel.time[-1] - guess
    if outside <= blurred:
        return None
    # Nearer than the mean over a window reaches, rest and motion are mixed.
    moving = side * (channel.time - guess) >= blurred
    part = Channel(channel.time[moving], channel.value[moving], channel.noise)
    return crossing(part, guess, 2.0 * WINDOW.share * period, 0.0)
