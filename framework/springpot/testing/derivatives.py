"""Random lawful parameters, and derivatives to be compared with the exact ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from springpot.rheology.parameters import Parameter
from springpot.rheology.points import Real

EIGHTH_ORDER = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
"""Central differences: weights of f(x + i h) - f(x - i h) for i = 1 ... 4."""
STEPS = np.array([1, 2, 3, 4, -1, -2, -3, -4])
ROOTS = np.exp(2j * np.pi * np.arange(16) / 16)


def sample(
    parameters: Sequence[Parameter], rng: np.random.Generator, shape: tuple[int, ...] = ()
) -> Real:
    """Random parameters well inside their bounds.

    Parameters
    ----------
    parameters : sequence of Parameter
        The p parameters.
    rng : numpy.random.Generator
        Source of randomness.
    shape : tuple of int
        Leading axes.

    Returns
    -------
    ndarray, shape (*shape, p)
    """
    columns = []
    for parameter in parameters:
        if parameter.scale == "log":
            # A factor of e to either side, for such sizes are known by their decade.
            drawn = parameter.typical * np.exp(rng.uniform(-1.0, 1.0, shape))
        elif np.isfinite(parameter.upper) and np.isfinite(parameter.lower):
            # Clear of the ends, where a derivative has one side only.
            drawn = parameter.lower + (parameter.upper - parameter.lower) * rng.uniform(
                0.3, 0.9, shape
            )
        else:
            drawn = parameter.typical * rng.uniform(0.3, 0.9, shape)
        columns.append(np.clip(drawn, parameter.lower, parameter.upper))
    return np.stack(columns, axis=-1)


def derivative(function: Callable[[Any], Any], x: Real, reach: float = 0.01) -> Any:
    """Derivative of `function` by each entry of `x` (p,), on the last axis.

    The mean over a circle in the complex plane (Cauchy's integral) has no truncation error to speak
    of, unlike a finite difference. A function that is not analytic (it reads only the loss, say, or
    refuses complex numbers) is differenced along the real axis instead, to eighth order.

    Parameters
    ----------
    function : callable
        From (p,) to an array.
    x : ndarray, shape (p,)
        Where.
    reach : float
        Radius of the circle, or the step, relative to each entry.
    """
    centre = function(x)
    columns = []
    for i in range(len(x)):
        # A parameter of zero has no size to go by.
        radius = reach * (abs(x[i]) or 0.01)
        column = _around(function, x, i, radius, np.abs(centre))
        # What takes no complex numbers, or is not analytic, is told by real steps.
        if column is None:
            column = _difference(function, x, i, radius)
        columns.append(column)
    return np.stack(columns, axis=-1)


def _around(function: Callable[[Any], Any], x: Real, i: int, radius: float, size: Real) -> Any:
    try:
        values = _along(function, x, i, radius * ROOTS)
    except (TypeError, ValueError):
        return None
    # An analytic function does not change with the conjugate (Cauchy and Riemann).
    by_x, by_conjugate = (np.mean(values * turn, axis=-1) / radius for turn in (1 / ROOTS, ROOTS))
    analytic = np.all(np.abs(by_conjugate) < 1e-7 * (np.abs(by_x) + size))
    if not analytic:
        return None
    return by_x


def _difference(function: Callable[[Any], Any], x: Real, i: int, radius: float) -> Any:
    weights = np.concatenate([EIGHTH_ORDER, -EIGHTH_ORDER])
    return _along(function, x, i, radius * STEPS) @ weights / radius


def _along(function: Callable[[Any], Any], x: Real, i: int, steps: Any) -> Any:
    around = np.repeat(x[None].astype(np.result_type(steps, float)), len(steps), axis=0)
    around[:, i] += steps
    return np.stack([function(point) for point in around], axis=-1)
