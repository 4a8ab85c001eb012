"""What a model answers to the loading of a test in time, with exact parameter derivatives."""

from __future__ import annotations

import numpy as np

from springpot.measurement.imposed import Loading
from springpot.measurement.timetest import TimeTest
from springpot.rheology.history import InTime
from springpot.rheology.intime import Traced
from springpot.rheology.model import Model
from springpot.rheology.points import ROOM, Real

from .warming import warming

TOLERANCE = 1e-6
"""Relative error of K for which the spectrum is read: a thousandth of the best transducer's noise.
"""


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
        Any model whose parts have a meaning in time; for effects of the test itself see `recorded`.
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

    Examples
    --------
    >>> import numpy as np
    >>> import springpot
    >>> from springpot.timetests import predicted
    >>> model = springpot.parse_model("maxwell")
    >>> test = springpot.TimeTest.of_relaxation([1.0, 4.0], [1.0, 1.0], "kPa")
    >>> predicted(model, model.theta(k=2.0, c=8.0), test).value.round(3)
    array([1.558, 0.736])
    """
    if test.warmth is not None and "temperature" in model.needs:
        return warming(model, theta, test, reference, at, tolerance)
    if at is None:
        at = test.time
    inside = specimen(model, theta, test, reference, tolerance)
    return answer(inside, test.loading, at, test.control)


def specimen(
    model: Model, theta: Real, test: TimeTest, reference: float | None, tolerance: float = TOLERANCE
) -> InTime:
    """A model with its parameters at the temperature of a test."""
    if reference is None:
        reference = test.kelvin
    # A model that no temperature moves takes any reference.
    if reference is None:
        reference = ROOM
    return model.in_time(
        theta, temperature=test.kelvin, reference_temperature=reference, tolerance=tolerance
    )


def answer(inside: InTime, loading: Loading, t: Real, control: str) -> Traced:
    """The response to a loading at the times t, with jumps and all."""
    value, by_theta = np.zeros(len(t)), np.zeros((len(t), len(inside.theta)))
    when, sizes = loading.jumps
    if len(when):
        since = t[:, None] - when
        after = since >= 0.0
        # A jump has no rate of change: its answer is the creep or the relaxation function itself.
        step_answer = inside.creep
        if control == "displacement":
            step_answer = inside.relaxation
        # All jumps at once: the spectrum of the material is read once.
        one = step_answer(since[after])
        rows, which = np.nonzero(after)
        np.add.at(value, rows, sizes[which] * one.value)
        np.add.at(by_theta, rows, sizes[which, None] * one.by_theta)
    smooth = loading.smooth
    if smooth is not None:
        rest = _to_smooth(inside, smooth, t, control)
        value, by_theta = value + rest.value, by_theta + rest.by_theta
    return Traced(value, by_theta)


def _to_smooth(inside: InTime, loading: Loading, t: Real, control: str) -> Traced:
    """The response to a loading without jumps at the times t, which need not be its knots."""
    # No other times: nothing needs to be interpolated.
    if len(t) == len(loading.time) and np.array_equal(t, loading.time):
        return _respond(inside, t, loading.value, control)
    grid = np.union1d(loading.time, t)
    if len(grid) < 2:
        # A history has two samples at the least.
        grid = np.append(grid, grid[-1] + 1.0)
    whole = _respond(inside, grid, np.interp(grid, loading.time, loading.value), control)
    place = np.searchsorted(grid, t)
    return Traced(whole.value[place], whole.by_theta[place])


def _respond(inside: InTime, t: Real, imposed: Real, control: str) -> Traced:
    if control == "displacement":
        return inside.respond(t, imposed)
    return inside.respond_force(t, imposed)
