"""Step two of the paper for a user who wants the answer.

`identify` gives parameters, their intervals, and what to know about them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from time import perf_counter
from typing import Any

import numpy as np

from springpot.distributions import ends_of_draws
from springpot.errors import DataError, ModelError, OptionError
from springpot.measurement.measurement import Measurement
from springpot.rheology.levels import Levels
from springpot.rheology.model import Model
from springpot.rheology.points import Real

from .held_material import intervals_beside_material
from .intervals import bootstrap, over_specimens, profiled
from .levels_alone import usual_objective
from .material import is_material
from .native import Fit, fit, require_enough
from .notes import notes_on
from .problem import Objective, Problem
from .result import Identification
from .robust import TUNED, robust_fit
from .runs import Optimiser
from .searching import NATIVE, STARTS, best_run, no_worse_than_simpler, searched
from .space import require_conditions, require_size
from .uncertainty import Uncertainty

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
