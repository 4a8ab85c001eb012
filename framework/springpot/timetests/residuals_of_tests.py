"""Tests of one specimen as residuals: each over its own noise, all with the same parameters.

Where in the parameters of an effect to look.

Values that the units suggest, for sizes and times of the tests.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.identification.problem import Objective
from springpot.identification.space import require_columns, require_effects
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import Test as Test
from springpot.measurement.timenoise import noise_of, relative_scatter
from springpot.measurement.timetest import TimeTest
from springpot.measurement.units import (
    AMPLITUDE_UNITS,
    MODULUS_UNITS,
    PRESSURE_UNITS,
    Units,
    one_modulus,
)
from springpot.rheology.effect import ALL, SWEEPS, Effect, Layer
from springpot.rheology.model import Model
from springpot.rheology.parameters import Parameter
from springpot.rheology.points import KELVIN, ROOM, Complex, Real
from springpot.rheology.stages import StageLaw

from .recording import TOLERANCE, recorded
from .start import apparent
from .where import rms

RIGS = (ALL, SWEEPS)
COARSE = 60
"""Samples of a test with which the search begins; all of them end it."""


class Residual(NamedTuple):
    """Differences over their noise (m,), and their derivatives by the parameters (m, p)."""

    value: Real
    by_theta: Real


@dataclass(frozen=True, eq=False)
class InTimePart:
    """A test in time.

    Parameters
    ----------
    test : TimeTest
        The test.
    scale : float
        By how much its noise is taken to be larger than its scatter says.
    noise : ndarray, shape (n,), optional
        Standard deviation of each sample, where it is known better than the signal itself tells.
    """

    test: TimeTest
    scale: float = 1.0
    noise: Real | None = None

    @cached_property
    def sd(self) -> Real:
        """Standard deviation of each sample."""
        if self.noise is not None:
            return self.noise
        return noise_of(self.test).sd

    @property
    def relative_sd(self) -> Real:
        """The same over the size of the signal (n,)."""
        return np.asarray(self.sd, dtype=float) / rms(self.test.response)

    @cached_property
    def apparent(self) -> Measurement | None:
        """The sweep that the test amounts to; None where no sum of exponentials follows it."""
        return apparent(self.test, self.sd)

    def count(self, coarse: bool = False) -> int:
        """How many numbers it gives."""
        if coarse:
            return len(self._thin())
        return len(self.test)

    @property
    def log_omega(self) -> float:
        """Logarithm of the angular frequency in the middle of what it saw."""
        return float(np.mean(np.log(self.test.seen)))

    def residual(
        self, model: Model, theta: Real, reference: float, coarse: bool = False
    ) -> Residual:
        """Predicted less measured, over the noise; of some samples only if `coarse`."""
        rows = np.arange(len(self.test))
        if coarse:
            rows = self._thin()
        answer = recorded(model, theta, self.test, reference, self.test.time[rows], TOLERANCE)
        weight = 1.0 / (self.scale * self.sd[rows])
        # At the very instant of a step the answer may be endless, and no instrument reads it.
        seen = ~np.isin(self.test.time[rows], self.test.loading.jumps[0])
        missed = np.where(seen, answer.value - self.test.response[rows], 0.0)
        by_theta = np.where(seen[:, None], answer.by_theta, 0.0)
        return Residual(missed * weight, by_theta * weight[:, None])

    def _thin(self) -> NDArray[np.intp]:
        """Samples spread evenly over the logarithm of time for steps, over time else."""
        n = len(self.test)
        if n <= COARSE:
            return np.arange(n)
        if self.test.kind not in ("relaxation", "creep"):
            return np.unique(np.linspace(0, n - 1, COARSE).astype(int))
        clock = np.maximum(self.test.time - self.test.start, 1e-300)
        # Samples at or before the step have no place on a logarithmic clock.
        positive = clock > 1e-300
        # What follows a step happens decade by decade: evenly in time its beginning would be left
        # out.
        wanted = np.geomspace(clock[positive][0], clock[-1], COARSE)
        return np.unique(np.minimum(np.searchsorted(clock, wanted), n - 1))

    def with_scale(self, scale: float) -> InTimePart:
        """The same with larger noise."""
        # The same object keeps what it has worked out, such as its noise.
        if scale == self.scale:
            return self
        return replace(self, scale=scale)


@dataclass(frozen=True, eq=False)
class SweepPart:
    """A test at frequencies; see `InTimePart`."""

    test: Measurement
    scale: float = 1.0

    @cached_property
    def sd(self) -> Complex:
        """Standard deviation of K' and K'' of each point.

        Given ones, or the scatter between neighbours.
        """
        if self.test.sd is not None:
            return self.test.sd
        # Without given deviations the scatter between neighbours is the best that is known of the
        # noise.
        share = relative_scatter(self.test)
        return np.asarray(share * self.test.magnitude * (1.0 + 1.0j), dtype=np.complex128)

    @property
    def relative_sd(self) -> Real:
        """The same over |K|, K' before K'' (2 n,): its mean square is that of |dK|^2 / |K|^2."""
        sd = np.concatenate([self.sd.real, self.sd.imag])
        return np.asarray(np.sqrt(2.0) * sd / np.tile(self.test.magnitude, 2), dtype=float)

    def count(self, coarse: bool = False) -> int:
        """How many numbers it gives."""
        return 2 * len(self.test)

    @property
    def log_omega(self) -> float:
        """Mean logarithm of the angular frequencies."""
        return float(np.mean(np.log(self.test.omega)))

    def residual(
        self, model: Model, theta: Real, reference: float, coarse: bool = False
    ) -> Residual:
        """Predicted less measured, over the noise: first K', then K''."""
        at = replace(self.test, reference=reference).points
        own, places = model.had_by(self.test)
        missed = own.stiffness(theta[places], at) - self.test.stiffness
        slopes = own.jacobian(theta[places], at)
        weight = 1.0 / (self.scale * np.concatenate([self.sd.real, self.sd.imag]))
        value = np.concatenate([missed.real, missed.imag]) * weight
        # Effects of other tests leave a sweep as it is.
        by_theta = np.zeros((len(value), len(theta)))
        by_theta[:, places] = np.concatenate([slopes.real, slopes.imag]) * weight[:, None]
        return Residual(value, by_theta)

    def with_scale(self, scale: float) -> SweepPart:
        """The same with larger noise."""
        if scale == self.scale:
            return self
        return replace(self, scale=scale)


