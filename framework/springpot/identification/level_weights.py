"""How points weigh where a material is shifted from level to level of a condition.

One noise for a master curve, its laws, and any command that fits such a model: sweeps of one series
share what their standard deviations hold beyond scatter, and a level that no material follows is
worth less than the others.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import f_sf
from springpot.measurement.measurement import Measurement
from springpot.rheology.continuum import Continuum
from springpot.rheology.effect import Layer
from springpot.rheology.levels import levels_of
from springpot.rheology.model import Model
from springpot.rheology.points import Complex, Real
from springpot.thresholds import SUPERPOSITION

from ..numerics import ROUNDING
from .levels_alone import ANY, Alone, each_alone, parts_of
from .material import is_material
from .problem import Objective, default_objective, relative_objective


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


def shifted_by(model: Model) -> str:
    """The condition by which a model of any material is shifted; empty of any other model.

    Where the rig or the signals are in the model too, no material follows a level by itself.
    """
    columns = sorted(
        {name for each in model.effects if each.plane == "shift" for name in each.needs}
    )
    of_levels = all(each.layer == Layer.TEMPERATURE for each in model.effects)
    if is_material(model) and of_levels and len(columns) == 1:
        return columns[0]
    return ""


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
    means = np.bincount(number, values) / np.bincount(number)
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
            if looked * float(f_sf(ratio, own.dof[level], part.dof)) < SUPERPOSITION.alarm:
                factors[level, i] = 1.0 / max(part.share, ROUNDING**2)
    return np.asarray(factors[:, 0] + 1j * factors[:, 1], dtype=np.complex128)


def _too_large(own: Alone) -> float:
    """How many times the scatter standard deviations are that weigh it; 0 where they are it."""
    dof, cost = float(own.dof[own.judged].sum()), float(own.cost[own.judged].sum())
    # Where each level's own material leaves as much as is given, it is that of scatter.
    if not dof or cost >= SUPERPOSITION.shared_errors**2 * dof:
        return 0.0
    return float(np.sqrt(dof / max(cost, 1e-300)))
