"""What a law of a test is told about it, at each of its samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from springpot.rheology.points import Real

from .imposed import Loading
from .timetest import TimeTest


@dataclass(frozen=True, eq=False)
class Record:
    """What a law is told about a test, at each of its samples.

    Attributes
    ----------
    time : ndarray, shape (n,)
        In s since the load first moved; nothing happens before, when it is negative.
    imposed, rate : ndarray, shape (n,)
        What was imposed, and its change per second; steps that take no time have none.
    largest : float
        Largest size of what was imposed.
    cycles : ndarray, shape (n,)
        The way that was gone until each sample, in cycles: the whole span there and back each.
    control : {"displacement", "force"}
        Which of the two that was.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import TimeTest
    >>> from springpot.measurement import Record
    >>> test = TimeTest.of_relaxation([0.5, 1.0], [3.0, 2.0])
    >>> Record.of(test, test.time).imposed
    array([1., 1.])
    """

    time: Real
    imposed: Real
    rate: Real
    largest: float
    cycles: Real
    control: str

    @classmethod
    def of(cls, test: TimeTest, at: Real | None = None) -> Record:
        """That of a test, at its own samples or at the times `at` (n,)."""
        t = test.time
        if at is not None:
            t = at
        imposed, rate = followed(test.loading, t)
        largest = float(np.abs(test.loading.value).max())
        # By the knots of the loading, so that it does not matter how many samples are looked at.
        way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(test.loading.value)))])
        # Of a load on one side a cycle goes there and back once, not twice.
        span = float(np.ptp(test.loading.value)) or largest
        # Those before the record have been; it counts its own.
        way -= way[test.loading.before]
        cycles = np.interp(t, test.loading.time, way) / (2.0 * span)
        return cls(t - test.start, imposed, rate, largest, cycles, test.control)


def followed(loading: Loading, t: Real) -> tuple[Real, Real]:
    """What a loading is at the times t (n,), and how fast it changes there.

    A step is over at its own instant.
    """
    times, sizes = loading.jumps
    # Steps are added by hand, as interpolation knows no two values at one time.
    value = (t[:, None] >= times).astype(float) @ sizes
    smooth = loading.smooth
    if smooth is None:
        return value, np.zeros(len(t))
    if len(smooth.time) < 2:
        return value + smooth.value[0], np.zeros(len(t))
    return value + np.interp(t, smooth.time, smooth.value), _rate(smooth, t)


def _rate(smooth: Loading, t: Real) -> Real:
    """Change per second between samples.

    At a knot the mean of both sides, and nothing beyond the ends.
    """
    slope = np.diff(smooth.value) / np.diff(smooth.time)
    # Before the first knot and after the last one everything rests.
    after = np.concatenate([[0.0], slope, [0.0]])
    left = after[np.searchsorted(smooth.time, t, side="left")]
    right = after[np.searchsorted(smooth.time, t, side="right")]
    rate: Real = 0.5 * (left + right)
    return rate
