"""Tests of one specimen as residuals: each over its own noise, all with the same parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.identification import require_conditions
from springpot.measurement import (
    AMPLITUDE_UNITS,
    KELVIN,
    MODULUS_UNITS,
    PRESSURE_UNITS,
    Measurement,
    Timed,
    TimeTest,
    Units,
    material_of,
    noise_of,
    relative_scatter,
)
from springpot.rheology import Complex, Model, Real

from .predicted import TOLERANCE
from .recorded import recorded
from .start import apparent

Test: TypeAlias = TimeTest | Measurement
COARSE = 60
"""Samples of a test with which the search begins; all of them end it."""


class Residual(NamedTuple):
    """Differences over their noise, shape (m,), and their derivatives by the parameters, shape (m, p)."""

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
        return noise_of(self.test).sd if self.noise is None else self.noise

    @cached_property
    def apparent(self) -> Measurement | None:
        """The sweep that the test amounts to; None where no sum of exponentials follows it."""
        return apparent(self.test, self.sd)

    def count(self, coarse: bool = False) -> int:
        """How many numbers it gives."""
        return len(self._thin()) if coarse else len(self.test)

    @property
    def log_omega(self) -> float:
        """Logarithm of the angular frequency in the middle of what it saw."""
        return float(np.mean(np.log(self.test.seen)))

    def residual(self, model: Model | Timed, theta: Real, reference: float, coarse: bool = False) -> Residual:
        """Predicted less measured, over the noise; of some samples only if `coarse`."""
        rows = self._thin() if coarse else np.arange(len(self.test))
        found = recorded(model, theta, self.test, reference, self.test.time[rows], TOLERANCE)
        weight = 1.0 / (self.scale * self.sd[rows])
        # At the very instant of a step the answer may be endless, and no instrument reads it.
        seen = ~np.isin(self.test.time[rows], self.test.loading.jumps[0])
        missed = np.where(seen, found.value - self.test.response[rows], 0.0)
        return Residual(missed * weight, np.where(seen[:, None], found.by_theta, 0.0) * weight[:, None])

    def _thin(self) -> NDArray[np.intp]:
        """Samples spread evenly over the logarithm of time for steps, over time else."""
        n = len(self.test)
        if n <= COARSE:
            return np.arange(n)
        if self.test.kind not in ("relaxation", "creep"):
            return np.unique(np.linspace(0, n - 1, COARSE).astype(int))
        clock = np.maximum(self.test.time - self.test.start, 1e-300)
        positive = clock > 1e-300
        wanted = np.geomspace(clock[positive][0], clock[-1], COARSE)
        return np.unique(np.minimum(np.searchsorted(clock, wanted), n - 1))

    def with_scale(self, scale: float) -> InTimePart:
        """The same with larger noise."""
        return self if scale == self.scale else replace(self, scale=scale)


@dataclass(frozen=True, eq=False)
class SweepPart:
    """A test at frequencies; see `InTimePart`."""

    test: Measurement
    scale: float = 1.0

    @cached_property
    def sd(self) -> Complex:
        """Standard deviation of K' and K'' of each point: given ones, or the scatter between neighbours."""
        if self.test.sd is not None:
            return self.test.sd
        share = relative_scatter(self.test)
        return np.asarray(share * self.test.magnitude * (1.0 + 1.0j), dtype=np.complex128)

    def count(self, coarse: bool = False) -> int:
        """How many numbers it gives."""
        return 2 * len(self.test)

    @property
    def log_omega(self) -> float:
        """Mean logarithm of the angular frequencies."""
        return float(np.mean(np.log(self.test.omega)))

    def residual(self, model: Model | Timed, theta: Real, reference: float, coarse: bool = False) -> Residual:
        """Predicted less measured, over the noise: first K', then K''."""
        at = replace(self.test, reference=reference).points
        own = material_of(model)
        count = len(own.parameters)
        missed = own.stiffness(theta[:count], at) - self.test.stiffness
        slopes = own.jacobian(theta[:count], at)
        weight = 1.0 / (self.scale * np.concatenate([self.sd.real, self.sd.imag]))
        value = np.concatenate([missed.real, missed.imag]) * weight
        by_theta = np.zeros((len(value), len(theta)))
        by_theta[:, :count] = np.concatenate([slopes.real, slopes.imag]) * weight[:, None]
        return Residual(value, by_theta)

    def with_scale(self, scale: float) -> SweepPart:
        """The same with larger noise."""
        return self if scale == self.scale else replace(self, scale=scale)


Part: TypeAlias = InTimePart | SweepPart


def parts_of_specimen(tests: Sequence[Test], noise: Sequence[Real | None] | None = None) -> list[Part]:
    """Tests in common units, as parts; with the noise (n,) of each in these units, where it is known.

    Raises
    ------
    DataError
        If some are of a stiffness and others of a modulus.
    """
    in_time = next((test for test in tests if isinstance(test, TimeTest)), None)
    units = tests[0].units if in_time is None else in_time.units
    parts: list[Part] = []
    for i, test in enumerate(tests):
        if isinstance(test, TimeTest):
            parts.append(InTimePart(test.in_units(units), noise=None if noise is None else noise[i]))
        else:
            parts.append(SweepPart(_in_units(test, units)))
    return parts


def reference_of(tests: Sequence[Test]) -> float:
    """Temperature in kelvin at which shifts are one: the measured one nearest to the median of all tests."""
    known = [
        *(test.temperature + KELVIN for test in tests if isinstance(test, TimeTest) and test.temperature is not None),
        *(
            test.reference_temperature
            for test in tests
            if isinstance(test, Measurement) and "temperature" in test.conditions
        ),
    ]
    return float(np.sort(known)[(len(known) - 1) // 2]) if known else 293.15


def require_tests(model: Model | Timed, tests: Sequence[Test]) -> None:
    """Check that a model has what it needs of every test.

    Raises
    ------
    SpringpotError
        If a condition lacks, or there are fewer numbers than parameters.
    """
    for test in tests:
        if isinstance(test, Measurement):
            require_conditions(material_of(model), test)
        elif "temperature" in model.needs and test.temperature is None:
            raise DataError(
                f"{test.name}: {model.name} needs a temperature: open it as '{test.name}?temperature=25[degC]'"
            )
    numbers = sum(len(test) if isinstance(test, TimeTest) else 2 * len(test) for test in tests)
    if numbers < len(model.parameters):
        raise DataError(
            f"{tests[0].name}: {model.name} has {len(model.parameters)} parameters but there are only {numbers} "
            "samples; choose a simpler model"
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
    sd = None if sweep.sd is None else sweep.sd * stiffer
    return replace(sweep, stiffness=sweep.stiffness * stiffer, sd=sd, conditions=conditions, units=units)
