"""Evolution strategies and differential evolution.

With a library's own settings, and as their authors run them where those are others; and L-SHADE,
which learns its settings and shrinks its population.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

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


@dataclass(frozen=True)
class IpopCmaEs(CmaEs):
    """CMA-ES of pycma as Auger and Hansen ran it at CEC 2005.

    The first step is half of the box, and the population doubles at each restart.

    Parameters
    ----------
    sigma : float
        Initial step as a part of the box.
    population : int
        Points of a generation; 0 takes 4 + 3 ln d.
    growth : float
        Factor on the population at each restart.
    """

    sigma: float = 0.5

    name: ClassVar[str] = "ipop-cma-es"
    card: ClassVar[Card] = Card(
        "covariance matrix adaptation, a doubling population, as its authors run it (pycma)",
        "Auger and Hansen 2005, doi:10.1109/CEC.2005.1554902, section 2",
        started=True,
    )


@dataclass(frozen=True)
class StornPrice(DifferentialEvolution):
    """Differential evolution of SciPy with the settings that Storn and Price recommend.

    DE/rand/1/bin, ten points a parameter, F = 0.5 and CR = 0.9.

    Parameters
    ----------
    strategy : str
        SciPy's name of the mutation.
    population : int
        Points of a generation for each parameter.
    mutation : tuple of float
        Range of the factor on differences.
    recombination : float
        Probability of taking a component of the mutant.
    """

    strategy: str = "rand1bin"
    population: int = 10
    mutation: tuple[float, float] = (0.5, 0.5)
    recombination: float = 0.9

    name: ClassVar[str] = "de-storn-price"
    card: ClassVar[Card] = Card(
        "differential evolution rand/1/bin, as its authors run it (SciPy)",
        "Storn and Price 1997, doi:10.1023/A:1008202821328, section 5",
        started=True,
    )


SMALLEST = 4
"""Points of the last generation: current-to-pbest takes three others."""


@dataclass(frozen=True)
class LShade(Optimiser):
    """L-SHADE as published, with its settings for the CEC 2014 competition; in the unit cube.

    Written from the paper: its schedule runs over the whole budget.

    Parameters
    ----------
    population : int
        Points of the first generation for each parameter.
    archive : float
        Size of the archive of beaten points, in populations.
    elite : float
        Share of the population from which a guide is drawn.
    memory : int
        Pairs of settings that are remembered.
    """

    population: int = 18
    archive: float = 2.6
    elite: float = 0.11
    memory: int = 6

    name: ClassVar[str] = "l-shade"
    card: ClassVar[Card] = Card(
        "adaptive differential evolution with a shrinking population (L-SHADE)",
        "Tanabe and Fukunaga 2014, doi:10.1109/CEC.2014.6900380",
        started=True,
    )

    def __post_init__(self) -> None:
        self._require("population", self.population >= SMALLEST, f"at least {SMALLEST}")
        self._require("archive", self.archive >= 0, "at least 0")
        self._require("elite", 0 < self.elite <= 1, "in (0, 1]")
        self._require("memory", self.memory >= 1, "at least 1")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Search once over the budget, and anew with what rounding leaves of it."""
        cube = Cube(problem)
        keep_on(problem, lambda: _Search(self, cube, budget, rng).run())


