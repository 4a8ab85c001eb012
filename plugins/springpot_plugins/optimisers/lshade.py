"""L-SHADE: differential evolution that learns its settings and shrinks its population."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from springpot.identification import Card, Optimiser, Recorder
from springpot.rheology import Real

from .cube import Cube, keep_on

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
