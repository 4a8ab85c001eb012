"""Tests of one specimen as residuals: each over its own noise, all with the same parameters."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import autocorrelation_time
from springpot.identification.convex import (
    ConvexSpectrum,
    apparent,
    lines_of_record,
    lines_of_sweep,
    unknowns_of,
)
from springpot.identification.leastsquares import Residual as Residual
from springpot.identification.problem import Objective
from springpot.measurement.covered import OtherTest
from springpot.measurement.instrument import roundings
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import Test as Test
from springpot.measurement.recording import recorded, spread
from springpot.measurement.timenoise import noise_of, noise_of_alike, relative_scatter, strays
from springpot.measurement.timetest import TimeTest
from springpot.measurement.units import Units, one_modulus
from springpot.rheology.intime import Traced
from springpot.rheology.model import Model
from springpot.rheology.nodes import GRADIENT, Node
from springpot.rheology.points import Complex, Points, Real, complex_form, real_form

from ..numerics import COARSE, NEGLIGIBLE, SMALLEST, evenly, rms
from .coloured_noise import Imposed
from .frame import NoiseFrame
from .residual_scatter import (
    FEWEST,
    ResidualScatter,
    scatter_of,
    scatter_of_record,
    scatter_of_sweep,
)
from .where import Where, where
from .where_in_time import places

ANSWERS = 2
"""Of a test that are kept: that to the best parameters of a search, and to the last it tried."""
WITHIN = 3.0
"""Rates over one a step at which relaxation beside a straight motion is still told from a dashpot.
"""


@dataclass(frozen=True, eq=False)
class TestPart(ABC):
    """A test as numbers beside those of a model: all that an engine asks of a test.

    Parameters
    ----------
    test : Test
        The test.
    scale : float
        By how much its noise is taken to be larger than its scatter says.
    noise : ndarray, shape (m,), optional
        Standard deviation of each number, where it is known better than the test itself tells.
    """

    test: Test
    scale: float = 1.0
    noise: Real | None = None

    @property
    @abstractmethod
    def at(self) -> Real:
        """Where each number (m,) was measured: time in s, or frequency in Hz."""

    @property
    @abstractmethod
    def rate(self) -> Real:
        """Angular frequency in rad/s that each of them tells of, (m,)."""

    @property
    @abstractmethod
    def measured(self) -> Real:
        """The numbers (m,)."""

    @cached_property
    def sd(self) -> Real:
        """Their standard deviations (m,)."""
        return self._own_sd if self.noise is None else self.noise

    @property
    @abstractmethod
    def _own_sd(self) -> Real:
        """Those that the test itself tells, (m,)."""

    @property
    def size(self) -> Real:
        """What an error of each of them is a share of, (m,): their root mean square.

        It is shared among them as their noise is, so that an error and the noise go together: of
        noise in proportion to the signal it is that of each sample over the sample, of constant
        noise that of all over all. One of which no model says anything is no part of it if it is
        larger than all others, such as a spike before the motion.
        """
        said = self.sure if self.measured.any() and self.sure.any() else slice(None)
        kept = np.abs(self.measured) <= np.abs(self.measured[said]).max()
        return np.asarray(self.sd * rms(self.measured[kept]) / max(rms(self.sd[kept]), SMALLEST))

    @property
    @abstractmethod
    def stiffness(self) -> float:
        """Typical size of K."""

    @property
    @abstractmethod
    def reach(self) -> float:
        """Largest displacement."""

    @abstractmethod
    def answer(self, model: Model, theta: Real, reference: float, rows: NDArray[np.intp]) -> Traced:
        """What a model says of some of these numbers (r,), with derivatives (r, p)."""

    @abstractmethod
    def scatter(self, residual: Real, followed: float = 0.0) -> ResidualScatter:
        """The noise in a residual (m,) that is told over the standard deviations.

        So many of the numbers a model has `followed`.
        """

    @property
    @abstractmethod
    def quantity(self) -> str:
        """What the numbers are, in words."""

    @property
    def unit(self) -> str:
        """Their unit."""
        return self.test.units.stiffness

    @property
    def lines(self) -> ConvexSpectrum | None:
        """The material that it shows where nothing but one has made it; None where none is read."""
        return None

    @property
    def unknowns(self) -> Real:
        """By how much the numbers (m, k) hang on what nobody knows, in its deviations."""
        return np.zeros((len(self.measured), 0))

    @property
    def judged(self) -> bool:
        """Whether they were measured; otherwise they are only asked for."""
        return True

    @property
    def conditions(self) -> dict[str, Real]:
        """What was set beside the load, for each of them (m,)."""
        return dict(self.test.conditions)

    @property
    def log_omega(self) -> float:
        """Logarithm of the angular frequency in the middle of what it saw."""
        return float(np.mean(np.log(self.test.seen)))

    @property
    def resolved(self) -> tuple[float, float]:
        """Angular frequencies between which it tells something of a material."""
        return self.test.seen

    @property
    def sure(self) -> NDArray[np.bool_]:
        """Of which of the numbers (m,) a model says anything."""
        return np.ones(len(self.measured), dtype=bool)

    @property
    def counted(self) -> NDArray[np.bool_]:
        """Which of the numbers (m,) say anything of a model."""
        return self.sure

    @property
    def relative_sd(self) -> Real:
        """The noise over the size of what was measured, (m,)."""
        return np.asarray(self.sd / self.size, dtype=float)

    @property
    def signal(self) -> Real:
        """What was measured, over its noise, (m,)."""
        return np.asarray(self.measured / (self.scale * self.sd), dtype=float)

    @property
    def thin(self) -> NDArray[np.intp]:
        """Those of the numbers with which a search begins."""
        return np.arange(len(self.measured))

    def count(self, coarse: bool = False) -> int:
        """How many numbers it gives."""
        return len(self.thin if coarse else self.measured)

    def residual(
        self, model: Model, theta: Real, reference: float, coarse: bool = False
    ) -> Residual:
        """Predicted less measured, over the noise; of some samples only if `coarse`."""
        rows = self.thin if coarse else np.arange(len(self.measured))
        answer = self.answer(model, theta, reference, rows)
        return self.missed(answer, rows, 1.0 / (self.scale * self.sd[rows]))

    def missed(self, answer: Traced, rows: NDArray[np.intp], weight: Real) -> Residual:
        """What an answer to some of the numbers (r,) misses, by weights (r,) of those that count.

        At the instant of a step, of weight nothing, an exact answer may be endless.
        """
        counted = self.counted[rows]
        missed = np.where(counted, answer.value - self.measured[rows], 0.0)
        by_theta = np.where(counted[:, None], answer.by_theta, 0.0)
        found = Residual(missed * weight, by_theta * weight[:, None])
        return found.freed(np.where(counted, weight, 0.0)[:, None] * self.unknowns[rows])

    def over_noise(self, model: Model, theta: Real, reference: float) -> Residual:
        """The same over its noise alone, whatever it weighs in a fit."""
        return self.with_scale(1.0).residual(model, theta, reference)

    def relative_error(self, residual: Real) -> float:
        """Root mean square of a residual (m,) over the signal, of the numbers that count."""
        return rms((residual * self.relative_sd)[self.counted])

    def neighbours(self, residual: Real) -> Real:
        """Those numbers of a residual (m,) that follow one another."""
        return residual

    def sampled(self, residual: Real) -> float:
        """Mean square of a residual times the numbers that make up one independent one."""
        return float(np.mean(residual**2)) * autocorrelation_time(self.neighbours(residual))

    def beside(self, residual: Real, parameters: int) -> float:
        """By how much its variance exceeds the noise's, where more than the parameters tell it."""
        return max(1.0, self.sampled(residual)) if len(residual) > parameters else 1.0

    def rounded(self, residual: Real) -> Real:
        """Errors (k, m) that the digits of the test may make of what leaves this residual (m,).

        Over the standard deviations, as the residual is.
        """
        return np.zeros((0, len(residual)))

    def places(self, residual: Real) -> list[Where]:
        """Where a residual (m,) over the noise is plainly more than that, the worst first."""
        return []

    @property
    def view(self) -> Measurement:
        """The numbers as an objective looks at them: one beside the other."""
        order, sd = np.arange(1.0, len(self.measured) + 1.0), complex_form(np.tile(self.sd, 2))
        return Measurement(order, self.measured.astype(complex), sd=sd, name=self.test.name)

    def weighed_by(self, objective: Objective) -> Self:
        """A part whose numbers weigh among each other as an objective has it.

        Against other tests it weighs by its noise, as ever; a logarithmic objective weighs relative
        to the size of what was measured.
        """
        weights = objective.weighing(self.view)
        if objective.logarithmic:
            weights = weights / self.view.magnitude
        by = real_form(weights)[: len(self.measured)]
        return self.with_sd(np.asarray(rms(self.sd * by) / by, dtype=float))

    def with_sd(self, sd: Real) -> Self:
        """The same with these standard deviations (m,)."""
        return replace(self, noise=sd)

    def with_scale(self, scale: float) -> Self:
        """The same with larger noise."""
        # The same object keeps what it has worked out, such as its noise.
        return self if scale == self.scale else replace(self, scale=scale)


