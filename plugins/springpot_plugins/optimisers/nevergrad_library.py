"""Algorithms of nevergrad, each an optimiser ``nevergrad-...``.

The library is imported when one of its names is asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from springpot.identification import Optimiser, Recorder

from .cube import Cube, integer, keep_on, seeded
from .families import algorithms, family

PREFIX = "nevergrad-"
INSTALL = "pip install 'springpot[nevergrad]'"
ALGORITHMS = {
    "ngopt": ("NGOpt", "Meunier et al. 2022, doi:10.1109/TEVC.2021.3108185"),
    "tbpsa": ("TBPSA", "Hellwig and Beyer 2016, doi:10.1007/978-3-319-45823-6_24"),
    "two-points-de": ("TwoPointsDE", "Rapin and Teytaud 2018, github.com/facebookresearch"),
    "one-plus-one": ("OnePlusOne", "Rapin and Teytaud 2018, github.com/facebookresearch"),
}
"""The library's name of an algorithm and the source of the method."""


@dataclass(frozen=True)
class Nevergrad(Optimiser):
    """An algorithm of nevergrad in the unit cube, told the budget, with the library's settings."""

    algorithm: ClassVar[str] = ""

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Search over the budget, and anew with what an algorithm leaves of it."""
        cube = Cube(problem)
        with seeded(rng):
            keep_on(problem, lambda: self._attempt(cube, rng))

    def _attempt(self, cube: Cube, rng: np.random.Generator) -> None:
        import nevergrad

        left = cube.problem.left
        place: Any = nevergrad.p.Array(shape=(cube.dimension,), lower=0.0, upper=1.0)
        # The only generator that the library knows is of the old kind.
        place.random_state = np.random.RandomState(integer(rng))
        search = nevergrad.optimizers.registry[self.algorithm](place, budget=left)
        for _ in range(left):
            asked = search.ask()
            search.tell(asked, cube(asked.value))


MEMBERS = algorithms(Nevergrad, PREFIX, "nevergrad", ALGORITHMS)
globals().update({kind.__name__: kind for kind in MEMBERS.values()})

OFFERS = "NGOpt, TBPSA, TwoPointsDE and OnePlusOne of nevergrad"
FAMILY = family(PREFIX, OFFERS, "nevergrad", INSTALL, MEMBERS)
