"""Of a measurement with very many points those that are diagnosed."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from springpot.measurement import Measurement

from .noise import average_repeats
from .regions import Rows
from .sweeps import sweeps_of

MOST_POINTS = 1500
"""Points that are diagnosed at most."""
FEWEST = 10
"""Points of a sweep that are kept before sweeps are left out."""
MOST_REPEATS = 30
"""Repeats of one point that are kept before points are left out."""


def thinned(measurement: Measurement) -> Measurement:
    """At most `MOST_POINTS` rows, in the order in which they stand.

    Every sweep keeps as many points as the longest may have, spread evenly over its own, with all their repeats. Only
    where that leaves fewer than `FEWEST` of each, whole sweeps are left out; only of more than `MOST_REPEATS` repeats
    some are.
    """
    if len(measurement) <= MOST_POINTS:
        return measurement
    data = average_repeats(measurement)
    points = np.split(np.argsort(data.group, kind="stable"), np.cumsum(np.bincount(data.group))[:-1])
    most = max(MOST_REPEATS, MOST_POINTS // len(points))
    points = [_even(rows, most) for rows in points]
    size = np.array([len(rows) for rows in points])
    lines = [sweep.rows for sweep in sweeps_of(data.mean)]

    def fits(lines: Sequence[Rows], each: int) -> bool:
        return sum(int(size[_even(line, each)].sum()) for line in lines) <= MOST_POINTS

    kept = _largest(lambda count: fits([lines[i] for i in _spread(len(lines), count)], FEWEST), len(lines))
    lines = [lines[i] for i in _spread(len(lines), kept)]
    each = _largest(lambda count: fits(lines, count), max(len(line) for line in lines))
    return measurement.subset(np.sort(np.concatenate([points[i] for line in lines for i in _even(line, each)])))


def _largest(fits: Callable[[int], bool], most: int) -> int:
    """The largest number up to `most` that fits, by halving; 1 where none does."""
    low, high = 1, most + 1
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low


def _even(rows: Rows, most: int) -> Rows:
    return rows[_spread(len(rows), most)]


def _spread(count: int, most: int) -> Rows:
    """At most so many of the numbers 0, ..., count - 1, from end to end."""
    return np.linspace(0, count - 1, min(count, most)).round().astype(np.int64)
