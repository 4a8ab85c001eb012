"""Generalised simulated annealing and the dividing of rectangles, both of SciPy."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import ClassVar

import numpy as np

from springpot.identification import Card, Optimiser, Recorder
from springpot.rheology import Real

from .cube import Cube, keep_on
from .evolution import UNENDING


@dataclass(frozen=True)
class DualAnnealing(Optimiser):
    """Dual annealing of SciPy with its local search, restarted until the budget is spent.

    Parameters
    ----------
    temperature : float
        Initial temperature.
    visit, accept : float
        Tails of the visiting and of the acceptance distribution.
    restart_ratio : float
        Part of the initial temperature at which the annealing starts anew.
    """

    temperature: float = 5230.0
    visit: float = 2.62
    accept: float = -5.0
    restart_ratio: float = 2e-5

    name: ClassVar[str] = "dual-annealing"
    card: ClassVar[Card] = Card(
        "generalised simulated annealing with local search (SciPy)",
        "Xiang et al. 1997, doi:10.1016/S0375-9601(97)00474-X",
        started=True,
    )

    def __post_init__(self) -> None:
        self._require("temperature", 0.01 < self.temperature <= 5e4, "in (0.01, 50000]")
        self._require("visit", 1 < self.visit <= 3, "in (1, 3]")
        self._require("accept", -1e4 < self.accept <= -5, "in (-10000, -5]")
        self._require("restart_ratio", 0 < self.restart_ratio < 1, "in (0, 1)")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Restart until the recorder ends it."""
        from scipy.optimize import dual_annealing

        cube = Cube(problem)
        keep_on(
            problem,
            lambda: dual_annealing(
                cube,
                [(0.0, 1.0)] * cube.dimension,
                # The budget is the recorder's to watch: the library counts other calls than it
                # does.
                maxiter=UNENDING,
                maxfun=UNENDING,
                initial_temp=self.temperature,
                visit=self.visit,
                accept=self.accept,
                restart_temp_ratio=self.restart_ratio,
                x0=cube.first(),
                rng=rng,
            ),
        )


@dataclass(frozen=True)
class ScipyDirect(Optimiser):
    """DIRECT of SciPy: deterministic division of the box.

    Parameters
    ----------
    locally_biased : bool
        Prefer small rectangles near the best point.
    """

    locally_biased: bool = True

    name: ClassVar[str] = "scipy-direct"
    card: ClassVar[Card] = Card(
        "dividing rectangles (SciPy)", "Jones et al. 1993, doi:10.1007/BF00941892", stochastic=False
    )

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Divide once; the method has nothing random to start anew with."""
        from scipy.optimize import direct

        cube, ended = Cube(problem), list[BaseException]()

        def guarded(u: Real) -> float:
            # An exception does not stop this library, it ends it in a SystemError later: keep it
            # until then.
            if ended:
                return inf
            try:
                return cube(u)
            except BaseException as error:
                ended.append(error)
                return inf

        direct(
            guarded,
            [(0.0, 1.0)] * cube.dimension,
            maxfun=budget,
            maxiter=budget,
            # It would otherwise end by the size of its rectangles, before the budget is spent.
            vol_tol=0.0,
            len_tol=0.0,
            locally_biased=self.locally_biased,
        )
        if ended:
            raise ended[0]