class _Search:
    """One population on its way."""

    def __init__(self, own: LShade, cube: Cube, budget: int, rng: np.random.Generator) -> None:
        self.own, self.cube, self.budget, self.rng = own, cube, budget, rng
        self.size = own.population * cube.dimension
        self.x = rng.random((self.size, cube.dimension))
        first = cube.first()
        if first is not None:
            self.x[0] = first
        self.value = cube.batch(self.x)
        self.beaten = np.empty((0, cube.dimension))
        # Crossover rates and scales that have done well; a rate that is no number stays at zero.
        self.rates, self.scales = np.full(own.memory, 0.5), np.full(own.memory, 0.5)
        self.oldest = 0

    def run(self) -> None:
        """Generation after generation until the recorder ends it."""
        while True:
            rate, scale = self._settings()
            children = self._crossed(rate, scale)
            value = self.cube.batch(children)
            won = value < self.value
            if won.any():
                self._learn(rate[won], scale[won], (self.value - value)[won])
            self.beaten = np.concatenate([self.beaten, self.x[won]])
            # An equal child takes its parent's place too, but teaches nothing.
            taken = value <= self.value
            self.x[taken], self.value[taken] = children[taken], value[taken]
            self._shrink()

    def _settings(self) -> tuple[Real, Real]:
        """Crossover rate and scale factor of each point (n,), drawn around remembered ones."""
        chosen = self.rng.integers(0, self.own.memory, len(self.x))
        centre = self.rates[chosen]
        rate = np.clip(self.rng.normal(np.nan_to_num(centre), 0.1), 0.0, 1.0)
        rate[np.isnan(centre)] = 0.0
        scale = np.zeros(len(self.x))
        while (left := scale <= 0.0).any():
            drawn = self.rng.standard_cauchy(int(left.sum()))
            scale[left] = np.minimum(self.scales[chosen[left]] + 0.1 * drawn, 1.0)
        return rate, scale

    def _crossed(self, rate: Real, scale: Real) -> Real:
        """Children (n, d) by current-to-pbest/1 with the archive, and binomial crossover."""
        n, d = self.x.shape
        best = np.argsort(self.value, kind="stable")[: max(2, round(self.own.elite * n))]
        guide = self.x[self.rng.choice(best, n)]
        pool = np.concatenate([self.x, self.beaten])
        one, two = self._others(n, n), self._others(len(pool), n)
        # The three of a difference are different points.
        while (same := one == two).any():
            two = np.where(same, self._others(len(pool), n), two)
        mutant = self.x + scale[:, None] * (guide - self.x + self.x[one] - pool[two])
        # What has left the box comes back half way between its parent and the edge.
        mutant = np.where(mutant < 0.0, 0.5 * self.x, mutant)
        mutant = np.where(mutant > 1.0, 0.5 * (1.0 + self.x), mutant)
        crossed = self.rng.random((n, d)) <= rate[:, None]
        crossed[np.arange(n), self.rng.integers(0, d, n)] = True
        return np.where(crossed, mutant, self.x)

    def _others(self, size: int, n: int) -> NDArray[np.int64]:
        """An index (n,) below `size` for each point, never its own."""
        drawn = self.rng.integers(0, size - 1, n)
        return drawn + (drawn >= np.arange(n))

    def _learn(self, rate: Real, scale: Real, gain: Real) -> None:
        """Remember the means of what won, by how much it did (of Lehmer)."""
        # A value that was infinite has gained without end: all such gains count alike.
        if not np.isfinite(gain).all():
            gain = np.where(np.isfinite(gain), 0.0, 1.0)
        weight = gain / gain.sum()
        if np.isnan(self.rates[self.oldest]) or rate.max() == 0.0:
            self.rates[self.oldest] = np.nan
        else:
            self.rates[self.oldest] = weight @ rate**2 / (weight @ rate)
        self.scales[self.oldest] = weight @ scale**2 / (weight @ scale)
        self.oldest = (self.oldest + 1) % self.own.memory

    def _shrink(self) -> None:
        """Fewer points as the budget goes, the worst of them dropped."""
        gone = self.cube.problem.evaluations / self.cube.problem.budget
        size = max(SMALLEST, round(self.size + (SMALLEST - self.size) * gone))
        kept = np.sort(np.argsort(self.value, kind="stable")[:size])
        self.x, self.value = self.x[kept], self.value[kept]
        room = round(self.own.archive * len(self.x))
        if len(self.beaten) > room:
            self.beaten = self.beaten[self.rng.permutation(len(self.beaten))[:room]]
