"""Which test of a damper would narrow the band of the structure's drift most.

The drift follows what is not known of a damper along the principal axes of its fit's covariance; a
further test adds its Fisher information to that covariance. What could be measured is what the
diagnosis offers as a next experiment, with a noise like that of the fit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import inf

import numpy as np

from springpot.diagnosis.experiment import ACTION, Action, actions, planned_sweep
from springpot.errors import ModelError
from springpot.identification.prediction import Known
from springpot.misfit.residuals_of_tests import SweepPart
from springpot.plain_data import Plain
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL

from ..distributions import student
from .damper import axes_of, sizes_of
from .frame import Frame
from .motion import GroundMotion, motion_of

WIDE = student(INTERVAL, inf)
"""Standard deviations of half a band."""


@dataclass(frozen=True, eq=False)
class FurtherTest(Plain):
    """A test of a damper, and what it would do to the drift.

    Attributes
    ----------
    damper : int
        Which one, 1 for the first entry; others of the same fit gain as well.
    says : str
        What to measure.
    half_width : float
        Half of the band of the drift in m after it.
    point : float
        Of its frequencies in Hz the one that alone would do most.
    action : dict
        Conditions of the test in numbers, as in `springpot.diagnosis`.
    """

    damper: int
    says: str
    half_width: float
    point: float
    action: dict[str, list[float]] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class FurtherTests(Plain):
    """What could be measured of the dampers, the most telling first.

    Attributes
    ----------
    storey : int
        Whose drift has the widest band.
    half_width : float
        Half of that band in m now.
    tests : list of FurtherTest
        By the band that they leave.
    """

    storey: int
    half_width: float
    tests: list[FurtherTest]


def further_tests(frame: Frame, records: Sequence[GroundMotion]) -> FurtherTests:
    """The tests of its dampers, ranked by the band of the drift that they leave.

    Parameters
    ----------
    frame : Frame
        With dampers from fits of sweeps.
    records : sequence of GroundMotion
        The drift is the mean of the largest under each.

    Raises
    ------
    ModelError
        If no damper has parameters that are uncertain, from the fit of a sweep.
    """
    fits: dict[int, tuple[int, Known]] = {}
    for i, damper in enumerate(frame.dampers, 1):
        if damper.tested is not None:
            fits.setdefault(id(damper.tested), (i, damper.tested))
    if not any(known.sweep is not None for _, known in fits.values()):
        raise ModelError(
            "no damper is from the fit of a sweep: what is not known of one is what a further test"
            " would narrow"
        )
    moves = {key: _moves(frame, records, key) for key in fits}
    # Each fit adds its own variance; a test of one lowers that part alone.
    variance = np.sum([np.sum(each**2, axis=0) for each in moves.values()], axis=0)
    storey = int(np.argmax(variance))
    ranked = [
        test
        for key, (i, known) in fits.items()
        for test in _of_one(known, i, moves[key][:, storey], float(variance[storey]))
    ]
    ranked.sort(key=lambda test: test.half_width)
    return FurtherTests(storey + 1, WIDE * float(np.sqrt(variance[storey])), ranked)


def _moves(frame: Frame, records: Sequence[GroundMotion], source: int) -> Real:
    """What one standard deviation along each axis of a fit does to the drifts in m, (q, n)."""
    members = [i for i, damper in enumerate(frame.dampers) if id(damper.tested) == source]
    count = frame.dampers[members[0]].axes.shape[1]

    def drifts(along: Real) -> Real:
        moved = [
            damper.moved(along) if i in members else damper
            for i, damper in enumerate(frame.dampers)
        ]
        there = Frame(frame.mass, frame.stiffness, frame.damping, tuple(moved))
        peaks = [motion_of(there, record).peak_drift for record in records]
        return np.asarray(np.mean(peaks, axis=0))

    # Over the width that the band has, not an endless slope: it bends within it.
    return np.array([0.5 * (drifts(axis) - drifts(-axis)) for axis in np.eye(count)])


def _of_one(known: Known, damper: int, moves: Real, variance: float) -> Iterator[FurtherTest]:
    """What could be measured of one damper."""
    if known.sweep is None:
        return
    rest = variance - float(moves @ moves)
    best, closest = np.inf, None
    for action in actions(known.sweep):
        # Another specimen, or none, has no part in this one's uncertainty.
        if action.scale != 1.0:
            continue
        seen = _seen(known, action)
        left = [_left(moves, rows) for rows in np.split(seen, len(seen) // 2)]
        point = int(np.argmin(left))
        whole = WIDE * np.sqrt(rest + _left(moves, seen))
        yield FurtherTest(damper, action.says, float(whole), _hertz(action, point), action.action)
        if left[point] < best:
            best, closest = left[point], (action, point, seen[2 * point : 2 * point + 2])
    if closest is None:
        return
    action, point, rows = closest
    # All at the one frequency that tells most.
    whole = WIDE * np.sqrt(rest + _left(moves, np.sqrt(ACTION.points / action.repeats) * rows))
    hertz = _hertz(action, point)
    told = {name: values for name, values in action.action.items() if len(values) == 1}
    where = ", ".join(f"{name} {value[0]:.3g}" for name, value in told.items() if name != "repeats")
    says = f"measure {ACTION.points} times at {hertz:.3g} Hz" + (f" ({where})" if where else "")
    told |= {"omega": [2.0 * np.pi * hertz], "repeats": [float(ACTION.points)]}
    yield FurtherTest(damper, says, float(whole), hertz, told)


def _hertz(action: Action, point: int) -> float:
    return float(np.exp(action.points.log_omega[point]) / (2.0 * np.pi))


def _left(moves: Real, seen: Real) -> float:
    """Variance of the drift after a test that sees the axes (q,) by the rows of (m, q)."""
    information = np.eye(len(moves)) + seen.T @ seen
    return float(moves @ np.linalg.solve(information, moves))


def _seen(known: Known, action: Action) -> Real:
    """Slopes (2 n, q) of K' and K'' of each point along the axes of the fit, over their noise."""
    sweep, model, theta = known.sweep, known.model, known.theta
    assert sweep is not None
    made = SweepPart(sweep)
    if sweep.sd is None:
        made = made.with_sd(known.misfit * made.size)
    plan = planned_sweep(action, made, known)
    slopes = plan.answer(model, theta, known.reference, np.arange(len(plan.measured))).by_theta
    axes = sizes_of(model, theta)[:, None] * axes_of(model, theta, known.theta_covariance)
    seen = slopes / plan.sd[:, None] @ axes
    return np.reshape(seen.reshape(2, -1, axes.shape[1]).swapaxes(0, 1), seen.shape)
