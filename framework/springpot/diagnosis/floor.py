"""Finding the noise floor of a measurement together with a first fit of its model."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from springpot.measurement import Measurement
from springpot.rheology import Complex, Model, Real

from .noise import (
    Averaged,
    Noise,
    Scatter,
    at_least_rounding,
    average_repeats,
    best_shape,
    checked,
    noise_of_repeats,
    plausible,
    robust_variance,
)
from .refit import Refit, refit

ROUNDS = 2
SHARPER = 0.7
"""The noise is estimated anew where the scatter about the best model is less than this share of the estimate."""
FEWEST = 4
"""Degrees of freedom from which the scatter about a model says how large the noise is."""


def fitted_to_floor(model: Model, measurement: Measurement) -> Refit:
    """Fit `model` to the averaged data, in units of a noise floor found on the way.

    Repeats tell the noise best; given standard deviations are checked against the data's own scatter; without
    either the scatter about slow curves is taken, which says at most how large the noise is.

    Parameters
    ----------
    model : Model
        The user's model; it need not be right.
    measurement : Measurement
        The data.
    """
    data = average_repeats(measurement)
    repeated = noise_of_repeats(data)
    if repeated is not None:
        return refit(model, data, repeated, starts=16)
    return _estimated(model, data) if data.mean.sd is None else _given(model, data, data.mean.sd)


def _given(model: Model, data: Averaged, sd: Complex) -> Refit:
    first = refit(model, data, Noise(sd, inf, "given"), starts=16)
    frame = first.frame()
    noise = checked(first.noise, frame.rough, frame.rough_dof, data.mean.omega)
    if noise is first.noise:
        return first
    return refit(model, data, noise, [first.theta], starts=4)


def as_given(base: Refit) -> Refit:
    """The fit in units of the given standard deviations, though they were doubted."""
    assert base.data.mean.sd is not None, "only what was given can be doubted"
    return refit(base.model, base.data, Noise(base.data.mean.sd, inf, "given"), [base.theta], starts=8)


def borne_out(best: Refit) -> bool:
    """Whether the scatter about a good model is as large as its noise says."""
    frame = best.frame()
    dof = max(frame.rough_dof, 1)
    return robust_variance(frame.rough, dof, frame.measurement.omega) < plausible(dof)[1]


def _estimated(model: Model, data: Averaged) -> Refit:
    size = data.mean.magnitude
    found = refit(model, data, Noise(np.asarray(size + 1j * size), 1.0, "estimated"), starts=16)
    for _ in range(ROUNDS):
        shaped = refit(model, data, _shaped(found), [found.theta], starts=2)
        frame = shaped.frame()
        dof = max(frame.rough_dof, 1)
        scale = float(np.sqrt(robust_variance(frame.rough, dof, data.mean.omega)))
        sd = at_least_rounding(scale * shaped.noise.sd, data.mean)
        noise = replace(shaped.noise, sd=sd, dof=float(dof))
        found = refit(model, data, noise, [shaped.theta], starts=2)
    return found


def sharpened(base: Refit, best: Refit) -> Refit | None:
    """The base model fitted again in units of the scatter about a better model, where that is much smaller.

    Where conditions differ from point to point there are no smooth curves whose scatter could be taken, and the
    misfit of a wrong model passes for noise; the scatter about a model that explains it cannot.

    Parameters
    ----------
    base, best : Refit
        The user's model and the best grown one.

    Returns
    -------
    Refit or None
        None where the noise is not estimated, or nothing would change.
    """
    frame = best.frame()
    dof = frame.size - int(frame.absorbed.shape[1])
    if base.noise.source != "estimated" or dof < FEWEST:
        return None
    noise = _of_residual(best, frame.rest, dof)
    if base.data.floor(noise) > SHARPER * base.data.floor(base.noise):
        return None
    return refit(base.model, base.data, noise, [base.theta], starts=8)


def _shaped(found: Refit) -> Noise:
    """Noise with the dependence on the point that the scatter about slow curves favours."""
    frame = found.frame()
    return _of_residual(found, frame.rough, max(frame.rough_dof, 1))


def _of_residual(found: Refit, whitened: Real, dof: int) -> Noise:
    weights, n = found.noise.weights, len(whitened) // 2
    real, imag = whitened[:n] / weights.real, whitened[n:] / weights.imag
    scatter = Scatter(real**2, imag**2, np.full(n, dof / (2.0 * n)))
    sd = at_least_rounding(best_shape(found.data.mean, scatter), found.data.mean)
    return Noise(sd, float(dof), "estimated")
