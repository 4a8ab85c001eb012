"""Searches of NLopt, in the unit cube, and of SciPy over the whole box.

Of SciPy generalised simulated annealing and the dividing of rectangles; and searches that lead
local descents: basin hopping, COBYQA and SHGO.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from math import inf
from typing import ClassVar, Literal

import numpy as np

from springpot.identification import Card, Optimiser, Recorder
from springpot.rheology import Real

from .cube import Cube, integer, keep_on
from .evolution import UNENDING


class Solver:
    """An NLopt solver on the unit cube.

    Parameters
    ----------
    algorithm : str
        NLopt's name of it.
    cube : Cube
        What is minimised.
    population : int
        Its population or sample; 0 takes NLopt's own.
    tolerance : float
        Relative change of point and objective that ends it; 0 for none.
    """

    def __init__(
        self, algorithm: str, cube: Cube, population: int = 0, tolerance: float = 0.0
    ) -> None:
        import nlopt

        self._cube = cube
        self._fault: BaseException | None = None
        # NLopt names its failures by classes of its own in newer releases.
        failure = getattr(nlopt, "runtime_error", RuntimeError)
        self._gives_up = (nlopt.ForcedStop, nlopt.RoundoffLimited, failure, RuntimeError)
        self.native = nlopt.opt(getattr(nlopt, algorithm), cube.dimension)
        self.native.set_lower_bounds(np.zeros(cube.dimension))
        self.native.set_upper_bounds(np.ones(cube.dimension))
        self.native.set_min_objective(self._objective)
        # Zero switches a tolerance off: a global method goes on until the recorder ends it.
        self.native.set_xtol_rel(tolerance)
        self.native.set_ftol_rel(tolerance)
        if population:
            self.native.set_population(population)

    def _objective(self, u: Real, slope: Real) -> float:
        # An exception does not stop every solver, and the next call would fail over it: keep it,
        # ask to stop.
        if self._fault is not None:
            return inf
        try:
            # NLopt hands an empty array to be filled where its method takes no derivatives.
            if not slope.size:
                return self._cube(u)
            value, slope[:] = self._cube.gradient(u)
            return value
        except BaseException as error:
            self._fault = error
            self.native.force_stop()
            return inf

    def search(self, start: Real) -> None:
        """Search from `start`.

        A line search that NLopt gives up is the end of a descent, not a fault.
        """
        with suppress(*self._gives_up):
            self.native.optimize(start)
        if self._fault is not None:
            raise self._fault


def _seed(rng: np.random.Generator) -> None:
    """Seed NLopt's generator, which all its solvers in this process share."""
    import nlopt

    nlopt.srand(integer(rng))


