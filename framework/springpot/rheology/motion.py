"""What moves, between its samples too.

A record holds a motion at its samples alone, and a dashpot, a mass and a mode that relaxes within a
step feel how it went there from one to the next. Straight lines are off by (omega h)^2 / 12 of what
they feel. So where differences tell that a motion is smooth it is a cubic between two samples, and
where it turns sharply it has the slope of its own side up to the corner.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..numerics import ALIKE
from .points import Real

FEWEST_AT_CORNER = 6
"""Samples that show a corner of a motion: its own two, and two on either side."""
SHARP = 8.0
"""Times as much as the samples beside it a corner bends the motion; at the peaks of a sine of eight
samples a cycle it would be nearly five.
"""
STEPS_OF_A_WAY = 3
"""Steps that a motion goes each way about a turn at least."""
APART = 1e-3
"""Share of a step by which a corner is off a sample at least to be a knot of its own."""


@dataclass(frozen=True, eq=False)
class Between:
    """A displacement or force that is a cubic between two knots, by its speeds at both ends.

    Parameters
    ----------
    time, value : ndarray, shape (n,)
        Knots: the samples, and the corners between them.
    speed, push : ndarray, shape (n,)
        First and second derivative, as a dashpot and a mass feel them there.
    leaving, arriving : ndarray, shape (n - 1,)
        Speed at the beginning and the end of each interval; the mean speed where it is straight.
    unsure : ndarray, shape (k,)
        Times of the samples next to a corner: whether it was passed there nobody knows.
    turning : ndarray, shape (l,)
        Times of the samples at which the motion turns.
    """

    time: Real
    value: Real
    speed: Real
    push: Real
    leaving: Real
    arriving: Real
    unsure: Real
    turning: Real

    @classmethod
    def of(cls, t: Real, x: Real) -> Between:
        """What samples (n,) at rising times tell.

        Examples
        --------
        >>> import numpy as np
        >>> t = np.linspace(0.0, 1.0, 21)
        >>> motion = Between.of(t, np.sin(2.0 * np.pi * t))
        >>> dense = motion.at(np.linspace(0.0, 1.0, 41))
        >>> bool(np.max(np.abs(dense.value - np.sin(2.0 * np.pi * dense.time))) < 2e-3)
        True
        """
        push, step = acceleration(t, x), np.diff(t)
        slope = np.diff(x) / step
        smooth = np.zeros(len(step), dtype=bool)
        corners = nearest = np.zeros(0, dtype=int)
        if len(t) < FEWEST_AT_CORNER:
            speed = exact = np.gradient(x, t)
        else:
            smooth = _smooth(t, x)
            corners, nearest = _turns(np.diff(slope))
            speed, exact = _speeds(t, x, slope, corners)
        # The differences about a corner tell of it alone.
        for corner in corners:
            smooth[max(corner - 2, 0) : corner + 3] = False
        both = np.flatnonzero(smooth[1:] & smooth[:-1]) + 1
        speed[both] = exact[both]
        leaving, arriving = np.where(smooth, speed[:-1], slope), np.where(smooth, speed[1:], slope)
        # Of the second difference and that of the speeds the leading errors are as one to two.
        push[both] = 2.0 * push[both] - (speed[both + 1] - speed[both - 1]) / (
            step[both] + step[both - 1]
        )
        turning = _turning(slope, speed)
        whole = cls(t, x, speed, push, leaving, arriving, t[nearest], t[turning])
        return whole._cornered(corners, slope)

    def _cornered(self, after: NDArray[np.intp], slope: Real) -> Between:
        """The same with a knot where the straight ways on either side of a corner meet."""
        t, x = self.time, self.value
        one, other = slope[after - 1], slope[after + 1]
        length = t[after + 1] - t[after]
        way = (x[after + 1] - x[after] - other * length) / (one - other)
        inside = (way > APART * length) & (way < (1.0 - APART) * length)
        after, way, one, other = after[inside], way[inside], one[inside], other[inside]
        leaving, arriving = self.leaving.copy(), self.arriving.copy()
        leaving[after] = arriving[after] = one

        def knotted(column: Real, more: Real) -> Real:
            return np.insert(column, after + 1, more)

        return Between(
            knotted(t, t[after] + way),
            knotted(x, x[after] + way * one),
            knotted(self.speed, 0.5 * (one + other)),
            knotted(self.push, np.zeros(len(after))),
            knotted(leaving, other),
            knotted(arriving, other),
            self.unsure,
            self.turning,
        )

    def at(self, times: Real) -> Between:
        """The same with knots at these times (k,) too; at rest before the first and after the last.

        Parameters
        ----------
        times : ndarray, shape (k,)
            Rising.
        """
        grid = np.union1d(self.time, times)
        if len(grid) == len(self.time):
            return self
        known = np.isin(grid, self.time)
        within = (grid >= self.time[0]) & (grid <= self.time[-1])
        place = np.clip(np.searchsorted(self.time, grid, "right") - 1, 0, len(self.leaving) - 1)
        step = np.diff(self.time)[place]
        u = np.where(within, (grid - self.time[place]) / step, grid > self.time[-1])
        slope, a, c = (each[place] for each in self._shapes)
        # Integral of the speed, which is slope + a (2 u - 1) + c (6 u^2 - 6 u + 1).
        value = self.value[place] + step * u * (slope + (u - 1.0) * (a + c * (2.0 * u - 1.0)))
        speed = np.where(within, slope + a * (2.0 * u - 1.0) + c * (6.0 * u * (u - 1.0) + 1.0), 0.0)
        push = np.where(within, (2.0 * a + 6.0 * c * (2.0 * u - 1.0)) / step, 0.0)
        # The speed from either side at the new knots is one; at the old ones it stays.
        moving = within[1:] & within[:-1]
        leaving, arriving = np.where(moving, speed[:-1], 0.0), np.where(moving, speed[1:], 0.0)
        begins, ends = known[:-1] & moving, known[1:] & moving
        leaving[begins] = self.leaving[place[:-1][begins]]
        arriving[ends] = self.arriving[place[:-1][ends]]
        for column, old in ((value, self.value), (speed, self.speed), (push, self.push)):
            column[known] = old
        return Between(grid, value, speed, push, leaving, arriving, self.unsure, self.turning)

    def by_clock(self, time: Any) -> Between:
        """The same course where a clock shows these times (n,) at its knots; they may be complex.

        Between two knots the clock goes at one pace.
        """
        step = np.diff(self.time) / np.diff(time)
        pace = 0.5 * (np.append(step[:1], step) + np.append(step, step[-1:]))
        leaving, arriving = self.leaving * step, self.arriving * step
        return Between(
            time,
            self.value,
            self.speed * pace,
            self.push * pace**2,
            leaving,
            arriving,
            self.unsure,
            self.turning,
        )

    @property
    def _shapes(self) -> tuple[Real, Real, Real]:
        """Of each interval (n - 1,) the mean speed and its shares in Legendre's P_1 and P_2."""
        slope = np.diff(self.value) / np.diff(self.time)
        return (
            slope,
            0.5 * (self.arriving - self.leaving),
            0.5 * (self.arriving + self.leaving) - slope,
        )

    @cached_property
    def changes(self) -> Real:
        """Into each knot, (n, 3): the change, and the shares in P_1 and P_2 times the step."""
        step = np.diff(self.time)[:, None]
        return np.vstack([np.zeros(3), np.column_stack(self._shapes) * step])

    @property
    def impulse(self) -> Real:
        """Integral (n,) from the first knot on of what is beyond the first value."""
        more = self.value - self.value[0]
        mean = 0.5 * (more[1:] + more[:-1]) - self.changes[1:, 1] / 6.0
        return np.concatenate([[0.0], np.cumsum(np.diff(self.time) * mean)])


