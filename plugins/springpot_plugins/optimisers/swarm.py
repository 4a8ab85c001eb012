"""The particle swarm of the paper, section 4."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.identification import BatchedOptimiser, Card, RecorderGroup, SearchSpace
from springpot.rheology import Real

Mask: TypeAlias = NDArray[np.bool_]
Indices: TypeAlias = NDArray[np.int64]

BLOCK = 20
"""Instances whose random numbers are drawn at once; they are the same as if drawn one by one."""


@dataclass(frozen=True)
class PaperSwarm(BatchedOptimiser):
    """Particle swarm with the paper's neighbourhood, inertia and repair of constraints; eq. (48) to (52).

    A swarm takes ``particles * (instances + 1)`` evaluations. A smaller budget shortens its schedule, so that the
    inertia still falls to its end; a larger one gives birth to further swarms, as the paper applies its own 5 times.

    Parameters
    ----------
    particles : int
        Size of the swarm.
    instances : int
        The paper's i_max.
    individuality, sociality : float
        c1 and c2 of eq. (50).
    neighbourhood : int or "global"
        How many particles of the ring, itself included, a particle knows: 3 is itself and one on each side, 2 is
        itself and the one before.
    inertia_first, inertia_last : float
        w_max and w_min of eq. (52); the paper gives neither.
    clamp : float
        Largest velocity as a part of the expected size of each parameter.
    penalty : float
        Factor on the objective of a particle that violates a constraint.
    """

    particles: int = 20
    instances: int = 400
    individuality: float = 2.0
    sociality: float = 2.0
    neighbourhood: int | Literal["global"] = 3
    inertia_first: float = 0.9
    inertia_last: float = 0.4
    clamp: float = 0.1
    penalty: float = 1e5

    name: ClassVar[str] = "pso-paper"
    card: ClassVar[Card] = Card("particle swarm of the paper", "section 4, eq. (48)-(52)", batched=True)

    def __post_init__(self) -> None:
        self._require("particles", self.particles >= 1, "at least 1")
        self._require("instances", self.instances >= 1, "at least 1")
        size = self.particles if self.neighbourhood == "global" else self.neighbourhood
        self._require("neighbourhood", 1 <= size <= self.particles, '"global" or from 1 to the number of particles')
        self._require("individuality", self.individuality >= 0, "at least 0")
        self._require("sociality", self.sociality >= 0, "at least 0")
        self._require("inertia_first", self.inertia_first >= self.inertia_last, "at least inertia_last")
        self._require("inertia_last", self.inertia_last >= 0, "at least 0")
        self._require("clamp", self.clamp > 0, "positive")
        self._require("penalty", self.penalty >= 1, "at least 1")

    def minimise_batch(self, problems: RecorderGroup, budget: int, rngs: Sequence[np.random.Generator]) -> None:
        """Fly swarm after swarm until the recorders end it."""
        constraints = Constraints.of(problems.problem.space, (len(rngs), self.particles))
        left = budget
        while True:
            instances = max(0, min(self.instances, left // self.particles - 1))
            self._fly(problems, constraints, instances, rngs)
            left -= self.particles * (instances + 1)

    def _fly(
        self,
        problems: RecorderGroup,
        constraints: Constraints,
        instances: int,
        rngs: Sequence[np.random.Generator],
    ) -> None:
        """One swarm for each run, all runs side by side: arrays of shape (runs, particles, d)."""
        x = constraints.birth(_draw(rngs, constraints.shape[1:]))
        velocity, fastest = np.zeros_like(x), self.clamp * constraints.expected
        own, own_value = x.copy(), self._evaluate(problems, constraints, x)
        known = _ring(self.particles, self.neighbourhood)
        for instance, (r1, r2) in enumerate(_numbers(rngs, constraints.shape[1:], instances)):
            guide = _best_known(own, own_value, known)
            pull = self.individuality * r1 * (own - x) + self.sociality * r2 * (guide - x)
            velocity = _clamped(self._inertia(instance, instances) * velocity + pull, fastest)
            outside = constraints.outside(x + velocity)
            velocity = np.where(outside, _clamped(pull / 2.0, fastest), velocity)
            x = constraints.space.repaired(x + velocity)
            value = self._evaluate(problems, constraints, x)
            better = value < own_value
            own[better], own_value[better] = x[better], value[better]

    def _inertia(self, instance: int, instances: int) -> float:
        """w(i) of eq. (52), which starts at w(1); w(0) never acts, for the first velocity is zero."""
        return self.inertia_first - (self.inertia_first - self.inertia_last) * max(instance - 1, 0) / instances

    def _evaluate(self, problems: RecorderGroup, constraints: Constraints, x: Real) -> Real:
        violated = constraints.violated(x)
        if not violated.any():
            return problems.batch(x)
        return problems.batch(constraints.mirrored(x), np.where(violated, self.penalty, 1.0))


@dataclass(frozen=True, eq=False)
class Constraints:
    """The paper's constraints on a search space, every bound in the shape (runs, particles, d) of the swarm.

    Times and bounded parameters (tau, alpha) stay between a floor and their expected size; all others that cannot
    be negative (stiffnesses) stay positive.
    """

    space: SearchSpace
    expected: Real
    floor: Real
    boxed: Mask
    positive: Mask

    @classmethod
    def of(cls, space: SearchSpace, lead: tuple[int, int]) -> Constraints:
        """Read them off the parameters, for so many runs and particles."""
        boxed = [p.upper < np.inf or (p.unit.time == 1 and not p.unit.stiffness) for p in space.parameters]
        positive = space.lower >= 0
        floor = np.where(positive, 0.0, -space.expected)
        columns = (space.expected, floor, np.array(boxed), positive)
        return cls(space, *(np.tile(column, (*lead, 1)) for column in columns))

    @property
    def shape(self) -> tuple[int, ...]:
        """(runs, particles, d)."""
        return self.expected.shape

    def birth(self, numbers: Real) -> Real:
        """Initial positions, uniform between floor and expected size."""
        return self.floor + (self.expected - self.floor) * numbers

    def outside(self, x: Real) -> Mask:
        """Which of the boxed components left their interval, shape of `x`."""
        left: Mask = self.boxed & ((x <= self.floor) | (x >= self.expected))
        return left

    def violated(self, x: Real) -> Mask:
        """Which points violate any constraint, shape (...)."""
        broken = (self.positive & (x <= 0.0)) | self.outside(x)
        any_broken: Mask = np.logical_or.reduce(broken, axis=-1)
        return any_broken

    def mirrored(self, x: Real) -> Real:
        """`x` with negative times made positive: where a penalised point is evaluated."""
        return np.where(self.boxed & self.positive, np.abs(x), x)


def _clamped(velocity: Real, fastest: Real) -> Real:
    return np.minimum(np.maximum(velocity, -fastest), fastest)


def _draw(rngs: Sequence[np.random.Generator], shape: tuple[int, ...]) -> Real:
    return np.stack([rng.random(shape) for rng in rngs])


def _numbers(
    rngs: Sequence[np.random.Generator], shape: tuple[int, ...], instances: int
) -> Iterator[tuple[Real, Real]]:
    """R1 and R2 of eq. (50) for each instance, each run from its own generator."""
    for first in range(0, instances, BLOCK):
        block = _draw(rngs, (min(BLOCK, instances - first), 2, *shape))
        for numbers in np.moveaxis(block, 0, 2):
            yield numbers[0], numbers[1]


def _ring(particles: int, neighbourhood: int | Literal["global"]) -> Indices:
    """Indices (size, particles) of those each particle knows, itself first."""
    size = particles if neighbourhood == "global" else neighbourhood
    offsets = np.array(sorted(range(-(size // 2), size - size // 2), key=abs))
    known: Indices = (np.arange(particles) + offsets[:, None]) % particles
    return known


def _best_known(own: Real, value: Real, known: Indices) -> Real:
    """Best position (runs, particles, d) in each particle's neighbourhood."""
    runs, particles, d = own.shape
    best, where = value, np.broadcast_to(known[0], value.shape)
    for others in known[1:]:
        rival = value.take(others, axis=1)
        closer = rival < best
        best, where = np.where(closer, rival, best), np.where(closer, others, where)
    rows = where + particles * np.arange(runs)[:, None]
    guides: Real = own.reshape(-1, d).take(rows, axis=0)
    return guides
