"""The native solver as a competitor.

Its descents run through the recorder, which counts every one of their steps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from springpot.identification import BoundedDescent, Card, Optimiser, Recorder

from .cube import keep_on


@dataclass(frozen=True)
class Native(Optimiser):
    """Batched Levenberg-Marquardt in the search form, from starts read off the data.

    Parameters
    ----------
    starts : int
        Descents side by side.
    """

    starts: int = 4

    name: ClassVar[str] = "native"
    card: ClassVar[Card] = Card(
        "multi-start Levenberg-Marquardt, starts by variable projection, exact Jacobian",
        "Marquardt 1963, doi:10.1137/0111030; Golub and Pereyra 1973, doi:10.1137/0710036",
        gradient=True,
    )

    def __post_init__(self) -> None:
        self._require("starts", self.starts >= 1, "at least 1")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Descend from the best starts of one scan after another."""
        # Every descent of it keeps to the box, unlike those of a fit: a race is run by all in the
        # same box.
        descent = BoundedDescent(problem)
        keep_on(problem, lambda: descent.from_scan(rng, self.starts))
