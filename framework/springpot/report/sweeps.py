"""Which measured points are one curve of a figure, and which of many curves are drawn."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.measurement.conversion import levels_in_words
from springpot.measurement.independence import ranges
from springpot.measurement.measurement import Measurement, held_levels, numbers_of_levels
from springpot.numerics import evenly
from springpot.rheology.levels import levels_of
from springpot.rheology.points import Real
from springpot.thresholds import VARIED

Rows = NDArray[np.int64]
Words = NDArray[np.str_]


class Drawing(NamedTuple):
    """Which of many curves are drawn, and what one is."""

    drawn: int
    """Sweeps drawn at most; of more, evenly many are chosen.

    More colours than this cannot be told apart.
    """
    varies: float
    """A frequency or amplitude varies if its largest value exceeds its smallest by this factor."""
    profile: float
    """Ranges that a condition travels at most if it changes along a sweep, not between sweeps."""
    bin: int
    """Points of a bin of a condition that was never held."""
    bins: int
    """Bins at most, however many points there are."""


SWEEPS = Drawing(drawn=12, varies=1.2, profile=3.0, bin=8, bins=40)


@dataclass(frozen=True, eq=False)
class DrawnSweep:
    """Rows measured under the same conditions, in order along the axis.

    Parameters
    ----------
    label : str
        The conditions.
    rows : ndarray of int
        Which rows.
    """

    label: str
    rows: Rows


def varies(name: str, column: Real) -> bool:
    """Whether a condition changes by more than a set value does while it is held."""
    low, high = float(np.min(column)), float(np.max(column))
    # Degrees have no zero of their own, so that their ratio means nothing.
    if name == "temperature":
        return high - low > VARIED.temperature_wanders
    return high > SWEEPS.varies * low


def travels(along: Real, column: Real) -> bool:
    """Whether `column` (n,) jumps to and fro along the axis, unlike within one sweep."""
    # Instruments leave cells empty: those without a value say nothing of a jump.
    known = np.isfinite(column)
    if not np.any(known):
        return False
    along, column = along[known], column[known]
    # Length of the way, over its range: one rise is 1, and a jump at each point as many as there
    # are points.
    way = float(np.sum(np.abs(np.diff(column[np.argsort(along, kind="stable")]))))
    _, place = np.unique(along, return_inverse=True)
    low, high = np.full(place.max() + 1, np.inf), np.full(place.max() + 1, -np.inf)
    np.minimum.at(low, place.ravel(), column)
    np.maximum.at(high, place.ravel(), column)
    whole = float(np.ptp(column))
    return way > SWEEPS.profile * whole or float(np.max(high - low)) > 0.5 * whole > 0.0


def all_sweeps(
    measurement: Measurement, column: str, along: Real, own: Collection[str] = ()
) -> list[DrawnSweep]:
    """Every sweep of a measurement, by repeat, temperature and amplitude in ascending order.

    Where a condition was not held but wandered, its points are taken together in levels or, if
    there are none, in bins of equally many points.

    Parameters
    ----------
    measurement : Measurement
        The data.
    column : str
        What the axis shows, which no sweep holds.
    along : ndarray, shape (n,)
        Where each point stands on it.
    own : collection of str
        Further columns that set sweeps apart, as levels do of which a model has parameters.
    """
    parts = [np.arange(len(measurement))]
    # Only what tells sweeps from one another is worth a word in their labels.
    telling: list[tuple[str, Real | Words]] = []
    further: list[tuple[str, Real | Words]] = []
    for name in sorted(set(own) - {"temperature", "amplitude"}):
        number, told = _further(measurement, name)
        parts = [one for part in parts for one in _alike(part, number[part])]
        further.append((name, told))
    if measurement.repeat is not None:
        again = [one for part in parts for one in _alike(part, measurement.repeat[part])]
        # Specimens are repeats already.
        if len(again) > len(parts):
            telling.append(("repeat", measurement.repeat.astype(float)))
        parts = again
    for name in ("temperature", "amplitude"):
        values = measurement.conditions.get(name)
        if values is None or name == column:
            continue
        finer: list[Rows] = []
        for part in parts:
            finer += _split(name, values, along, part)
        # What is the same for all sweeps tells none from another.
        if len(finer) > len(parts):
            telling.append((name, values))
        parts = finer
    telling += further
    ordered = [rows[np.argsort(along[rows], kind="stable")] for rows in parts]
    return [
        DrawnSweep(_label(rows, telling, measurement.units.amplitude), rows) for rows in ordered
    ]


def _further(measurement: Measurement, name: str) -> tuple[Rows, Real | Words]:
    """The level (n,) of each row of a further column, and the words or numbers that tell it."""
    if name in measurement.labels:
        label = measurement.labels[name]
        places = {word: i for i, word in enumerate(dict.fromkeys(label.tolist()))}
        return np.array([places[word] for word in label.tolist()]), label
    values = measurement.conditions[name]
    words = levels_in_words(measurement, name)
    told = values if words is None else np.array(words)[values.astype(int) - 1]
    return levels_of(name, values), told


def chosen(sweeps: list[DrawnSweep]) -> list[DrawnSweep]:
    """At most `SWEEPS.drawn` of the sweeps, evenly spread, the first and the last among them."""
    # Both ends among them: they show how much a condition changes.
    return [sweeps[i] for i in evenly(len(sweeps), SWEEPS.drawn)]


def _split(name: str, values: Real, along: Real, rows: Rows) -> list[Rows]:
    """Rows of each level of a condition; all of them where it is held or follows the axis."""
    here = values[rows]
    if not varies(name, here):
        return [rows]
    profile = not travels(along[rows], here)
    # A rig that cannot keep its amplitude lets it fall along the sweep; a temperature that changes
    # was set.
    if profile and name == "amplitude":
        return [rows]
    levels = held_levels(name, here)
    low, high = ranges(levels, here)
    wide = np.maximum(high - low, np.roll(high - low, -1))[:-1]
    # Neighbours that are each near the next may make a chain as wide as what lies between: then
    # those are a level that are the same.
    if len(low) == 1 or np.any(wide > low[1:] - high[:-1]):
        levels = numbers_of_levels(here, 0.0)
    # With fewer than two points in most levels there are none.
    if levels.max() < max(1, len(here) // 2):
        return _alike(rows, levels)
    if profile:
        return [rows]
    return _alike(rows, _bins(here))


def _alike(rows: Rows, numbers: NDArray[np.int64]) -> list[Rows]:
    """Rows (n,) of each number (n,) that some of them have."""
    return [rows[numbers == number] for number in np.unique(numbers)]


def _bins(values: Real) -> NDArray[np.int64]:
    """Number of the bin of each value, bins holding equally many."""
    count = int(np.clip(len(values) // SWEEPS.bin, 1, SWEEPS.bins))
    # By rank, so that bins hold equally many wherever the values crowd.
    rank = np.empty(len(values), dtype=np.int64)
    rank[np.argsort(values, kind="stable")] = np.arange(len(values))
    return rank * count // len(values)


def _label(rows: Rows, telling: list[tuple[str, Real | Words]], unit: str) -> str:
    """``20 °C, 0.5 mm``, or the range of a bin; ``all`` where nothing is told."""
    return ", ".join(_condition(name, values[rows], unit) for name, values in telling) or "all"


def _condition(name: str, values: Real | Words, unit: str) -> str:
    # Rows of one sweep have one word.
    if values.dtype.kind == "U":
        return f"{name} {values[0]}"
    numbers = values.astype(float)
    low, high = float(np.min(numbers)), float(np.max(numbers))
    mean = float(np.mean(numbers))
    if name == "temperature":
        mean = round(mean, 1)
    shown = f"{mean:.4g}"
    if name != "repeat" and varies(name, numbers):
        shown = f"{low:.3g} to {high:.3g}"
    if name == "temperature":
        return f"{shown} °C"
    if name == "amplitude" and unit != "-":
        return f"{shown} {unit}"
    # An amplitude without a unit is one of length over length.
    if name == "amplitude":
        return f"strain {shown}"
    return f"{name} {shown}"
