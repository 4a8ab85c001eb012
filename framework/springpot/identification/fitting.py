"""Step two of the paper for a user who wants the answer, and plain sentences about it.

`identify` gives parameters, their intervals, and what to know about them that numbers alone do not
say.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from math import sqrt
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from springpot.distributions import chi2_quantile, ends_of_draws
from springpot.errors import DataError, ModelError, OptionError
from springpot.measurement.measurement import CONDITIONS, Measurement
from springpot.rheology.elements import asked_as_measured
from springpot.rheology.levels import Levels
from springpot.rheology.model import Model
from springpot.rheology.nodes import FULL
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL
from springpot.writing import NAMED

from ..numerics import FEWEST, NEGLIGIBLE, ROUNDING
from .held_material import intervals_beside_material
from .intervals import bootstrap, over_specimens, profiled
from .kept import note_on_levels, words_in
from .known_factors import refused_in_words
from .levels_alone import usual_objective
from .material import is_material
from .native import Fit, fit, require_enough
from .normal import Bordered, variance_of
from .population import told
from .problem import Objective, Problem
from .result import Identification
from .robust import TUNED, robust_fit
from .runs import Optimiser
from .searching import NATIVE, STARTS, best_run, no_worse_than_simpler, searched
from .space import require_conditions, require_size
from .uncertainty import Uncertainty, printed_covariance
from .value import LOST

RESAMPLES = 400
"""Of a bootstrap: ten of them lie beyond each end of a 95 % interval."""


def identify(
    measurement: Measurement,
    model: Model,
    *,
    optimiser: Optimiser | None = None,
    objective: Objective | None = None,
    budget: int | None = None,
    restarts: int | None = None,
    seed: int | None = None,
    intervals: str = "jacobian",
    simpler: Sequence[Model] = (),
    start: Mapping[str, float] | None = None,
    robust: str | None = None,
) -> Identification:
    """Identify the parameters of a model.

    Parameters
    ----------
    measurement : Measurement
        The data.
    model : Model
        What is fitted.
    optimiser : Optimiser, optional
        Who searches; the native solver by default.
    objective : Objective, optional
        How the misfit is measured; by default as `usual_objective` says.
    budget : int, optional
        Evaluations of each restart of an optimiser; 8000 by default. The native solver ends by
        itself.
    restarts : int, optional
        Independent restarts of which the best counts, 1 by default; the native solver takes as many
        times its starts.
    seed : int, optional
        Seed of all randomness; without it the native solver's starts are its fixed ones.
    intervals : {"jacobian", "profile", "bootstrap"}
        Where the intervals come from. Those of the Jacobian hold also where a parameter without an
        end is elsewhere and the fit as good; see `beside_endless`.
    simpler : sequence of Model
        Models that this one contains: if one fits better, the search has failed and is repeated.
    start : mapping of str to float, optional
        Where the native solver begins too, in the units of the measurement; parameters that are
        left out start where they fit best beside these.
    robust : {"huber", "soft-l1"}, optional
        Let numbers that lie far off count less.

    Returns
    -------
    Identification
        Parameters, intervals and notes.

    Raises
    ------
    ModelError
        If the data lack a column that the model needs, or an optimiser is to search a material,
        whose spectrum is no search.
    DataError
        If there is one point only, or if there are more unknowns than data.
    OptionError
        If the optimiser fails: it raises, crashes, hangs, or no value was finite.

    Examples
    --------
    >>> import numpy as np
    >>> import springpot
    >>> from springpot.identification import identify
    >>> model, omega = springpot.parse_model("kelvin"), np.geomspace(1.0, 10.0, 8)
    >>> data = springpot.Measurement(omega, model.stiffness([2.0, 0.5], omega))
    >>> round(identify(data, model)["c"].value, 6)
    0.5
    """
    began = perf_counter()
    require_conditions(model, measurement)
    require_size(measurement)
    # Factors of levels are as many as the data have levels: only from here on are all parameters
    # known.
    model = model.bound_to(measurement.points)
    if len(measurement) < 2:
        raise DataError(
            f"{measurement.name}: one point identifies no model; measure at two frequencies or more"
        )
    require_enough(model, measurement)
    objective = usual_objective(model, measurement, objective)
    if optimiser is None or optimiser.name == NATIVE:
        name, status = NATIVE, "not converged"
        best, notes = _by_native(
            model, measurement, objective, restarts or 1, seed, simpler, start or {}
        )
        if best.converged:
            status = "converged"
    else:
        # Before the problem is made: what cannot be searched is told at once.
        refuse_search(model, optimiser, start)
        name, problem = optimiser.name, Problem.of(model, measurement, objective)
        best, status, notes = _by_optimiser(problem, optimiser, budget, restarts, seed)
    # Whoever has searched: intervals are told in one way.
    known = Uncertainty.of(best)
    if robust is not None:
        known, told_of_it = _robust(best, robust, name, intervals)
        notes = [*notes, told_of_it]
    told: dict[str, Any] = {"evaluations": best.evaluations}
    low, high, told["verdicts"] = _interval(known, intervals, seed or 0)
    notes = [*notes, *_references(model), *notes_on(known, low, high)]
    spent = perf_counter() - began
    told |= {"seconds": spent, "notes": tuple(notes), "seed": seed or 0}
    return Identification.of_sweep(known, low, high, name, status, **told)


def require_robust(loss: str, optimiser: str, intervals: str) -> None:
    """Refuse what no robust fit has.

    Raises
    ------
    OptionError
        If the loss is none, or if another search or other intervals are wanted.
    """
    if loss not in TUNED:
        raise OptionError(f"robust is {' or '.join(TUNED)}, not '{loss}'")
    if optimiser != NATIVE or intervals != "jacobian":
        raise OptionError(
            "a robust fit is the native solver's, with intervals by its jacobian:"
            " leave out the optimiser and the intervals"
        )


def _robust(best: Fit, loss: str, optimiser: str, intervals: str) -> tuple[Uncertainty, str]:
    """What robust weights make of a fit."""
    require_robust(loss, optimiser, intervals)

    def refit(objective: Objective, theta: Real) -> Fit:
        return fit(best.model, best.measurement, objective, starts=0, seeds_theta=[theta])

    return robust_fit(best, loss, refit)


def refuse_search(model: Model, optimiser: Optimiser, start: Mapping[str, float] | None) -> None:
    """Refuse what only the native solver can do."""
    if is_material(model):
        raise ModelError(
            f"{model.name}: the spectrum of a material is no search; leave out the optimiser"
        )
    if start:
        raise OptionError(
            f"the optimiser {optimiser.name} draws its own starts:"
            " leave out the start values, or it"
        )


def start_at(
    model: Model, start: Mapping[str, float], fitted: Callable[[Model], Fit | Identification]
) -> Real:
    """A start (p,) of which some values are given; the others are fitted beside them."""
    # What levels have for themselves begins alike in all of them, where it is named for all.
    pairs = list(zip(model.names, model.origins, strict=True))
    known = {name: value for name, value in start.items() if name not in model.origins}
    known |= {name: start[origin] for name, origin in pairs if origin in start}
    if set(known) != set(model.names):
        # The given values are held meanwhile, so that the others suit them.
        found = fitted(model.holding(known))
        known |= found.model.named(found.theta)
    # The lines of a free spectrum are no part of a start.
    return model.picked(known)


def _references(model: Model) -> list[str]:
    """Where the factors of levels are one."""
    elements = [
        (effect.name, effect.element)
        for effect in model.effects
        if isinstance(effect.element, Levels)
    ]
    return [
        f"{name}: the factor is 1 at {each.column} {each.shown[each.reference]:.6g}"
        for name, each in elements
    ]


def _by_native(
    model: Model,
    measurement: Measurement,
    objective: Objective,
    restarts: int,
    seed: int | None,
    simpler: Sequence[Model],
    start: Mapping[str, float],
) -> tuple[Fit, list[str]]:
    """The native fit, checked against the simpler models that it contains, and notes on that."""
    seeds = []
    if start:
        seeds = [
            start_at(model, start, lambda rest: fit(rest, measurement, objective, starts=STARTS))
        ]
    # Without a seed the scan stays where it is: the same data give the same answer.
    rng = None
    if seed is not None:
        rng = np.random.default_rng(seed)
    best = searched(model, measurement, objective, seeds, restarts, rng)
    if is_material(model):
        return best, []
    best, notes = no_worse_than_simpler(best, simpler)
    if not best.converged:
        notes.append(
            "the search did not come to rest: the parameters may be improved by more restarts"
        )
    return best, notes


def _by_optimiser(
    problem: Problem,
    optimiser: Optimiser,
    budget: int | None,
    restarts: int | None,
    seed: int | None,
) -> tuple[Fit, str, list[str]]:
    """The best of several supervised runs, as a fit."""
    best, notes = best_run(problem, optimiser, budget, restarts, seed)
    as_fit = Fit(
        problem.model,
        problem.measurement,
        problem.objective,
        best.theta,
        best.best,
        best.evaluations,
        # A run that its budget has ended may have been on its way still.
        best.status != "budget",
        best.seconds,
    )
    return as_fit, best.status, notes


def _interval(known: Uncertainty, kind: str, seed: int) -> tuple[Real, Real, tuple[str, ...]]:
    """Ends of the intervals (p,), and of profiles what they tell of each parameter."""
    if kind == "profile":
        found = [profiled(known, i) for i in range(len(known.fit.theta))]
        low, high = np.array([(each.low, each.high) for each in found]).T
        return low, high, tuple(each.verdict for each in found)
    return *_ends(known, kind, seed), ()


def _ends(known: Uncertainty, kind: str, seed: int) -> tuple[Real, Real]:
    if kind == "bootstrap":
        # A stream apart from the restarts, which draw from the seed alone.
        rng = np.random.default_rng([seed, 1])
        if known.specimens is None:
            drawn = bootstrap(known.fit, RESAMPLES, rng)
        else:
            drawn = over_specimens(known, RESAMPLES, rng)
        low, high = ends_of_draws(drawn, known.level)
        # Of a parameter as good as zero no two fits stop at the same tiny number: its interval
        # begins at the bound.
        bounds = np.array([[p.lower, p.upper] for p in known.fit.model.parameters]).T
        low = np.where(known.at_bound < 0, bounds[0], np.minimum(low, known.fit.theta))
        high = np.where(known.at_bound > 0, bounds[1], np.maximum(high, known.fit.theta))
        return low, high
    return intervals_beside_material(known)


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
