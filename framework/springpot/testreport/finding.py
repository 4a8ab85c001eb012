"""Where the cycles of a record begin and end, however it drifts and scatters.

A cycle begins where the displacement crosses its moving mean in the direction of the first motion.
A crossing counts once the displacement has gone on by half the amplitude: noise and drift that are
smaller than that make and lose none.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from springpot.errors import DataError
from springpot.measurement.signals import harmonics_of
from springpot.rheology.points import Real

from .local import EIGHTH, Channel, Value, crossing, noise_of
from .record import Record


@dataclass(frozen=True, eq=False)
class Found:
    """The cycles of a record.

    Parameters
    ----------
    bounds : tuple of Value
        Where cycles begin, and where the last one ends, one more than cycles.
    middles : tuple of Value
        The crossing in the middle of each.
    speeds : tuple of Value
        Greatest speed at these crossings, of beginning and middle of each cycle in turn.
    period : float
        Of the test as a whole.
    amplitude : float
        Of its steady part.
    notes : tuple of str
        What is left out.
    """

    bounds: tuple[Value, ...]
    middles: tuple[Value, ...]
    speeds: tuple[Value, ...]
    period: float
    amplitude: float
    notes: tuple[str, ...]


def find_cycles(record: Record) -> Found:
    """The whole cycles of a record.

    Raises
    ------
    DataError
        If nothing oscillates, or no cycle is whole.
    """
    test = harmonics_of(record.time, record.displacement, record.force, name=record.name)
    period = 2.0 * np.pi / test.omega
    seen = record.displacement - moving_mean(record.time, record.displacement, period)
    smooth = _box(seen, record.time, EIGHTH * period)
    guesses, partial = _crossings(record.time, smooth, test.amplitude)
    channel = Channel(record.time, seen, noise_of(record.displacement))
    found = [crossing(channel, guess, EIGHTH * period, 0.0) for guess in guesses]
    spacing = float(np.median(np.diff(record.time)))
    found, tail = _ended(found, record, spacing, smooth)
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
    if partial:
        notes.append(
            f"the record begins within a cycle: what comes before {bounds[0].value:.4g} {clock} is"
            " no whole one"
        )
    if tail or len(found) > 2 * whole + 1:
        notes.append(
            f"the record ends within a cycle: what comes after {bounds[-1].value:.4g} {clock} is no"
            " whole one"
        )
    return Found(bounds, middles, speeds, period, test.amplitude, tuple(notes))


def moving_mean(time: Real, values: Real, period: float) -> Real:
    """Mean over one period around each sample: it holds nothing of what repeats with the period."""
    steps = np.diff(time)
    area = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * steps)])
    # At the ends the nearest period that is whole stands for those that are not.
    half = 0.5 * min(period, time[-1] - time[0])
    centre = np.clip(time, time[0] + half, time[-1] - half)
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


def _crossings(time: Real, smooth: Real, amplitude: float) -> tuple[list[float], bool]:
    """Moments of the crossings of zero, in order, and whether motion comes before the first."""
    far = np.flatnonzero(np.abs(smooth) > 0.5 * amplitude)
    if not len(far):
        return [], False
    side = np.sign(smooth[far])
    turns = far[np.concatenate([[True], np.diff(side) != 0.0])]
    crossings = []
    for place in turns[1:]:
        crossings.append(_last_zero(time, smooth, int(place)))
    first = _last_zero(time, smooth, int(turns[0]))
    # A record that begins at rest or on its mean has its first crossing; one that begins elsewhere
    # begins within a cycle.
    begins = first is not None and abs(smooth[0]) < 0.5 * amplitude
    moments = [moment for moment in ([first] if begins else []) + crossings if moment is not None]
    return moments, not begins


def _last_zero(time: Real, smooth: Real, place: int) -> float | None:
    """The last crossing of zero before a sample; the beginning where it is as near as the noise."""
    side = np.sign(smooth[place])
    behind = np.flatnonzero(side * smooth[:place] <= 0.0)
    if len(behind):
        last = int(behind[-1])
        share = smooth[last] / (smooth[last] - smooth[last + 1])
        return float(time[last] + share * (time[last + 1] - time[last]))
    # Straight through the first samples, back to zero by no more than they lie apart.
    few = slice(0, min(place, 4) + 1)
    slope, start = np.polyfit(time[few] - time[0], smooth[few], 1)
    back = start / slope if slope else np.inf
    if abs(back) <= 2.0 * (time[1] - time[0]):
        return float(time[0])
    return None


def _ended(
    found: list[tuple[Value, Value]], record: Record, spacing: float, smooth: Real
) -> tuple[list[tuple[Value, Value]], bool]:
    """The crossings with that at the end of the record, and whether motion comes after the last."""
    if len(found) < 2:
        return found, False
    time = record.time
    channel = Channel(time, smooth, noise_of(record.displacement))
    rest = smooth[time > found[-1][0].value]
    largest = float(np.max(np.abs(smooth)))
    # After the last crossing the displacement has gone out and is on its way back to zero.
    if len(rest) and np.max(np.abs(rest)) > 0.5 * largest:
        slope = found[-2][1]
        near = float(rest[-1])
        # As far as one sample moves, and what noise hides: then the next sample would be zero.
        reach = abs(slope.value) * spacing + 2.0 * channel.noise
        if abs(near) <= reach:
            sure = Value(float(time[-1]), channel.noise / max(abs(slope.value), 1e-300))
            return [*found, (sure, slope)], False
        return found, True
    return found, False
