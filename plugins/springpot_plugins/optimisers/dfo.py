"""Trust regions without derivatives by the makers of DFO-LS and Py-BOBYQA, each where installed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np

from springpot.errors import ModelError
from springpot.identification import Card, Optimiser, OptimiserFamily, Recorder
from springpot.rheology import Real

from .cube import Cube, keep_on, seeded

PREFIX = "dfo-"
INSTALL = "pip install 'springpot[race]'"


@dataclass(frozen=True)
class _TrustRegion(Optimiser):
    """Descents from one uniform start after another, with the library's own settings."""

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Descend until the recorder ends it."""
        cube = Cube(problem)
        solve, objective = self._parts(cube)
        box = np.zeros(cube.dimension), np.ones(cube.dimension)

        def descend() -> None:
            # Never reached: the recorder ends the run when the budget is spent.
            most = budget + 1
            solve(objective, cube.start(rng), bounds=box, maxfun=most, do_logging=False)

        with seeded(rng):
            keep_on(problem, descend)

    def _parts(self, cube: Cube) -> tuple[Callable[..., Any], Callable[[Real], Any]]:
        raise NotImplementedError


class DfoLs(_TrustRegion):
    """A linear model of every residual: the rival of a solver that has their derivatives."""

    name = f"{PREFIX}ls"
    card = Card(
        "DFO-LS, linear models of the residuals, multi-start",
        "Cartis et al. 2019, doi:10.1145/3338517",
        globally=False,
        started=True,
        distribution="DFO-LS",
    )

    def _parts(self, cube: Cube) -> tuple[Callable[..., Any], Callable[[Real], Any]]:
        from dfols import solve

        return solve, lambda u: cube.problem.misfit(cube.place(u))


class PyBobyqa(_TrustRegion):
    """A quadratic model of the objective."""

    name = f"{PREFIX}bobyqa"
    card = Card(
        "Py-BOBYQA, quadratic models, multi-start",
        "Cartis et al. 2019, doi:10.1145/3338517",
        globally=False,
        started=True,
        distribution="Py-BOBYQA",
    )

    def _parts(self, cube: Cube) -> tuple[Callable[..., Any], Callable[[Real], Any]]:
        from pybobyqa import solve

        return solve, cube


LIBRARIES: dict[str, type[Optimiser]] = {"dfols": DfoLs, "pybobyqa": PyBobyqa}
"""Module that does the work, and its optimiser."""


def members() -> dict[str, type[Optimiser]]:
    """Those whose library is installed, by name.

    Raises
    ------
    ModelError
        If none is.
    """
    found = {kind.name: kind for module, kind in LIBRARIES.items() if find_spec(module)}
    if not found:
        raise ModelError(f"optimisers {PREFIX}... need DFO-LS or Py-BOBYQA: {INSTALL}")
    return found


FAMILY = OptimiserFamily(f"{PREFIX}NAME", "ls and bobyqa, of DFO-LS and Py-BOBYQA", members)