@dataclass(frozen=True, eq=False)
class InTimePart(TestPart):
    """A test in time.

    Parameters
    ----------
    worth : float
        Independent numbers of other tests too that tell it; 0 where this one alone does.
    told : deque
        The last answers: a fit, its covariance and what it leaves ask for the same ones.
    """

    test: TimeTest
    worth: float = 0.0
    told: deque[tuple[tuple[Any, ...], Traced]] = field(
        default_factory=lambda: deque(maxlen=ANSWERS), repr=False
    )

    @property
    def at(self) -> Real:
        """Time of each sample in s."""
        return self.test.time

    @property
    def rate(self) -> Real:
        """After a step each instant tells of its own rate.

        Where the load keeps moving all samples tell of all rates.
        """
        if self.test.after_step:
            return np.asarray(1.0 / np.maximum(self.at - self.test.start, SMALLEST))
        return np.full(len(self.at), float(np.sqrt(np.prod(self.test.seen))))

    @property
    def measured(self) -> Real:
        """The response."""
        return self.test.response

    @property
    def _own_sd(self) -> Real:
        return noise_of(self.test).sd

    @property
    def stiffness(self) -> float:
        """Typical size of K."""
        # The median: at the instant of a step the answer may be many times what it is later.
        imposed, answered = np.abs(self.test.loading.value).max(), np.median(np.abs(self.measured))
        if self.test.control == "displacement":
            return max(float(answered / imposed), SMALLEST)
        return max(float(imposed / max(answered, SMALLEST)), SMALLEST)

    @property
    def reach(self) -> float:
        """Largest displacement."""
        moved = self.measured
        if self.test.control == "displacement":
            moved = self.test.loading.value
        return max(float(np.abs(moved).max()), SMALLEST)

    @property
    def quantity(self) -> str:
        """Force or displacement, stress or strain."""
        return self.test.words[1]

    @property
    def unit(self) -> str:
        """Of the response."""
        return self.test.response_unit

    @property
    def judged(self) -> bool:
        """Whether there was a response, and not only a plan."""
        return self.test.measured

    @property
    def resolved(self) -> tuple[float, float]:
        """What relaxes within a step of a record is felt too, as the motion there is known."""
        slowest, fastest = self.test.seen
        if self.test.after_step:
            return slowest, fastest
        return slowest, WITHIN * fastest

    @cached_property
    def sure(self) -> NDArray[np.bool_]:
        """All but the very instant of a step, and samples that stray from their neighbours.

        At the former the answer may be endless, and no instrument reads it.
        """
        said = ~np.isin(self.at, self.test.loading.unsure(self.judged))
        said[self.strays] = False
        return said

    @cached_property
    def counted(self) -> NDArray[np.bool_]:
        """The same without those at which the motion turns: of friction they say nothing.

        Not for any model, or one with friction would be held against other samples.
        """
        return self.sure & ~np.isin(self.at, self.test.loading.turning)

    @cached_property
    def strays(self) -> NDArray[np.int64]:
        """Samples that are off by themselves, which no model is to follow."""
        return strays(self.test)

    @cached_property
    def lines(self) -> ConvexSpectrum:
        """Of relaxation; under a force those of its retardation tell them."""
        return lines_of_record(self.test, self.sd)

    @cached_property
    def unknowns(self) -> Real:
        """Of steps of the load between two samples, and of noise in the first one."""
        return unknowns_of(self.test, self.sd) if self.judged else super().unknowns

    @cached_property
    def apparent(self) -> Measurement | None:
        """The sweep that the test amounts to; None where no sum of exponentials follows it."""
        return apparent(self.test, self.lines)

    def answer(self, model: Model, theta: Real, reference: float, rows: NDArray[np.intp]) -> Traced:
        """What the test records of a model and of what it did itself."""
        asked = (self.test, model, reference, theta.tobytes(), rows.tobytes())
        known = next((told for of, told in self.told if of == asked), None)
        if known is not None:
            return known
        told = recorded(model, theta, self.test, reference, self.at[rows], NEGLIGIBLE)
        self.told.append((asked, told))
        return told

    def scatter(self, residual: Real, followed: float = 0.0) -> ResidualScatter:
        """From the spectrum of the residual."""
        rounded = self.rounded(residual)
        return scatter_of_record(residual, rounded, self.imposed, self.worth, followed)

    @cached_property
    def imposed(self) -> Imposed:
        """What of the loading may leave its traces in the noise."""
        return Imposed.of(self.test, self.stiffness, self.sd)

    def rounded(self, residual: Real) -> Real:
        """Of a channel with few values."""
        return roundings(self.measured + residual * self.sd, self.measured) / self.sd

    def places(self, residual: Real) -> list[Where]:
        """Between which times, and where in a loop."""
        return places(self.test, np.where(self.counted, residual, np.nan))

    @cached_property
    def thin(self) -> NDArray[np.intp]:
        """Samples spread evenly over the logarithm of time for steps, over time else."""
        n = len(self.at)
        if n <= COARSE:
            return np.arange(n)
        if not self.test.after_step:
            return evenly(n, COARSE)
        clock = np.maximum(self.at - self.test.start, SMALLEST)
        # Samples at or before the step have no place on a logarithmic clock.
        positive = clock > SMALLEST
        # What follows a step happens decade by decade: evenly in time its beginning would be left
        # out.
        wanted = np.geomspace(clock[positive][0], clock[-1], COARSE)
        return np.unique(np.minimum(np.searchsorted(clock, wanted), n - 1))


