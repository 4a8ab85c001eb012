"""Plain sentences about a fit that its numbers alone do not say."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import sqrt
from typing import NamedTuple

import numpy as np

from springpot.distributions import chi2_quantile
from springpot.measurement.measurement import CONDITIONS
from springpot.rheology.elements import asked_as_measured
from springpot.rheology.model import Model
from springpot.rheology.nodes import FULL
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL
from springpot.writing import NAMED

from ..numerics import FEWEST, NEGLIGIBLE, ROUNDING
from .kept import note_on_levels, words_in
from .known_factors import refused_in_words
from .material import is_material
from .native import Fit
from .normal import Bordered, variance_of
from .population import told
from .uncertainty import Uncertainty, printed_covariance
from .value import LOST


class NoteLevels(NamedTuple):
    """From where something is told of a fit."""

    weak: float
    """Width of an interval, over its value, from which a parameter is called weakly identified."""
    correlated: float
    """Correlation from which a pair is told.

    Either interval is then five times what it were with the other known.
    """
    loose: float
    """Given standard deviations that a misfit may be on average before intervals by them are called
    too narrow.
    """
    specimens: int
    """Specimens from which their scatter is known within a factor of two and a half."""
    settling: float
    """Power of omega by which the loss falls towards rest: level it were 0, at rest it is 1."""
    near_end: float
    """The same that may be taken for none: the phase is within 9 degrees of a spring's or a
    dashpot's.
    """


TOLD = NoteLevels(weak=1.0, correlated=0.98, loose=2.0, specimens=6, settling=0.5, near_end=0.1)


def notes_on(known: Uncertainty, low: Real, high: Real) -> list[str]:
    """What a user should know about a fit.

    Parameters
    ----------
    known : Uncertainty
        The fit and what the Jacobian says about it.
    low, high : ndarray, shape (p,)
        Ends of the parameters' intervals.

    Returns
    -------
    list of str
        Plain sentences, the gravest first.
    """
    return [
        *_undetermined(known.fit),
        *refused_in_words(known.fit),
        *notes_on_specimens(known.fit.model, words_in(known.fit.measurement)),
        *told(known.fit),
        *_bounds(known),
        *_slower_still(known.fit, high),
        *_orders(known, low, high),
        *_weak(known, low, high),
        *_correlated(known),
        *_too_narrow(known),
    ]


def _undetermined(fit: Fit) -> Iterator[str]:
    if fit.dof == 0:
        yield (
            "there are as many parameters as measured numbers: nothing is left to judge the fit by"
        )


def notes_on_specimens(model: Model, words: Mapping[str, Sequence[str]]) -> Iterator[str]:
    """What the levels with parameters of their own are called, and what so few cannot tell."""
    for column in dict.fromkeys(model.own.values()):
        if note := note_on_levels(words, column):
            yield note
    if not model.own or set(model.own.values()) & set(CONDITIONS):
        return
    count = len(model.places)
    if count < FEWEST:
        yield f"{count} specimens do not tell how others would differ: three or more do"
    elif count < TOLD.specimens:
        # Of a normal scatter, by its chi-square.
        most = sqrt((count - 1) / float(chi2_quantile(0.5 * (1.0 - INTERVAL), count - 1)))
        yield (
            f"{count} specimens tell little of others: these may scatter {most:.2g} times as much"
            " as is seen, and mean and limits are as wide as that makes them"
        )


def _orders_of(fit: Fit) -> set[str]:
    """Names of the parameters that are orders."""
    parameters = fit.model.parameters
    # Not every number between 0 and 1 is an order: the unit of a constant has to depend on it.
    within = {each.name for each in parameters if (each.lower, each.upper) == (0.0, 1.0)}
    return within & {str(each.unit.time) for each in parameters}


def _bounds(known: Uncertainty) -> Iterator[str]:
    orders = _orders_of(known.fit)
    for parameter, side in zip(known.fit.model.parameters, known.at_bound.tolist(), strict=True):
        name = parameter.name
        # An order at its end is told as the element that it then is, the lines of a spectrum as a
        # whole.
        if side == 0 or parameter.detail or name in orders:
            continue
        if side < 0 and parameter.lower == 0.0:
            yield f"{name} is zero as far as these data show: a model without it fits as well"
        elif side > 0 and np.isinf(parameter.upper):
            yield f"{name} has grown without limit: its element is rigid as far as these data show"
        else:
            factor, unit = known.fit.measurement.units.of(parameter.unit)
            bound = parameter.upper
            if side < 0:
                bound = parameter.lower
            shown = f"{factor * bound:g}"
            if unit != "-":
                shown += f" {unit}"
            yield f"{name} rests on its bound {shown}: the data ask for more than the model allows"


def _slower_still(fit: Fit, high: Real) -> Iterator[str]:
    """What K_e of a material counts as well, where it has not come to rest at the slowest point."""
    if not is_material(fit.model) or not asked_as_measured(fit.model.network):
        return
    points = fit.measurement.points
    slow = int(np.argmin(points.log_omega))
    own = fit.theta[: len(fit.model.material.parameters)]
    response = fit.model.material.respond(own, points, FULL)
    value, slope = response.value[slow], response.by_log_omega[slow]
    # One that is zero has a note of its own.
    falls = 0.0 < fit.theta[0] <= high[0] < value.real
    if falls and slope.imag < TOLD.settling * value.imag:
        slowest = fit.measurement.units.at(float(np.min(fit.measurement.frequency)))
        yield (
            f"K_e counts all that relaxes more slowly than {slowest}: storage still falls there,"
            " and at rest it may be any less"
        )


def _orders(known: Uncertainty, low: Real, high: Real) -> Iterator[str]:
    element, orders = {0: "spring", 1: "dashpot"}, _orders_of(known.fit)
    for i, parameter in enumerate(known.fit.model.parameters):
        if parameter.name not in orders:
            continue
        for bound, end in ((0, low[i]), (1, high[i])):
            near = abs(known.fit.theta[i] - bound)
            if near < NEGLIGIBLE:
                yield f"{parameter.name} is {bound}: the springpot is a {element[bound]}"
            elif near < TOLD.near_end and abs(end - bound) < ROUNDING:
                yield (
                    f"{parameter.name} cannot be told from {bound}: a {element[bound]} for the"
                    " springpot fits too"
                )


def _weak(known: Uncertainty, low: Real, high: Real) -> Iterator[str]:
    open_ones, variance = [], variance_of(known.covariance)
    for i, parameter in enumerate(known.fit.model.parameters):
        name = parameter.name
        if known.at_bound[i] or parameter.detail:
            continue
        width = high[i] - low[i]
        size = abs(known.fit.theta[i])
        # Not "above": a width that is no number counts as well.
        if np.isinf(variance[i]) or not width < LOST * size:
            open_ones.append(name)
        elif width > TOLD.weak * size:
            yield (
                f"{name} is weakly identified: its interval is"
                f" {100 * width / max(size, 1e-300):.0f} % of its value"
            )
    if len(open_ones) == 1:
        yield f"{open_ones[0]} is not determined by these data: other values fit as well"
    elif open_ones:
        yield (
            f"{', '.join(open_ones[:-1])} and {open_ones[-1]} are not determined by these data:"
            " others fit as well"
        )


def _correlated(known: Uncertainty) -> list[str]:
    """The few most strongly correlated pairs."""
    names = known.fit.model.names
    if isinstance(known.covariance, Bordered):
        return _told_of_pairs(names, _pairs_of_levels(known.fit, known.covariance))
    detail = [i for i, parameter in enumerate(known.fit.model.parameters) if parameter.detail]
    correlation = np.nan_to_num(known.correlation)
    # Neighbouring lines of a spectrum are nearly one: nobody asks for either by itself.
    correlation[detail] = correlation[:, detail] = 0.0
    rows, columns = np.tril_indices(len(names), -1)
    return _told_of_pairs(names, zip(rows, columns, correlation[rows, columns], strict=True))


def _pairs_of_levels(fit: Fit, covariance: Bordered) -> Iterator[tuple[int, int, float]]:
    """Numbers of two parameters of one level, and their correlation."""
    known, seen = printed_covariance(fit, covariance), set[tuple[int, int]]()
    sd, places = np.sqrt(known.variance), known.layout.places
    rows, columns = np.tril_indices(places.shape[1], -1)
    with np.errstate(all="ignore"):
        sizes = sd[places[:, rows]] * sd[places[:, columns]]
        correlation = np.nan_to_num(known.of_levels[:, rows, columns] / sizes)
    numbers = (each.ravel().tolist() for each in (places[:, rows], places[:, columns], correlation))
    for i, j, size in zip(*numbers, strict=True):
        # Two that all levels share are a pair of each.
        if (i, j) not in seen:
            yield i, j, size
        seen.add((i, j))


def _told_of_pairs(names: Sequence[str], pairs: Iterable[tuple[int, int, float]]) -> list[str]:
    strong = [pair for pair in pairs if abs(pair[2]) > TOLD.correlated]
    strong.sort(key=lambda pair: -abs(pair[2]))
    return [
        f"{names[j]} and {names[i]} are strongly correlated ({size:+.3f}): the data"
        " fix a combination of them better than either"
        for i, j, size in strong[:NAMED]
    ]


def _too_narrow(known: Uncertainty) -> Iterator[str]:
    fit = known.fit
    if known.absolute and fit.dof > 0:
        # Where standard deviations are given each weighted residual should be one: more is misfit.
        ratio = float(np.sqrt(fit.cost / fit.dof))
        if ratio > TOLD.loose:
            yield (
                f"the misfit is {ratio:.1f} times the given standard deviations: the model lacks"
                " something or they are too small, and the intervals are too narrow"
            )
