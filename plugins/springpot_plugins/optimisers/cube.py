"""The unit cube, for libraries that want every parameter of the same size.

And random points in it: the baseline that every optimiser must beat.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from springpot.identification import Card, Optimiser, Recorder
from springpot.rheology import Real


@dataclass(frozen=True, eq=False)
class Cube:
    """A problem whose search box is mapped to [0, 1]^d.

    Parameters
    ----------
    problem : Recorder
        Where values come from.
    """

    problem: Recorder

    @property
    def dimension(self) -> int:
        """Number of parameters."""
        return self.problem.dimension

    def place(self, u: Real) -> Real:
        """Search point of a point of the cube."""
        return self.problem.lower + np.asarray(u) * (self.problem.upper - self.problem.lower)

    def start(self, rng: np.random.Generator) -> Real:
        """Point (d,) of the cube to begin at: the race's first, then uniform ones."""
        own, first = rng.random(self.dimension), self.first()
        if first is None:
            return own
        return first

    def first(self) -> Real | None:
        """The race's first point (d,) at the first attempt, for libraries that draw their own."""
        if self.problem.start is None or self.problem.evaluations > 1:
            return None
        width = self.problem.upper - self.problem.lower
        return np.clip((self.problem.start - self.problem.lower) / width, 0.0, 1.0)

    def __call__(self, u: Real) -> float:
        """Objective at one point (d,) of the cube."""
        return self.problem(self.place(u))

    def batch(self, u: Real) -> Real:
        """Objective (m,) at points (m, d) of the cube."""
        return self.problem.batch(self.place(u))

    def gradient(self, u: Real) -> tuple[float, Real]:
        """Objective and its gradient (d,) by the cube's coordinates."""
        value, slope = self.problem.gradient(self.place(u))
        # A step of 1 in the cube is the width of the box.
        return value, slope * (self.problem.upper - self.problem.lower)


def keep_on(problem: Recorder, attempt: Callable[[], object]) -> None:
    """Make attempts until the recorder ends the run, or an attempt asks for no more values."""
    # An attempt that asks for no value would otherwise be repeated for ever, and some libraries
    # crash when they are to search with nothing left.
    before = -1
    while problem.evaluations > before and problem.left > 0:
        before = problem.evaluations
        attempt()


def integer(rng: np.random.Generator) -> int:
    """A seed for a library that takes no generator."""
    return int(rng.integers(1, 2**31 - 1))


@contextmanager
def seeded(rng: np.random.Generator) -> Iterator[None]:
    """Let libraries with generators of the whole process draw what ours says, without a trace."""
    kept, known = np.random.get_state(), random.getstate()  # noqa: NPY002  not ours, but theirs
    seed = integer(rng)
    np.random.seed(seed)  # noqa: NPY002
    random.seed(seed)
    try:
        yield
    finally:
        np.random.set_state(kept)  # noqa: NPY002
        random.setstate(known)


@dataclass(frozen=True)
class RandomSearch(Optimiser):
    """Points uniform in the box.

    Parameters
    ----------
    block : int
        Points evaluated at once.
    """

    block: int = 256

    name: ClassVar[str] = "random-search"
    card: ClassVar[Card] = Card("uniform random points, a baseline")

    def __post_init__(self) -> None:
        self._require("block", self.block >= 1, "at least 1")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Draw and evaluate until the recorder ends it."""
        # In blocks: to evaluate many points at once takes a small part of the time of one by one.
        cube = Cube(problem)
        keep_on(problem, lambda: cube.batch(rng.random((self.block, cube.dimension))))
