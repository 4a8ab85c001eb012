"""Searches of SciPy over the whole box.

Generalised simulated annealing and the dividing of rectangles; and searches that lead local
descents: basin hopping, COBYQA and SHGO.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import ClassVar, Literal

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


@dataclass(frozen=True)
class BasinHopping(Optimiser):
    """Basin hopping of SciPy with bounded quasi-Newton descents and exact derivatives.

    Parameters
    ----------
    temperature : float
        Rise of the objective that a hop accepts with probability 1/e.
    step : float
        First hop as a part of the box; the library adapts it.
    """

    temperature: float = 1.0
    step: float = 0.5

    name: ClassVar[str] = "basin-hopping"
    card: ClassVar[Card] = Card(
        "basin hopping with L-BFGS-B (SciPy)",
        "Wales and Doye 1997, doi:10.1021/jp970984n",
        gradient=True,
        started=True,
    )

    def __post_init__(self) -> None:
        self._require("temperature", self.temperature >= 0, "at least 0")
        self._require("step", self.step > 0, "positive")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Hop until the recorder ends it."""
        from scipy.optimize import basinhopping

        cube = Cube(problem)
        descent = {"method": "L-BFGS-B", "jac": True, "bounds": [(0.0, 1.0)] * cube.dimension}
        keep_on(
            problem,
            lambda: basinhopping(
                cube.gradient,
                cube.start(rng),
                niter=UNENDING,
                T=self.temperature,
                stepsize=self.step,
                minimizer_kwargs=descent,
                rng=rng,
            ),
        )


@dataclass(frozen=True)
class Cobyqa(Optimiser):
    """COBYQA of SciPy, Powell's quadratic models without derivatives, from uniform starts.

    Parameters
    ----------
    radius : float
        First trust region as a part of the box.
    final_radius : float
        Trust region at which a descent ends.
    """

    radius: float = 0.1
    final_radius: float = 1e-8

    name: ClassVar[str] = "cobyqa"
    card: ClassVar[Card] = Card(
        "trust region of quadratic models, multi-start (SciPy)",
        "Ragonneau and Zhang, COBYQA; Ragonneau 2022, arXiv:2210.12018",
        started=True,
    )

    def __post_init__(self) -> None:
        self._require("radius", 0 < self.radius <= 0.5, "in (0, 0.5]")
        self._require("final_radius", 0 < self.final_radius <= self.radius, "in (0, radius]")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Descend from one uniform start after another."""
        from scipy.optimize import minimize

        cube = Cube(problem)
        options = {
            "initial_tr_radius": self.radius,
            "final_tr_radius": self.final_radius,
            # Never reached: the recorder ends the run when the budget is spent. The library keeps
            # room for every evaluation that it may take.
            "maxfev": budget + 1,
            "maxiter": budget + 1,
        }
        keep_on(
            problem,
            lambda: minimize(
                cube,
                cube.start(rng),
                method="COBYQA",
                bounds=[(0.0, 1.0)] * cube.dimension,
                options=options,
            ),
        )


@dataclass(frozen=True)
class Shgo(Optimiser):
    """SHGO of SciPy: descents from the minima of a complex that is refined on and on.

    Parameters
    ----------
    points : int
        Points that a refinement adds.
    sampling : {"simplicial", "halton", "sobol"}
        How they are placed.
    """

    points: int = 100
    sampling: Literal["simplicial", "halton", "sobol"] = "simplicial"

    name: ClassVar[str] = "shgo"
    card: ClassVar[Card] = Card(
        "simplicial homology global optimisation (SciPy)",
        "Endres et al. 2018, doi:10.1007/s10898-018-0645-y",
        gradient=True,
        stochastic=False,
    )

    def __post_init__(self) -> None:
        self._require("points", self.points >= 1, "at least 1")
        known = ("simplicial", "halton", "sobol")
        self._require("sampling", self.sampling in known, f"one of {', '.join(known)}")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Refine until the recorder ends it; the method has nothing random to start anew with."""
        from scipy.optimize import shgo

        cube = Cube(problem)
        shgo(
            # With its derivative at each vertex too: asked for alone it would count once more.
            cube.gradient,
            [(0.0, 1.0)] * cube.dimension,
            n=self.points,
            iters=UNENDING,
            minimizer_kwargs={"method": "L-BFGS-B"},
            options={"jac": True},
            sampling_method=self.sampling,
        )
