"""Leaving out a temperature or an amplitude, and asking whether the grown model predicts it better."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .noise import Averaged, Noise, Scatter
from .refit import Refit, refit
from .sweeps import temperatures_differ
from .words import times

BETTER = 0.98
"""Share of an error from which on a smaller one is better."""
FOLDS = 4
"""Values left out at most, each by itself."""


def validation(base: Refit, grown: Refit) -> Iterator[str]:
    """One sentence for each condition of which several values were measured.

    Parameters
    ----------
    base : Refit
        The user's model.
    grown : Refit
        The model with what is missing.
    """
    conditions = ("temperature", "amplitude") if temperatures_differ(base.fit.measurement) else ("amplitude",)
    for name in conditions:
        folds = _folds(base, name)
        if not folds:
            continue
        old, new = (left_out_error(fitted, folds) for fitted in (base, grown))
        word = "predicts it better" if new < BETTER * old else "does not predict it better"
        yield (
            f"leaving out one {name} at a time, {grown.model} {word}: {times(new)} the noise instead of {times(old)}"
        )


def left_out_error(fitted: Refit, folds: list[NDArray[np.bool_]]) -> float:
    """Root mean square error, in units of the noise, of points that the fit has not seen.

    Parameters
    ----------
    fitted : Refit
        A fit of all data, from which each fit of less starts.
    folds : list of ndarray of bool, shape (n,)
        Rows to leave out.
    """
    total, count = 0.0, 0
    for fold in folds:
        less = refit(fitted.model, _without(fitted.data, fold), _noise_of(fitted, ~fold), [fitted.theta], starts=0)
        off = fitted.fit.measurement.stiffness - less.model.stiffness(less.theta, fitted.fit.measurement.points)
        sd = fitted.noise.sd
        total += float(np.sum((off.real / sd.real)[fold] ** 2 + (off.imag / sd.imag)[fold] ** 2))
        count += 2 * int(np.sum(fold))
    return float(np.sqrt(total / count))


def _folds(base: Refit, name: str) -> list[NDArray[np.bool_]]:
    column = base.fit.measurement.conditions.get(name)
    if column is None:
        return []
    rounded = np.round(column / max(float(np.max(np.abs(column))), 1e-300), 3)
    values = np.unique(rounded)
    if not 3 <= len(values) <= len(column) // 4:
        return []
    chosen = values[np.unique(np.linspace(0, len(values) - 1, FOLDS).round().astype(int))]
    return [rounded == value for value in chosen]


def _without(data: Averaged, fold: NDArray[np.bool_]) -> Averaged:
    """The averaged data without some rows; the reference temperature stays."""
    mean = data.mean.subset(np.flatnonzero(~fold))
    mean.__dict__["reference_temperature"] = data.mean.reference_temperature
    scatter = Scatter(*(column[~fold] for column in data.scatter))
    return Averaged(mean, mean, scatter, np.arange(len(mean)))


def _noise_of(fitted: Refit, rows: NDArray[np.bool_]) -> Noise:
    return replace(fitted.noise, sd=fitted.noise.sd[rows])
