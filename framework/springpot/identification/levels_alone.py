"""Each level of sweeps with a material of its own: what no common one could do better."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import f_sf
from springpot.measurement.independence import frequency_numbers
from springpot.measurement.measurement import Measurement
from springpot.rheology.elements import Continuum
from springpot.rheology.levels import levels_of
from springpot.rheology.model import Model
from springpot.rheology.points import Complex, Real
from springpot.thresholds import SUPERPOSITION, VERDICT

from ..numerics import ROUNDING, SMALLEST, level_means, rms, set_numbers
from .material import shifted_by
from .native import fit
from .problem import Objective, default_objective, relative_objective

ANY = Continuum()
"""Any material, as sweeps show it."""
FEW = 4
"""Points of a level from which it can be fitted by itself."""


@dataclass(frozen=True, eq=False)
class Alone:
    """Each level with a material of its own.

    Attributes
    ----------
    cost, dof : ndarray, shape (m,)
        Sum of squared weighted residuals and its degrees of freedom; nan and 0 where there are too
        few points.
    error : ndarray, shape (m,)
        Relative error.
    repeats : ndarray, shape (m,)
        Relative scatter of repeated points; zero where none is.
    low, high : ndarray, shape (m,)
        Least and largest ln|K| of its material where it was measured; nan where it was not fitted.
    """

    cost: Real
    dof: Real
    error: Real
    repeats: Real
    low: Real
    high: Real

    @classmethod
    def exact(cls, count: int) -> Alone:
        """Levels without any scatter, none of them fitted."""
        nothing = np.full(count, np.nan)
        return cls(nothing, np.zeros(count), nothing, np.zeros(count), nothing, nothing)

    @property
    def share(self) -> Real:
        """Factors (m,) on the weights.

        Below one at levels that no material follows as nearly as elsewhere: their error would bend
        the curve at the neighbours, where there is none. It is the root of the ratio of errors: by
        the ratio itself such a level is all but left out and ends anywhere (the tape at -40 degC
        5.1 % off, not 3.9 %).
        """
        strange = self.strange
        if not np.any(strange):
            return np.ones(len(self.error))
        ratio = np.median(self.error[self.judged]) / np.maximum(self.error, ROUNDING**2)
        return np.where(strange, np.sqrt(np.where(strange, ratio, 1.0)), 1.0)

    @property
    def strange(self) -> NDArray[np.bool_]:
        """Levels that no material follows as nearly as elsewhere, though repeats differ less."""
        judged = self.judged
        if not np.any(judged):
            return judged
        error = np.where(judged, self.error, 0.0)
        far_off = error > SUPERPOSITION.stands_out * np.median(error[judged])
        return np.asarray(far_off & (error > VERDICT.agrees * self.repeats))

    @property
    def judged(self) -> NDArray[np.bool_]:
        """Levels with points enough."""
        return np.asarray(np.isfinite(self.cost) & (self.dof > 0))


def each_alone(
    measurement: Measurement,
    number: NDArray[np.int64],
    objective: Objective,
    unfitted: Continuum = ANY,
) -> Alone:
    """A fit of any material to each level by itself.

    Parameters
    ----------
    measurement : Measurement
        All sweeps.
    number : ndarray of int, shape (n,)
        Level of each point.
    objective : Objective
        How the misfit is measured.
    unfitted : Continuum
        Any material, as these data show it.
    """
    material = Model("material", unfitted)
    m = int(number.max()) + 1
    cost, dof, error = np.full(m, np.nan), np.zeros(m), np.full(m, np.nan)
    low, high = np.full((2, m), np.nan)
    for level in range(m):
        part = measurement.subset(number == level, f"level {level}")
        # So few points a material follows nearly whatever they are.
        if len(np.unique(part.omega)) < FEW:
            continue
        own = fit(material, part, objective)
        line = own.model.stiffness(own.theta, part.points)
        cost[level], dof[level] = own.cost, own.dof
        error[level] = rms(np.abs(line / part.stiffness - 1.0))
        low[level], high[level] = np.log(np.abs(line).min()), np.log(np.abs(line).max())
    return Alone(cost, dof, error, repeat_scatter(measurement, number), low, high)


class StorageOrLoss(NamedTuple):
    """Storage or loss of a sweep by itself.

    Attributes
    ----------
    values : ndarray, shape (n,)
        In ascending order of frequency.
    share : float
        Median of its size over |K|.
    scatter, dof : float
        Its own relative scatter, with the degrees of freedom of that.
    """

    values: Real
    share: float
    scatter: float
    dof: float


def parts_of(sweep: Measurement) -> tuple[StorageOrLoss, StorageOrLoss]:
    """Storage and loss of a sweep, with the scatter that their own neighbours tell.

    J. von Neumann et al. 1941, doi:10.1214/aoms/1177731746.
    """
    order = np.argsort(sweep.omega, kind="stable")
    found = []
    for values in (sweep.storage[order], sweep.loss[order]):
        size = np.maximum(np.abs(values), ROUNDING**2)
        # Second differences that share points: each is worth 36 / 70 of a degree of freedom.
        bent = np.diff(values, 2) / size[1:-1]
        scatter = float(np.sqrt(np.mean(bent**2) / 6.0)) if len(bent) else 0.0
        share = float(np.median(size / sweep.magnitude[order]))
        found.append(StorageOrLoss(values, share, scatter, max(len(bent) * 36.0 / 70.0, 1.0)))
    return found[0], found[1]


def repeat_scatter(data: Measurement, number: NDArray[np.int64]) -> Real:
    """Relative scatter (m,) of points repeated at one level and frequency; zero where none is."""
    group = set_numbers(number, frequency_numbers(data))
    count = np.bincount(group)
    square = np.abs(data.stiffness / level_means(group, data.stiffness)[group] - 1.0) ** 2
    spare = np.bincount(number, 1.0 - 1.0 / count[group])
    summed = np.bincount(number, square)
    # One pair of repeats leaves one degree of freedom; without repeats there is nothing to divide.
    return np.asarray(np.sqrt(summed / np.maximum(spare, 1.0)))


class Weighing(NamedTuple):
    """How the points of sweeps at several levels weigh.

    Attributes
    ----------
    objective : Objective
        With levels that no material follows weighted by what they are worth.
    own : Alone
        Each level by itself, before that.
    note : str
        Why given standard deviations are not used; empty where they are, or none are given.
    """

    objective: Objective
    own: Alone
    note: str = ""


@dataclass(frozen=True, eq=False)
class _ByLevel:
    """Weights (n,) of an objective times factors (m,) of storage and of loss at each point's level.

    A function made on the spot would keep every fit from being pickled.
    """

    objective: Objective
    column: str
    levels: Real
    factors: Complex

    def __call__(self, measurement: Measurement) -> Complex:
        values = measurement.points.need(self.column)
        # By the nearest level, as a part of the data need not have all of them.
        nearest = np.argmin(np.abs(values[:, None] - self.levels), axis=1)
        weights, here = self.objective.weighing(measurement), self.factors[nearest]
        return np.asarray(weights.real * here.real + 1j * weights.imag * here.imag)


def usual_objective(
    model: Model, measurement: Measurement, asked: Objective | None = None
) -> Objective:
    """The objective of a model where none is asked for, and what levels are worth beside it.

    Parameters
    ----------
    model : Model
        What is fitted.
    measurement : Measurement
        To what.
    asked : Objective, optional
        How the misfit is to be measured.
    """
    column = shifted_by(model)
    if not column or column not in measurement.conditions:
        return asked or default_objective(measurement)
    return weighing_of(measurement, column, asked).objective


def weighing_of(
    measurement: Measurement,
    column: str,
    asked: Objective | None = None,
    unfitted: Continuum = ANY,
) -> Weighing:
    """How points weigh that one material is to follow at all levels of a condition.

    Parameters
    ----------
    measurement : Measurement
        All sweeps.
    column : str
        The condition.
    asked : Objective, optional
        How the misfit is to be measured; by default weighted by given standard deviations that are
        those of scatter, else relative.
    unfitted : Continuum
        Any material, as these data show it.
    """
    values = measurement.points.need(column)
    number = levels_of(column, values)
    objective, note = asked or default_objective(measurement), ""
    own = each_alone(measurement, number, objective, unfitted)
    if asked is None and measurement.sd is not None and (size := _too_large(own)):
        note = (
            f"the given standard deviations are {size:.2g} times the scatter within a sweep: they"
            " hold what all points share, so that relative differences are compared instead"
        )
        objective = relative_objective()
        own = each_alone(measurement, number, objective, unfitted)
    means = level_means(number, values)
    factors = _by_own_size(measurement, number, own, unfitted)
    if np.any(factors != 1.0 + 1.0j):
        by_part = _ByLevel(objective, column, means, factors)
        objective = replace(objective, weights=by_part)
        own = each_alone(measurement, number, objective, unfitted)
    share = own.share
    if np.all(share == 1.0):
        return Weighing(objective, own, note)
    by_level = _ByLevel(objective, column, means, share.astype(np.complex128) * (1.0 + 1.0j))
    return Weighing(replace(objective, weights=by_level), own, note)


def _by_own_size(
    measurement: Measurement, number: NDArray[np.int64], own: Alone, unfitted: Continuum
) -> Complex:
    """Factors (m,) on the weights of storage and of loss.

    The misfit counts relative to |K|. Of a glass the loss is a hundredth of it and less, so that
    the line might be anywhere within what |K| scatters by. A part that its own neighbours tell
    better than that counts relative to its own size.
    """
    factors = np.ones((len(own.error), 2))
    looked = 2 * max(int(own.judged.sum()), 1)
    # What no material follows is no scatter that a part could be beside.
    for level in np.flatnonzero(own.judged & ~own.strange).tolist():
        parts = parts_of(measurement.subset(number == level))
        for i, part in enumerate(parts[: len(unfitted.columns) - 1]):
            # What is left of |K|, relative to the part.
            left = own.error[level] / max(part.share, ROUNDING**2)
            if left <= SUPERPOSITION.missed:
                continue
            ratio = (left / max(part.scatter, ROUNDING**2)) ** 2
            if looked * float(f_sf(ratio, own.dof[level], part.dof)) < VERDICT.structure_alarm:
                factors[level, i] = 1.0 / max(part.share, ROUNDING**2)
    return np.asarray(factors[:, 0] + 1j * factors[:, 1], dtype=np.complex128)


def _too_large(own: Alone) -> float:
    """How many times the scatter standard deviations are that weigh it; 0 where they are it."""
    dof, cost = float(own.dof[own.judged].sum()), float(own.cost[own.judged].sum())
    # Where each level's own material leaves as much as is given, it is that of scatter.
    if not dof or cost >= SUPERPOSITION.shared_errors**2 * dof:
        return 0.0
    return float(np.sqrt(dof / max(cost, SMALLEST)))
