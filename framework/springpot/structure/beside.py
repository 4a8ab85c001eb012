"""What in a damper is not linear, step by step: friction, a slider, a stop, a power of the speed.

Each is followed for what it is. Within a step each such force is constant. It is taken in the
middle of the step, that of a slider as it moves along. Where a force jumps as the motion turns (dry
friction), the damper sticks if a force between the ends of the jump brings it to rest at the end of
the step: a jump is no steep slope, and what sticks does not creep (Moreau 1988, Unilateral contact
and dry friction in finite freedom dynamics, doi:10.1007/978-3-7091-2624-0_1).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from springpot.rheology.points import Real

from ..numerics import MOST_STEPS, NEGLIGIBLE, ROUNDING
from .damper import Damper

CLOSE = 1e-7
"""Relative change of the forces at which they are found.

Far below what the length of a step changes.
"""
CALM = 8
"""Rounds after which only half of a change is taken, and so on.

Near rest a power of the speed may be steep.
"""
SWEEPS = 200
"""Over the dampers that stick.

Those of neighbouring storeys feel each other by half, so that each sweep halves.
"""


class Beside:
    """The forces of one entry of dampers that are not linear.

    Parameters
    ----------
    damper : Damper
        With such effects.
    """

    def __init__(self, damper: Damper) -> None:
        self.along = damper.cosine / damper.length
        # The cosine of the way is in `along` already: here is that of the force.
        self.size = damper.count * damper.cosine * damper.unit * damper.length
        self.laws: list[tuple[Any, list[float]]] = []
        self.sliders: list[tuple[Callable[..., float], list[float]]] = []
        for effect, theta in damper.beside:
            # A slider remembers its force; any other law is told by the motion of the moment.
            slides = getattr(effect.element, "step", None)
            if slides is None:
                self.laws.append((effect.element, theta.tolist()))
            else:
                self.sliders.append((slides, theta.tolist()))
        self.carried = [0.0] * len(self.sliders)
        # Asked on either side of rest: what differs there by more than a slope could is a jump.
        back, on = self._pointwise(0.0, -ROUNDING), self._pointwise(0.0, ROUNDING)
        self.jumps = on - back > NEGLIGIBLE * (
            self._pointwise(0.0, 1.0) - self._pointwise(0.0, -1.0)
        )

    def _pointwise(self, way: float, speed: float) -> float:
        """Force in the damper's own units, of all laws that remember nothing."""
        now, here, fast = np.zeros(1), np.array([way]), np.array([speed])
        force = 0.0
        for element, theta in self.laws:
            value, _ = element.in_time(now, here, fast, *theta)
            force += float(value[0])
        return force

    def _slid(self, way: float) -> list[float]:
        """Forces of the sliders after a way within the step."""
        pairs = zip(self.sliders, self.carried, strict=True)
        return [slides(before, way, *theta) for (slides, theta), before in pairs]

    def ends(
        self, start: float, end: float, start_speed: float, end_speed: float
    ) -> tuple[float, float]:
        """Least and largest force in N along the floor in a step; where nothing jumps they are one.

        Parameters
        ----------
        start, end : float
            Drift in m at both ends of the step.
        start_speed, end_speed : float
            In m/s.
        """
        # In the middle of the step: the error then falls with the square of its length.
        way, speed = 0.5 * self.along * (start + end), 0.5 * self.along * (start_speed + end_speed)
        slid = 0.5 * sum(self.carried) + 0.5 * sum(self._slid(self.along * (end - start)))
        if not self.jumps:
            force = self.size * (self._pointwise(way, speed) + slid)
            return force, force
        back, on = (
            self._pointwise(way, min(speed, -ROUNDING)),
            self._pointwise(way, max(speed, ROUNDING)),
        )
        return self.size * (back + slid), self.size * (on + slid)

    def move(self, way: float) -> None:
        """Let a step be over, in which the drift changed by so much."""
        self.carried = self._slid(self.along * way)


def forces(
    besides: Sequence[Beside],
    start: tuple[Real, Real],
    free: tuple[Real, Real],
    by_force: tuple[Real, Real],
    guess: Real,
) -> Real:
    """The forces (q,) in N of a step, at which motion and laws agree.

    Parameters
    ----------
    besides : sequence of Beside
        The q dampers.
    start, free : tuple of ndarray, shape (q,)
        Drifts and their speeds at the beginning of the step, and at its end without these forces.
    by_force : tuple of ndarray, shape (q, q)
        What each force, constant in the step, changes of both at its end.
    guess : ndarray, shape (q,)
        Such as the forces of the step before.
    """
    (first, first_speed), (last, last_speed) = start, free
    way_by, speed_by = by_force
    force, share = guess, 1.0
    low, high = np.full(len(guess), np.nan), np.full(len(guess), np.nan)
    for turn in range(MOST_STEPS):
        end, end_speed = last + way_by @ force, last_speed + speed_by @ force
        motion = zip(
            besides,
            first.tolist(),
            end.tolist(),
            first_speed.tolist(),
            end_speed.tolist(),
            strict=True,
        )
        ends = np.array([beside.ends(*each) for beside, *each in motion])
        size = np.abs(ends).max()
        # In the first round there is nothing to compare with.
        if turn and np.abs(ends - np.column_stack([low, high])).max() <= CLOSE * size:
            break
        if turn >= CALM:
            share *= 0.9
            ends = share * ends + (1.0 - share) * np.column_stack([low, high])
        low, high = ends.T
        force = _at_rest_if_it_can(last_speed, speed_by, low, high, force)
    return force


def _at_rest_if_it_can(
    free_speed: Real, by_force: Real, low: Real, high: Real, force: Real
) -> Real:
    """Forces (q,) from `low` to `high` that bring each damper to rest, or as near as they can."""
    if np.array_equal(low, high):
        return low.copy()
    ends = list(zip(low.tolist(), high.tolist(), strict=True))
    now, matrix, speeds = force.tolist(), by_force.tolist(), free_speed.tolist()
    for _ in range(SWEEPS):
        change = 0.0
        for i, (row, (least, most)) in enumerate(zip(matrix, ends, strict=True)):
            others = speeds[i] + sum(a * b for a, b in zip(row, now, strict=True)) - row[i] * now[i]
            # One damper after the other, each at rest beside what the others do now (Gauss and
            # Seidel).
            stopping = min(max(-others / row[i], least), most)
            change = max(change, abs(stopping - now[i]))
            now[i] = stopping
        # One damper alone is at rest at once: there is no neighbour that moves it again.
        if len(now) == 1 or change <= CLOSE * max(map(abs, now)):
            break
    return np.array(now)
