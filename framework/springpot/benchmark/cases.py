"""What a problem of a study is made of.

Its reference, its optimum where that is known beforehand, and the noise that a repetition draws.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from springpot.identification.native import fit, minima_in_box
from springpot.identification.problem import Objective, Problem, SpecimenProblem
from springpot.identification.space import rounded_up
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import Test
from springpot.measurement.scatter import with_noise
from springpot.measurement.timetest import TimeTest
from springpot.numerics import ALIKE
from springpot.registry import parse_model
from springpot.rheology.model import Model
from springpot.rheology.points import Complex, Real

from .plan import DrawnNoise, Plan, RaceCase, Source, stream_of

AGREEING = 5
"""Descents within the box that must end at the same value before it is taken for the optimum."""


def with_noise_axis(
    source: Source, levels: Sequence[float], seed: int
) -> list[tuple[Source, DrawnNoise | None]]:
    """The data at each level of noise; those in time or of unknown truth stay as they are.

    At level zero they have no noise. Above it they hold the noise-free data too, to which every
    repetition adds its own noise.
    """
    clean = noise_free(source)
    # Eq. (53) is of sweeps.
    if not levels or clean is None or source.sweep is None:
        return [(source, None)]
    if not noisy(source, clean):
        # To the last bit what the data set holds, so that its trials are those of other studies.
        clean = source.tests
    (sweep,) = clean
    assert isinstance(sweep, Measurement)
    scale = source.stiffness_scale
    if scale is None:
        # Read off what has no noise: all repetitions search the same box.
        scale = rounded_up(float(np.max(sweep.magnitude)))
    # What is the best of the data with their own noise says nothing of other draws.
    exact = replace(source, tests=clean, digest=sweep.digest(), best=None)
    found: list[tuple[Source, DrawnNoise | None]] = []
    for level in levels:
        if level == 0.0:
            found.append((exact, None))
            continue
        name = f"{source.name}+{100 * level:g}%"
        drawn = DrawnNoise(level, seed, source.name)
        found.append((replace(exact, name=name, stiffness_scale=scale), drawn))
    return found


def noisy(source: Source, clean: Sequence[Test]) -> bool:
    """Whether data differ from those without noise by more than rounding."""
    return not all(
        np.allclose(_numbers(exact), _numbers(test), rtol=ALIKE, atol=0.0)
        for exact, test in zip(clean, source.tests, strict=True)
    )


def _numbers(test: Test) -> Real | Complex:
    if isinstance(test, Measurement):
        return test.stiffness
    assert isinstance(test, TimeTest)
    return test.response


def drawn(plan: Plan, case: RaceCase, repetition: int) -> RaceCase:
    """The case as a repetition has it: with noise of its own where the study draws noise."""
    noise = case.noise
    if noise is None:
        return case
    # From the names of the data and the repetition only: models, objectives, optimisers and levels
    # share a draw, whatever process asks for it.
    rng = np.random.default_rng(stream_of(noise.seed, "noise", noise.of, repetition))
    sweep = case.source.sweep
    assert sweep is not None
    data = with_noise(sweep, noise.level, rng, symmetric=True)
    source = replace(case.source, tests=(data,), digest="")
    wanted = None
    if plan.stop_at_target:
        wanted = plan.target
    return case_of(source, case.model, case.objective, wanted)


def case_of(
    source: Source, expression: str, objective: Objective, target: float | None
) -> RaceCase:
    """The problem of a model on data by an objective.

    Parameters
    ----------
    source : Source
        The data.
    expression : str
        The model.
    objective : Objective
        How the misfit is measured.
    target : float or None
        Fraction at which trials will end, if they will: the optimum is looked for only then.
    """
    model = source.model_of(expression)
    # Here already: a model that does not fit its data is told before the first trial.
    problem = problem_of(source, model, objective)
    reference = reference_of(problem)
    known = None
    if truth_fits(source, model):
        with np.errstate(all="ignore"):
            known = float(problem.evaluate(problem.space.from_theta(_truth(source, model))))
    optimum = None
    if target is not None and source.best is not None and objective.name == source.objective:
        if parse_model(source.model).name == model.name:
            optimum = source.best
    elif target is not None and isinstance(problem, Problem):
        optimum = _optimum(problem, reference, known, target)
    return RaceCase(source, model.name, objective, reference, known, optimum)


def problem_of(source: Source, model: Model, objective: Objective) -> SpecimenProblem:
    """A model on the data of a source: of a sweep, or of all tests of a specimen together."""
    from springpot.timetests.fitting import InTimeProblem

    sweep = source.sweep
    if sweep is not None:
        return Problem.of(model, sweep, objective, source.stiffness_scale)
    return InTimeProblem.alike(model, source.tests, objective, source.stiffness_scale)


def reference_of(problem: SpecimenProblem) -> float:
    """Objective from which progress is measured.

    At the centre of the box, or of no answer at all if that is less.

    Where the centre is absurd (a box far too large, an inertia at high frequency) its objective
    says nothing of the data, and a millionth of it would be reached by fits that are of no use.
    """
    with np.errstate(all="ignore"):
        centre = problem.evaluate(0.5 * (problem.lower + problem.upper))
        nothing = problem.nothing
    # No answer has no logarithm.
    return float(np.fmin(centre, nothing))


def _optimum(
    problem: Problem, reference: float, known: float | None, target: float
) -> float | None:
    """Smallest objective in the box; None where that is not certain.

    It is where the native solver, which knows no box, finds nothing better outside, or where
    several descents within the box end at the same value.
    """
    # The native solver is told nothing of the box: it says what there is at best.
    unbounded = fit(problem.model, problem.measurement, problem.objective)
    least = np.inf
    with np.errstate(all="ignore"):
        x = np.clip(problem.space.from_theta(unbounded.theta), problem.lower, problem.upper)
        if np.all(np.isfinite(x)):
            least = float(problem.evaluate(x))
    if known is not None:
        least = min(least, known)
    # What rounding and the ends of the box cost must not matter beside the target.
    slack = 0.01 * target * (reference - unbounded.cost)
    if least - unbounded.cost <= slack:
        return least
    minima = minima_in_box(problem)
    least = float(minima[0])
    # Descents that agree on what is above the truth have all missed the optimum.
    missed = known is not None and known < least - slack
    if missed or not minima[AGREEING - 1] - least <= slack:
        return None
    return least


def truth_fits(source: Source, model: Model) -> bool:
    """Whether the true parameters are those of this model."""
    return (
        bool(source.truth)
        and parse_model(source.model).name == model.name
        and set(source.truth) == set(model.names)
    )


def noise_free(source: Source) -> tuple[Test, ...] | None:
    """The data as they would be without noise, where the truth is known."""
    if not source.truth:
        return None
    from springpot.timetests import answered

    model = source.model_of(source.model)
    return answered(model, _truth(source, model), source.tests)


def _truth(source: Source, model: Model) -> Real:
    return model.vector(dict(source.truth))