def _turning(slope: Real, speed: Real) -> NDArray[np.intp]:
    """Samples (k,) at which a motion turns, of which noise is no part.

    That turns with every other step, and a motion goes some steps each way.
    """
    way, k = np.sign(slope), STEPS_OF_A_WAY
    # Beyond its ends it goes on as it went there.
    ways = np.lib.stride_tricks.sliding_window_view(np.pad(way, k - 1, mode="edge"), 2 * k)
    before, after = ways[:, :k].sum(axis=1), ways[:, k:].sum(axis=1)
    turns = (np.abs(before) == k) & (after == -before)
    # At an end only the bend of the motion tells that it has just turned, or is about to.
    ends = np.array([way[0] * speed[0] < 0.0, way[-1] * speed[-1] < 0.0])
    return np.concatenate([1 + np.flatnonzero(turns), np.array([0, len(way)])[ends]])


def velocity(t: Any, x: Any) -> Any:
    """First derivative (n,) from differences, as a dashpot feels it.

    By central differences, freed of their leading error where neighbours agree how the motion bends
    (van Leer 1974, doi:10.1016/0021-9991(74)90019-9), as that alone is 1 % of a sine of 25 samples
    a cycle. Where the motion turns sharply between two samples, each has the slope of its own side:
    a difference across the corner would mix two speeds, neither of which is felt there.
    """
    if len(t) < FEWEST_AT_CORNER:
        return np.gradient(x, t)
    slope = np.diff(x) / np.diff(t)
    corners, _ = _turns(np.diff(slope).real)
    return _speeds(t, x, slope, corners)[0]


