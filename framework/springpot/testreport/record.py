"""A record of displacement and force as a test report takes it, and where its cycles begin and end.

A cycle begins where the displacement crosses its moving mean in the direction of the first motion.
A crossing counts once the displacement has gone on by half the amplitude: noise and drift that are
smaller than that make and lose none.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path, PurePath

import numpy as np

from springpot.errors import DataError
from springpot.measurement.from_signals import stiffness_unit
from springpot.measurement.reader import OpenQuestion, file_and_choice
from springpot.measurement.signals import harmonics_of
from springpot.measurement.steady import Signals, in_order
from springpot.measurement.timetest import TimeTest
from springpot.measurement.units import STRAIN_UNITS
from springpot.registry import open_in_time, open_signals
from springpot.rheology.points import Real

from .local import EIGHTH, Channel, Estimate, crossing, noise_of


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
    smooth = _box(seen, record.time, EIGHTH * period)
    guesses, begins, ends = _crossings(record.time, smooth, test.amplitude)
    channel = Channel(record.time, seen, noise_of(record.displacement))
    found = [crossing(channel, guess, EIGHTH * period, 0.0) for guess in guesses]
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
    blurred = 0.5 * EIGHTH * period
    outside = guess - channel.time[0] if side > 0 else channel.time[-1] - guess
    if outside <= blurred:
        return None
    # Nearer than the mean over a window reaches, rest and motion are mixed.
    moving = side * (channel.time - guess) >= blurred
    part = Channel(channel.time[moving], channel.value[moving], channel.noise)
    return crossing(part, guess, 2.0 * EIGHTH * period, 0.0)
