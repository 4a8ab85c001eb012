"""Laws in time of what is not linear, or belongs to the signals; see `Formula.in_time`."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

from .points import Real
from .terms import driven

Law: TypeAlias = tuple[Any, tuple[Any, ...]]


def friction(t: Real, x: Real, v: Real, force: float) -> Law:
    """F sgn(v)."""
    direction = np.sign(v)
    return force * direction, (direction,)


def jenkins(t: Real, x: Real, v: Real, k: float, force: float) -> Law:
    """A spring that slips at the force F: exact for a path that is straight between its samples.

    Notes
    -----
    The force remembers its last reversal only, so that each run in one direction is one vectorised
    step.
    """
    slider, by_k, by_force = np.zeros(len(x)), np.zeros(len(x)), np.zeros(len(x))
    # From one reversal to the next the path goes one way, and is one step.
    moves = np.sign(np.diff(x))
    turns = np.flatnonzero(np.diff(moves) != 0.0) + 1
    for first, last in zip([0, *turns], [*turns, len(x) - 1], strict=True):
        run = slice(first + 1, last + 1)
        way = x[run] - x[first]
        free = slider[first] + k * way
        slips = np.abs(free) > force
        slider[run] = np.clip(free, -force, force)
        by_k[run] = np.where(slips, 0.0, by_k[first] + way)
        by_force[run] = np.where(slips, np.sign(free), by_force[first])
    return slider, (by_k, by_force)


def jenkins_step(before: float, way: float, k: float, force: float) -> float:
    """Force of the same after one more straight way."""
    return min(max(before + k * way, -force), force)


def power_law(t: Real, x: Real, v: Real, force: float, exponent: float) -> Law:
    """F |v|^a sgn(v)."""
    speed = np.abs(v)
    moving = speed > 0.0
    # At rest there is no logarithm; the sign of the speed is zero there, so that any number will
    # do.
    log_speed = np.log(np.where(moving, speed, 1.0))
    unit = np.sign(v) * np.exp(exponent * log_speed)
    return force * unit, (unit, force * unit * log_speed)


def cubic_spring(t: Real, x: Real, v: Real, k3: float) -> Law:
    """k3 x^3."""
    return k3 * x**3, (x**3,)


def cubic_dashpot(t: Real, x: Real, v: Real, c3: float) -> Law:
    """c3 v^3."""
    return c3 * v**3, (v**3,)


def dead_zone(t: Real, x: Real, v: Real, k: float, b: float) -> Law:
    """K times the way beyond the gap."""
    beyond = np.sign(x) * np.maximum(np.abs(x) - b, 0.0)
    return k * beyond, (beyond, np.where(np.abs(x) > b, -k * np.sign(x), 0.0))


def delay(t: Real, signals: Real, tau: float) -> Law:
    """Each signal tau later; before the record begins, and after its end, it stands still."""
    late = np.stack([np.interp(t - tau, t, column) for column in signals.T], axis=-1)
    # The derivative by the delay is minus the rate of what is delayed.
    rate = np.gradient(signals[:, 0], t)
    return late, (-np.interp(t - tau, t, rate),)


def gain(t: Real, signals: Real, g: float) -> Law:
    """1 + g times each signal."""
    return (1.0 + g) * signals, (signals[:, 0],)


def one_filter(t: Real, signals: Real, tau: float) -> Law:
    """First-order filter of the force (tau > 0), or of the displacement (tau < 0).

    Then the force seems to lead.
    """
    if tau <= 0.0:
        rate = np.gradient(signals, t, axis=0)
        return signals - tau * rate, (-rate[:, 0],)
    steps, size = np.diff(t, prepend=t[0]), signals.shape[1]
    one, none = np.ones((1, 1)), np.zeros((1, 1))
    rates = np.array([1.0 / tau])
    changes = np.diff(signals, axis=0, prepend=signals[:1])
    # What a filter lags behind is a mode that the signal drives: the same exact recursion as of a
    # material.
    behind = [driven(rates, steps, changes[:, i], one, none)[:, 0] for i in range(size)]
    slope = driven(rates, steps, changes[:, 0], none, one)[:, 0] / tau**2
    return signals - np.stack(behind, axis=-1), (slope,)
