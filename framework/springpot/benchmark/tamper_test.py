"""A canary: a small run of known outcome, which tells a process in which something was changed.

An optimiser shares its process with the objective and the recorder. Whatever it replaced or
overwrote there, a method, an array of the measurement, the generator, shows in what the canary
finds.
"""

from __future__ import annotations

from dataclasses import dataclass
from hashlib import sha256
from typing import ClassVar

import numpy as np

from springpot.identification.optimiser import Card, Optimiser
from springpot.identification.problem import Problem
from springpot.identification.recorder import Recorder
from springpot.identification.runs import run
from springpot.rheology.points import Real

BUDGET = 4
"""A single evaluation, two in a stack, one with its gradient.

About 0.2 ms, which is added to every trial.
"""


@dataclass(frozen=True)
class Canary(Optimiser):
    """Asks for values one by one, in a stack and with a derivative."""

    name: ClassVar[str] = "canary"
    card: ClassVar[Card] = Card("fixed points", gradient=True)

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Evaluate a few points of the box."""
        # By each door of the recorder: whichever of them was tampered with, one of these shows it.
        x = problem.lower + rng.random((3, problem.dimension)) * (problem.upper - problem.lower)
        problem(x[0])
        problem.batch(x[:2])
        problem.gradient(x[2])


def outcome(problem: Problem) -> str:
    """What the canary finds, to the last bit."""
    # With a diary: an array that was changed shows in the points that are seen even where the best
    # stays.
    done = run(Canary(), problem, BUDGET, np.random.default_rng(7), diary=True)
    seen = sha256(
        repr((done.status, done.evaluations, done.gradients, done.batched, done.trace)).encode()
    )
    for array in (done.best_x, done.theta, done.point, *(page for page, _ in done.diary or ())):
        seen.update(np.ascontiguousarray(array).tobytes())
    return seen.hexdigest()


def digest_of_objective(problem: Problem) -> str:
    """SHA-256 of the data, the weights, the box, and the objective at three points of it."""
    low, high = problem.lower, problem.upper
    # Three places: what was changed may have no part in the value at one of them.
    x: Real = low + np.array([[0.2], [0.5], [0.8]]) * (high - low)
    with np.errstate(all="ignore"):
        value = problem.evaluate(x)
    seen = sha256(problem.measurement.digest().encode())
    for array in (low, high, problem.space.lowest, problem.space.highest, problem.weights, value):
        seen.update(np.ascontiguousarray(array).tobytes())
    return seen.hexdigest()


@dataclass(frozen=True)
class Witness:
    """What a problem answered in a process that had run no optimiser.

    Parameters
    ----------
    objective, canary : str
        Digests.
    """

    objective: str
    canary: str

    @classmethod
    def of(cls, problem: Problem) -> Witness:
        """The witness of a problem as it is now."""
        return cls(digest_of_objective(problem), outcome(problem))

    def complaint(self, problem: Problem) -> str:
        """What has changed since, in one line; nothing if all is as it was."""
        try:
            now = Witness.of(problem)
        except Exception as error:
            return (
                f"after the trial a canary failed in its process: {type(error).__name__}: {error}"
            )
        if now.objective != self.objective:
            return "after the trial its process had another objective than before"
        if now.canary != self.canary:
            return "after the trial a canary found something else in its process than before"
        return ""
