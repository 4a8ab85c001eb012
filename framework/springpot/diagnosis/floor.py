"""Finding the noise floor of a measurement together with a first fit of its model."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from springpot.measurement import (
    Averaged,
    Measurement,
    Noise,
    Scatter,
    at_least_rounding,
    average_repeats,
    checked_noise,
    noise_of_repeats,
    noise_shape,
    plausible_variance,
    robust_noise_shape,
)
from springpot.rheology import Complex, Model, Real

from .policy import SCATTER
from .refit import Refit, refit
from .scatter import Trimmed, scatter_about, trimmed


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
    noise = checked_noise(first.noise, *scatter_about(first.frame()))
    if noise is first.noise:
        return first
    return refit(model, data, noise, [first.theta], starts=4)


def as_given(base: Refit) -> Refit:
    """The fit in units of the given standard deviations, though they were doubted."""
    assert base.data.mean.sd is not None, "only what was given can be doubted"
    return refit(base.model, base.data, Noise(base.data.mean.sd, inf, "given"), [base.theta], starts=8)


def borne_out(best: Refit) -> bool:
    """Whether the scatter about a good model is as large as its noise says."""
    variance, dof = scatter_about(best.frame())
    return variance < plausible_variance(dof)[1]


def _estimated(model: Model, data: Averaged, seeds: Sequence[Real]) -> Refit:
    size = data.mean.magnitude
    found = refit(model, data, Noise(np.asarray(size + 1j * size), 1.0, "estimated"), seeds, starts=16)
    free, inside = found, np.ones(len(data.mean), dtype=bool)
    for _ in range(SCATTER.rounds):
        # Each way says at most how large the noise is: the smaller one is the better bound.
        tried = [_scaled(model, data, shape, found) for shape in _shapes(free, data.mean, inside)]
        found, free, inside = min(tried, key=lambda one: data.floor(one[0].noise))
    return found


def _scaled(model: Model, data: Averaged, shape: Noise, before: Refit) -> tuple[Refit, Refit, NDArray[np.bool_]]:
    """The fit in units of a noise of this shape and of the size that the scatter gives it; see `undragged`."""
    shaped = refit(model, data, shape, [before.theta], starts=2)
    free, inside = undragged(shaped)
    variance, dof = scatter_about(free.frame())
    sd = at_least_rounding(float(np.sqrt(variance)) * shape.sd, data.mean)
    noise = replace(shape, sd=sd, dof=dof)
    return refit(model, data, noise, [shaped.theta], starts=2), free, inside


def undragged(fitted: Refit) -> tuple[Refit, NDArray[np.bool_]]:
    """The fit to what does not stand out, and which points (n,) that is.

    A notch or a bad point drags the curve, and all else then seems to scatter. Those that stand out are found anew
    beside the curve that is free of them (Rousseeuw 1984, least trimmed squares, doi:10.1080/01621459.1984.10477105).
    """
    n = len(fitted.fit.measurement)
    free, followed = fitted, np.ones(n, dtype=bool)
    inside = trimmed(fitted.frame()).kept[:n]
    for _ in range(SCATTER.trimmed_fits):
        if np.array_equal(inside, followed):
            break
        free, followed = fitted.without(~inside), inside
        of_all = replace(fitted, fit=replace(free.fit, measurement=fitted.fit.measurement))
        inside = trimmed(of_all.frame(), followed).kept[:n]
    return free, followed


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
    if base.noise.source != "estimated" or dof < SCATTER.fewest_about_model:
        return None
    everything = np.ones(frame.size, dtype=bool)
    noise = _of_residual(best, Trimmed(frame.rest, everything, float(dof)))
    if base.data.floor(noise) > SCATTER.sharper * base.data.floor(base.noise):
        return None
    return refit(base.model, base.data, noise, [base.theta], starts=8)


def _shapes(free: Refit, measurement: Measurement, inside: NDArray[np.bool_]) -> Iterator[Noise]:
    """Noise with the dependence on the point that the scatter about slow curves favours; its size comes later.

    Where a ripple or a drift is seen in that scatter, also without it: its storage and its loss would be taken for
    the sizes of the noise in both.

    Parameters
    ----------
    free : Refit
        The fit to the points that do not stand out.
    measurement : Measurement
        All points.
    inside : ndarray of bool, shape (n,)
        Those that do not.
    """
    frame, n = free.frame(), int(np.sum(inside))
    scatters = [frame.rough]
    left = trimmed(frame).left
    if not np.allclose(left, frame.rough, atol=1e-6 * float(np.max(np.abs(frame.rough), initial=0.0))):
        scatters.append(left)
    for scatter in scatters:
        rough = scatter[:n] / free.noise.weights.real + 1j * scatter[n:] / free.noise.weights.imag
        sd = at_least_rounding(robust_noise_shape(measurement, rough, inside), measurement)
        yield Noise(sd, float(max(frame.rough_dof, 1)), "estimated")


def _of_residual(found: Refit, scatter: Trimmed) -> Noise:
    """Noise of the shape and size of a whitened scatter; points set aside say nothing of it."""
    weights, n = found.noise.weights, len(scatter.left) // 2
    squares = np.where(scatter.kept, scatter.left, 0.0) ** 2
    each: Real = scatter.dof / float(np.sum(scatter.kept)) * scatter.kept.astype(np.float64)
    parts = Scatter(squares[:n] / weights.real**2, squares[n:] / weights.imag**2, each[:n])
    sd = at_least_rounding(noise_shape(found.data.mean, parts), found.data.mean)
    return Noise(sd, scatter.dof, "estimated")