Part: TypeAlias = InTimePart | SweepPart


def parts_of_specimen(
    tests: Sequence[Test], noise: Sequence[Real | None] | None = None
) -> list[Part]:
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
    parts: list[Part] = []
    for test, own_noise in zip(tests, noise, strict=True):
        if isinstance(test, TimeTest):
            parts.append(InTimePart(test.in_units(units), noise=own_noise))
        else:
            parts.append(SweepPart(_in_units(test, units)))
    return parts


def weighed_by(part: Part, objective: Objective) -> Part:
    """A part whose samples weigh among each other as an objective has it.

    Against other tests it weighs by its noise, as ever; a logarithmic objective weighs relative to
    the size of what was measured.
    """
    if isinstance(part, InTimePart):
        # What an objective asks of a sweep, of the response: one number for each sample.
        order = np.arange(1.0, len(part.test) + 1.0)
        sd = np.asarray(part.sd * (1.0 + 1.0j), dtype=np.complex128)
        shown = part.test.response.astype(np.complex128)
        view = Measurement(order, shown, sd=sd, name=part.test.name)
        weights = _weights(view, objective).real
        return replace(part, noise=np.asarray(rms(part.sd * weights) / weights, dtype=float))
    sweep = replace(part.test, sd=part.sd)
    by = _weights(sweep, objective)
    level = rms(np.concatenate([part.sd.real * by.real, part.sd.imag * by.imag]))
    shared = np.asarray(level / by.real + 1j * level / by.imag, dtype=np.complex128)
    return replace(part, test=replace(sweep, sd=shared))


def _weights(view: Measurement, objective: Objective) -> Complex:
    weights = objective.weighing(view)
    if objective.logarithmic:
        return np.asarray(weights / view.magnitude, dtype=np.complex128)
    return weights


def units_of(tests: Sequence[Test]) -> Units:
    """Those in which parameters are printed: of the first test in time, or of the only sweep.

    Raises
    ------
    DataError
        If the tests are of different moduli.
    """
    in_time = [test for test in tests if isinstance(test, TimeTest)]
    units = (in_time or tests)[0].units
    letter = one_modulus((test.name, test.units) for test in tests)
    return replace(units, letter=letter or units.letter)


def at_rig(effect: Effect, tests: Sequence[Test]) -> Effect:
    """An effect as tests of one specimen can have it.

    What a measuring chain does to its signals is a fault of one rig. Where sweeps stand beside
    tests in time it is that of the sweeps: a step has no phase that a delay could turn.
    """
    if effect.layer is not Layer.SIGNAL or not _is_rig(effect):
        return effect
    if any(isinstance(test, Measurement) for test in tests):
        return effect.at(SWEEPS)
    return effect.at(ALL)


