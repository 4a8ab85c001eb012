"""How much of a measurement the places of a spectrum's lines have followed, beside the weights."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.elements import Continuum
from springpot.rheology.points import Real

from ..numerics import ROUNDING, SMALLEST
from .material import FINE, SpectrumSearch, own_parameters
from .trials import Trial


def followed_by_places(search: SpectrumSearch, theta: Real, residual: Real, known: Real) -> float:
    """Numbers that the places of the lines of a fitted spectrum have followed, beside the weights.

    A line stands where one explains most. Had the noise been other it would stand elsewhere: it
    moves by what the slope of its curve finds in the noise, against the curvature of what is left
    there. So far its place is a parameter, and its share of one lies between 0 and 1: with S the
    map from noise to curve, a residual has lost tr(2 S - S S') numbers (Hastie and Tibshirani,
    Generalized Additive Models, 1990, sec. 3.5). Of two lines side by side the weights move them,
    and nothing is left for the places.

    Parameters
    ----------
    search : SpectrumSearch
        For the model with its lines, which is a `Continuum` with effects.
    theta : ndarray, shape (p,)
        The parameters.
    residual : ndarray, shape (m,)
        Predicted less measured, weighted.
    known : ndarray, shape (m, q)
        Its slopes by the parameters that follow the data, in whatever unit.
    """
    material, own = search.model.material, own_parameters(search.model)
    assert isinstance(material, Continuum)
    count = len(material.parameters)
    weights, rates = theta[:count], np.log(material.rates)
    carrying = _alone(rates, weights[2:])
    if not len(carrying):
        return 0.0
    places = np.concatenate([rates[carrying] + step for step in (-FINE, 0.0, FINE)])
    beside = Trial(
        search.u_of(theta[own]),
        np.concatenate([rates, places]),
        np.concatenate([weights, np.zeros(len(places))]),
        np.inf,
    )
    columns = search.respond(beside).by_theta[count : count + len(places)]
    before, at, after = search.weigh(columns).reshape(3, len(carrying), -1)
    weight = weights[2:][carrying, None]
    slopes = weight * (after - before) / (2.0 * FINE)
    left = (weight * (2.0 * at - before - after) / FINE**2) @ -residual
    # What the weights and the effects' parameters follow is no gain of the places.
    basis, _ = np.linalg.qr(known / np.maximum(np.linalg.norm(known, axis=0), SMALLEST))
    slopes = slopes.T - basis @ (basis.T @ slopes.T)
    stiff = np.diag(np.sqrt(np.maximum(left, 0.0)))
    spread, sizes, _ = np.linalg.svd(np.concatenate([slopes, stiff]), full_matrices=False)
    # By their shares: of what is seen of one combination of places, how much the data move.
    moved = spread[: len(slopes), sizes > ROUNDING * sizes[0]]
    share = np.linalg.svd(moved, compute_uv=False) ** 2
    return float(np.sum(2.0 * share - share**2))


def _alone(rates: Real, weights: Real) -> NDArray[np.int64]:
    """Numbers of the lines that carry weight with none beside them; rates in logarithms."""
    carrying = np.flatnonzero(weights > 0.0)
    carrying = carrying[np.argsort(rates[carrying])]
    apart = np.diff(rates[carrying], prepend=-np.inf, append=np.inf) > FINE
    return carrying[apart[1:] & apart[:-1]]
