"""The parameters of a model in the form in which it was published, with their intervals."""

from __future__ import annotations

import numpy as np

from springpot.rheology.parameters import SearchForm
from springpot.rheology.points import Real

from ..numerics import ROUNDING
from .bordered import matrix_of
from .native import Fit
from .uncertainty import Uncertainty, ends, spread_of
from .value import Value, printed


def search_parameters(known: Uncertainty, ends_low: Real, ends_high: Real) -> dict[str, Value]:
    """The parameters in the model's published search form, by linear propagation.

    None where it has no such form.
    """
    estimate, form = known.fit, known.fit.model.search
    if form is None:
        return {}
    q = len(form.parameters)
    with np.errstate(all="ignore"):
        # The elements come first in theta; what follows are effects, which the published form does
        # not know.
        x = form.from_elements(estimate.theta[:q])
        reach = _reach(known, form, x)
        log = np.array([p.scale == "log" for p in form.parameters])
        bounds = (
            np.array([p.lower for p in form.parameters]),
            np.array([p.upper for p in form.parameters]),
        )
        low, high = ends(x, np.where(np.isfinite(reach), reach, np.inf), log, bounds)
        # A slope tells nothing of a step away from a bound: there the ends themselves are carried
        # over.
        for moved in _at_ends(known, ends_low[:q], ends_high[:q]):
            other = np.nan_to_num(form.from_elements(moved), nan=np.inf)
            low, high = (
                np.fmax(np.fmin(low, other), bounds[0]),
                np.fmin(np.fmax(high, other), bounds[1]),
            )
    for i, j in _shared(estimate, form, x):
        low[i], high[i] = ends_low[j], ends_high[j]
    return printed(form.parameters, x, low, high, estimate.measurement.units)


def _at_ends(known: Uncertainty, low: Real, high: Real) -> list[Real]:
    """The parameters of the form, those at a bound put at both ends of their interval in turn."""
    moved = []
    at_bound = known.at_bound[: len(low)]
    for i in np.flatnonzero(at_bound).tolist():
        # An upper end is often infinite, where the form has limits that its formulas do not reach.
        places = [low[i]]
        if at_bound[i] < 0:
            places.append(high[i])
        for place in places:
            theta = known.fit.theta[: len(low)].copy()
            theta[i] = place
            moved.append(theta)
    return moved


def _shared(fit: Fit, form: SearchForm, x: Real) -> list[tuple[int, int]]:
    """Places (in the form, in the model) of parameters that both have.

    These have one interval, not two.
    """
    names = fit.model.names[: len(form.parameters)]
    places = [(i, names.index(p.name)) for i, p in enumerate(form.parameters) if p.name in names]
    return [(i, j) for i, j in places if np.isclose(x[i], fit.theta[j], rtol=ROUNDING)]


def _reach(known: Uncertainty, form: SearchForm, x: Real) -> Real:
    """Half the width of the intervals of ln x (logarithmic parameters) or x."""
    coordinates = known.fit.task.coordinates
    q = len(form.parameters)
    turn = coordinates.slopes(known.fit.theta, coordinates.size[0])[:q]
    by_theta = form.jacobian(x)
    # Where several values of the form give the same elements, the data say nothing of its
    # parameters.
    if not np.all(np.isfinite(by_theta)) or np.linalg.matrix_rank(by_theta) < q:
        return np.full(q, np.inf)
    by_u: Real = np.asarray(np.linalg.solve(by_theta, turn), dtype=float)
    log = np.array([p.scale == "log" for p in form.parameters])
    by_u /= np.where(log, x, 1.0)[:, None]
    return known.quantile * spread_of(by_u, matrix_of(known.covariance))