@dataclass(frozen=True, eq=False)
class SweepPart(TestPart):
    """A test at frequencies: first K', then K''."""

    test: Measurement

    @property
    def at(self) -> Real:
        """Frequency in Hz."""
        return np.tile(self.test.frequency, 2)

    @property
    def rate(self) -> Real:
        """Angular frequency in rad/s."""
        return np.tile(self.test.omega, 2)

    @cached_property
    def measured(self) -> Real:
        """K' and K''."""
        return np.concatenate([self.test.storage, self.test.loss])

    @property
    def _own_sd(self) -> Real:
        if self.test.sd is not None:
            return real_form(self.test.sd)
        # Without given deviations the scatter between neighbours is the best that is known of the
        # noise.
        return np.tile(relative_scatter(self.test) * self.test.magnitude, 2)

    @property
    def size(self) -> Real:
        """|K|, so that K' and K'' of a point together weigh as one relative error of K."""
        return np.asarray(np.tile(self.test.magnitude, 2) / np.sqrt(2.0))

    @property
    def quantity(self) -> str:
        """Both parts of K."""
        return "storage and loss"

    @property
    def conditions(self) -> dict[str, Real]:
        """All columns of conditions, for K' and again for K''."""
        return {name: np.tile(column, 2) for name, column in self.test.conditions.items()}

    @property
    def log_omega(self) -> float:
        """Mean logarithm of the angular frequencies."""
        return float(np.mean(np.log(self.test.omega)))

    @property
    def stiffness(self) -> float:
        """Typical size of K."""
        return float(np.exp(np.mean(np.log(self.test.magnitude))))

    @property
    def reach(self) -> float:
        """Largest displacement, nothing where it is not known."""
        return float(np.max(self.test.conditions.get("amplitude", 0.0)))

    def answer(self, model: Model, theta: Real, reference: float, rows: NDArray[np.intp]) -> Traced:
        """K' and K'' of a model."""
        # Effects of other tests leave a sweep as it is.
        own, places = model.had_by(self.test)
        at = replace(self.points, reference_temperature=reference)
        found = self.network_of(own).respond(theta[places], at, GRADIENT)
        both = Traced(real_form(found.value)[rows], real_form(found.by_theta.T)[rows])
        return spread(both, places, len(theta))

    @property
    def points(self) -> Points:
        """Where K is asked for."""
        return self.test.points

    def network_of(self, own: Model) -> Node:
        """What stands in the rig, of a model without effects of other tests."""
        return own.network

    @property
    def view(self) -> Measurement:
        """The sweep itself."""
        return replace(self.test, sd=complex_form(self.sd))

    def scatter(self, residual: Real, followed: float = 0.0) -> ResidualScatter:
        """A sweep is too short for a spectrum."""
        known = self.noise is not None or self.test.sd is not None
        return scatter_of_sweep(residual, known, followed)

    def neighbours(self, residual: Real) -> Real:
        """K' comes first and then K'': its neighbours are told by K' alone."""
        return residual[: len(self.test)]

    @cached_property
    def lines(self) -> ConvexSpectrum:
        """By K' and K''."""
        return lines_of_sweep(self.test, self.sd)

    def modelled(self, residual: Real) -> Complex:
        """K (n,) of the model that leaves a residual (2 n,) over the standard deviations."""
        return np.asarray(self.test.stiffness + complex_form(residual * self.sd))

    def places(self, residual: Real) -> list[Where]:
        """As of a sweep that stands alone, by its name among the other tests."""
        unmoved = np.zeros((0, len(self.test)), dtype=np.complex128)
        weights = complex_form(1.0 / self.sd)
        frame = NoiseFrame(self.test, self.modelled(residual), weights, unmoved)
        name = self.test.name
        return [
            replace(place, condition=name, says=f"{name}: {place.says}") for place in where(frame)
        ]


