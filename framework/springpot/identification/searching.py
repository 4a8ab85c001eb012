"""The search for parameters: the native one beside simpler models, or a guarded optimiser's."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from springpot.errors import OptionError
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import Test, sweep_of
from springpot.numerics import NEGLIGIBLE
from springpot.rheology.model import Model
from springpot.rheology.points import Real

from .free_factors import superposed_fit
from .levels_alone import usual_objective
from .material import is_material, shifted_by
from .material_fit import STARTS as STARTS
from .native import Fit, FittedModel, fit
from .problem import Objective, Searched
from .runs import Optimiser, Run, run

DEADLINE = 300.0
"""Seconds of a run, as in a study."""
MEMORY = 2048
"""MiB that a run may take, as in a study."""


def guarded(optimiser: Optimiser, problem: Searched, budget: int, rng: np.random.Generator) -> Run:
    """`run` in a process of its own, where a crash or a hang is a run that failed.

    The process is a copy of this one. Where other threads run here, that would not be safe, and the
    run takes place in this process.

    Parameters
    ----------
    optimiser, problem, budget, rng
        As for `run`.
    """
    from springpot.processes import can_copy

    if can_copy():
        return _elsewhere(optimiser, problem, budget, rng)
    return run(optimiser, problem, budget, rng)


def _failure(optimiser: Optimiser, problem: Searched, reason: str) -> Run:
    nowhere = np.full(problem.dimension, np.nan)
    theta = np.full(len(problem.space.model.names), np.nan)
    return Run(optimiser.name, f"failed: {reason}", np.inf, nowhere, theta, 0, 0, 0.0, ())


def _elsewhere(
    optimiser: Optimiser, problem: Searched, budget: int, rng: np.random.Generator
) -> Run:
    from springpot.processes import elsewhere

    def action(report: Callable[[bytes], object]) -> None:
        try:
            outcome = run(optimiser, problem, budget, rng)
        except BaseException as error:
            # Nothing interrupts this process from outside: whatever it is, the optimiser raised it.
            outcome = _failure(optimiser, problem, f"{type(error).__name__}: {error}")
        report(pickle.dumps(outcome))

    ended = elsewhere(action, DEADLINE, MEMORY)
    if ended.late:
        return _failure(optimiser, problem, f"it did not end within {DEADLINE:g} s")
    try:
        outcome: Run = pickle.loads(ended.message)
        return outcome
    except Exception:
        # What was cut short tells nothing: how the process ended is told instead.
        return _failure(optimiser, problem, ended.cause)


NATIVE = "native"
BUDGET = 8000
"""Evaluations of a restart: 20 particles and 400 time instances, as in section 5.1 of the paper."""
MORE_STARTS = 32
"""Starts of a fit that has not been confirmed, or that a simpler model beats."""


def refound(
    fit: FittedModel, objective: Objective | None = None
) -> Callable[[Sequence[Test]], Mapping[str, float]]:
    """What finds the parameters of other sweeps, by name, from where a fit has ended."""

    def again(moved: Sequence[Test]) -> Mapping[str, float]:
        data = sweep_of(moved)
        assert data is not None
        found = searched(fit.model, data, objective, [fit.theta])
        return found.model.named(found.theta)

    return again


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


def no_worse_than_simpler(whole: Fit, simpler: Sequence[Model]) -> tuple[Fit, list[str]]:
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
    known = part.model.named(part.theta)
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
