"""Parameters that follow from others, as they are printed: their intervals follow as well."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from springpot.measurement.units import Units
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.rheology.tied import Follower

from .uncertainty import ends, spread_of
from .value import Value


def tied_values(
    model: Model,
    theta: Real,
    interval: tuple[Real, Real],
    covariance: Real,
    quantile: float,
    units: Units,
) -> dict[str, tuple[str, Value]]:
    """The tied parameters by name, each with the name that its levels share.

    What follows from a single parameter has the ends of that one's interval, wherever these come
    from; the others follow the covariance.

    Parameters
    ----------
    model : Model
        The fitted model.
    theta : ndarray, shape (p,)
        Its parameters.
    interval : tuple of ndarray, shape (p,)
        Ends of their intervals.
    covariance : ndarray, shape (p, p)
        Of theta.
    quantile : float
        Standard deviations to the end of an interval.
    units : Units
        Those of the data.
    """
    found = {}
    # Where each parameter alone goes to the ends of its own interval.
    moved = [list(_moved(model, theta, interval, i)) for i in range(len(theta) * bool(model.ties))]
    for number, each in enumerate(model.followers(theta)):
        low, high = _by_covariance(each, covariance, quantile)
        parents = np.flatnonzero(each.slopes)
        resting = [i for i in parents if theta[i] in (interval[0][i], interval[1][i])]
        if len(parents) == 1:
            low, high = np.inf, -np.inf
        for i in parents if len(parents) == 1 else resting:
            values = [rows[number].value for rows in moved[i]]
            low, high = min(low, *values), max(high, *values)
        low, high = max(low, each.parameter.lower), min(high, each.parameter.upper)
        factor, label = units.of(each.parameter.unit)
        value = Value(
            factor * each.value, factor * float(low), factor * float(high), label, tied=each.text
        )
        found[each.parameter.name] = (each.origin, value)
    return found


def _moved(
    model: Model, theta: Real, interval: tuple[Real, Real], i: int
) -> Iterator[list[Follower]]:
    """What follows where one parameter stands at either end of its interval."""
    for end in interval:
        place = theta.copy()
        place[i] = end[i]
        with np.errstate(all="ignore"):
            yield model.followers(place)


def _by_covariance(each: Follower, covariance: Real, quantile: float) -> tuple[float, float]:
    log = np.array([each.parameter.scale == "log" and each.value > 0.0])
    turn = each.slopes[None] / (each.value if log[0] else 1.0)
    reach = quantile * spread_of(turn, covariance)
    bounds = np.array([each.parameter.lower]), np.array([each.parameter.upper])
    low, high = ends(np.array([each.value]), reach, log, bounds)
    return float(low[0]), float(high[0])
