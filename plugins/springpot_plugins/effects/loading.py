"""What was imposed is not what reached the specimen.

A step that took time, play in a joint, a bearing that holds.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from springpot.measurement import Loading, TimeTest
from springpot.rheology import (
    AMPLITUDE,
    FORCE,
    AppliesTo,
    Effect,
    Parameter,
    Real,
    StageLaw,
    on_loading,
    relaxation_time,
)

FEWEST = 21
"""Samples of an imposed history from which play in it is looked for."""


def ramped(loading: Loading, tau: Any) -> tuple[Loading, tuple[Loading]]:
    """Each step as a ramp of tau seconds; the derivative by tau is a ramp down and a jump back."""
    # Only jumps become ramps: what was recorded in between is followed as it was.
    when, sizes = loading.jumps
    smooth = loading.smooth
    corners = [when, when + tau]
    if smooth is not None:
        corners.append(smooth.time)
    time = np.unique(np.concatenate(corners))
    share = np.clip((time[:, None] - when) / tau, 0.0, 1.0)
    rest: Real | float = 0.0
    if smooth is not None:
        rest = np.interp(time, smooth.time, smooth.value)
    bent = Loading(time, rest + share @ sizes)
    ends = np.stack([when, when + tau, when + tau], axis=1).ravel()
    back = np.stack([0.0 * sizes, -sizes / tau, 0.0 * sizes], axis=1).ravel()
    order = np.argsort(ends, kind="stable")
    if len(when) == 1:
        # Ramps of several steps may overlap, those of one do not.
        return bent, (Loading(ends[order], back[order]),)
    return bent, (_summed(when, -sizes / tau, tau),)


def _summed(when: Real, depths: Real, tau: float) -> Loading:
    """The sum of ramps from nothing to `depths` in tau seconds that then jump back, one a step."""
    time = np.repeat(np.unique(np.concatenate([when, when + tau])), 2)
    since = (time[:, None] - when) / tau
    after = np.arange(len(time)) % 2 == 1
    # At its own end a ramp is all there just before, and nothing just after.
    ends = np.isclose(since, 1.0, rtol=0.0, atol=1e-12)
    there = np.where(ends, ~after[:, None], (since > 0.0) & (since < 1.0))
    return Loading(time, (np.where(there, since, 0.0)) @ depths)


def held_back(loading: Loading, reach: Any) -> tuple[Loading, tuple[Loading]]:
    """What follows a value at a distance of at most `reach`, as the far end of a joint's play."""
    x, behind, slope = loading.value, np.empty(len(loading.value)), np.zeros(len(loading.value))
    moves = np.sign(np.diff(x))
    turns = np.flatnonzero((moves[1:] != moves[:-1]) & (moves[1:] != 0.0)) + 1
    behind[0] = x[0]
    # Between two turns the load moves one way, so that no sample has to wait for the one before it.
    for first, last in zip([0, *turns], [*turns, len(x) - 1], strict=True):
        run = slice(first + 1, last + 1)
        way = 1.0
        if x[last] < x[first]:
            way = -1.0
        pulled = way * x[run] - reach > way * behind[first]
        behind[run] = np.where(pulled, x[run] - way * reach, behind[first])
        slope[run] = np.where(pulled, -way, slope[first])
    return Loading(loading.time, behind), (Loading(loading.time, slope),)


def _stepped(test: TimeTest) -> bool:
    return len(test.loading.jumps[0]) > 0


def _returns(test: TimeTest) -> bool:
    """Whether the load turns back: while it only rises, one that is held back is a smaller one."""
    moves = np.sign(np.diff(test.loading.value))
    return bool(np.any(moves > 0.0) and np.any(moves < 0.0))


def _rough(test: TimeTest) -> bool:
    return not _stepped(test) and len(test.loading.time) >= FEWEST and _returns(test)


EFFECTS = (
    Effect(
        "finite-ramp",
        on_loading,
        StageLaw(ramped, (relaxation_time("rise"),)),
        "the step was no step: it took some time, in a straight line",
        citation="Boltzmann's superposition; Zapas and Phillips 1971, doi:10.6028/jres.075A.005",
        applies_to=AppliesTo(suits=_stepped),
        signature="early, up to some ten times the rise: a relaxation begins lower, a creep later",
        aliases=("slow-step",),
    ),
    Effect(
        "backlash-in-time",
        on_loading,
        StageLaw(held_back, (Parameter("b", "b", AMPLITUDE, typical=0.3),)),
        "a joint with play of b on either side: after each turn the specimen rests until the play"
        " is taken up",
        citation="Visintin, Differential Models of Hysteresis, 1994",
        applies_to=AppliesTo(("displacement",), _rough),
        signature="flat pieces after each turn of the motion, and a smaller loop",
        aliases=("play-in-time",),
    ),
    Effect(
        "bearing-friction",
        on_loading,
        StageLaw(held_back, (Parameter("F", "F", FORCE, typical=0.1),)),
        "the bearing holds up to a force F: what was imposed reaches the specimen less that",
        citation="Coulomb's friction; the specimen follows its load without overshoot",
        applies_to=AppliesTo(("force",), _returns),
        signature="after the load is taken off, the specimen comes back less, and stops early",
    ),
)
