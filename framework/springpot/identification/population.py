"""Specimens of one kind: fitted together, and as a population of which each has its own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import chi2_quantile, f_sf, normal_quantile, student
from springpot.measurement.conversion import FILE
from springpot.measurement.measurement import CONDITIONS, Measurement
from springpot.measurement.units import Units
from springpot.plain_data import jsonable
from springpot.rheology.parameters import Parameter
from springpot.rheology.points import Real
from springpot.rheology.tied import Follower
from springpot.thresholds import INTERVAL, WHERE

from ..numerics import FEWEST, SMALLEST
from .material import is_material
from .normal import Bordered, Covariance, LevelSlopes
from .value import Value

if TYPE_CHECKING:
    from springpot.rheology.model import Model

    from .native import Fit


@dataclass(frozen=True, eq=False)
class Specimens:
    """The files of a joint fit.

    Attributes
    ----------
    number : ndarray of int, shape (n,)
        Of the file that each point is from.
    count : int
        How many files there are.
    """

    number: NDArray[np.intp]
    count: int

    @classmethod
    def of(cls, measurement: Measurement) -> Specimens | None:
        """Those of joined files that all hold the same test.

        None where one file, each another condition, or no frequency within the ranges of all: then
        they are parts of one sweep, as cycles are that were recorded one frequency a file.
        """
        if FILE not in measurement.labels:
            return None
        names, number = np.unique(measurement.labels[FILE], return_inverse=True)
        if len(names) < 2:
            return None
        # A temperature in each file makes no specimens: what differs there is what was varied.
        for name in set(CONDITIONS) & set(measurement.conditions):
            levels = measurement.levels(name)
            if len({tuple(np.unique(levels[number == i])) for i in range(len(names))}) > 1:
                return None
        omega = [measurement.omega[number == i] for i in range(len(names))]
        if max(each.min() for each in omega) > min(each.max() for each in omega):
            return None
        return cls(number.astype(np.intp), len(names))

    def sandwich(self, jacobian: Real, residual: Real, inverse: Real) -> Real:
        """Covariance (p, p) from how much each specimen alone pulls at the parameters.

        Parameters
        ----------
        jacobian : ndarray, shape (2n, p)
            Of the weighted residuals, real parts first.
        residual : ndarray, shape (2n,)
            These residuals.
        inverse : ndarray, shape (p, p)
            Inverse of the jacobian's square.

        Notes
        -----
        Liang and Zeger 1986, doi:10.1093/biomet/73.1.13, with the factor G / (G - 1) of few
        clusters and Student's t of G - 1 degrees of freedom (Cameron and Miller 2015,
        doi:10.3368/jhr.50.2.317).
        """
        both = np.concatenate([self.number, self.number])
        pulls = np.array([jacobian[both == i].T @ residual[both == i] for i in range(self.count)])
        moved = pulls @ inverse
        return self.count / (self.count - 1) * moved.T @ moved

    def sandwich_of_levels(
        self, slopes: LevelSlopes, residual: Real, inverse: Bordered
    ) -> Bordered:
        """The same of specimens among levels that have parameters of their own."""
        both = np.concatenate([self.number, self.number])
        moved = inverse.times(slopes.pulls(residual, both, self.count))
        columns = np.sqrt(self.count / (self.count - 1)) * moved.T
        return replace(inverse, blocks=np.zeros_like(inverse.blocks), columns=columns)

    def scatter(self, fit: Fit) -> float:
        """Standard deviation of the specimens' stiffness over their mean.

        0 where noise alone may be all of it.
        """
        model = fit.model.stiffness(fit.theta, fit.measurement.points)
        off = (fit.measurement.stiffness - model) / model
        parts = [off[self.number == i].real for i in range(self.count)]
        means = np.array([part.mean() for part in parts])
        sizes = np.array([len(part) for part in parts])
        spare = int(sizes.sum()) - self.count
        if spare < 1:
            return 0.0
        within = sum(float(np.sum((part - part.mean()) ** 2)) for part in parts) / spare
        whole = float(np.average(means, weights=sizes))
        between = float(np.sum(sizes * (means - whole) ** 2)) / (self.count - 1)
        if f_sf(between / max(within, SMALLEST), self.count - 1, spare) > WHERE.levels_differ:
            return 0.0
        return float(np.sqrt(max(between - within, 0.0) / sizes.mean()))


def follows_specimens(fit: Fit) -> Specimens | None:
    """The specimens that the intervals of a fit can follow.

    None where they are too few, or it has a spectrum.
    """
    specimens = _among_levels(fit)
    if specimens is None or specimens.count < FEWEST or is_material(fit.model):
        return None
    return specimens


def _among_levels(fit: Fit) -> Specimens | None:
    """The specimens of a fit; None where each is a level that has parameters of its own.

    How levels differ is what their parameters say: they are no scatter of the others.
    """
    specimens = Specimens.of(fit.measurement)
    if specimens is None or fit.task.levels is None:
        return specimens
    level = fit.task.levels.layout.number
    pairs = np.unique(np.column_stack([level, specimens.number]), axis=0)
    return specimens if len(pairs) > len(np.unique(level)) else None


def told(fit: Fit) -> Iterator[str]:
    """What is to be known of specimens that were fitted together."""
    specimens = _among_levels(fit)
    if specimens is None:
        return
    scatter = specimens.scatter(fit)
    differ = "the files are taken for specimens of one kind"
    if scatter:
        differ = f"the specimens differ by {100.0 * scatter:.2g} %"
    if follows_specimens(fit) is not None:
        yield (
            f"{differ}: intervals follow the scatter of {specimens.count} specimens,"
            " not that of the points"
        )
    else:
        yield (
            f"{differ}: intervals do not know it, and are too narrow;"
            " three or more specimens would tell"
        )


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
        The value of each by its name, drawn towards the mean as far as its own error asks for.
    relative : bool
        Whether `between` is a share of the mean.
    groups : Value, optional
        Standard deviation between the batches that the specimens are of, where they are told;
        `between` is then that of specimens within a batch.
    limits : tuple of float, optional
        Between which 95 % of such specimens lie, at a confidence of 95 %; of specimens that are of
        one batch.
    compared : mapping of tuple of str to Value
        By two batches: the second over the first, or less it where the scatter is no share.
        The intervals hold all together.
    """

    mean: Value
    between: Value
    specimens: Mapping[str, float]
    relative: bool = True
    groups: Value | None = None
    limits: tuple[float, float] | None = None
    compared: Mapping[tuple[str, str], Value] = field(default_factory=dict)

    def told_apart(self, compared: Value) -> bool:
        """Whether two batches, as they were compared, differ for certain."""
        alike = 1.0 if self.relative else 0.0
        return not compared.low <= alike <= compared.high

    def to_dict(self) -> dict[str, Any]:
        """As in the schema, where the specimens stand by themselves."""
        told = {"between": self.between, "between_groups": self.groups}
        answer: dict[str, Any] = {"mean": self.mean.to_dict()}
        answer |= {key: _ends(each) for key, each in told.items() if each}
        if self.limits is not None:
            answer["limits"] = dict(zip(("low", "high"), self.limits, strict=True))
        if self.compared:
            answer["compared"] = [
                {"first": first, "second": second, **_ends(each)}
                for (first, second), each in self.compared.items()
            ]
        return dict(jsonable(answer))


