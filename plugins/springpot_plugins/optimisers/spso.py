"""Standard particle swarm optimisation 2011, the baseline of its field."""

from __future__ import annotations

from dataclasses import dataclass
from math import log
from typing import ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.identification import Card, Optimiser, Recorder
from springpot.rheology import Real

from .cube import Cube

Mask: TypeAlias = NDArray[np.bool_]


@dataclass(frozen=True)
class StandardSwarm(Optimiser):
    """SPSO-2011 as published, with its own settings; in the unit cube, a whole swarm a call.

    A particle draws its next place in a ball around the mean of itself and of points towards its
    own best and its informants': no direction is special.

    Parameters
    ----------
    particles : int
        Size of the swarm.
    informed : int
        Particles that each one informs, drawn anew after every step without progress.
    inertia, pull : float
        w and c.
    """

    particles: int = 40
    informed: int = 3
    inertia: float = 1.0 / (2.0 * log(2.0))
    pull: float = 0.5 + log(2.0)

    name: ClassVar[str] = "spso-2011"
    card: ClassVar[Card] = Card(
        "standard particle swarm 2011",
        "Clerc 2012, hal-00764996; Zambrano-Bigiarini et al. 2013, doi:10.1109/CEC.2013.6557848",
        started=True,
    )

    def __post_init__(self) -> None:
        self._require("particles", self.particles >= 2, "at least 2")
        self._require("informed", self.informed >= 1, "at least 1")
        self._require("inertia", 0 <= self.inertia < 1, "in [0, 1)")
        self._require("pull", self.pull > 0, "positive")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Fly until the recorder ends it."""
        cube, shape = Cube(problem), (self.particles, problem.dimension)
        x = rng.random(shape)
        first = cube.first()
        if first is not None:
            x[0] = first
        velocity = rng.random(shape) - x
        own, value = x.copy(), cube.batch(x)
        informants = self._informants(rng)
        while True:
            least = value.min()
            velocity = self.inertia * velocity + self._drawn(x, own, value, informants, rng) - x
            x = x + velocity
            outside = (x < 0.0) | (x > 1.0)
            x, velocity = np.clip(x, 0.0, 1.0), np.where(outside, -0.5 * velocity, velocity)
            new = cube.batch(x)
            better = new < value
            own[better], value[better] = x[better], new[better]
            if value.min() >= least:
                informants = self._informants(rng)

    def _informants(self, rng: np.random.Generator) -> Mask:
        """Which particles (columns) inform each one (rows), itself among them."""
        known = np.eye(self.particles, dtype=bool)
        told = rng.integers(0, self.particles, (self.informed, self.particles))
        known[told, np.arange(self.particles)] = True
        return known

    def _drawn(
        self, x: Real, own: Real, value: Real, informants: Mask, rng: np.random.Generator
    ) -> Real:
        """Places (n, d) in balls around the centres of gravity."""
        best = np.where(informants, value, np.inf).argmin(axis=1)
        to_own, to_best = self.pull * (own - x), self.pull * (own[best] - x)
        # A particle that is its own best informant has two to be drawn to, not three.
        alone = (best == np.arange(len(x)))[:, None]
        centre = x + np.where(alone, to_own / 2.0, (to_own + to_best) / 3.0)
        radius = np.linalg.norm(centre - x, axis=1) * rng.random(len(x))
        away = rng.standard_normal(x.shape)
        away /= np.linalg.norm(away, axis=1, keepdims=True)
        drawn: Real = centre + radius[:, None] * away
        return drawn
