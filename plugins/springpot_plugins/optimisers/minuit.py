"""MINUIT, the minimiser of particle physics, by iminuit where it is installed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from springpot.identification import Card, Optimiser, Recorder
from springpot.rheology import Real

from .cube import Cube, keep_on
from .families import family

PREFIX = "minuit-"
INSTALL = "pip install 'springpot[race]'"
STEP = 0.1
"""First step as a part of the box."""


@dataclass(frozen=True)
class Migrad(Optimiser):
    """Variable metric with numerical derivatives, from one uniform start after another.

    As its users run it: limits by MINUIT's own transformation, strategy 1.

    Parameters
    ----------
    strategy : int
        0, 1 or 2: how much is spent on derivatives.
    """

    strategy: int = 1

    name: ClassVar[str] = f"{PREFIX}migrad"
    card: ClassVar[Card] = Card(
        "MIGRAD of MINUIT with numerical derivatives, multi-start (iminuit)",
        "James and Roos 1975, doi:10.1016/0010-4655(75)90039-9",
        globally=False,
        started=True,
        distribution="iminuit",
    )

    def __post_init__(self) -> None:
        self._require("strategy", self.strategy in (0, 1, 2), "0, 1 or 2")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Descend until the recorder ends it."""
        cube, ended = Cube(problem), list[BaseException]()

        def value(u: Real) -> float:
            # What passes through compiled code may come out as another exception: keep it.
            try:
                return cube(u)
            except BaseException as error:
                ended.append(error)
                raise

        def descend() -> None:
            from iminuit import Minuit

            search = Minuit(value, cube.start(rng))
            search.limits = [(0.0, 1.0)] * cube.dimension
            search.errors = STEP
            search.errordef, search.strategy = Minuit.LEAST_SQUARES, self.strategy
            # Its own is a part of the error of a chi-squared; an objective has no such unit.
            search.tol = 0.0
            try:
                # Never reached: the recorder ends the run when the budget is spent.
                search.migrad(ncall=budget + 1)
            except RuntimeError:
                # The descent is over: where minionpy is in the same process iminuit cannot read its
                # own result, which nobody wants here.
                pass
            finally:
                if ended:
                    raise ended[0]

        keep_on(problem, descend)


FAMILY = family(PREFIX, "migrad of MINUIT, by iminuit", "iminuit", INSTALL, {Migrad.name: Migrad})
