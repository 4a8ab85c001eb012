"""Leaving out a temperature, an amplitude or a band of frequencies, and asking whether a model predicts it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from springpot.measurement import CONDITIONS, Measurement

from .noise import Averaged, Noise, Scatter
from .refit import Refit, refit
from .sweeps import temperatures_differ
from .words import times

BETTER = 0.98
"""Share of an error from which on a smaller one is better."""
FOLDS = 4
"""Levels or bands left out at most, each by itself."""
POINTS_OF_EACH = 4
"""Points of each level at least: of fewer one says little."""
FEWEST_LEVELS = 4
"""Levels from which two inner ones can be left out between others."""
BANDS = 6
"""Bands into which frequencies are divided where no condition has levels."""


def validation(base: Refit, grown: Refit) -> Iterator[str]:
    """One sentence for each condition of which several levels were measured.

    Parameters
    ----------
    base : Refit
        The user's model.
    grown : Refit
        The model with what is missing.
    """
    for name in CONDITIONS:
        folds = _of_levels(base.fit.measurement, name)
        if not folds:
            continue
        old, new = (left_out_error(fitted, folds) for fitted in (base, grown))
        word = "predicts it better" if new < BETTER * old else "does not predict it better"
        yield (
            f"leaving out one {name} at a time, {grown.model} {word}: {times(new)} the noise instead of {times(old)}"
        )


def prediction_gain(before: Refit, after: Refit) -> float:
    """Error of prediction after over before, where something inside the data is left out; one where nothing can be.

    What is physics predicts what it has not seen; a curve that was bent to a misfit does not.

    Parameters
    ----------
    before, after : Refit
        A model, and the same with an effect.
    """
    measurement = after.fit.measurement
    folds = next((folds for name in CONDITIONS if (folds := _of_levels(measurement, name))), _of_bands(measurement))
    if not folds:
        return 1.0
    # Both on the same data in units of the same noise: outliers may have been set aside on one rung only.
    again = refit(before.model, after.data, after.noise, [before.theta], starts=2)
    return left_out_error(after, folds) / max(left_out_error(again, folds), 1e-300)


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


def _of_levels(measurement: Measurement, name: str) -> list[NDArray[np.bool_]]:
    """Rows of a few inner levels of a condition; the ends would have to be extrapolated."""
    column = measurement.conditions.get(name)
    if column is None or (name == "temperature" and not temperatures_differ(measurement)):
        return []
    level = measurement.levels(name)
    count = int(level.max()) + 1
    if count < FEWEST_LEVELS or len(level) < POINTS_OF_EACH * count:
        return []
    return [level == number for number in _inner(count)]


def _of_bands(measurement: Measurement) -> list[NDArray[np.bool_]]:
    """Rows of inner bands of frequency."""
    _, which = np.unique(np.round(np.log(measurement.omega), 6), return_inverse=True)
    distinct = int(which.max()) + 1
    if distinct < 2 * BANDS:
        return []
    band = which.ravel() * BANDS // distinct
    return [band == number for number in _inner(BANDS)]


def _inner(count: int) -> list[int]:
    """A few of the numbers 1 to count - 2, evenly."""
    return sorted({round(x) for x in np.linspace(1, count - 2, min(FOLDS, count - 2)).tolist()})


def _without(data: Averaged, fold: NDArray[np.bool_]) -> Averaged:
    """The averaged data without some rows; the reference temperature stays."""
    mean = data.mean.subset(np.flatnonzero(~fold))
    scatter = Scatter(*(column[~fold] for column in data.scatter))
    return Averaged(mean, mean, scatter, np.arange(len(mean)))


def _noise_of(fitted: Refit, rows: NDArray[np.bool_]) -> Noise:
    return replace(fitted.noise, sd=fitted.noise.sd[rows])