def _speeds(t: Any, x: Any, slope: Any, corners: NDArray[np.intp]) -> tuple[Any, Any]:
    """That derivative (n,) of what has corners, and by five samples that of what is smooth."""
    moving, step = np.gradient(x, t, edge_order=2), np.diff(t)
    before, after = _third(t, x)
    alike = (before * after).real > 0.0
    third = np.zeros_like(before)
    third[alike] = 2.0 * (before * after)[alike] / (before + after)[alike]
    exact = moving.copy()
    exact[1:-1] -= 0.5 * (before + after) * step[:-1] * step[1:] / 6.0
    moving[1:-1] -= third * step[:-1] * step[1:] / 6.0
    moving[corners], moving[corners + 1] = slope[corners - 1], slope[corners + 1]
    # The three samples at an end tell its speed only where there is no corner among them.
    if 1 in corners:
        moving[0] = slope[0]
    if len(t) - 3 in corners:
        moving[-1] = slope[-1]
    return moving, exact


def _third(t: Any, x: Any) -> tuple[Any, Any]:
    """Third derivative (n - 2,) about each sample between the ends, from either side."""
    step = np.diff(t)
    curved = 2.0 * np.diff(np.diff(x) / step) / (step[1:] + step[:-1])
    change = np.diff(curved) / step[1:-1]
    # At the two samples beside the ends there is one neighbour to ask.
    return np.concatenate([change[:1], change]), np.concatenate([change, change[-1:]])


def acceleration(t: Any, x: Real) -> Any:
    """Second derivative (n,) from differences, as a mass feels it.

    At the ends that of the next sample.
    """
    # A second difference needs three samples.
    if len(t) < 3:
        return np.zeros(len(t))
    slope, step = np.diff(x) / np.diff(t), np.diff(t)
    inner = 2.0 * np.diff(slope) / (step[1:] + step[:-1])
    return np.concatenate([inner[:1], inner, inner[-1:]])


def _smooth(t: Real, x: Real) -> NDArray[np.bool_]:
    """In which intervals (n - 1,) the differences about it fall with their order.

    Those of what is smooth do by omega h; those of noise, of digits and of corners grow.
    """
    step = np.diff(t)
    mean = 0.5 * (step[1:] + step[:-1])
    curved = np.diff(np.diff(x) / step) / mean
    second, third = (curved * mean**2) ** 2, (np.diff(curved) * step[1:-1] ** 2) ** 2
    # Of an interval the second differences at four samples, and the third ones on either side of
    # each.
    about = np.convolve(second, np.ones(4))[1:-1]
    among = np.convolve(third, np.ones(5))[1:-1]
    # What bends all along may be sampled coarsely: a sine by six samples a cycle, of which the
    # ratio is 1.25. Of a corner, which has half or more of the bend about it, it is one to two, and
    # of noise four.
    near = np.lib.stride_tricks.sliding_window_view(np.pad(second, 3), 6)
    limit = np.where(near.max(axis=1) < 0.45 * near.sum(axis=1), 2.0, 1.0)
    return np.asarray(among < limit * about)


def _turns(bend: Real) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Intervals (k,) within which a motion turns sharply, and the samples (m,) next to corners.

    Of what it bends at each sample between the ends (n - 2,). Of a corner that is nearly at a
    sample the interval is unknown.
    """
    if len(bend) < 2:
        return np.zeros(0, dtype=int), np.zeros(0, dtype=int)
    # The two bends of one corner have one sign.
    here, there = bend[:-1], bend[1:]
    lesser = np.where(here * there > 0.0, np.minimum(np.abs(here), np.abs(there)), 0.0)
    far = np.concatenate([np.zeros(2), np.abs(bend), np.zeros(2)])
    beside = np.maximum(np.maximum(far[:-5], far[1:-4]), np.maximum(far[4:-1], far[5:]))
    # Digits bend what is straight, now here and now there: a corner is more than what is usual.
    usual = np.maximum(beside, np.median(np.abs(bend)))
    sharp = np.abs(here + there) > np.maximum(SHARP * usual, ALIKE * np.max(np.abs(bend)))
    within = sharp & (lesser > beside)
    nearest = np.where(np.abs(here) >= np.abs(there), 1, 2) + np.arange(len(here))
    near, last = set(nearest[sharp].tolist()), len(bend) + 1
    told = set(nearest[within].tolist())
    # With one straight way only, that before or after it, it may be anywhere up to the end.
    near |= {end for end, inner in ((0, 1), (last, last - 1)) if inner in near - told}
    return 1 + np.flatnonzero(within), np.array(sorted(near), dtype=int)