@dataclass(frozen=True)
class _Global(Optimiser):
    """A global NLopt method, started from a random point."""

    algorithm: ClassVar[str]

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Search until the recorder ends it."""
        cube = Cube(problem)
        # Seeded once: attempt after attempt goes on in one stream, and none repeats another.
        _seed(rng)
        solver = Solver(self.algorithm, cube, getattr(self, "population", 0))
        keep_on(problem, lambda: solver.search(cube.start(rng)))


@dataclass(frozen=True)
class _Population(_Global):
    """A global NLopt method with a population.

    Parameters
    ----------
    population : int
        Its size; 0 takes NLopt's own.
    """

    population: int = 0

    def __post_init__(self) -> None:
        self._require("population", self.population >= 0, "at least 0")


class Crs(_Population):
    """Controlled random search with local mutation."""

    algorithm = "GN_CRS2_LM"
    name = "nlopt-crs"
    card = Card(
        "controlled random search (NLopt)",
        "Kaelo and Ali 2006, doi:10.1007/s10957-006-9101-0",
        started=True,
    )

    def __post_init__(self) -> None:
        self._require("population", self.population == 0 or self.population >= 6, "0 or at least 6")


class Isres(_Population):
    """Evolution strategy with stochastic ranking."""

    algorithm = "GN_ISRES"
    name = "nlopt-isres"
    card = Card(
        "improved stochastic ranking evolution strategy (NLopt)",
        "Runarsson and Yao 2005",
        started=True,
    )


class Esch(_Population):
    """Evolutionary algorithm with Cauchy mutation."""

    algorithm = "GN_ESCH"
    name = "nlopt-esch"
    card = Card(
        "evolutionary algorithm with Cauchy mutation (NLopt)", "da Silva Santos 2010", started=True
    )


class DirectL(_Global):
    """Locally biased division of rectangles; deterministic."""

    algorithm = "GN_DIRECT_L"
    name = "nlopt-direct-l"
    card = Card(
        "locally biased dividing rectangles (NLopt)",
        "Gablonsky and Kelley 2001, doi:10.1023/A:1017930332101",
        stochastic=False,
    )


@dataclass(frozen=True)
class Mlsl(Optimiser):
    """Multi-level single linkage.

    Local descents from random points that no earlier descent explains.

    Parameters
    ----------
    descent : {"bobyqa", "lbfgs"}
        The local method.
    low_discrepancy : bool
        Take the points from a Sobol sequence, which is the same for every seed.
    sample : int
        Points sampled in each round; 0 takes NLopt's 4.
    tolerance : float
        Relative change of point and objective that ends a descent.
    """

    descent: Literal["bobyqa", "lbfgs"] = "bobyqa"
    low_discrepancy: bool = False
    sample: int = 0
    tolerance: float = 1e-10

    name: ClassVar[str] = "nlopt-mlsl"
    card: ClassVar[Card] = Card(
        "multi-level single linkage (NLopt)",
        "Rinnooy Kan and Timmer 1987, doi:10.1007/BF02592071",
        started=True,
    )

    def __post_init__(self) -> None:
        self._require("descent", self.descent in ("bobyqa", "lbfgs"), "bobyqa or lbfgs")
        self._require("sample", self.sample >= 0, "at least 0")
        self._require("tolerance", 0 < self.tolerance < 1, "in (0, 1)")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Search until the recorder ends it."""
        cube = Cube(problem)
        _seed(rng)
        # NLopt's names say by N or D whether a method takes derivatives.
        whole, descent = "GN_MLSL", "LN_BOBYQA"
        if self.descent == "lbfgs":
            whole, descent = "GD_MLSL", "LD_LBFGS"
        if self.low_discrepancy:
            whole += "_LDS"
        # For MLSL the population is the number of points sampled in a round.
        solver = Solver(whole, cube, self.sample)
        local = Solver(descent, cube, tolerance=self.tolerance)
        solver.native.set_local_optimizer(local.native)
        keep_on(problem, lambda: solver.search(cube.start(rng)))


@dataclass(frozen=True)
class _Local(Optimiser):
    """A local NLopt method from one random start after another.

    Parameters
    ----------
    tolerance : float
        Relative change of point and objective that ends a descent.
    """

    tolerance: float = 1e-10

    algorithm: ClassVar[str]

    def __post_init__(self) -> None:
        self._require("tolerance", 0 < self.tolerance < 1, "in (0, 1)")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Descend from uniform starts until the recorder ends it."""
        cube = Cube(problem)
        _seed(rng)
        solver = Solver(self.algorithm, cube, tolerance=self.tolerance)
        keep_on(problem, lambda: solver.search(cube.start(rng)))


class Sbplx(_Local):
    """Rowan's subspace-searching simplex."""

    algorithm = "LN_SBPLX"
    name = "nlopt-sbplx"
    card = Card("multi-start subplex (NLopt)", "Rowan 1990", globally=False, started=True)


class Bobyqa(_Local):
    """Powell's quadratic models in bounds."""

    algorithm = "LN_BOBYQA"
    name = "nlopt-bobyqa"
    card = Card("multi-start BOBYQA (NLopt)", "Powell 2009", globally=False, started=True)


class NelderMead(_Local):
    """Nelder and Mead's simplex in bounds."""

    algorithm = "LN_NELDERMEAD"
    name = "nlopt-nelder-mead"
    card = Card(
        "multi-start simplex (NLopt)",
        "Nelder and Mead 1965, doi:10.1093/comjnl/7.4.308",
        globally=False,
        started=True,
    )


class Lbfgs(_Local):
    """Limited-memory BFGS in bounds with the exact gradient."""

    algorithm = "LD_LBFGS"
    name = "nlopt-lbfgs"
    card = Card(
        "multi-start L-BFGS with exact gradient (NLopt)",
        "Liu and Nocedal 1989, doi:10.1007/BF01589116",
        globally=False,
        started=True,
        gradient=True,
    )


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