def _ends(value: Value) -> dict[str, Any]:
    return {name: getattr(value, name) for name in ("value", "low", "high")}


def populations(
    model: Model,
    values: Real,
    covariance: Covariance,
    units: Units,
    words: Mapping[str, Sequence[str]],
    sweep: Measurement | None = None,
) -> dict[str, Population]:
    """Of each parameter that levels have for themselves, by the name that they share.

    None of a parameter of fewer than three levels, or that the data leave open at one of them.

    Parameters
    ----------
    model : Model
        The fitted model.
    values : ndarray, shape (p,)
        Its parameters in printed units.
    covariance : ndarray, shape (p, p), or Bordered
        Of these.
    units : Units
        Those of the data.
    words : mapping of str to sequence of str
        What specimens and batches are called, in the order of their numbers.
    sweep : Measurement, optional
        The data, which tell of ``batch/specimen`` the batch of each.
    """
    found = {}
    for kind in (*_of_levels(model, values, covariance), *_tied(model, values, covariance, units)):
        own, error = kind.values, kind.error
        # Sizes scatter by a share of themselves; an order, which may be zero, by itself.
        log = kind.parameter.scale == "log"
        if (
            len(own) < FEWEST
            or not np.all(np.isfinite(error.variance))
            or (log and np.any(own <= 0.0))
        ):
            continue
        if log:
            error = Errors(error.own / own**2, error.common / own[:, None])
            own = np.log(own)
        column = next(iter(model.own.values()))
        levels = words.get(column, kind.levels)
        batches = None if sweep is None else _batches(sweep, column, words)
        unit = units.of(kind.parameter.unit)[1]
        found[kind.name] = of_one(own, error, log, levels, unit, batches)
    return found


