"""Evolution strategies and differential evolution."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from springpot.identification import Card, Optimiser, Recorder
from springpot.rheology import Real

from .cube import Cube, keep_on

STRATEGIES = tuple(
    f"{base}{crossing}"
    for base in ("best1", "best2", "rand1", "rand2", "randtobest1", "currenttobest1")
    for crossing in ("bin", "exp")
)
"""SciPy's names of the mutations."""

UNENDING = 2**31 - 1
"""Iterations after which a library may end by itself: the recorder ends the run long before."""


@dataclass(frozen=True)
class CmaEs(Optimiser):
    """CMA-ES of pycma in the unit cube, restarted with a growing population within the budget.

    Parameters
    ----------
    sigma : float
        Initial step as a part of the box.
    population : int
        Points of a generation; 0 takes pycma's 4 + 3 ln d.
    growth : float
        Factor on the population at each restart.
    """

    sigma: float = 0.3
    population: int = 0
    growth: float = 2.0

    name: ClassVar[str] = "cma-es"
    card: ClassVar[Card] = Card(
        "covariance matrix adaptation with restarts (pycma)",
        "Hansen 2016, arXiv:1604.00772",
        started=True,
    )

    def __post_init__(self) -> None:
        self._require("sigma", self.sigma > 0, "positive")
        self._require("population", self.population == 0 or self.population >= 4, "0 or at least 4")
        self._require("growth", self.growth >= 1, "at least 1")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Restart until the recorder ends it."""
        # As a float, so that a growth of less than a point a restart adds up.
        size = float(self.population or 4 + int(3 * np.log(problem.dimension)))

        def attempt() -> None:
            nonlocal size
            _evolve(Cube(problem), int(size), self.sigma, UNENDING, rng)
            size *= self.growth

        keep_on(problem, attempt)


@dataclass(frozen=True)
class BipopCmaEs(Optimiser):
    """CMA-ES of pycma in the unit cube, restarted with large and small populations in turn.

    Whichever kind has used fewer evaluations is next. Large ones double;
    small ones are drawn between the default and half of the last large one, begin with a step of
    1 to 0.01 of the first, and may take half of what the last large one took.

    Parameters
    ----------
    sigma : float
        Initial step as a part of the box; the source's 2 in a box of width 10 by default.
    """

    sigma: float = 0.2

    name: ClassVar[str] = "bipop-cma-es"
    card: ClassVar[Card] = Card(
        "covariance matrix adaptation, two populations (pycma)",
        "Hansen 2009, doi:10.1145/1570256.1570333",
        started=True,
    )

    def __post_init__(self) -> None:
        self._require("sigma", self.sigma > 0, "positive")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Restart until the recorder ends it."""
        cube, default = Cube(problem), 4 + int(3 * np.log(problem.dimension))
        large, last, spent_large, spent_small = default, 0, 0, 0

        def attempt() -> None:
            nonlocal large, last, spent_large, spent_small
            before = problem.evaluations
            # The first run is of neither kind: it counts for none.
            if not last:
                _evolve(cube, default, self.sigma, UNENDING, rng)
                last = problem.evaluations - before
            elif spent_small < spent_large:
                share = float(rng.random())
                size = int(default * (0.5 * large / default) ** share**2)
                step = self.sigma * 10.0 ** (-2.0 * float(rng.random()))
                _evolve(cube, max(size, default), step, last // 2, rng)
                spent_small += problem.evaluations - before
            else:
                large *= 2
                _evolve(cube, large, self.sigma, UNENDING, rng)
                last = problem.evaluations - before
                spent_large += last

        keep_on(problem, attempt)


def _evolve(cube: Cube, size: int, sigma: float, allowed: int, rng: np.random.Generator) -> None:
    """One run of pycma from a uniform start or the race's, of `allowed` evaluations at most."""
    import cma

    options = {
        "bounds": [0.0, 1.0],
        "popsize": size,
        # Its own numbers come from a process-wide generator; these from ours, and seeding is
        # switched off.
        "randn": lambda *shape: rng.standard_normal(shape),
        "seed": np.nan,
        "maxiter": UNENDING,
        "maxfevals": allowed,
        # No words, and no files of its own in the user's folder.
        "verbose": -9,
        "verb_log": 0,
    }
    strategy = cma.CMAEvolutionStrategy(cube.start(rng), sigma, options)
    while not strategy.stop():
        points = strategy.ask()
        strategy.tell(points, cube.batch(np.array(points)).tolist())


@dataclass(frozen=True)
class DifferentialEvolution(Optimiser):
    """Differential evolution of SciPy, a whole generation a call, restarted within the budget.

    Parameters
    ----------
    strategy : str
        SciPy's name of the mutation.
    population : int
        Points of a generation for each parameter.
    mutation : tuple of float
        Range of the factor on differences, drawn anew for each generation.
    recombination : float
        Probability of taking a component of the mutant.
    """

    strategy: str = "best1bin"
    population: int = 15
    mutation: tuple[float, float] = (0.5, 1.0)
    recombination: float = 0.7

    name: ClassVar[str] = "differential-evolution"
    card: ClassVar[Card] = Card(
        "differential evolution, vectorised (SciPy)",
        "Storn and Price 1997, doi:10.1023/A:1008202821328",
        started=True,
    )

    def __post_init__(self) -> None:
        low, high = self.mutation
        self._require("strategy", self.strategy in STRATEGIES, f"one of {', '.join(STRATEGIES)}")
        self._require("population", self.population >= 1, "at least 1")
        self._require("mutation", 0 <= low <= high < 2, "an ascending pair in [0, 2)")
        self._require("recombination", 0 <= self.recombination <= 1, "in [0, 1]")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Restart until the recorder ends it."""
        from scipy.optimize import differential_evolution

        cube = Cube(problem)

        def columns(u: Real) -> Real | float:
            if u.ndim == 1:
                return cube(u)
            return cube.batch(u.T)

        def attempt() -> None:
            differential_evolution(
                columns,
                [(0.0, 1.0)] * cube.dimension,
                strategy=self.strategy,
                popsize=self.population,
                mutation=self.mutation,
                recombination=self.recombination,
                maxiter=UNENDING,
                # It ends only where all of a generation have one value, and starts anew.
                tol=0.0,
                # A descent by another method at the end would be counted as this one's merit.
                polish=False,
                # A whole generation in one call knows no better point of the same generation.
                updating="deferred",
                x0=cube.first(),
                vectorized=True,
                rng=rng,
            )

        keep_on(problem, attempt)
