"""Finding the noise floor of a measurement together with a first fit of its model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf

import numpy as np
from scipy.stats import f

from springpot.measurement import Measurement
from springpot.rheology import Complex, Model, Real

from .frame import Frame
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
from .sweeps import sweeps_of

ROUNDS = 2
SHARPER = 0.7
"""The noise is estimated anew where the scatter about the best model is less than this share of the estimate."""
DIFFERENCES = 0.5
"""Degrees of freedom that a second difference is worth: neighbouring ones share points."""
ENOUGH_NEIGHBOURS = 10
"""Degrees of freedom below which second differences say too little."""
FASTER = 1e-3
"""Chance that second differences vary by so much less than the scatter if that is noise."""
FEWEST = 4
"""Degrees of freedom from which the scatter about a model says how large the noise is."""


def fitted_to_floor(model: Model, measurement: Measurement, seeds: Sequence[Real] = ()) -> Refit:
    """Fit `model` to the averaged data, in units of a noise floor found on the way.

    Repeats tell the noise best; given standard deviations are checked against the data's own scatter; without
    either the scatter about slow curves is taken, which says at most how large the noise is.

    Parameters
    ----------
    model : Model
        The user's model; it need not be right.
    measurement : Measurement
        The data.
    seeds : sequence of ndarray, shape (p,)
        Starts worth trying beside those read off the data.
    """
    data = average_repeats(measurement)
    repeated = noise_of_repeats(data)
    if repeated is not None:
        return refit(model, data, repeated, seeds, starts=16)
    if data.mean.sd is None:
        return _estimated(model, data, seeds)
    return _given(model, data, data.mean.sd, seeds)


def _given(model: Model, data: Averaged, sd: Complex, seeds: Sequence[Real]) -> Refit:
    first = refit(model, data, Noise(sd, inf, "given"), seeds, starts=16)
    noise = checked(first.noise, *_scatter(first.frame()))
    if noise is first.noise:
        return first
    return refit(model, data, noise, [first.theta], starts=4)


def as_given(base: Refit) -> Refit:
    """The fit in units of the given standard deviations, though they were doubted."""
    assert base.data.mean.sd is not None, "only what was given can be doubted"
    return refit(base.model, base.data, Noise(base.data.mean.sd, inf, "given"), [base.theta], starts=8)


def borne_out(best: Refit) -> bool:
    """Whether the scatter about a good model is as large as its noise says."""
    variance, dof = _scatter(best.frame())
    return variance < plausible(dof)[1]


def _scatter(frame: Frame) -> tuple[float, float]:
    """Variance of whitened scatter and its degrees of freedom: what neither the fit nor structure can follow.

    A ripple too fast for the slow curves would pass for scatter, but neighbours along a sweep share most of it:
    where their second differences vary by much less (von Neumann et al. 1941, doi:10.1214/aoms/1177731746), these
    tell the noise.
    """
    dof = max(frame.rough_dof, 1)
    whole = robust_variance(frame.rough, dof, frame.measurement.omega)
    lines = [sweep.rows for sweep in sweeps_of(frame.measurement) if len(sweep.rows) >= 3]
    parts = [frame.rest[rows + k] for rows in lines for k in (0, len(frame.measurement))]
    bend = np.concatenate([np.zeros(0), *(np.diff(part, 2) for part in parts)])
    efficient = DIFFERENCES * len(bend)
    if efficient < ENOUGH_NEIGHBOURS:
        return whole, float(dof)
    near = float(np.mean(bend**2)) / 6.0 / (1.0 - frame.absorbed.shape[1] / frame.size)
    return (near, efficient) if near < whole * f.ppf(FASTER, efficient, dof) else (whole, float(dof))


def _estimated(model: Model, data: Averaged, seeds: Sequence[Real]) -> Refit:
    size = data.mean.magnitude
    found = refit(model, data, Noise(np.asarray(size + 1j * size), 1.0, "estimated"), seeds, starts=16)
    for _ in range(ROUNDS):
        shaped = refit(model, data, _shaped(found), [found.theta], starts=2)
        variance, dof = _scatter(shaped.frame())
        sd = at_least_rounding(float(np.sqrt(variance)) * shaped.noise.sd, data.mean)
        noise = replace(shaped.noise, sd=sd, dof=dof)
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
