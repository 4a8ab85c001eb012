"""What harmonics hide: forces that are not the same on both sides of the middle."""

from __future__ import annotations

from typing import Any

import numpy as np

from springpot.measurement import Record, TimeTest
from springpot.rheology import (
    AMPLITUDE,
    Answered,
    AppliesTo,
    Dimension,
    Effect,
    Parameter,
    StageLaw,
    on_response,
    stiffness,
)

SOFTEST = 0.3
"""Stiffness of a stop at the start of the search, over that of the specimen.

Much softer ones go unnoticed.
"""
TO_THAT_SIDE = 0.05
"""Share of the largest motion from which it goes to a side at all, and can meet a stop there."""
PLACES = (0.1, 0.3, 0.5, 0.7, 0.85, 0.95)
"""Shares of the way, to either side, at which a stop is sought."""
DRAG = Dimension(stiffness=1, time=1)
ASYMMETRY = Dimension(stiffness=1, amplitude=-1)


def stopped(record: Record, response: Any, k: Any, place: Any) -> Answered:
    """The response and a spring touched beyond a place, on that side of the middle alone."""
    # The place itself says on which side the stop stands, so that a search may move it across the
    # middle.
    side = 1.0
    if place < 0.0:
        side = -1.0
    into = np.maximum(side * (record.imposed - place), 0.0) * side
    return Answered(
        response + k * into, (into, np.where(into != 0.0, -k, 0.0)), np.ones_like(response)
    )


def leaned(record: Record, response: Any, k2: Any) -> Answered:
    """The response and a force quadratic in the displacement: even harmonics alone."""
    return Answered(response + k2 * record.imposed**2, (record.imposed**2,), np.ones_like(response))


def damped(record: Record, response: Any, c2: Any) -> Answered:
    """The response and a force by the size of the speed: more drag one way than the other."""
    speed = np.abs(record.rate)
    return Answered(response + c2 * speed, (speed,), np.ones_like(response))


def _moves(test: TimeTest) -> bool:
    """Whether there is a motion to hit something with, rather than a step."""
    return test.kind in ("history", "startup", "recovery") and not len(test.loading.jumps[0])


def _places(test: TimeTest) -> tuple[tuple[float, float], ...]:
    value = test.loading.value
    size = float(np.abs(test.response).max() / np.abs(value).max())
    up, down = max(float(value.max()), 0.0), min(float(value.min()), 0.0)
    ends = [end for end in (up, down) if abs(end) > TO_THAT_SIDE * np.abs(value).max()]
    return tuple((SOFTEST * size, share * end) for end in ends for share in PLACES)


EFFECTS = (
    Effect(
        "asymmetric-stop",
        on_response,
        StageLaw(
            stopped,
            (
                stiffness("k"),
                Parameter("place", "x_0", AMPLITUDE, -np.inf, scale="linear", typical=0.5),
            ),
            _places,
        ),
        "a stop on one side: beyond a place the motion meets a spring that is not there on the"
        " other side",
        citation="Gelb and Vander Velde, Multiple-Input Describing Functions, 1968",
        applies_to=AppliesTo(("displacement",), _moves),
        signature="a corner of the loop at one end of the motion alone; even harmonics and a mean"
        " force",
        aliases=("one-sided-stop",),
    ),
    Effect(
        "asymmetric-stiffness",
        on_response,
        StageLaw(leaned, (Parameter("k2", "k₂", ASYMMETRY, -np.inf, scale="linear"),)),
        "stiffer on one side than on the other, as after a preload: a force as the square of the"
        " displacement",
        citation="Nayfeh and Mook, Nonlinear Oscillations, 1979",
        applies_to=AppliesTo(("displacement",), _moves),
        signature="one half of the loop is steeper than the other; even harmonics and a mean force,"
        " nothing"
        " in the first one",
        prior=0.5,
    ),
    Effect(
        "asymmetric-damping",
        on_response,
        StageLaw(damped, (Parameter("c2", "c₂", DRAG, -np.inf, scale="linear"),)),
        "more drag one way than the other, as a damper with a valve each for bump and rebound",
        citation="Dixon, The Shock Absorber Handbook, 2007",
        applies_to=AppliesTo(("displacement",), _moves),
        signature="one side of the loop is fuller than the other, most where the speed is highest",
        aliases=("bump-and-rebound",),
        prior=0.5,
    ),
)