@dataclass(frozen=True, eq=False)
class OtherPart(TestPart):
    """A test of a further kind, which says by itself what a model shows of it."""

    test: OtherTest

    @property
    def at(self) -> Real:
        """As the test says."""
        return self.test.at

    @property
    def rate(self) -> Real:
        """Of frequencies their own; in time that of the middle of what was seen."""
        if self.test.control == "frequency":
            return 2.0 * np.pi * self.at
        return np.full(len(self.at), float(np.sqrt(np.prod(self.test.seen))))

    @property
    def measured(self) -> Real:
        """As the test says."""
        return self.test.measured

    @property
    def _own_sd(self) -> Real:
        return self.test.sd

    @property
    def stiffness(self) -> float:
        """As the test says."""
        return self.test.stiffness

    @property
    def reach(self) -> float:
        """As the test says."""
        return self.test.reach

    @property
    def quantity(self) -> str:
        """As the test says."""
        return self.test.quantity

    @property
    def unit(self) -> str:
        """Of its numbers."""
        return self.test.unit

    def answer(self, model: Model, theta: Real, reference: float, rows: NDArray[np.intp]) -> Traced:
        """What the test says of a model with those effects that apply to it."""
        own, places = model.had_by(self.test)
        told = self.test.answer(own, theta[places], reference)
        return spread(Traced(told.value[rows], told.by_theta[rows]), places, len(theta))

    def scatter(self, residual: Real, followed: float = 0.0) -> ResidualScatter:
        """From the spectrum of the residual."""
        return scatter_of(residual)