class OwnValues(NamedTuple):
    """A parameter that levels have for themselves, by the name that they share.

    Attributes
    ----------
    name : str
        That name.
    parameter : Parameter
        Of one level.
    values : ndarray, shape (n,)
        Of all of them, in printed units.
    error : Errors
        Of these.
    levels : list of str
        What the levels are called.
    """

    name: str
    parameter: Parameter
    values: Real
    error: Errors
    levels: list[str]


def _of_levels(model: Model, values: Real, covariance: Covariance) -> Iterator[OwnValues]:
    """The free parameters."""
    released = {each.name: each for each in model.released().parameters}
    names, rows_of = model.names, dict[str, list[int]]()
    for i, origin in enumerate(model.origins):
        rows_of.setdefault(origin, []).append(i)
    for shared in model.own:
        rows = rows_of[shared]
        # The share of an order is none of the released model's.
        parameter = released.get(shared, model.parameters[rows[0]])
        levels = [names[i][len(shared) + 1 :] for i in rows]
        yield OwnValues(shared, parameter, values[rows], _errors(covariance, rows), levels)


def _tied(model: Model, values: Real, covariance: Covariance, units: Units) -> Iterator[OwnValues]:
    """What follows from these by ties, and so is each level's own too."""
    factors = np.array([units.of(each.unit)[0] for each in model.parameters])
    told = dict[str, list[Follower]]()
    for each in model.followers(values / factors) if model.own and model.ties else ():
        if each.parameter.name != each.origin:
            told.setdefault(each.origin, []).append(each)
    for shared, rows in told.items():
        factor = units.of(rows[0].parameter.unit)[0]
        slopes = [factor * each.slopes / factors[each.at] for each in rows]
        errors = _carried(covariance, [each.at for each in rows], slopes)
        levels = [each.parameter.name[len(shared) + 1 :] for each in rows]
        own = factor * np.array([each.value for each in rows])
        yield OwnValues(shared, rows[0].parameter, own, errors, levels)


def _carried(covariance: Covariance, at: list[NDArray[np.intp]], slopes: list[Real]) -> Errors:
    """Those of what follows from parameters (k,) of each level by slopes (k,)."""
    if isinstance(covariance, Bordered):
        parts = [covariance.errors(*each) for each in zip(at, slopes, strict=True)]
        return Errors(np.array([own for own, _ in parts]), np.array([each for _, each in parts]))
    turn = np.zeros((len(at), len(covariance)))
    for row, places, slope in zip(turn, at, slopes, strict=True):
        row[places] = slope
    with np.errstate(invalid="ignore"):
        whole = np.nan_to_num(turn @ covariance @ turn.T, nan=np.inf)
    return Errors.of(whole) if np.all(np.isfinite(whole)) else Errors(np.diag(whole), turn[:, :0])


def _errors(covariance: Covariance, rows: list[int]) -> Errors:
    """Those of one parameter of all levels, by its numbers."""
    if not isinstance(covariance, Bordered):
        return Errors.of(covariance[np.ix_(rows, rows)])
    alone = np.zeros(len(covariance.lost))
    alone[covariance.layout.own] = np.diagonal(covariance.blocks, axis1=1, axis2=2)
    alone[covariance.lost] = np.inf
    return Errors(alone[rows], covariance.columns[rows])


def _batches(
    sweep: Measurement, column: str, words: Mapping[str, Sequence[str]]
) -> list[str] | None:
    """The batch (n,) of each specimen, in the order of their own numbers."""
    outer, conditions = column.rpartition("/")[0], sweep.conditions
    if outer not in conditions or column not in conditions:
        return None
    first = np.unique(conditions[column], return_index=True)[1]
    levels, number = np.unique(conditions[outer][first], return_inverse=True)
    # As many batches as specimens tell nothing of what is between specimens of one.
    if not 1 < len(levels) < len(number):
        return None
    names = words.get(outer, [f"{level:g}" for level in levels])
    return [names[i] for i in number.ravel().tolist()]


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


