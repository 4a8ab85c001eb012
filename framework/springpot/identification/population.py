"""Specimens as a population: the mean of a parameter that each has for itself, and its scatter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

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
    groups : Value, optional
        Standard deviation between the batches that the specimens are of, where they are told;
        `between` is then that of specimens within a batch.
    """

    mean: Value
    between: Value
    specimens: Mapping[str, float]
    relative: bool = True
    groups: Value | None = None

    def to_dict(self) -> dict[str, Any]:
        """As in the schema, where the specimens stand by themselves."""
        told = {"between": self.between, "between_groups": self.groups}
        ends = ("value", "low", "high")
        scatter = {
            key: {name: getattr(each, name) for name in ends} for key, each in told.items() if each
        }
        return dict(jsonable({"mean": self.mean.to_dict(), **scatter}))


def populations(
    model: Model,
    values: Real,
    covariance: Real,
    units: Units,
    conditions: Mapping[str, Real] | None = None,
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
    conditions : mapping of str to ndarray, optional
        Columns of the data, which tell the batch of each specimen of ``batch/specimen``.
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
        groups = _groups(model.own[shared], conditions or {})
        unit = units.of(parameter.unit)[1]
        found[shared] = of_one(own, error, log, levels, unit, groups)
    return found


def _groups(column: str, conditions: Mapping[str, Real]) -> NDArray[np.intp] | None:
    """Number (n,) of the batch of each specimen, in the order of their own numbers."""
    outer = column.rpartition("/")[0]
    if outer not in conditions or column not in conditions:
        return None
    first = np.unique(conditions[column], return_index=True)[1]
    _, number = np.unique(conditions[outer][first], return_inverse=True)
    # As many batches as specimens tell nothing of what is between specimens of one.
    if not 1 < number.max() + 1 < len(number):
        return None
    return np.asarray(number.ravel(), dtype=np.intp)


class Component(NamedTuple):
    """A scatter beside known errors, by restricted maximum likelihood.

    Attributes
    ----------
    value, low, high : float
        Its standard deviation and the ends of its interval.
    means, covariance : ndarray, shape (b,), (b, b)
        What it scatters about, and how well that is known with it.
    drawn : ndarray, shape (n,)
        The values, drawn towards what they scatter about as far as their own errors ask for.
    misfit : float
        Sum of squares about it, in units of scatter and errors.
    """

    value: float
    low: float
    high: float
    means: Real
    covariance: Real
    drawn: Real
    misfit: float


def component(value: Real, error: Real, design: Real) -> Component:
    """The scatter of values (n,) about `design` (n, b) times means, beside their errors (n, n)."""
    spread, ways = np.linalg.eigh(error)
    turned, columns = ways.T @ value, ways.T @ design
    weight = 1.0 / (np.maximum(spread, 0.0) + SIZES[:, None] ** 2 + 1e-300)
    power = np.einsum("sn,nb,nc->sbc", weight, columns, columns)
    pull = np.einsum("sn,nb,n->sb", weight, columns, turned)
    means = np.linalg.solve(power, pull[..., None])[..., 0]
    apart = turned - means @ columns.T
    misfit = (weight * apart**2).sum(axis=1)
    _, determinant = np.linalg.slogdet(power)
    likelihood = -0.5 * (misfit - np.log(weight).sum(axis=1) + determinant)
    best, quantile = int(np.argmax(likelihood)), student(INTERVAL, len(value) - design.shape[1])
    inside = SIZES[2.0 * (likelihood[best] - likelihood) <= quantile**2]
    drawn = design @ means[best] + SIZES[best] ** 2 * (ways @ (weight[best] * apart[best]))
    ends = float(SIZES[best]), float(inside.min()), float(inside.max())
    return Component(*ends, means[best], np.linalg.inv(power[best]), drawn, float(misfit[best]))


def of_one(
    value: Real,
    error: Real,
    log: bool,
    levels: Sequence[str],
    unit: str,
    groups: NDArray[np.intp] | None = None,
) -> Population:
    """The population of one parameter, of values (n,) with the covariance (n, n) of their errors.

    Logarithms where `log`; `groups` (n,) number the batches that the specimens are of.

    By restricted maximum likelihood with a normal scatter between specimens (Patterson and Thompson
    1971, doi:10.1093/biomet/58.3.545). The interval of the mean is by Student's t with the scatter
    as it was found (Hartung and Knapp 2001, doi:10.1002/sim.1009), that of the scatter by the
    profile of the same likelihood.
    """
    count = len(value)
    if groups is None:
        within, outer = component(value, error, np.ones((count, 1))), None
        variance, spare = float(within.covariance[0, 0]), count - 1
        # A scatter that is smaller than errors alone would make it is no reason for a narrow
        # interval.
        variance *= max(within.misfit / spare, 1.0)
        mean, drawn = float(within.means[0]), within.drawn
    else:
        design = np.eye(int(groups.max()) + 1)[groups]
        within = component(value, error, design)
        outer = component(within.means, within.covariance, np.ones((design.shape[1], 1)))
        mean, spare = float(outer.means[0]), design.shape[1] - 1
        variance = _of_mean(error, design, within, outer)
        drawn = within.drawn + (outer.drawn - within.means)[groups]
    half = student(INTERVAL, spare) * np.sqrt(variance)
    ends = np.array([mean, mean - half, mean + half, *drawn])
    if log:
        ends = np.exp(ends)
    own = dict(zip(levels, ends[3:].tolist(), strict=True))
    middle, low, high = ends[:3].tolist()
    apart = Value(within.value, within.low, within.high, "-")
    groups_apart = None if outer is None else Value(outer.value, outer.low, outer.high, "-")
    return Population(Value(middle, low, high, unit), apart, own, log, groups_apart)


def _of_mean(error: Real, design: Real, within: Component, outer: Component) -> float:
    """Variance of the mean by the scatter of the batches' means alone, which are few.

    Of equal batches these are independent and normal, so that Student's t with one less than the
    batches is exact whatever the components are; never less than errors alone make.
    """
    count = len(within.means)
    variance = float(outer.covariance[0, 0]) * outer.misfit / (count - 1)
    whole = within.covariance + (outer.value**2 + 1e-300) * np.eye(count)
    share = np.linalg.solve(whole, np.ones(count))
    single = np.linalg.solve(error + (within.value**2 + 1e-300) * np.eye(len(error)), design)
    weight = single @ within.covariance @ (share / share.sum())
    return max(variance, float(weight @ error @ weight))


def specimens_of(found: Mapping[str, Population]) -> dict[str, dict[str, float]]:
    """The values of each specimen, by its level and the name of the parameter."""
    specimens: dict[str, dict[str, float]] = {}
    for name, population in found.items():
        for level, value in population.specimens.items():
            specimens.setdefault(level, {})[name] = value
    return specimens