def parts_of_specimen(
    tests: Sequence[Test], noise: Sequence[Real | None] | None = None
) -> list[TestPart]:
    """Tests in common units, as parts.

    With the noise (n,) of each in these units, where it is known.

    Raises
    ------
    DataError
        If some are of a stiffness and others of a modulus, or of different moduli.
    """
    if noise is None:
        noise = [None] * len(tests)
    units = units_of(tests)
    alike = [test.in_units(units) for test in tests]
    pairs = list(zip(alike, noise, strict=True))
    unknown = [test for test, own in pairs if own is None and isinstance(test, TimeTest)]
    together = _told_together(tuple(unknown))
    return [together.get(test) or part_of(test, own) for test, own in pairs]


@lru_cache(maxsize=64)
def _told_together(tests: tuple[TimeTest, ...]) -> dict[Test, TestPart]:
    """Parts of answers to a step that are too short to tell their noise alone, by their tests."""
    parts: dict[Test, TestPart] = {}
    short = [test for test in tests if test.after_step and len(test) < FEWEST]
    for kind in {(test.kind, test.response_unit) for test in short}:
        alike = [test for test in short if (test.kind, test.response_unit) == kind]
        if len(alike) > 1:
            for test, told in zip(alike, noise_of_alike(alike), strict=True):
                parts[test] = InTimePart(test, noise=told.sd, worth=told.worth)
    return parts


def reach_of(parts: Sequence[TestPart]) -> float:
    """Largest displacement of all tests; one where none tells it, as nothing hangs on it then."""
    return max(part.reach for part in parts) or 1.0


def typical_stiffness(parts: Sequence[TestPart]) -> float:
    """Mean of the typical |K| of tests: by logarithms, as they may lie decades apart."""
    return float(np.exp(np.mean([np.log(part.stiffness) for part in parts])))


def part_of(test: Test, noise: Real | None = None) -> TestPart:
    """A test as an engine sees it, with the noise of each sample (n,) where it is known."""
    if isinstance(test, TimeTest):
        return _told_by_itself(test) if noise is None else InTimePart(test, noise=noise)
    if isinstance(test, OtherTest):
        return OtherPart(test, noise=noise)
    return SweepPart(test, noise=noise)


@lru_cache(maxsize=256)
def _told_by_itself(test: TimeTest) -> InTimePart:
    """One part for all fits of a test: its noise and its lines are worked out once."""
    return InTimePart(test)


def units_of(tests: Sequence[Test]) -> Units:
    """Those in which parameters are printed: of the first test that is no sweep, if there is one.

    Raises
    ------
    DataError
        If the tests are of different moduli.
    """
    others = [test for test in tests if not isinstance(test, Measurement)]
    units = (others or tests)[0].units
    letter = one_modulus((test.name, test.units) for test in tests)
    return replace(units, letter=letter or units.letter)