class Errors(NamedTuple):
    """Covariance of the errors of values: each has its own, and some they have in common.

    Attributes
    ----------
    own : ndarray, shape (n,)
        Variances of those of each alone.
    common : ndarray, shape (n, k)
        The common ones, each of unit variance: times its own transpose their covariance.
    """

    own: Real
    common: Real

    @classmethod
    def of(cls, covariance: Real) -> Errors:
        """Those of a covariance (n, n), of which as much as there can be is each one's own."""
        own = np.diag(covariance)
        if np.array_equal(covariance, np.diag(own)):
            return cls(own, np.zeros((len(own), 0)))
        spread, ways = np.linalg.eigh(covariance)
        least = max(float(spread[0]), 0.0)
        return cls(np.full(len(own), least), ways * np.sqrt(np.maximum(spread - least, 0.0)))

    @property
    def variance(self) -> Real:
        """Of each value, (n,)."""
        return np.asarray(self.own + np.sum(self.common**2, axis=1))

    def times(self, vector: Real) -> Real:
        """The covariance times a vector (n,)."""
        return np.asarray(self.own * vector + self.common @ (self.common.T @ vector))

    def beside(self, square: float, right: Real) -> Real:
        """Solution (n, b) of the covariance and a further variance of each (Woodbury 1950)."""
        weight = 1.0 / (self.own + square + SMALLEST)
        part = weight[:, None] * self.common
        inner = np.eye(self.common.shape[1]) + self.common.T @ part
        return weight[:, None] * right - part @ np.linalg.solve(inner, part.T @ right)


def component(value: Real, error: Errors, design: Real) -> Component:
    """The scatter of values (n,) about `design` (n, b) times means, beside their errors."""
    weight = 1.0 / (error.own + SIZES[:, None] ** 2 + SMALLEST)
    count, columns = design.shape[1], np.column_stack([design, value, error.common])
    # Of each size: products of all columns, and less what common errors take from these.
    products = np.array([weight @ (columns * each[:, None]) for each in columns.T])
    products = np.moveaxis(products, 1, 0)
    mine, border = products[:, :count, : count + 1], products[:, count + 1 :, : count + 1]
    inner = np.eye(error.common.shape[1]) + products[:, count + 1 :, count + 1 :]
    taken = np.matmul(np.swapaxes(border[..., :count], 1, 2), np.linalg.solve(inner, border))
    power, pull = (mine - taken)[..., :count], (mine - taken)[..., count:]
    means = np.linalg.solve(power, pull)[..., 0]
    # What is left itself, as it may be a small difference of large squares.
    apart = value - means @ design.T
    along = (weight * apart) @ error.common
    misfit = (weight * apart**2).sum(axis=1)
    misfit -= (along * np.linalg.solve(inner, along[..., None])[..., 0]).sum(axis=1)
    determinant = np.linalg.slogdet(power)[1] + np.linalg.slogdet(inner)[1]
    likelihood = -0.5 * (misfit - np.log(weight).sum(axis=1) + determinant)
    best, quantile = int(np.argmax(likelihood)), student(INTERVAL, len(value) - count)
    inside = SIZES[2.0 * (likelihood[best] - likelihood) <= quantile**2]
    square = float(SIZES[best]) ** 2
    pulled = error.beside(square, apart[best][:, None])[:, 0]
    drawn = design @ means[best] + square * pulled
    # What reaches the end of those that were tried has none that the data tell.
    most = float(inside.max()) if inside.max() < SIZES[-1] else float("inf")
    ends = float(SIZES[best]), float(inside.min()), most
    covariance = np.linalg.inv(power[best])
    return Component(*ends, means[best], covariance, drawn, float(apart[best] @ pulled))


