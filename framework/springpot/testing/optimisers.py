"""The contract of an optimiser, tried on a problem with four parameters whose answer is known."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import FrozenInstanceError, fields, is_dataclass
from typing import Any

import numpy as np

from springpot.identification.problem import Objective, Problem, watched
from springpot.identification.runs import (
    BatchedOptimiser,
    Optimiser,
    Run,
    options_of,
    run,
    run_batch,
)
from springpot.measurement.measurement import Measurement
from springpot.measurement.units import Units
from springpot.rheology.points import Real

from ..numerics import ALIKE
from .networks import CONTRACT, SAMPLE, complaints, kept_random_state, name_and_summary

TRUTH = np.array([600.0, 400.0, 150.0, 0.6])
"""Those of the paper, section 5.1, in kN/m and s."""

EQUAL = Objective("sample", "plain squares", lambda data: np.full(data.stiffness.shape, 1.0 + 1.0j))


def check_optimiser(
    optimiser: type[Optimiser], *, skip: Collection[str] = (), deadline: float = CONTRACT.deadline
) -> list[str]:
    """What is wrong with an optimiser, as plain sentences.

    Aspects: ``words`` (name and card), ``options`` (frozen, documented, plain values), ``budget``
    (runs to its end without a fault), ``repeatable`` (same seed, same bits; the process-wide random
    state has no part in it), ``box`` (no point outside), ``improves``, ``faults`` (an error of the
    model is not swallowed), ``gradient`` (used if, and only if, the card says so) and ``batch`` (as
    single runs).

    Parameters
    ----------
    optimiser : type of Optimiser
        The class; its default instance is tried.
    skip : collection of str
        Aspects to leave out.
    deadline : float
        Seconds that all aspects together may take: one that hangs is named then.

    Returns
    -------
    list of str
        Empty if nothing is wrong.
    """
    aspects = {
        "words": lambda: name_and_summary(optimiser.name, optimiser.card.summary),
        "options": lambda: _options(optimiser),
        "budget": lambda: _budget(optimiser()),
        "repeatable": lambda: _repeatable(optimiser()),
        "box": lambda: _box(optimiser()),
        "improves": lambda: _improves(optimiser()),
        "faults": lambda: _faults(optimiser()),
        "gradient": lambda: _gradient(optimiser()),
        "batch": lambda: _batch(optimiser()),
    }
    return complaints(aspects, skip, deadline)


def sample_problem() -> Problem:
    """Exact data of the sample model at 14 frequencies, in kN/m."""
    omega = 2.0 * np.pi * np.arange(0.5, 14.0)
    data = Measurement(
        omega, SAMPLE.stiffness(TRUTH, omega), units=Units("kN/m", "mm"), name="sample"
    )
    return Problem.of(SAMPLE, data, EQUAL, 1000.0)


def _run(
    optimiser: Optimiser, budget: int, seed: int = CONTRACT.seed, problem: Problem | None = None
) -> Run:
    return run(optimiser, problem or sample_problem(), budget, np.random.default_rng(seed))


def _options(optimiser: type[Optimiser]) -> Iterator[str]:
    made = optimiser()
    if not is_dataclass(made):
        yield (
            "it is no dataclass, so that its options cannot be listed: decorate it with"
            " @dataclass(frozen=True)"
        )
        return
    # Called for what it raises: options that are no plain values cannot be kept with a trial.
    options_of(made)
    described = "".join(kind.__doc__ or "" for kind in optimiser.__mro__)
    for option in fields(made):
        # A dataclass without a docstring is given its signature for one: only a described name
        # counts.
        if not re.search(rf"(?m)^.*\b{option.name}\b.* : ", described):
            yield f"option {option.name} is not described in the docstring"
        try:
            setattr(made, option.name, getattr(made, option.name))
        except FrozenInstanceError:
            continue
        yield (
            f"option {option.name} can be changed: decorate the class with @dataclass(frozen=True)"
        )


def _budget(optimiser: Optimiser) -> Iterator[str]:
    for budget in (1, 2, 9, 57):
        outcome = _run(optimiser, budget)
        if outcome.failed:
            yield (
                f"with a budget of {budget} it ends as '{outcome.status}' after"
                f" {outcome.evaluations} evaluations"
            )


def _same(one: Run, other: Run) -> bool:
    # By their bytes: the same to the last bit, which comparing numbers would not tell of nan or of
    # -0.0.
    same_end = one.theta.tobytes() == other.theta.tobytes()
    return same_end and one.status == other.status and one.trace == other.trace


def _repeatable(optimiser: Optimiser) -> Iterator[str]:
    runs = []
    # Two states of the process, one generator: only what draws from elsewhere differs.
    for seed in (1, 2):
        with kept_random_state():
            np.random.seed(seed)  # noqa: NPY002
            runs.append(_run(optimiser, 150))
    if not _same(*runs):
        yield "two runs with the same generator differ: every random number must come from rng"
    depends = _run(optimiser, 150, seed=1).trace != _run(optimiser, 150, seed=2).trace
    if depends and not optimiser.card.stochastic:
        yield "it depends on the generator, but its card says stochastic=False"
    if not depends and optimiser.card.stochastic:
        yield "it does not depend on the generator: say stochastic=False on its card"


def _box(optimiser: Optimiser) -> Iterator[str]:
    low, high = np.full(4, np.inf), np.full(4, -np.inf)

    def watch(x: Real) -> None:
        np.fmin(low, x.min(axis=0), out=low)
        np.fmax(high, x.max(axis=0), out=high)

    problem = watched(sample_problem(), watch)
    outcome = _run(optimiser, CONTRACT.long, problem=problem)
    if outcome.failed:
        yield f"the run ends as '{outcome.status}'"
    # Rounding may put a point that was meant for the edge a little beyond it.
    room = ALIKE * (problem.upper - problem.lower)
    for i, name in enumerate(problem.space.names):
        if low[i] < problem.lower[i] - room[i]:
            yield (
                f"it asks for {name} = {low[i]:.6g} below the box,"
                f" which begins at {problem.lower[i]:.6g}"
            )
        if high[i] > problem.upper[i] + room[i]:
            yield (
                f"it asks for {name} = {high[i]:.6g} above the box,"
                f" which ends at {problem.upper[i]:.6g}"
            )


def _improves(optimiser: Optimiser) -> Iterator[str]:
    problem = sample_problem()
    centre = float(problem.evaluate(0.5 * (problem.lower + problem.upper)))
    # Of three, as one run of a search by chance may be unlucky.
    best = min(_run(optimiser, CONTRACT.long, seed).best for seed in (1, 2, 3))
    if not best < CONTRACT.better * centre:
        yield (
            f"the best of three runs of {CONTRACT.long} evaluations is {best / centre:.2g} of the"
            " value at the box's centre"
        )


def _faults(optimiser: Optimiser) -> Iterator[str]:
    calls = 0

    def fail(x: Real) -> None:
        nonlocal calls
        calls += 1
        if calls > 5:
            raise ZeroDivisionError("the model fails")

    outcome = _run(optimiser, CONTRACT.long, problem=watched(sample_problem(), fail))
    # Some end by themselves before the sixth call, and have met no error.
    if not outcome.status.startswith("failed: ZeroDivisionError") and calls > 5:
        yield f"an error of the model is swallowed: the run ends as '{outcome.status}'"


def _gradient(optimiser: Optimiser) -> Iterator[str]:
    used = _run(optimiser, CONTRACT.long).gradients > 0
    if used != optimiser.card.gradient:
        does = "does not use"
        if used:
            does = "uses"
        yield f"it {does} derivatives, but its card says gradient={optimiser.card.gradient}"


def _batch(optimiser: Optimiser) -> Iterator[str]:
    if isinstance(optimiser, BatchedOptimiser) != optimiser.card.batched:
        yield "its card must say batched=True if, and only if, it is a BatchedOptimiser"
    if not isinstance(optimiser, BatchedOptimiser):
        return
    seeds = range(3)
    together: list[Any] = run_batch(
        optimiser, sample_problem(), 130, [np.random.default_rng(s) for s in seeds]
    )
    for seed, one in zip(seeds, together, strict=True):
        if not _same(one, _run(optimiser, 130, seed)):
            yield f"run {seed + 1} of a batch of three differs from the same run alone"
