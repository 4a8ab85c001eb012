"""Step two of the paper for a user who wants the answer.

Parameters, their intervals, and what to know about them.

A run of an optimiser in a process of its own: whatever it does there ends there, and is told.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from time import perf_counter
from typing import Any

import numpy as np

from springpot.errors import LONGEST_REASON, DataError, ModelError, OptionError
from springpot.measurement.measurement import Measurement
from springpot.rheology.levels import Levels
from springpot.rheology.model import Model
from springpot.rheology.points import Real

from ..numerics import NEGLIGIBLE
from .free_factors import superposed_fit
from .held_material import intervals_beside_material
from .intervals import bootstrap, over_specimens, profiled
from .levels_alone import shifted_by, usual_objective
from .material import is_material
from .native import Fit, fit, require_enough
from .notes import notes_on
from .problem import Objective, Problem, Searched
from .result import Identification
from .robust import TUNED, robust_fit
from .runs import Optimiser, Run, contradiction, run
from .space import require_conditions, require_size
from .uncertainty import Uncertainty

DEADLINE = 300.0
"""Seconds of a run, as in a study."""
MEMORY = 2048
"""MiB that a run may take, as in a study."""


def guarded(optimiser: Optimiser, problem: Searched, budget: int, rng: np.random.Generator) -> Run:
    """`run` in a process of its own; a crash, a hang or a forged record is a run that failed.

    The process is a copy of this one. Where other threads run here, that would not be safe, and the
    run takes place in this process; its record is checked all the same.

    Parameters
    ----------
    optimiser, problem, budget, rng
        As for `run`.
    """
    from springpot.processes import can_copy

    if can_copy():
        outcome = _elsewhere(optimiser, problem, budget, rng)
    else:
        outcome = run(optimiser, problem, budget, rng)
    if outcome.failed:
        return outcome
    wrong = contradiction(outcome, problem, budget)
    if wrong:
        return _failure(optimiser, problem, wrong)
    return outcome


def _failure(optimiser: Optimiser, problem: Searched, reason: str) -> Run:
    nowhere = np.full(problem.dimension, np.nan)
    theta = np.full(len(problem.space.model.names), np.nan)
    return Run(optimiser.name, f"failed: {reason}", np.inf, nowhere, theta, 0, 0, 0.0, ())


def _elsewhere(
    optimiser: Optimiser, problem: Searched, budget: int, rng: np.random.Generator
) -> Run:
    from springpot.processes import elsewhere, unpacked

    def action(report: Callable[[bytes], object]) -> None:
        try:
            outcome = run(optimiser, problem, budget, rng)
        except BaseException as error:
            # Nothing interrupts this process from outside: whatever it is, the optimiser raised it.
            outcome = _failure(optimiser, problem, f"{type(error).__name__}: {error}")
        report(pickle.dumps(_plain(outcome)))

    ended = elsewhere(action, DEADLINE, MEMORY)
    if ended.late:
        return _failure(optimiser, problem, f"it did not end within {DEADLINE:g} s")
    try:
        return _told(optimiser, problem, unpacked(ended.message))
    except Exception:
        # What was cut short or never was a run tells nothing: how the process ended is told
        # instead.
        return _failure(optimiser, problem, ended.cause)


def _plain(outcome: Run) -> dict[str, Any]:
    """What is sent of a run: plain values, of which none is called where they are read."""
    told = {field.name: getattr(outcome, field.name) for field in fields(Run)}
    return told | {"point": outcome.point.tolist(), "best_x": None, "theta": None, "diary": None}


def _told(optimiser: Optimiser, problem: Searched, told: dict[str, Any]) -> Run:
    """The run again; what follows from its best point is reckoned here."""
    point, space = np.array(told["point"], dtype=float), problem.space
    x = np.full(problem.dimension, np.nan)
    if point.size:
        x = space.repaired(point.reshape(problem.dimension))
    return Run(
        optimiser.name,
        str(told["status"]),
        float(told["best"]),
        x,
        space.theta(x),
        int(told["evaluations"]),
        int(told["gradients"]),
        float(told["seconds"]),
        tuple((int(number), float(value)) for number, value in told["trace"]),
        int(told["batched"]),
        point=point,
        factor=float(told["factor"]),
        processor=float(told["processor"]),
        # One line each, whatever a library has put into it.
        remarks=tuple(" ".join(str(text).split())[:LONGEST_REASON] for text in told["remarks"]),
    )


NATIVE = "native"
BUDGET = 8000
"""Evaluations of a restart: 20 particles and 400 time instances, as in section 5.1 of the paper."""
STARTS = 8
"""Starts of a native fit, for each restart."""
MORE_STARTS = 32
"""Starts of a fit that has not been confirmed, or that a simpler model beats."""
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
        Where the intervals come from.
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


def _robust(best: Fit, loss: str, optimiser: str, intervals: str) -> tuple[Uncertainty, str]:
    """What robust weights make of a fit."""
    if loss not in TUNED:
        raise OptionError(f"robust is {' or '.join(TUNED)}, not '{loss}'")
    if optimiser != NATIVE or intervals != "jacobian":
        raise OptionError(
            "a robust fit is the native solver's, with intervals by its jacobian:"
            " leave out the optimiser and the intervals"
        )

    def refit(objective: Objective, theta: Real) -> Fit:
        return fit(best.model, best.measurement, objective, starts=0, seeds_theta=[theta])

    return robust_fit(best, loss, refit)


def searched(
    model: Model,
    measurement: Measurement,
    objective: Objective | None = None,
    seeds_theta: Sequence[Real] = (),
    restarts: int = 1,
    rng: np.random.Generator | None = None,
) -> Fit:
    """The search by which `identify` finds parameters, and a diagnosis the errors it prints.

    Parameters
    ----------
    model : Model
        What is fitted.
    measurement : Measurement
        To what.
    objective : Objective, optional
        How the misfit is measured; by default as `usual_objective` says.
    seeds_theta : sequence of ndarray, shape (p,)
        Starts worth trying beside those read off the data.
    restarts : int
        As many times the usual starts.
    rng : numpy.random.Generator, optional
        Moves the scanned shapes; without it they are always the same.
    """
    if objective is None:
        objective = usual_objective(model, measurement)
    if shifted_by(model):
        return superposed_fit(model, measurement, objective, seeds_theta)
    best = fit(
        model, measurement, objective, starts=STARTS * restarts, rng=rng, seeds_theta=seeds_theta
    )
    # A spectrum has a solver of its own (`fit_spectrum`), which takes no further starts.
    if is_material(model) or (best.converged and best.confirmed):
        return best
    # Begun where the first has ended too, so that it cannot become worse.
    return _better(
        best, fit(model, measurement, objective, starts=MORE_STARTS, seeds_theta=[best.theta])
    )


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
        known |= dict(zip(found.model.names, found.theta.tolist(), strict=True))
    # The lines of a free spectrum are no part of a start.
    return model.vector({name: known[name] for name in model.names})


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
    best, notes = _no_worse_than_simpler(best, simpler)
    if not best.converged:
        notes.append(
            "the search did not come to rest: the parameters may be improved by more restarts"
        )
    return best, notes


def _no_worse_than_simpler(whole: Fit, simpler: Sequence[Model]) -> tuple[Fit, list[str]]:
    """A fit, repeated from the best simpler one if that is better, and a note where it stays so.

    A model contains what it is without one of its effects, so its least objective cannot be the
    larger one.
    """
    model, measurement, objective = whole.model, whole.measurement, whole.objective
    # A failed search shows where a part of the model fits better than the whole.
    inner = [
        fit(part, measurement, objective, starts=STARTS)
        for part in (*_without_effects(model), *simpler)
    ]
    best = min(inner, key=lambda other: other.cost, default=None)
    if best is None or not _beats(best, whole):
        return whole, []
    seeds = [*_grown(best, model), whole.theta]
    whole = _better(
        whole, fit(model, measurement, objective, starts=MORE_STARTS, seeds_theta=seeds)
    )
    if _beats(best, whole):
        return whole, [
            f"the simpler {best.model.name} fits better than {model.name}: the search has failed"
        ]
    return whole, []


def _beats(simpler: Fit, whole: Fit) -> bool:
    """Whether a simpler model fits better by more than rounding."""
    # Below the floor a cost is rounding: of two exact fits neither beats the other.
    return bool(simpler.cost < whole.cost * (1.0 - NEGLIGIBLE) - whole.task.floor[0])


def _better(one: Fit, other: Fit) -> Fit:
    if other.cost <= one.cost:
        return other
    return one


def _without_effects(model: Model) -> list[Model]:
    """The models that lack one of the effects and have something left to be fitted."""
    # Of two effects of one kind it does not matter which is left out: each name counts once.
    names = dict.fromkeys(effect.name for effect in model.effects)
    lacking = [model - name for name in names]
    # Where all else is held.
    return [each for each in lacking if each.parameters]


def _grown(part: Fit, model: Model) -> list[Real]:
    """Starts of `model` at the fit of a model that it contains.

    What is new is small, middling or large.
    """
    known = dict(zip(part.model.names, part.theta.tolist(), strict=True))
    # Sizes as the data suggest them: a share of one is then an effect of the size of the rest.
    coordinates = part.task.coordinates
    sizes = coordinates.of(
        model.parameters, coordinates.log_omega, part.task.scale, coordinates.amplitude
    ).size[0]
    starts = []
    # Nearly absent, of the size that the data suggest, or ruling all: which of them it is, is not
    # known.
    for share in (1e-4, 1.0, 1e4):
        values = [
            known.get(p.name, share * size) for p, size in zip(model.parameters, sizes, strict=True)
        ]
        starts.append(
            np.clip(
                values, [p.lower for p in model.parameters], [p.upper for p in model.parameters]
            )
        )
    return starts


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


def best_run(
    problem: Searched,
    optimiser: Optimiser,
    budget: int | None,
    restarts: int | None,
    seed: int | None,
) -> tuple[Run, list[str]]:
    """The best of several supervised runs, with evaluations and seconds of all, and what failed.

    Parameters
    ----------
    problem : Problem, or whatever else can be searched
        What is minimised.
    optimiser : Optimiser
        With its options.
    budget : int or None
        Evaluations of each run; `BUDGET` by default.
    restarts, seed : int or None
        Number of runs, and of the generator from which each gets its own; one and 0 by default.

    Raises
    ------
    OptionError
        If all of them failed.
    """
    # Optimisers draw at random: even without a seed their answer must come again.
    rngs = np.random.default_rng(seed or 0).spawn(restarts or 1)
    # Every run has a generator of its own: a restart more changes none of the others.
    runs = [guarded(optimiser, problem, budget or BUDGET, rng) for rng in rngs]
    # A run that failed may hold a smaller number, which nobody vouches for.
    best = min(runs, key=lambda one: (one.failed, one.best))
    failed = [one.status.removeprefix("failed: ") for one in runs if one.failed]
    if best.failed:
        raise OptionError(
            f"the optimiser {optimiser.name} found nothing: {failed[0]}; try another one"
        )
    notes = list(best.remarks)
    if failed:
        notes.append(f"{len(failed)} of {len(rngs)} restarts failed, the first: {failed[0]}")
    evaluations, seconds = sum(one.evaluations for one in runs), sum(one.seconds for one in runs)
    return replace(best, evaluations=evaluations, seconds=seconds), notes


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
        tail = 50.0 * (1.0 - known.level)
        low, high = np.percentile(drawn, [tail, 100.0 - tail], axis=0)
        # Of a parameter as good as zero no two fits stop at the same tiny number: its interval
        # begins at the bound.
        bounds = np.array([[p.lower, p.upper] for p in known.fit.model.parameters]).T
        low = np.where(known.at_bound < 0, bounds[0], np.minimum(low, known.fit.theta))
        high = np.where(known.at_bound > 0, bounds[1], np.maximum(high, known.fit.theta))
        return low, high
    return intervals_beside_material(known)
