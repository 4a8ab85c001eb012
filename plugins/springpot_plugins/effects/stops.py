"""What harmonics hide: forces unlike on both sides of the middle, and a maximum on the way up."""

from __future__ import annotations

from typing import Any

import numpy as np

from springpot.measurement import Record, TimeTest
from springpot.rheology import (
    AMPLITUDE,
    VISCOSITY,
    Answered,
    AppliesTo,
    Dimension,
    Effect,
    Parameter,
    StageLaw,
    on_response,
    stiffness,
)

FEWEST = 8
"""Samples of a start-up from which a maximum on the way is looked for."""
FADINGS = (0.3, 1.0, 3.0, 10.0, 30.0, 100.0)
"""Exponents at the largest strain at which a fading network is sought."""
SMALLEST = 1e-9
"""Share of the largest strain that is no motion."""
SOFTEST = 0.3
"""Stiffness of a stop at the start of the search, over that of the specimen.

Much softer ones go unnoticed.
"""
TO_THAT_SIDE = 0.05
"""Share of the largest motion from which it goes to a side at all, and can meet a stop there."""
PLACES = (0.1, 0.3, 0.5, 0.7, 0.85, 0.95)
"""Shares of the way, to either side, at which a stop is sought."""
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


def disentangled(record: Record, response: Any, n: Any) -> Answered:
    """The stress at start-up of a network that fades with the strain, from that of a linear one.

    By K-BKZ with a damping function h the stress grows by G(t) d(gamma h) where that of a linear
    material grows by G(t) d gamma, so that each further strain counts by the slope of gamma h.
    """
    strain = np.abs(record.imposed)
    ends = np.concatenate([[0.0], strain])
    with np.errstate(under="ignore"):
        left = np.exp(-n * ends)
    step = np.diff(ends)
    moves = np.maximum(step, SMALLEST * strain.max())
    # Between two samples the mean of the slope, which is exact; where nothing moved, the slope.
    counts = np.where(
        step > moves * 0.5, np.diff(ends * left) / moves, (1.0 - n * strain) * left[1:]
    )
    by_n = np.where(
        step > moves * 0.5,
        np.diff(-(ends**2) * left) / moves,
        (n * strain**2 - 2.0 * strain) * left[1:],
    )
    grows = np.diff(response, prepend=0.0)
    later = np.append(counts[1:], 0.0)
    by_response = np.tril(np.broadcast_to(counts - later, (len(counts), len(counts))), -1)
    return Answered(
        np.cumsum(counts * grows), (np.cumsum(by_n * grows),), by_response + np.diag(counts)
    )


def _starts_up(test: TimeTest) -> bool:
    """Whether a motion began and went on: in a step a strain that fades is a smaller one."""
    return test.kind == "startup" and not len(test.loading.jumps[0]) and len(test.time) >= FEWEST


def _fadings(test: TimeTest) -> tuple[tuple[float], ...]:
    largest = float(np.abs(test.loading.value).max())
    return tuple((fading / largest,) for fading in FADINGS)


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
        StageLaw(damped, (Parameter("c2", "c₂", VISCOSITY, -np.inf, scale="linear"),)),
        "more drag one way than the other, as a damper with a valve each for bump and rebound",
        citation="Dixon, The Shock Absorber Handbook, 2007",
        applies_to=AppliesTo(("displacement",), _moves),
        signature="one side of the loop is fuller than the other, most where the speed is highest",
        aliases=("bump-and-rebound",),
        prior=0.5,
    ),
    Effect(
        "fading-network",
        on_response,
        StageLaw(
            disentangled, (Parameter("n", "n", Dimension(amplitude=-1), typical=0.3),), _fadings
        ),
        "a network that fades with the strain: at start-up the stress goes over a maximum, which no"
        " linear material's does",
        citation="Wagner 1976, doi:10.1007/BF01517505: h = exp(-n gamma) in the K-BKZ equation",
        applies_to=AppliesTo(("displacement",), _starts_up),
        signature="below the linear response from a strain on, whatever the rate; an overshoot",
        aliases=("overshoot",),
    ),
)
