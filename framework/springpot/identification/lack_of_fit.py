"""Laws that do not follow the levels they join.

Their constants are known as nearly as the levels scatter about them.

The points of a sweep share its level's error. Where a law of temperature is off at each level by
more than the points scatter, more points at a level tell no more of its constants; more levels do.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from springpot.distributions import f_sf, student
from springpot.rheology.levels import levels_of
from springpot.rheology.points import Real
from springpot.thresholds import SUPERPOSITION

from ..numerics import ROUNDING
from .allowed_shifts import laws_of_shift
from .levels_alone import alike
from .problem import weighted
from .uncertainty import RANK, Uncertainty


def lack_of_fit(known: Uncertainty, column: str) -> tuple[float, float] | None:
    """Root mean square by which sweeps ask for shifts of their own, and its degrees of freedom.

    None if by chance.

    The test of lack of fit: what a free factor at each level would gain, in a step of least
    squares, over the scatter that is then left (Fisher; N. R. Draper and H. Smith, Applied
    Regression Analysis, 1998, section 2.1).

    Parameters
    ----------
    known : Uncertainty
        Of a fit with a law of shifts.
    column : str
        The condition whose levels the law joins.
    """
    fit = known.fit
    points = fit.measurement.points
    number = levels_of(column, points.need(column))
    slope = fit.model.slope(fit.theta, points)
    weights = fit.task.weights[0]
    if fit.task.logarithmic:
        slope = slope / fit.model.stiffness(fit.theta, points)
    columns = [
        weighted(np.where(number == i, slope, 0.0), weights) for i in range(int(number.max()) + 1)
    ]
    freed, residual = np.nan_to_num(np.array(columns).T), fit.residual
    if fit.expected is not None:
        # What was expected knows of no shift.
        beside = len(fit.expected.rows)
        freed = np.concatenate([freed, np.zeros((beside, freed.shape[1]))])
        residual = np.concatenate([residual, known.surprise])
    basis = known.slopes[:, known.at_bound == 0]
    gained = _spanned(_without(_spanned(basis), freed), np.linalg.norm(freed, axis=0))
    spare = gained.shape[1]
    left = fit.dof - spare
    if not spare or left <= 0:
        return None
    gain = float(np.sum((gained.T @ residual) ** 2))
    whole = float(residual @ residual)
    rest = max((whole - gain) / left, ROUNDING**2 * whole / left)
    mean = gain / spare
    if not mean > rest or float(f_sf(mean / rest, spare, left)) >= SUPERPOSITION.alarm:
        return None
    return float(np.sqrt(mean)), float(spare)


def widened(known: Uncertainty) -> Uncertainty:
    """What is known of the laws of a model.

    By the scatter of the levels about them where that is the larger.
    """
    if known.fit.dof <= 0:
        return known
    for effect in laws_of_shift(known.fit.model):
        (column,) = effect.needs
        spreads = [(known.scale, float(known.fit.dof))]
        # Neighbours that are alike count for fewer, whether or not a factor at each level would
        # mend them; what was given as the noise may hold what they share already.
        if not known.absolute:
            spreads = [(known.scale * float(np.sqrt(_alike(known, column))), float(known.fit.dof))]
        lack = lack_of_fit(known, column)
        if lack is not None:
            spreads.append(lack)
        spread = max(spreads, key=lambda one: one[0] * student(known.level, one[1]))
        if spread[0] > known.scale:
            return replace(known, spread=spread)
    return known


def _alike(known: Uncertainty, column: str) -> float:
    data = known.fit.measurement
    return alike(known.fit.residual, data.omega, levels_of(column, data.points.need(column)))


def _spanned(columns: Real, whole: Real | None = None) -> Real:
    """Orthonormal basis of columns of which something is left beside their whole size."""
    size = np.linalg.norm(columns, axis=0)
    if whole is None:
        whole = size
    kept = size > np.sqrt(RANK) * np.maximum(whole, 1e-300)
    if not np.any(kept):
        return np.zeros((len(columns), 0))
    left, values, _ = np.linalg.svd(columns[:, kept] / size[kept], full_matrices=False)
    return np.asarray(left[:, values > np.sqrt(RANK) * values[0]], dtype=np.float64)


def _without(basis: Real, columns: Real) -> Real:
    return np.asarray(columns - basis @ (basis.T @ columns), dtype=np.float64)
