"""Particle swarms: that of the paper, section 4, and SPSO-2011, the baseline of their field."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import log
from typing import ClassVar, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.identification import (
    BatchedOptimiser,
    Card,
    Optimiser,
    Recorder,
    RecorderGroup,
    SearchSpace,
)
from springpot.rheology import Real

from .cube import Cube

Mask: TypeAlias = NDArray[np.bool_]
Indices: TypeAlias = NDArray[np.int64]

BLOCK = 5
"""Instances whose random numbers are drawn at once.

Those of 50 swarms then stay in the processor's cache.

They are the same as if drawn one by one.
"""

# The swarm computes with (d, runs, particles), where each parameter's numbers lie side by side; all
# else has d last.
PARAMETERS_LAST, PARAMETERS_FIRST = (1, 2, 0), (2, 0, 1)


@dataclass(frozen=True)
class PaperSwarm(BatchedOptimiser):
    """Particle swarm with the paper's neighbourhood, inertia and repair of constraints; eq.

    (48) to (52).

    A swarm takes ``particles * (instances + 1)`` evaluations. A smaller budget shortens its
    schedule, so that the inertia still falls to its end; a larger one gives birth to further
    swarms, as the paper applies its own 5 times.

    Parameters
    ----------
    particles : int
        Size of the swarm.
    instances : int
        The paper's i_max.
    individuality, sociality : float
        c1 and c2 of eq. (50).
    neighbourhood : int or "global"
        How many particles of the ring, itself included, a particle knows: 3 is itself and one on
        each side, 2 is itself and the one before.
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
    # Section 4 clamps to 0.1 k-bar and multiplies by a number of the order 10^5.
    clamp: float = 0.1
    penalty: float = 1e5

    name: ClassVar[str] = "pso-paper"
    card: ClassVar[Card] = Card(
        "particle swarm of the paper", "section 4, eq. (48)-(52)", batched=True, started=True
    )

    def __post_init__(self) -> None:
        self._require("particles", self.particles >= 1, "at least 1")
        self._require("instances", self.instances >= 1, "at least 1")
        size = _known_to_each(self.particles, self.neighbourhood)
        self._require(
            "neighbourhood",
            1 <= size <= self.particles,
            '"global" or from 1 to the number of particles',
        )
        self._require("individuality", self.individuality >= 0, "at least 0")
        self._require("sociality", self.sociality >= 0, "at least 0")
        self._require(
            "inertia_first", self.inertia_first >= self.inertia_last, "at least inertia_last"
        )
        self._require("inertia_last", self.inertia_last >= 0, "at least 0")
        self._require("clamp", self.clamp > 0, "positive")
        self._require("penalty", self.penalty >= 1, "at least 1")

    def minimise_batch(
        self, problems: RecorderGroup, budget: int, rngs: Sequence[np.random.Generator]
    ) -> None:
        """Fly swarm after swarm until the recorders end it."""
        limits = Limits.of(problems.problem.space)
        left = budget
        while True:
            # The birth is an evaluation of each particle too.
            instances = max(0, min(self.instances, left // self.particles - 1))
            self._fly(problems, limits, instances, rngs)
            left -= self.particles * (instances + 1)

    def _fly(
        self,
        problems: RecorderGroup,
        limits: Limits,
        instances: int,
        rngs: Sequence[np.random.Generator],
    ) -> None:
        """One swarm for each run, all runs side by side: arrays of shape (d, runs, particles)."""
        d = len(limits.expected)
        # Positions stay as drawn, also where kinf is below k0: they are evaluated with the repair.
        x = limits.birth(_draw(rngs, (self.particles, d)))
        for own_x, recorder in zip(x.transpose(PARAMETERS_LAST), problems.recorders, strict=True):
            # One particle begins at the race's first point, where there is one.
            own_x[0] = recorder.first(own_x[0])
        # Zero vectors are what the paper begins with.
        velocity, fastest = np.zeros_like(x), self.clamp * limits.expected
        own, own_value = x.copy(), self._evaluate(problems, limits, x).copy()
        known = _places(_ring(self.particles, self.neighbourhood), len(own_value))
        weights = np.array([self.individuality, self.sociality])
        for instance, (r1, r2) in enumerate(_numbers(rngs, self._drawn(d), instances, weights)):
            # In place wherever that can be: tables of fifty swarms fill the processor's cache.
            pull, social = own - x, _best_known(own, own_value, known)
            pull *= r1
            social -= x
            social *= r2
            pull += social
            velocity *= self._inertia(instance, instances)
            velocity += pull
            _clamp(velocity, fastest)
            x = limits.moved(x, velocity, pull, fastest)
            limits.repair(x)
            value = self._evaluate(problems, limits, x)
            # All particles have moved by now: they follow the bests of the instance before, in no
            # order.
            better = value < own_value
            own = np.where(better, x, own)
            np.minimum(own_value, value, out=own_value)

    def _drawn(self, dimension: int) -> tuple[int, int]:
        """Particles, and random numbers of each for one term: R1 and R2 are diagonal matrices."""
        return self.particles, dimension

    def _inertia(self, instance: int, instances: int) -> float:
        """w(i) of eq. (52), which starts at w(1); w(0) never acts: the first velocity is zero."""
        return (
            self.inertia_first
            - (self.inertia_first - self.inertia_last) * max(instance - 1, 0) / instances
        )

    def _evaluate(self, problems: RecorderGroup, limits: Limits, x: Real) -> Real:
        violated = limits.violated(x)
        if violated is None:
            return problems.batch(x.transpose(PARAMETERS_LAST))
        # A negative time has no real power: its absolute value is evaluated, and penalised.
        points = limits.mirrored(x).transpose(PARAMETERS_LAST)
        return problems.batch(points, np.where(violated, self.penalty, 1.0))


@dataclass(frozen=True)
class ScalarSwarm(PaperSwarm):
    """The paper's swarm with one random number for a whole particle and term, not a matrix."""

    name: ClassVar[str] = "pso-paper-scalar"
    card: ClassVar[Card] = Card(
        "particle swarm of the paper, random numbers read as scalars",
        "section 4, eq. (48)-(52), and Kennedy and Eberhart 1995, doi:10.1109/ICNN.1995.488968",
        batched=True,
        started=True,
    )

    def _drawn(self, dimension: int) -> tuple[int, int]:
        return self.particles, 1


@dataclass(frozen=True, eq=False)
class Limits:
    """The paper's constraints on a search space.

    Columns (d, 1, 1) for swarms of shape (d, runs, particles).

    Times and bounded parameters (tau, alpha) stay between a floor and their expected size; all
    others that cannot be negative (stiffnesses) stay positive. Where there is no such limit, it is
    infinite.

    Parameters
    ----------
    space : SearchSpace
        What is searched.
    expected : ndarray
        Sizes of the order of the answer.
    birthplace : ndarray
        Lower ends of the intervals in which particles are born.
    floor, ceiling : ndarray
        What makes the velocity of a bounded component turn back once it is reached.
    least : ndarray
        What breaks a constraint once it is reached; so does the ceiling.
    held : slice
        From the first bounded component to the last.
    upright : tuple of int
        Components that are evaluated at their absolute value: bounded ones that cannot be negative.
    """

    space: SearchSpace
    expected: Real
    birthplace: Real
    floor: Real
    ceiling: Real
    least: Real
    held: slice
    upright: tuple[int, ...]

    @classmethod
    def of(cls, space: SearchSpace) -> Limits:
        """Read them off the parameters."""
        # Times and orders are held between limits; a stiffness may leave the interval in which it
        # was born.
        boxed = np.array(
            [
                p.upper < np.inf or (p.unit.time == 1 and not p.unit.stiffness)
                for p in space.parameters
            ]
        )
        positive = space.lower >= 0
        birthplace = np.where(positive, 0.0, -space.expected)
        floor = np.where(boxed, birthplace, -np.inf)
        ceiling = np.where(boxed, space.expected, np.inf)
        least = np.where(positive, 0.0, floor)
        rows = np.array([space.expected, birthplace, floor, ceiling, least])
        expected, birthplace, floor, ceiling, least = rows[:, :, None, None]
        upright = tuple(np.flatnonzero(boxed & positive).tolist())
        bounded = np.flatnonzero(boxed).tolist() or [0]
        held = slice(bounded[0], bounded[-1] + 1)
        return cls(space, expected, birthplace, floor, ceiling, least, held, upright)

    def birth(self, numbers: Real) -> Real:
        """Initial positions (d, runs, particles) from numbers (runs, particles, d).

        They are uniform in the expected size.
        """
        spread = np.multiply(
            numbers.transpose(PARAMETERS_FIRST), self.expected - self.birthplace, order="C"
        )
        return self.birthplace + spread

    def moved(self, x: Real, velocity: Real, pull: Real, fastest: Real) -> Real:
        """Where to; what would leave its interval goes by half the pull, clamped, from now on."""
        ahead = x + velocity
        held = ahead[self.held]
        leaving = held <= self.floor[self.held]
        leaving |= held >= self.ceiling[self.held]
        if not leaving.any():
            return ahead
        # The pull of this step with its random numbers, halved and then clamped: the paper leaves
        # open whether they are drawn anew. Late in a run only a few turn back: they are picked out
        # of the flat arrays.
        places = np.flatnonzero(leaving) + self.held.start * x[0].size
        limit = fastest.ravel().take(places // x[0].size)
        back = np.minimum(np.maximum(pull.ravel().take(places) / 2.0, -limit), limit)
        velocity.ravel()[places] = back
        ahead.ravel()[places] = x.ravel().take(places) + back
        return ahead

    def repair(self, x: Real) -> None:
        """Restore the order kinf > k0, in place."""
        # The position itself, not only what is evaluated: "a new value of k_inf equal to 1.01 k_0
        # is introduced".
        points = x.transpose(PARAMETERS_LAST)
        repaired = self.space.repaired(points)
        if repaired is not points:
            x[...] = repaired.transpose(PARAMETERS_FIRST)

    def violated(self, x: Real) -> Mask | None:
        """Which points violate any constraint, shape (runs, particles); nothing if none does."""
        # A limit that is reached is broken: the paper's section 4 has 0 < alpha < 1, without the
        # ends.
        broken = x <= self.least
        broken[self.held] |= x[self.held] >= self.ceiling[self.held]
        if not broken.any():
            return None
        any_broken: Mask = np.logical_or.reduce(broken, axis=0)
        return any_broken

    def mirrored(self, x: Real) -> Real:
        """`x` with negative times made positive: where a penalised point is evaluated."""
        upright = x.copy()
        for i in self.upright:
            np.abs(x[i], out=upright[i])
        return upright


def _clamp(velocity: Real, fastest: Real) -> None:
    np.maximum(velocity, -fastest, out=velocity)
    np.minimum(velocity, fastest, out=velocity)


def _draw(rngs: Sequence[np.random.Generator], shape: tuple[int, ...]) -> Real:
    """Random numbers (runs, *shape), each run's from its own generator."""
    numbers = np.empty((len(rngs), *shape))
    for rng, own in zip(rngs, numbers, strict=True):
        rng.random(out=own)
    return numbers


def _numbers(
    rngs: Sequence[np.random.Generator], shape: tuple[int, int], instances: int, weights: Real
) -> Iterator[Real]:
    """R1 and R2 of eq. (50) times their weights, (2, d, runs, particles) for each instance.

    Each generator is asked in the order instance, term, particle, parameter, as if one number were
    drawn at a time.
    """
    for first in range(0, instances, BLOCK):
        block = _draw(rngs, (min(BLOCK, instances - first), 2, *shape))
        turned = block.transpose(1, 2, 4, 0, 3)
        yield from np.multiply(turned, weights[:, None, None, None], order="C")


def _known_to_each(particles: int, neighbourhood: int | Literal["global"]) -> int:
    """How many particles each one knows."""
    if neighbourhood == "global":
        return particles
    return neighbourhood


def _ring(particles: int, neighbourhood: int | Literal["global"]) -> Indices:
    """Indices (size, particles) of those each particle knows, itself first."""
    size = _known_to_each(particles, neighbourhood)
    # Itself first, then its neighbours as they are further away.
    offsets = np.array(sorted(range(-(size // 2), size - size // 2), key=abs))
    known: Indices = (np.arange(particles) + offsets[:, None]) % particles
    return known


def _places(ring: Indices, runs: int) -> Indices:
    """The same of many runs (size, runs, particles), as places in flat tables."""
    places: Indices = ring[:, None] + ring.shape[1] * np.arange(runs)[:, None]
    return places


def _best_known(own: Real, value: Real, known: Indices) -> Real:
    """Best position (d, runs, particles) in each particle's neighbourhood."""
    best, where = value, known[0]
    for others in known[1:]:
        rival = value.take(others)
        # Added and not chosen: whose value is less is anybody's guess, also the processor's.
        where = where + (rival < best) * (others - where)
        best = np.minimum(rival, best)
    guides: Real = own.reshape(len(own), -1).take(where.ravel(), axis=1).reshape(own.shape)
    return guides


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
