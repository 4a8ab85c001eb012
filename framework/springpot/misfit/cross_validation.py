"""Prediction of what a fit has not seen: inner amplitudes, temperatures or bands left out."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from springpot.measurement.independence import telling
from springpot.measurement.measurement import CONDITIONS, Measurement
from springpot.measurement.one_frequency import frequency_numbers
from springpot.measurement.sweeps import temperatures_differ
from springpot.rheology.points import Real
from springpot.thresholds import VERDICT

from .frame import Frame
from .refit import Refit, refit
from .shapes import Drawn
from .words import times

FOLDS = 4
"""Levels or bands left out at most, each by itself."""
POINTS_OF_EACH = 4
"""Points of each level at least: of fewer one says little."""
FEWEST_LEVELS = 4
"""Levels from which two inner ones can be left out between others."""
LEAST_FREE = 0.1
"""Share of a level's residual that the other levels must leave along an axis to predict it."""
BANDS = 6
"""Bands into which a swept condition is divided, or the frequency if no condition differs."""


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
        folds = folds_of(base.fit.measurement, name)
        if not folds:
            continue
        # From the ends of the fits of all data: a few rows less do not move a minimum far.
        old, new = (left_out_error(fitted, folds) for fitted in (base, grown))
        word = "does not predict it better"
        if new < VERDICT.predicts_better * old:
            word = "predicts it better"
        yield (
            f"leaving out one {name} at a time, {grown.model} {word}: {times(new)} the noise"
            f" instead of {times(old)}"
        )


def prediction_gain(before: Refit, after: Refit) -> float:
    """Error of prediction after over before, where something inside the data is left out.

    One where nothing can be.

    What is physics predicts what it has not seen; a curve that was bent to a misfit does not.

    Parameters
    ----------
    before, after : Refit
        A model, and the same with an effect.
    """
    measurement = after.fit.measurement
    # A condition before the frequency: leaving out a whole level is the harder question.
    by_condition = (folds for name in CONDITIONS if (folds := folds_of(measurement, name)))
    folds = next(by_condition, _folds_of_bands(frequency_numbers(measurement)))
    # Nothing to predict is no sign of physics: the rung is judged as one that gains nothing.
    if not folds:
        return 1.0
    # Both on the same data in units of the same noise: outliers may have been set aside on one rung
    # only.
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
        less = fitted.without(fold)
        off = fitted.fit.measurement.stiffness - less.model.stiffness(
            less.theta, fitted.fit.measurement.points
        )
        # In units of the noise of all data: a fit of less has no better one.
        sd = fitted.noise.sd
        total += float(np.sum((off.real / sd.real)[fold] ** 2 + (off.imag / sd.imag)[fold] ** 2))
        count += 2 * int(np.sum(fold))
    return float(np.sqrt(total / count))


def folds_of(measurement: Measurement, name: str) -> list[NDArray[np.bool_]]:
    """Rows of a few inner levels of a condition, or of inner bands where it was swept.

    Ends would be extrapolated.
    """
    column = measurement.conditions.get(name)
    if column is None or (name == "temperature" and not temperatures_differ(measurement)):
        return []
    level = measurement.levels(name)
    count = int(level.max()) + 1
    if count < FEWEST_LEVELS:
        return []
    if len(level) >= POINTS_OF_EACH * count:
        return [level == number for number in _inner(count)]
    # Bands of what moved with the frequency would be bands of the frequency.
    if name not in telling(measurement):
        return []
    return _folds_of_bands(level)


def _folds_of_bands(number: NDArray[np.int64]) -> list[NDArray[np.bool_]]:
    """Rows of inner bands of frequencies, or of levels, by their numbers (n,).

    None where they are few.
    """
    distinct = int(number.max()) + 1
    # A band of a single frequency is predicted by its neighbours, whatever the model.
    if distinct < 2 * BANDS:
        return []
    band = number * BANDS // distinct
    return [band == each for each in _inner(BANDS)]


def _inner(count: int) -> list[int]:
    """A few of the numbers 1 to count - 2, evenly."""
    return sorted({round(x) for x in np.linspace(1, count - 2, min(FOLDS, count - 2)).tolist()})


def unseen_error(frame: Frame, sample: Drawn, name: str) -> Real | None:
    """Squared error (m,) of inner levels of a condition in fits without them.

    From residuals (m, 2n) of full fits.

    To first order what a fit without some rows misses of them is (I - H)^-1 times their residual, H
    being their part of the projection on the parameters (Cook and Weisberg, Residuals and Influence
    in Regression, 1982). What those rows alone determine is left out of it: nothing else predicts
    that.

    Parameters
    ----------
    frame : Frame
        The fit.
    sample : ndarray, shape (m, 2n)
        Residuals.
    name : str
        Of the condition.

    Returns
    -------
    ndarray or None
        None where too few levels were measured to leave inner ones out.
    """
    folds = folds_of(frame.measurement, name)
    if not folds:
        return None
    total = np.zeros(len(sample))
    for fold in folds:
        rows = np.flatnonzero(np.tile(fold, 2))
        # By the axes of H, not by a refit of each draw: thousands of draws are asked.
        followed = frame.absorbed[rows]
        axes, shares, _ = np.linalg.svd(followed, full_matrices=False)
        seen = 1.0 - shares**2 > LEAST_FREE
        # Along an axis of which the parameters follow the share h, 1 / (1 - h) of the residual is
        # missed.
        gain = np.where(seen, 1.0 / np.where(seen, 1.0 - shares**2, 1.0), 0.0)
        part = sample[:, rows].astype(np.float64)
        along = part @ axes
        total += np.einsum("ij,ij->i", part, part) + (along**2) @ (gain**2 - 1.0)
    return total


def unseen_in_words(frame: Frame, name: str) -> tuple[float, str]:
    """By how much such levels are missed, over what noise makes of it, and the sentence."""
    error = unseen_error(frame, frame.rest[None], name)
    assert error is not None, "the test was made"
    count = 2.0 * sum(float(np.sum(fold)) for fold in folds_of(frame.measurement, name))
    ratio = float(np.sqrt(error[0] / count))
    return ratio, f"{one_of(name)} that a fit has not seen is predicted to {times(ratio)} the noise"


def one_of(name: str) -> str:
    """A level of a condition with its article: ``an amplitude``."""
    article = "a"
    if name[0] in "aeiou":
        article = "an"
    return f"{article} {name}"
