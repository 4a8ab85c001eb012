"""Small studies and optimisers of every temper, defined where worker processes can import them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from dataclasses import dataclass, replace
from time import sleep
from typing import ClassVar

import numpy as np

from springpot import Measurement, Units, parse_model
from springpot.benchmark import Study
from springpot.identification import Card, Optimiser, Recorder
from springpot.measurement import DataSet

TRUTH = {"k": 100.0, "c": 60.0, "alpha": 0.5}
OMEGA = 2 * np.pi * np.geomspace(0.1, 10.0, 12)


@dataclass(frozen=True)
class Walk(Optimiser):
    """A (1+1) random walk with shrinking steps."""

    shrink: float = 0.97

    name: ClassVar[str] = "walk"
    card: ClassVar[Card] = Card("random walk")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        room = problem.upper - problem.lower
        x = problem.lower + rng.random(problem.dimension) * room
        best, step = problem(x), 0.5
        while True:
            y = np.clip(
                x + step * room * rng.standard_normal(problem.dimension),
                problem.lower,
                problem.upper,
            )
            value = problem(y)
            if value < best:
                x, best = y, value
            else:
                step *= self.shrink


@dataclass(frozen=True)
class Moody(Walk):
    """A walk that does something unkind after some evaluations."""

    mood: str = "fine"

    name: ClassVar[str] = "moody"

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        if budget == 1:
            return
        for _ in range(3):
            problem(problem.lower)
        getattr(self, self.mood)(problem, rng)
        super().minimise(problem, budget, rng)

    def fine(self, problem: Recorder, rng: np.random.Generator) -> None:
        pass

    def segfault(self, problem: Recorder, rng: np.random.Generator) -> None:
        os.kill(os.getpid(), signal.SIGSEGV)

    def hang(self, problem: Recorder, rng: np.random.Generator) -> None:
        while True:
            pass

    def eat(self, problem: Recorder, rng: np.random.Generator) -> None:
        meal = []
        while True:
            meal.append(np.ones(2**24))

    def exit(self, problem: Recorder, rng: np.random.Generator) -> None:
        sys.exit("enough")

    def vanish(self, problem: Recorder, rng: np.random.Generator) -> None:
        os._exit(7)

    def throw(self, problem: Recorder, rng: np.random.Generator) -> None:
        raise ValueError("out of\nspirits")

    def orphan(self, problem: Recorder, rng: np.random.Generator) -> None:
        subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])

    def swallow(self, problem: Recorder, rng: np.random.Generator) -> None:
        for _ in range(1000):
            try:
                problem(
                    problem.lower + rng.random(problem.dimension) * (problem.upper - problem.lower)
                )
            except BaseException:
                continue


@dataclass(frozen=True)
class Heavy(Walk):
    """Imports for longer than a trial may take, then hangs in half of its trials."""

    name: ClassVar[str] = "heavy"
    imported: ClassVar[bool] = False

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        if not Heavy.imported:
            sleep(0.8)
            Heavy.imported = True
        hangs = rng.random() < 0.5
        problem(problem.lower)
        while hangs:
            sleep(1.0)
        super().minimise(problem, budget, rng)


@dataclass(frozen=True)
class Mute(Walk):
    """Never asks for a value."""

    name: ClassVar[str] = "mute"

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        while True:
            sleep(1.0)


@dataclass(frozen=True)
class Fixed(Mute):
    """Knows no chance, asks for one value, and hangs."""

    name: ClassVar[str] = "fixed"
    card: ClassVar[Card] = Card("a point", stochastic=False)

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        problem(problem.lower)
        super().minimise(problem, budget, rng)


@dataclass(frozen=True)
class Sleepy(Walk):
    """Waits before it walks: that is no work of the processor."""

    name: ClassVar[str] = "sleepy"

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        sleep(0.05)
        super().minimise(problem, budget, rng)


def measurement(noise: float = 0.0, name: str = "kelvin") -> Measurement:
    """Data of a fractional Kelvin element, with noise if wanted."""
    model = parse_model("fractional-kelvin")
    stiffness = model.stiffness(model.theta(**TRUTH), OMEGA)
    drawn = np.random.default_rng(5).standard_normal((2, len(OMEGA)))
    return Measurement(
        OMEGA, stiffness * (1 + noise * (drawn[0] + 1j * drawn[1])), units=Units("kN/m"), name=name
    )


def artificial(noise: float = 0.0, name: str = "kelvin") -> DataSet:
    """The same as a data set that knows its truth."""
    return DataSet(
        name,
        "artificial data of a fractional Kelvin element",
        lambda: measurement(noise, name),
        kind="artificial",
        truth=dict(TRUTH),
        model="fractional-kelvin",
    )


def small_study(**changes: object) -> Study:
    """Two data sets, two models, two optimisers."""
    study = Study(
        "small",
        datasets=[artificial(), artificial(0.02, "noisy")],
        models=["own", "springpot"],
        objectives=["paper"],
        optimisers=[Walk(), ("walk-slow", Walk(shrink=0.99))],
        repetitions=4,
        budget=300,
        target=1e-3,
    )
    return replace(study, **changes)  # type: ignore[arg-type]


def moody_study(mood: str, **changes: object) -> Study:
    """One optimiser in a mood, and a good one beside it."""
    given = {"datasets": [artificial()], "models": ["own"], "repetitions": 3}
    return small_study(**{**given, "optimisers": [Moody(mood=mood), Walk()], **changes})