def at_tests(effect: Effect, tests: Sequence[Test]) -> list[Effect]:
    """The forms in which tests of a specimen have an effect.

    All of them, all sweeps, or one test alone.
    """
    if effect.applies_to.one:
        # One test by itself has nothing to be told from.
        names = dict.fromkeys(test.name for test in tests if isinstance(test, TimeTest))
        return [effect.of_one(name) for name in names if len(tests) > 1]
    there = at_rig(effect, tests)
    if not _is_rig(there) or len(tests) == 1:
        return [there]
    forms, sweeps = [there], [test for test in tests if isinstance(test, Measurement)]
    if there.in_time and sweeps:
        forms.append(there.at(SWEEPS))
    # One rig alone may have it; one sweep is all sweeps.
    apart = [test for test in tests if there.applies_to(test) and [test] != sweeps]
    return forms + [there.of_one(name) for name in dict.fromkeys(test.name for test in apart)]


def at_rigs(model: Model, tests: Sequence[Test]) -> Model:
    """A model of tests of one specimen, each of its effects where `at_rig` puts it."""
    return _with_effects(model, [at_rig(effect, tests) for effect in model.effects])


def rig_of_sweeps(model: Model, tests: Sequence[Test]) -> Model | None:
    """The model where sweeps were made on a rig of their own; None where that changes nothing."""
    if not any(isinstance(test, Measurement) for test in tests):
        return None
    apart = [each.at(SWEEPS) if _is_rig(each) else each for each in model.effects]
    if tuple(apart) == model.effects:
        return None
    return _with_effects(model, apart)


def _is_rig(effect: Effect) -> bool:
    """Whether an effect joins the specimen from outside, and nobody said of which tests."""
    return Layer.SPECIMEN < effect.layer < Layer.TEST and effect.applies_to in RIGS


def _with_effects(model: Model, effects: Sequence[Effect]) -> Model:
    """The model with other effects; itself where they are its own."""
    if tuple(effects) == model.effects:
        return model
    return replace(model, effects=tuple(effects))


def runs_against(test: TimeTest) -> bool:
    """Whether force and displacement have opposite signs all along, as if one column were reversed.

    A mass pushes back too, but gives no work from one turn of its motion to another: so both are
    asked for.
    """
    imposed = np.interp(test.time, test.loading.time, test.loading.value)
    moved, pulled = imposed, test.response
    if test.control == "force":
        moved, pulled = pulled, moved
    # After a step one of the two does not move at all: there the signs themselves are looked at.
    if len(test.loading.jumps[0]):
        return bool(np.sum(moved * pulled) < 0.0)
    # Work over whole cycles: what a spring gives and takes cancels there.
    steps = np.diff(moved)
    turns = np.flatnonzero(np.diff(np.sign(steps)) != 0.0) + 1
    # What moves when the record begins brings work of its own.
    if len(turns) > 1:
        steps[: turns[0]] = 0.0
        steps[turns[-1] :] = 0.0
    work = np.sum(0.5 * (pulled[1:] + pulled[:-1]) * steps)
    together = np.sum((moved - moved.mean()) * (pulled - pulled.mean()))
    return bool(work < 0.0 and together < 0.0)


