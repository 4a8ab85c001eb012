"""Random search: the baseline that every optimiser must beat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from springpot.identification import Card, Optimiser, Recorder

from .cube import Cube, keep_on


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
