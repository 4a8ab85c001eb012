"""A run of an optimiser in a process of its own: whatever it does there ends there, and is told."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import fields
from typing import Any

import numpy as np

from .optimiser import Optimiser
from .problem import Searched
from .record import contradiction
from .runs import Run, run

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
    )