def reference_of(tests: Sequence[Test]) -> float:
    """Temperature in kelvin at which shifts are one.

    The measured one nearest to the median of all tests.
    """
    known = []
    for test in tests:
        if isinstance(test, TimeTest):
            if test.temperature is not None:
                known.append(test.temperature + KELVIN)
        elif "temperature" in test.conditions:
            known.append(test.reference_temperature)
    if not known:
        return ROOM
    return float(np.sort(known)[(len(known) - 1) // 2])


def require_tests(model: Model, tests: Sequence[Test]) -> None:
    """Check that a model has what it needs of every test.

    Raises
    ------
    SpringpotError
        If a condition lacks, or there are fewer numbers than parameters.
    """
    require_effects(model, tests)
    for test in tests:
        if isinstance(test, Measurement):
            require_columns(model.had_by(test)[0], test)
        elif "temperature" in model.needs and test.temperature is None:
            raise DataError(
                f"{test.name}: {model.name} needs a temperature: open it as"
                f" '{test.name}?temperature=25[degC]'"
            )
    numbers = 0
    for test in tests:
        numbers += len(test)
        # A point at a frequency is two numbers, K' and K''.
        if isinstance(test, Measurement):
            numbers += len(test)
    if numbers < len(model.parameters):
        raise DataError(
            f"{tests[0].name}: {model.name} has {len(model.parameters)} parameters but there are"
            f" only {numbers} samples; choose a simpler model"
        )


def _in_units(sweep: Measurement, units: Units) -> Measurement:
    """A sweep in the units of a test in time."""
    if (sweep.units.stiffness in PRESSURE_UNITS) != (units.stiffness in PRESSURE_UNITS):
        raise DataError(
            f"{sweep.name} is in {sweep.units.stiffness} and the other test in {units.stiffness}: "
            "a stiffness is no modulus; convert one of them by --geometry"
        )
    stiffer = MODULUS_UNITS[sweep.units.stiffness] / MODULUS_UNITS[units.stiffness]
    conditions = dict(sweep.conditions)
    if "amplitude" in conditions:
        longer = AMPLITUDE_UNITS[sweep.units.amplitude] / AMPLITUDE_UNITS[units.amplitude]
        conditions["amplitude"] = conditions["amplitude"] * longer
    sd = sweep.sd
    if sd is not None:
        sd = sd * stiffer
    # Frequencies are told as the sweep's own file tells them.
    told = replace(units, clock=sweep.units.clock, letter=sweep.units.letter)
    return replace(
        sweep, stiffness=sweep.stiffness * stiffer, sd=sd, conditions=conditions, units=told
    )


TIMES = 7
"""Times tried between the shortest and the longest.

Nearer than a decade, for an exponential is a decade wide.
"""
SHARES = (0.03, 0.1, 0.3, 0.6, 0.9)
"""Of the largest displacement or force, where a threshold may lie."""
INSIDE = (0.1, 0.3, 0.5, 0.7, 0.9)
"""Of the range of a parameter that has two ends, such as an order."""
MOST = 40
"""Places tried of one effect; more would cost more than a fit from a poor one."""


@dataclass(frozen=True)
class Scales:
    """Sizes of the tests of a specimen.

    Attributes
    ----------
    stiffness, reach : float
        Typical |K|, and the largest displacement.
    shortest, longest : float
        Times in s that the tests tell about.
    """

    stiffness: float
    reach: float
    shortest: float
    longest: float

    @classmethod
    def of(cls, parts: Sequence[Part]) -> Scales:
        """Those of tests in common units."""
        sizes, reaches, times = [], [], []
        for part in parts:
            if isinstance(part, InTimePart):
                stiffness, reach = _sizes(part.test)
                slow, fast = part.test.seen
            else:
                stiffness = float(np.exp(np.mean(np.log(part.test.magnitude))))
                reach = float(np.max(part.test.conditions.get("amplitude", np.ones(1))))
                slow, fast = float(part.test.omega.min()), float(part.test.omega.max())
            sizes.append(stiffness)
            reaches.append(reach)
            times += [1.0 / fast, 1.0 / slow]
        return cls(float(np.exp(np.mean(np.log(sizes)))), max(reaches), min(times), max(times))

    def typical(self, parameter: Parameter) -> float:
        """The natural size of a parameter here."""
        unit = parameter.unit
        # A power of s that another parameter tells is not known here.
        time = 0.0
        if not isinstance(unit.time, str):
            time = float(unit.time)
        # Times go by factors: their middle is that of the logarithms.
        middle = float(np.sqrt(self.shortest * self.longest))
        size = (
            parameter.typical
            * self.stiffness**unit.stiffness
            * self.reach**unit.amplitude
            * middle**time
        )
        return float(np.clip(size, parameter.lower, parameter.upper))

    def values(self, parameter: Parameter) -> list[float]:
        """Values worth trying."""
        unit, width = parameter.unit, parameter.upper - parameter.lower
        if parameter.scale == "linear" and np.isfinite(width):
            return [parameter.lower + share * width for share in INSIDE]
        sized = (unit.stiffness, unit.amplitude)
        if sized == (0, 0) and unit.time in (1, -1):
            return [
                float(t) ** int(unit.time) for t in np.geomspace(self.shortest, self.longest, TIMES)
            ]
        if sized in ((0, 1), (1, 1)) and unit.time == 0:
            largest = self.reach
            # A threshold of force: what the specimen answers to its largest displacement.
            if unit.stiffness:
                largest = self.reach * self.stiffness
            return [share * largest for share in SHARES]
        return [self.typical(parameter)]


def _sizes(test: TimeTest) -> tuple[float, float]:
    imposed, answer = np.abs(test.loading.value).max(), np.abs(test.response)
    if test.control == "displacement":
        return max(float(np.median(answer) / imposed), 1e-300), float(imposed)
    reach = max(float(answer.max()), 1e-300)
    return max(float(imposed) / reach, 1e-300), reach


def tries_of(effect: Effect, test: TimeTest, scales: Scales) -> list[tuple[float, ...]]:
    """Places in the parameters of an effect of time tests from which to look further."""
    law, free = effect.element, effect.element.parameters
    if isinstance(law, StageLaw) and law.tries is not None:
        return [tuple(map(float, place)) for place in law.tries(test)][:MOST]
    return list(product(*(scales.values(parameter) for parameter in free)))[:MOST]