def of_one(
    value: Real,
    error: Real | Errors,
    log: bool,
    levels: Sequence[str],
    unit: str,
    batches: Sequence[str] | None = None,
) -> Population:
    """The population of one parameter, of values (n,) with their errors or these' covariance.

    Logarithms where `log`; `batches` (n,) are those that the specimens are of.

    By restricted maximum likelihood with a normal scatter between specimens (Patterson and Thompson
    1971, doi:10.1093/biomet/58.3.545). The interval of the mean is by Student's t with the scatter
    as it was found (Hartung and Knapp 2001, doi:10.1002/sim.1009), that of the scatter by the
    profile of the same likelihood.
    """
    count, compared, limits = len(value), {}, None
    if not isinstance(error, Errors):
        error = Errors.of(error)
    if batches is None:
        within, outer = component(value, error, np.ones((count, 1))), None
        variance, spare = float(within.covariance[0, 0]), count - 1
        # A scatter that is smaller than errors alone would make it is no reason for a narrow
        # interval.
        variance *= max(within.misfit / spare, 1.0)
        mean, drawn = float(within.means[0]), within.drawn
        limits = _limits(mean, within.value, error.variance, log)
    else:
        names = list(dict.fromkeys(batches))
        groups = np.array([names.index(each) for each in batches])
        design = np.eye(len(names))[groups]
        within = component(value, error, design)
        outer = component(within.means, Errors.of(within.covariance), np.ones((len(names), 1)))
        mean, spare = float(outer.means[0]), design.shape[1] - 1
        variance = _of_mean(error, design, within, outer)
        # What is sure of itself stays where it is, wherever its batch is drawn to.
        moved = error.times((outer.drawn - within.means)[groups])
        drawn = within.drawn + error.beside(within.value**2, moved[:, None])[:, 0]
        compared = _compared(within, names, count, unit, log)
    half = student(INTERVAL, spare) * np.sqrt(variance)
    ends = np.array([mean, mean - half, mean + half, *drawn])
    if log:
        ends = np.exp(ends)
    own = dict(zip(levels, ends[3:].tolist(), strict=True))
    middle, low, high = ends[:3].tolist()
    apart = Value(within.value, within.low, within.high, "-")
    groups_apart = None if outer is None else Value(outer.value, outer.low, outer.high, "-")
    whole = Value(middle, low, high, unit)
    return Population(whole, apart, own, log, groups_apart, limits, compared)


def _limits(mean: float, between: float, errors: Real, log: bool) -> tuple[float, float]:
    """Tolerance limits: a share of specimens lies between them, at the same confidence.

    Those of Howe 1969 (doi:10.2307/2283644), for the scatter that is left of what was seen when the
    errors (n,) of the specimens' own values are taken off.
    """
    count, own = len(errors), float(np.mean(errors))
    seen = (count - 1) * (between**2 + own) / float(chi2_quantile(1.0 - INTERVAL, count - 1))
    most = max(seen - own, 0.0) + seen / count
    half = float(normal_quantile(0.5 * (1.0 + INTERVAL))) * np.sqrt(most)
    low, high = np.exp([mean - half, mean + half]) if log else (mean - half, mean + half)
    return float(low), float(high)


def _compared(
    within: Component, names: Sequence[str], count: int, unit: str, log: bool
) -> dict[tuple[str, str], Value]:
    """Each batch beside each that stands before it, by Student's t shared among all pairs.

    Bonferroni's intervals: all of them hold together as often as one alone is said to.
    """
    spare, pairs = count - len(names), list(combinations(range(len(names)), 2))
    level = 1.0 - (1.0 - INTERVAL) / len(pairs)
    quantile, share = student(level, spare), max(within.misfit / spare, 1.0)
    compared = {}
    for i, j in pairs:
        ways = np.zeros(len(names))
        ways[[i, j]] = -1.0, 1.0
        half = quantile * np.sqrt(share * float(ways @ within.covariance @ ways))
        ends = float(ways @ within.means) + half * np.array([0.0, -1.0, 1.0])
        value, low, high = (np.exp(ends) if log else ends).tolist()
        compared[names[i], names[j]] = Value(value, low, high, "-" if log else unit)
    return compared


def _of_mean(error: Errors, design: Real, within: Component, outer: Component) -> float:
    """Variance of the mean by the scatter of the batches' means alone, which are few.

    Of equal batches these are independent and normal, so that Student's t with one less than the
    batches is exact whatever the components are; never less than errors alone make.
    """
    count = len(within.means)
    variance = float(outer.covariance[0, 0]) * outer.misfit / (count - 1)
    whole = within.covariance + (outer.value**2 + SMALLEST) * np.eye(count)
    share = np.linalg.solve(whole, np.ones(count))
    single = error.beside(within.value**2, design)
    weight = single @ within.covariance @ (share / share.sum())
    return max(variance, float(weight @ error.times(weight)))


def specimens_of(found: Mapping[str, Population]) -> dict[str, dict[str, float]]:
    """The values of each specimen, by its own name and that of the parameter."""
    specimens: dict[str, dict[str, float]] = {}
    for name, population in found.items():
        for level, value in population.specimens.items():
            specimens.setdefault(level, {})[name] = value
    return specimens
