"""A spring that yields by flowing: elastic below a force, at nearly that force beyond it.

A spring before a damper whose force goes as a small power of the speed. So a gel, an emulsion, a
field-responsive fluid or a pressed valve answers: as a solid at small amplitude, with a plateau of
force over the speed at large ones.
"""

from __future__ import annotations

from math import log, sqrt
from typing import Any

import numpy as np

from ..numerics import MOST_STEPS, ROUNDING
from .elements import spring
from .formula import Formula
from .nodes import FULL
from .nonlinear import NEEDS_AMPLITUDE, balanced_series, slip_film
from .parameters import FORCE, PURE, Parameter, stiffness
from .points import Points, Real

STAGE = 1.0 - sqrt(0.5)
"""Coefficient of Alexander's two implicit stages (1977, doi:10.1137/0714068).

They are of second order and damp whatever is fast.
"""
BALANCED = balanced_series(spring("k"), slip_film("F", "a"))


def _first_harmonic(at: Points, k: Any, force: Any, exponent: Any) -> Any:
    theta = np.concatenate(np.broadcast_arrays(k, force, exponent), axis=-1)
    response = BALANCED.respond(theta, at, FULL)
    return response.value, np.moveaxis(response.by_theta, -2, 0), response.by_log_omega


def _in_time(
    t: Real, x: Real, v: Real, k: float, force: float, exponent: float
) -> tuple[Real, tuple[Real, ...]]:
    """The force z of z' = k (v - sgn(z) |z / F|^(1/a)) from rest, and its derivatives."""
    power = 1.0 / exponent
    # The force, and what k, F and a do to it.
    state = [0.0, 0.0, 0.0, 0.0]
    answer = np.zeros((len(x), 4))
    for i, (step, way) in enumerate(zip(np.diff(t).tolist(), np.diff(x).tolist(), strict=True)):
        begun, rates = state, [0.0, 0.0, 0.0, 0.0]
        speed, held = way / step, STAGE * step
        # The second stage ends the step; it stands on the rates of the first.
        for share in (0.0, (1.0 - STAGE) * step):
            start = [each + share * rate for each, rate in zip(begun, rates, strict=True)]
            z = _flowed(start[0] + held * k * speed, held * k, force, power, state[0])
            flow, slope, bend = _flow(z, force, power)
            # Of the rate by k, by F and by a, the force being what it is.
            direct = (speed - flow, k * power * flow / force, k * power**2 * bend)
            whole = 1.0 + held * k * slope
            moved = [(start[j + 1] + held * direct[j]) / whole for j in range(3)]
            rates = [
                k * (speed - flow),
                *(each - k * slope * by for each, by in zip(direct, moved, strict=True)),
            ]
            state = [z, *moved]
        answer[i + 1] = state
    return answer[:, 0], tuple(answer[:, 1:].T)


def _flow(z: float, force: float, power: float) -> tuple[float, float, float]:
    """Speed at which a force z flows, and its slopes by z and by the power 1 / a."""
    size = abs(z) / force
    if size == 0.0:
        return 0.0, 0.0, 0.0
    speed = size**power
    slope, bend = power * speed / abs(z), speed * log(size)
    if z < 0.0:
        return -speed, slope, -bend
    return speed, slope, bend


def _flowed(free: float, share: float, force: float, power: float, near: float) -> float:
    """The force z of z + share * flow(z) = free, by Newton's method from one that is near."""
    size = abs(free)
    if size == 0.0:
        return 0.0
    # Either term alone is at most all: the smaller of both ends is beyond the solution.
    z: float = min(size, force * (size / share) ** (1.0 / power))
    if near * free > 0.0:
        z = min(z, abs(near))
    for _ in range(MOST_STEPS):
        flow = share * (z / force) ** power
        change = (z + flow - size) / (1.0 + power * flow / z)
        z -= change
        if abs(change) <= ROUNDING * size:
            break
    if free < 0.0:
        return -z
    return z


def yielding_spring(k: str = "k", force: str = "F", exponent: str = "a") -> Formula:
    """A spring before a damper of force F |v|^a: elastic below a force, flowing above it.

    The smaller a, the sharper it yields and the flatter its force lies over the speed; F is the
    force at a speed of one amplitude unit per second. In frequency by the balance of the first
    harmonics, which is up to a tenth off at a = 0.3, and a fifth at 0.1.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, yielding_spring
    >>> at = Points.at([1.0, 1.0], amplitude=[0.001, 10.0])
    >>> yielding_spring().respond(np.array([5.0, 1.0, 0.2]), at).value.round(2)
    array([5.  +0.j  , 0.01+0.19j])
    """
    free = (
        stiffness(k),
        Parameter(force, "F", FORCE),
        Parameter(exponent, "a", PURE, 0.05, 1.0, "linear", 0.3),
    )
    return Formula(
        free,
        _first_harmonic,
        NEEDS_AMPLITUDE,
        "yielding spring",
        in_time=_in_time,
        flows=True,
    )
