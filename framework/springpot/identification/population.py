"""Specimens as a population: the mean of a parameter that each has for itself, and its scatter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from springpot.distributions import student
from springpot.measurement.units import Units
from springpot.plain_data import jsonable
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL

from .value import Value

FEWEST = 3
"""Specimens from which their scatter is told: two leave one degree of freedom."""
SIZES = np.concatenate([[0.0], np.geomspace(1e-4, 3.0, 400)])
"""Standard deviations between specimens, relative to the mean, among which it is sought."""


@dataclass(frozen=True, eq=False)
class Population:
    """What the specimens say together of one parameter.

    Attributes
    ----------
    mean : Value
        The median over all specimens of the kind, with its 95 % interval.
    between : Value
        Standard deviation between them, relative to the mean; of an order as it is.
    specimens : mapping of str to float
        The value of each by its level, drawn towards the mean as far as its own error asks for.
    relative : bool
        Whether `between` is a share of the mean.
    """

    mean: Value
    between: Value
    specimens: Mapping[str, float]
    relative: bool = True

    def to_dict(self) -> dict[str, Any]:
        """As in the schema, where the specimens stand by themselves."""
        between = {name: getattr(self.between, name) for name in ("value", "low", "high")}
        return dict(jsonable({"mean": self.mean.to_dict(), "between": between}))


def populations(
    model: Model, values: Real, covariance: Real, units: Units
) -> dict[str, Population]:
    """Of each parameter that levels have for themselves, by the name that they share.

    None of a parameter of fewer than three levels, or that the data leave open at one of them.

    Parameters
    ----------
    model : Model
        The fitted model.
    values : ndarray, shape (p,)
        Its parameters in printed units.
    covariance : ndarray, shape (p, p)
        Of these.
    units : Units
        Those of the data.
    """
    found, released = {}, {each.name: each for each in model.released().parameters}
    for shared in model.own:
        rows = [i for i, origin in enumerate(model.origins) if origin == shared]
        # The share of an order is none of the released model's.
        parameter = released.get(shared, model.parameters[rows[0]])
        own, error = values[rows], covariance[np.ix_(rows, rows)]
        # Sizes scatter by a share of themselves; an order, which may be zero, by itself.
        log = parameter.scale == "log"
        if len(rows) < FEWEST or not np.all(np.isfinite(error)) or (log and np.any(own <= 0.0)):
            continue
        if log:
            own, error = np.log(own), error / np.outer(own, own)
        start = len(shared) + 1
        levels = [model.names[i][start:] for i in rows]
        found[shared] = of_one(own, error, log, levels, units.of(parameter.unit)[1])
    return found


def of_one(value: Real, error: Real, log: bool, levels: Sequence[str], unit: str) -> Population:
    """The population of one parameter, of values (n,) with the covariance (n, n) of their errors.

    Logarithms where `log`.

    By restricted maximum likelihood with a normal scatter between specimens (Patterson and Thompson
    1971, doi:10.1093/biomet/58.3.545). The interval of the mean is by Student's t with the scatter
    as it was found (Hartung and Knapp 2001, doi:10.1002/sim.1009), that of the scatter by the
    profile of the same likelihood.
    """
    spread, ways = np.linalg.eigh(error)
    turned, ones = ways.T @ value, ways.T @ np.ones(len(value))
    weight = 1.0 / (np.maximum(spread, 0.0) + SIZES[:, None] ** 2 + 1e-300)
    power = (weight * ones**2).sum(axis=1)
    means = (weight * ones * turned).sum(axis=1) / power
    misfit = (weight * (turned - means[:, None] * ones) ** 2).sum(axis=1)
    likelihood = -0.5 * (misfit - np.log(weight).sum(axis=1) + np.log(power))
    best, quantile = int(np.argmax(likelihood)), student(INTERVAL, len(value) - 1)
    inside = SIZES[2.0 * (likelihood[best] - likelihood) <= quantile**2]
    # A scatter that is smaller than errors alone would make it is no reason for a narrow interval.
    half = quantile * np.sqrt(max(misfit[best] / (len(value) - 1), 1.0) / power[best])
    apart = weight[best] * (turned - means[best] * ones)
    drawn = means[best] + SIZES[best] ** 2 * (ways @ apart)
    ends = np.array([means[best], means[best] - half, means[best] + half, *drawn])
    if log:
        ends = np.exp(ends)
    own = dict(zip(levels, ends[3:].tolist(), strict=True))
    middle, low, high = ends[:3].tolist()
    between = Value(float(SIZES[best]), float(inside.min()), float(inside.max()), "-")
    return Population(Value(middle, low, high, unit), between, own, log)


def specimens_of(found: Mapping[str, Population]) -> dict[str, dict[str, float]]:
    """The values of each specimen, by its level and the name of the parameter."""
    specimens: dict[str, dict[str, float]] = {}
    for name, population in found.items():
        for level, value in population.specimens.items():
            specimens.setdefault(level, {})[name] = value
    return specimens
