"""Parameters as they are printed, in the model's own form and in its published search form."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from springpot.measurement.units import Units
from springpot.rheology.forms import SearchForm
from springpot.rheology.model import Model
from springpot.rheology.parameters import Parameter
from springpot.rheology.points import Real

from .estimate import Estimate
from .uncertainty import ends, spread_of
from .value import Value


def printed(
    parameters: Sequence[Parameter], values: Real, low: Real, high: Real, units: Units
) -> dict[str, Value]:
    """Parameters with their intervals in printed units.

    Lines of a spectrum are told as a whole and left out.

    Parameters
    ----------
    parameters : sequence of Parameter
        Length p.
    values, low, high : ndarray, shape (p,)
        In the units of the measurement.
    units : Units
        Those of the measurement.
    """
    rows = {}
    for i, parameter in enumerate(parameters):
        # Lines of a spectrum are told as a whole elsewhere: a list of fifty weights tells nobody
        # anything.
        if parameter.detail:
            continue
        factor, label = units.of(parameter.unit)
        value, below, above = (factor * float(column[i]) for column in (values, low, high))
        rows[parameter.name] = Value(value, below, above, label)
    return rows


def all_parameters(
    model: Model, theta: Real, low: Real, high: Real, units: Units
) -> dict[str, Value]:
    """All parameters of a fit, those that were held in their places; see `printed`."""
    free = printed(model.parameters, theta, low, high, units)
    held = model.held
    if not held:
        return free
    rows = {}
    for parameter in model.released().parameters:
        name = parameter.name
        if name in held:
            factor, label = units.of(parameter.unit)
            value = factor * held[name]
            rows[name] = Value(value, value, value, label, fixed=True)
        elif name in free:
            rows[name] = free[name]
    return rows


def search_parameters(estimate: Estimate) -> dict[str, Value]:
    """The parameters in the model's published search form, by linear propagation.

    None where it has no such form.
    """
    form = estimate.model.search
    if form is None:
        return {}
    q = len(form.parameters)
    with np.errstate(all="ignore"):
        # The elements come first in theta; what follows are effects, which the published form does
        # not know.
        x = form.from_elements(estimate.theta[:q])
        reach = _reach(estimate, form, x)
        log = np.array([p.scale == "log" for p in form.parameters])
        bounds = (
            np.array([p.lower for p in form.parameters]),
            np.array([p.upper for p in form.parameters]),
        )
        low, high = ends(x, np.where(np.isfinite(reach), reach, np.inf), log, bounds)
        # A slope tells nothing of a step away from a bound: there the ends themselves are carried
        # over.
        for moved in _at_ends(estimate, q):
            other = np.nan_to_num(form.from_elements(moved), nan=np.inf)
            low, high = (
                np.fmax(np.fmin(low, other), bounds[0]),
                np.fmin(np.fmax(high, other), bounds[1]),
            )
    for i, j in _shared(estimate, form, x):
        low[i], high[i] = estimate.low[j], estimate.high[j]
    return printed(form.parameters, x, low, high, estimate.measurement.units)


def _at_ends(estimate: Estimate, q: int) -> list[Real]:
    """The parameters of the form, those at a bound put at both ends of their interval in turn."""
    moved = []
    at_bound = estimate.uncertainty.at_bound[:q]
    for i in np.flatnonzero(at_bound).tolist():
        # An upper end is often infinite, where the form has limits that its formulas do not reach.
        places = [estimate.low[i]]
        if at_bound[i] < 0:
            places.append(estimate.high[i])
        for place in places:
            theta = estimate.theta[:q].copy()
            theta[i] = place
            moved.append(theta)
    return moved


def _shared(estimate: Estimate, form: SearchForm, x: Real) -> list[tuple[int, int]]:
    """Places (in the form, in the model) of parameters that both have.

    These have one interval, not two.
    """
    names = estimate.model.names[: len(form.parameters)]
    places = [(i, names.index(p.name)) for i, p in enumerate(form.parameters) if p.name in names]
    return [(i, j) for i, j in places if np.isclose(x[i], estimate.theta[j], rtol=1e-12)]


def _reach(estimate: Estimate, form: SearchForm, x: Real) -> Real:
    """Half the width of the intervals of ln x (logarithmic parameters) or x."""
    known, coordinates = estimate.uncertainty, estimate.fit.task.coordinates
    q = len(form.parameters)
    turn = coordinates.slopes(estimate.theta, coordinates.size[0])[:q]
    by_theta = form.jacobian(x)
    # Where several values of the form give the same elements, the data say nothing of its
    # parameters.
    if not np.all(np.isfinite(by_theta)) or np.linalg.matrix_rank(by_theta) < q:
        return np.full(q, np.inf)
    by_u: Real = np.asarray(np.linalg.solve(by_theta, turn), dtype=float)
    log = np.array([p.scale == "log" for p in form.parameters])
    by_u /= np.where(log, x, 1.0)[:, None]
    return known.quantile * spread_of(by_u, known.covariance)
