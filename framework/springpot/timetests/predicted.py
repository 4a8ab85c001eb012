"""What a model answers to the loading of a test in time, with exact derivatives by its parameters."""

from __future__ import annotations

import numpy as np

from springpot.measurement import Loading, TimeTest
from springpot.rheology import InTime, Model, Real, Traced

from .warming import warming

TOLERANCE = 1e-6
"""Relative error of K for which the spectrum is read: a thousandth of the best transducer's noise."""


def predicted(
    model: Model,
    theta: Real,
    test: TimeTest,
    reference: float | None = None,
    at: Real | None = None,
    tolerance: float = TOLERANCE,
) -> Traced:
    """The response of a model to the loading of a test.

    Parameters
    ----------
    model : Model
        Any model whose parts have a meaning in time.
    theta : ndarray, shape (p,)
        Its parameters, in the units of the test.
    test : TimeTest
        What is imposed, on which side, at which temperature.
    reference : float, optional
        Temperature in kelvin at which shifts are one; that of the test by default.
    at : ndarray, shape (m,), optional
        Rising times in s; those of the test by default.
    tolerance : float
        Relative error of K.

    Returns
    -------
    Traced
        Response (m,) and its derivatives (m, p).

    Raises
    ------
    ModelError
        If an effect of the model has no law in time, or not for a step that takes no time.
    """
    if test.warmth is not None and "temperature" in model.needs:
        return warming(model, theta, test, reference, at, tolerance)
    t = test.time if at is None else at
    kelvin = test.kelvin
    away = kelvin if reference is None else reference
    inside = model.in_time(
        theta, temperature=kelvin, reference_temperature=293.15 if away is None else away, tolerance=tolerance
    )
    value, by_theta = np.zeros(len(t)), np.zeros((len(t), len(inside.theta)))
    for when, size in zip(*test.loading.jumps, strict=True):
        since = t - when
        after = since >= 0.0
        one = inside.relaxation(since[after]) if test.control == "displacement" else inside.creep(since[after])
        value[after] += size * one.value
        by_theta[after] += size * one.by_theta
    smooth = test.loading.smooth
    if smooth is not None:
        rest = _answer(inside, smooth, t, test.control)
        value, by_theta = value + rest.value, by_theta + rest.by_theta
    return Traced(value, by_theta)


def _answer(inside: InTime, loading: Loading, t: Real, control: str) -> Traced:
    """The response to a loading without jumps at the times t, which need not be its knots."""
    if len(t) == len(loading.time) and np.array_equal(t, loading.time):
        return _respond(inside, t, loading.value, control)
    grid = np.union1d(loading.time, t)
    if len(grid) < 2:
        grid = np.append(grid, grid[-1] + 1.0)
    whole = _respond(inside, grid, np.interp(grid, loading.time, loading.value), control)
    place = np.searchsorted(grid, t)
    return Traced(whole.value[place], whole.by_theta[place])


def _respond(inside: InTime, t: Real, imposed: Real, control: str) -> Traced:
    if control == "displacement":
        return inside.respond(t, imposed)
    return inside.respond_force(t, imposed)
