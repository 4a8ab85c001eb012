"""Single-objective algorithms of pymoo, each an optimiser ``pymoo-...``.

The library is imported when one of its names is asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any, ClassVar

import numpy as np

from springpot.identification import Optimiser, Recorder

from .cube import Cube, integer, keep_on
from .families import algorithms, family

PREFIX = "pymoo-"
INSTALL = "pip install 'springpot[pymoo]'"
ALGORITHMS = {
    "de": ("DE", "Storn and Price 1997, doi:10.1023/A:1008202821328"),
    "es": ("ES", "Runarsson and Yao 2005, doi:10.1109/TSMCC.2004.841906"),
    "g3pcx": ("G3PCX", "Deb et al. 2002, doi:10.1162/106365602760972767"),
    "ga": ("GA", "Blank and Deb 2020, doi:10.1109/ACCESS.2020.2990567"),
    "pso": ("PSO", "Zhan et al. 2009, doi:10.1109/TSMCB.2009.2015956"),
}
"""The library's name of an algorithm and the source of the method."""


@dataclass(frozen=True)
class Pymoo(Optimiser):
    """An algorithm of pymoo in the unit cube, with the library's own settings."""

    algorithm: ClassVar[str] = ""

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Search over the budget, and anew where the library ends before."""
        cube = Cube(problem)
        keep_on(problem, lambda: self._attempt(cube, rng))

    def _attempt(self, cube: Cube, rng: np.random.Generator) -> None:
        from pymoo.core.problem import Problem
        from pymoo.optimize import minimize

        class InCube(Problem):  # type: ignore[misc]
            def _evaluate(self, x: Any, out: dict[str, Any], *_: Any, **__: Any) -> None:
                out["F"] = cube.batch(np.asarray(x, dtype=float))

        module = import_module(f"pymoo.algorithms.soo.nonconvex.{self.algorithm.lower()}")
        problem = InCube(n_var=cube.dimension, n_obj=1, xl=0.0, xu=1.0)
        minimize(
            problem,
            getattr(module, self.algorithm)(),
            ("n_eval", cube.problem.left),
            seed=integer(rng),
            verbose=False,
        )


MEMBERS = algorithms(Pymoo, PREFIX, "pymoo", ALGORITHMS)
globals().update({kind.__name__: kind for kind in MEMBERS.values()})

FAMILY = family(PREFIX, "DE, ES, G3PCX, GA and PSO of pymoo", "pymoo", INSTALL, MEMBERS)
