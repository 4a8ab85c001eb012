"""Displacement and force against time, read by blocks: a long record never needs room twice."""

from __future__ import annotations

import mmap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from springpot.errors import DataError
from springpot.rheology.points import Real

FEWEST = 8
"""Complete samples below which nothing is made of a record."""
BLOCK = 1 << 16
"""Rows worked on at a time."""
FORGET = 32 * BLOCK
"""Rows after which the pages of a mapped file are given back."""


@dataclass(frozen=True, eq=False)
class Signals:
    """One test: displacement and force (strain and stress, angle and torque) against time.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Seconds, in any order, irregular or with gaps.
    displacement, force : ndarray, shape (n,)
        The two channels; nan where a sample is missing.
    displacement_unit, force_unit : str
        Their units, such as ``mm`` and ``N``.
    name : str
        Shown in reports.
    provenance : mapping of str to str
        Where the signals come from.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import Signals, measurement_from_signals
    >>> t = np.linspace(0.0, 5.0, 2000)
    >>> test = Signals(t, np.cos(6.0 * t), 3.0 * np.cos(6.0 * t + 0.5), "mm", "N", "pad")
    >>> np.angle(measurement_from_signals([test]).stiffness).round(3)
    array([0.5])
    """

    time: Real
    displacement: Real
    force: Real
    displacement_unit: str = "mm"
    force_unit: str = "N"
    name: str = "signals"
    provenance: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Record:
    """Signals in order of time, with what had to be mended.

    Parameters
    ----------
    time, displacement, force : ndarray, shape (n,)
        The channels; `time` does not fall.
    name : str
        Shown in errors.
    notes : tuple of str
        What was mended.
    """

    time: Real
    displacement: Real
    force: Real
    name: str
    notes: tuple[str, ...] = ()

    def blocks(self, start: float = -np.inf, stop: float = np.inf) -> Iterator[tuple[Real, Real]]:
        """Complete samples with start <= time < stop.

        Times (m,) and the two channels (m, 2), block by block.
        """
        first, last = np.searchsorted(self.time, [start, stop]).tolist()
        for low in range(first, last, BLOCK):
            if (low - first) % FORGET == 0:
                forget(self.time, self.displacement, self.force)
            rows = slice(low, min(low + BLOCK, last))
            both = np.column_stack([self.displacement[rows], self.force[rows]])
            # Both channels or none: a sample that lacks one tells no stiffness.
            good = np.isfinite(both).all(axis=1)
            yield np.asarray(self.time[rows])[good], both[good]

    @property
    def span(self) -> float:
        """Duration in seconds."""
        return float(self.time[-1] - self.time[0])


def forget(*channels: Real) -> None:
    """Give back the memory of channels that are mapped from a file.

    They are read again when they are needed.
    """
    for channel in channels:
        below: object = channel
        # A column is a view of a view: the map lies under all of them.
        while isinstance(below, np.ndarray):
            below = below.base
        if isinstance(below, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED"):
            below.madvise(mmap.MADV_DONTNEED)


def in_order(time: Real, displacement: Real, force: Real, name: str = "signals") -> Record:
    """The signals as a record: cut to the common length, sorted by time if need be.

    Raises
    ------
    DataError
        If fewer than eight samples are left, or time stands still.
    """
    notes = []
    lengths = {len(time), len(displacement), len(force)}
    if len(lengths) > 1:
        # Loggers stop their channels one after the other: what all have is one test.
        common = min(lengths)
        notes.append(f"time, displacement and force differ in length: cut to {common} samples")
        time, displacement, force = time[:common], displacement[:common], force[:common]
    if len(time) and not _rises(time):
        keep = np.flatnonzero(np.isfinite(time))
        # Stable, so that samples of one time stay in the order of the file.
        keep = keep[np.argsort(time[keep], kind="stable")]
        notes.append("time runs backwards or has gaps: samples were put in order")
        time, displacement, force = time[keep], displacement[keep], force[keep]
    record = Record(time, displacement, force, name, tuple(notes))
    complete = sum(len(t) for t, _ in record.blocks())
    if complete < FEWEST:
        raise DataError(
            f"{name}: {complete} complete samples of time, displacement and force; at least"
            f" {FEWEST} are needed"
        )
    if not record.span > 0:
        raise DataError(f"{name}: time stands still at {time[0]:g} s")
    return record


def _rises(time: Real) -> bool:
    """Whether time is finite and never falls."""
    for low in range(0, len(time), BLOCK):
        # One sample of overlap sees a fall at the seam of two blocks.
        block = time[max(low - 1, 0) : low + BLOCK]
        if low % FORGET == 0:
            forget(time)
        if not (np.isfinite(block).all() and (np.diff(block) >= 0).all()):
            return False
    return True
