"""Where in a test in time a model fails.

Between which times, and where in the loop of force and displacement.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from springpot.measurement.timetest import TimeTest
from springpot.rheology.points import Real
from springpot.thresholds import VERDICT

from ..numerics import FEWEST, rms
from .error import plain, times
from .where import Where

PIECES = 12
"""Parts of a record among which the place of the largest misfit is sought."""
EDGES = (-1.001, -0.8, -0.3, 0.3, 0.8, 1.001)
"""Of what was imposed over its largest size: two ends, two flanks and the middle of a loop."""
ENDS = (
    "at the lower end",
    "on the lower flank",
    "through the middle",
    "on the upper flank",
    "at the upper end",
)
ONE_SIDED = 3.0
"""Times by which one side of a loop must be missed more than its mirror image to be told alone."""
SLOW = 0.3
"""Share of the highest speed, single peaks apart, below which a motion turns."""
AFTER_TURN = 0.25
"""Share of a half cycle that is just after a turn."""
USUAL_TOP = 95
"""Percentile that stands for the highest speed: a single peak of the derivative is mostly noise."""
FLAT = 1e-3
"""Share of the largest response within which samples are level."""


def places(test: TimeTest, residual: Real) -> list[Where]:
    """Where a test is missed by more than noise, the worst first.

    Parameters
    ----------
    test : TimeTest
        The test.
    residual : ndarray, shape (n,)
        Predicted less measured, over the noise; nan where a sample says nothing.

    Returns
    -------
    list of Where
        In the plane ``signal``, the record itself over its time in s, or ``loop``, force over
        displacement, by shares of the largest value of what was imposed; the condition is the name
        of the test, and the size the root mean square of the misfit over the noise.
    """
    candidates = [_in_time(test, residual)]
    if test.kind in ("history", "recovery") and _goes_back(test):
        candidates.append(_in_loop(test, residual))
    missed = (place for place in candidates if place is not None)
    return sorted(
        (place for place in missed if place.size > VERDICT.agrees), key=lambda place: -place.size
    )


def _in_time(test: TimeTest, residual: Real) -> Where | None:
    # Of few samples some parts have none.
    told = np.flatnonzero(np.isfinite(residual))
    rows = [piece for piece in np.array_split(told, PIECES) if len(piece)]
    if not rows:
        return None
    sizes = [rms(residual[piece]) for piece in rows]
    worst = rows[int(np.argmax(sizes))]
    first, last = float(test.time[worst[0]]), float(test.time[worst[-1]])
    size = max(sizes)
    # Larger is further from nothing, whatever the sign of the response.
    way = float(np.mean(np.sign(test.response[worst]) * residual[worst]))
    side = "smaller"
    if way > 0.0:
        side = "larger"
    between = f"at {plain(first)} s"
    if len(worst) > 1:
        between = f"from {plain(first)} to {plain(last)} s"
    says = (
        f"{test.name} is missed most {between}, by {times(size)} the noise: "
        f"the model's {test.words[1]} is {side} there{_manner(test, residual)}"
    )
    return Where("signal", test.name, first, last, size, says)


def _speed(test: TimeTest) -> tuple[Real, NDArray[np.bool_]]:
    """The speed of what was imposed at the samples, and where it is slow."""
    imposed = np.interp(test.time, test.loading.time, test.loading.value)
    speed = np.gradient(imposed, test.time)
    # Friction and play show where a motion turns, what goes by the speed where it is fast.
    return speed, np.abs(speed) < SLOW * np.percentile(np.abs(speed), USUAL_TOP)


def _goes_back(test: TimeTest) -> bool:
    """Whether what was imposed goes both ways: without it nothing turns and no loop closes."""
    speed, slow = _speed(test)
    return {-1.0, 1.0} <= set(np.sign(speed[~slow]).tolist())


def _manner(test: TimeTest, residual: Real) -> str:
    """Whether a record is missed where its motion turns, or where it is fast."""
    if test.kind != "history":
        return ""
    _, slow = _speed(test)
    told = np.isfinite(residual)
    if not (slow & told).any() or not (~slow & told).any():
        return ""
    turning, moving = (float(np.mean(residual[rows & told] ** 2)) for rows in (slow, ~slow))
    if turning > VERDICT.agrees**2 * moving:
        return f"; all along, where the motion {'turns' if _goes_back(test) else 'is slow'}"
    if moving > VERDICT.agrees**2 * turning:
        return "; all along, where the motion is fast"
    return ""


def _in_loop(test: TimeTest, residual: Real) -> Where | None:
    """The part of the loop that is missed most, all cycles together."""
    imposed = np.interp(test.time, test.loading.time, test.loading.value)
    # All cycles on one loop: what fails in each of them at one place stands out.
    share = imposed / np.abs(test.loading.value).max()
    rising = np.gradient(imposed, test.time) >= 0.0
    sector, told = np.digitize(share, EDGES) - 1, np.isfinite(residual)
    sizes, counts = np.zeros((5, 2)), np.zeros((5, 2), dtype=int)
    for i in range(5):
        for j, way in enumerate((False, True)):
            rows = (sector == i) & (rising == way) & told
            counts[i, j] = int(rows.sum())
            if counts[i, j] >= FEWEST:
                sizes[i, j] = rms(residual[rows])
    if not np.any(counts >= FEWEST):
        return None
    i, j = divmod(int(np.argmax(sizes)), 2)
    # The mirror image of a loop: the other end, the other way.
    mirror = sizes[4 - i, 1 - j]
    alone = counts[4 - i, 1 - j] >= FEWEST and sizes[i, j] > ONE_SIDED * max(mirror, 1.0)
    ways = ("falling", "rising")
    says = f"in the loop of {test.name} the model fails most {ENDS[i]}, {test.words[0]} {ways[j]}"
    says += f", by {times(sizes[i, j])} the noise"
    if alone:
        says += f"; on that side alone, {times(mirror)} on the other"
    says += _after_turn(imposed, residual) + _flat(test)
    return Where(
        "loop", test.name, max(EDGES[i], -1.0), min(EDGES[i + 1], 1.0), float(sizes[i, j]), says
    )


def _after_turn(imposed: Real, residual: Real) -> str:
    """Whether a loop is missed just after its turns more than elsewhere."""
    moves = np.sign(np.diff(imposed))
    turns = np.flatnonzero(np.diff(moves) != 0.0) + 1
    if len(turns) < 3:
        return ""
    ends = np.append(turns[1:], len(imposed))
    fresh = np.zeros(len(imposed), dtype=bool)
    for first, last in zip(turns, ends, strict=True):
        fresh[first : first + max(2, int(AFTER_TURN * (last - first)))] = True
    told = np.isfinite(residual)
    if not (fresh & told).any() or not (~fresh & told).any():
        return ""
    if rms(residual[fresh & told]) > VERDICT.agrees * rms(residual[~fresh & told]):
        return "; just after each turn"
    return ""


def _flat(test: TimeTest) -> str:
    """Whether the record is level at its top, as one that was clipped."""
    size = np.abs(test.response)
    top = np.sort(size)[-max(5, len(size) // 50) :]
    if np.ptp(top) <= FLAT * size.max():
        return "; the record is level at its top"
    return ""
