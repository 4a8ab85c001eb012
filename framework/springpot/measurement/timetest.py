"""Tests in time: what was imposed on a specimen, and what it answered, against the clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from springpot.errors import DataError, plain
from springpot.rheology.points import KELVIN, STEADY, Real

from ..numerics import SMALLEST
from .course import as_imposed, control_of
from .from_signals import stiffness_unit
from .geometry import Conversion, Geometry, to_modulus, to_stiffness, words_of
from .imposed import SHORT, Loading, from_rest, is_released, since_nothing
from .instrument import even_clock, without_hum
from .rows import digest_of_columns
from .steady_start import said_of_start
from .units import (
    AMPLITUDE_UNITS,
    ANGLE_UNITS,
    FILE_UNITS,
    FORCE_UNITS,
    LENGTH_UNITS,
    MODULUS_UNITS,
    PRESSURE_UNITS,
    TORQUE_UNITS,
    Units,
)

CONTROLS = ("displacement", "force")
IMMENSE = 1e60
"""No number of a test is larger, nor the inverse of one, in whatever unit.

Its square must still be a number.
"""
PLANNED_IN = (
    (LENGTH_UNITS, "m", FORCE_UNITS, "N"),
    ({"-": 1.0}, "-", PRESSURE_UNITS, "Pa"),
    (ANGLE_UNITS, "rad", TORQUE_UNITS, "N m"),
)
"""Units of what is imposed, displacement or force, each with the unit that the other is told in."""


@dataclass(frozen=True, eq=False)
class TimeTest:
    """A test in time: relaxation, creep, startup, recovery, or any history.

    Parameters
    ----------
    time : ndarray, shape (n,)
        In s, rising; when the response was read.
    response : ndarray, shape (n,)
        Force in ``force_unit`` for a displacement that was imposed, else displacement in
        ``displacement_unit``.
    loading : Loading
        What was imposed.
    control : {"displacement", "force"}
        Which of the two that was.
    displacement_unit, force_unit : str
        Such as ``mm`` and ``kN``, or ``-`` and ``Pa`` for strain and stress.
    temperature : float, optional
        In degC.
    name : str
        Shown in reports.
    provenance : mapping of str to str
        Where the data come from.
    measured : bool
        Whether the response was measured; otherwise it is zero and only asked for.
    warmth : ndarray, shape (n,), optional
        Temperature in degC of each sample, where it moved during the test; `temperature` is then
        its mean.
    letter : {"", "G", "E", "K"}
        Which modulus stress and strain are of, see `Units`; empty where nobody says.
    marks : mapping of str to float
        Further conditions by name, such as the number of the specimen.
    aside : mapping of int to float
        Samples at its ends that a diagnosis has set aside, and by how many times the noise each of
        them is off.

    Raises
    ------
    DataError
        If the columns do not fit each other or hold what cannot be measured, with the sample and
        what to do.

    Examples
    --------
    >>> test = TimeTest.of_relaxation([0.1, 1.0, 10.0], [30.0, 20.0, 15.0], "kPa")
    >>> test.kind, test.units.stiffness
    ('relaxation', 'kPa')
    """

    time: Real
    response: Real
    loading: Loading
    control: str = "displacement"
    displacement_unit: str = "-"
    force_unit: str = "Pa"
    temperature: float | None = None
    name: str = "test"
    provenance: Mapping[str, str] = field(default_factory=dict)
    measured: bool = True
    warmth: Real | None = None
    letter: str = ""
    marks: Mapping[str, float] = field(default_factory=dict)
    aside: Mapping[int, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "provenance", MappingProxyType(dict(self.provenance)))
        if self.warmth is not None:
            object.__setattr__(self, "warmth", np.asarray(self.warmth, dtype=float))
            # One number for what looks up a test by its temperature.
            object.__setattr__(self, "temperature", float(np.mean(self.warmth)))
        for name in ("time", "response"):
            object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=float))
        if self.control not in CONTROLS:
            raise DataError(f"{self.name}: control is displacement or force, not '{self.control}'")
        self._check()

    def _check(self) -> None:
        n = len(self.time)
        if self.time.ndim != 1 or self.response.shape != self.time.shape:
            raise DataError(
                f"{self.name}: {n} times for {self.response.size} values:"
                " each sample has one of both"
            )
        _require_samples(n, self.name)
        columns = [("time", self.time), (self.answered, self.response)]
        if self.warmth is not None:
            columns.append(("temperature", self.warmth))
            if self.warmth.shape != self.time.shape:
                raise DataError(
                    f"{self.name}: {self.warmth.size} temperatures for {n} samples: each has one"
                )
        for what, values in columns:
            bad = np.flatnonzero(~np.isfinite(values))
            if len(bad):
                raise DataError(
                    f"{self.name}: the {what} of sample {bad[0] + 1} is no number:"
                    " leave that sample out"
                )
            largest = float(np.abs(values).max())
            if largest and not 1.0 / IMMENSE < largest < IMMENSE:
                raise DataError(
                    f"{self.name}: a {what} of {largest:g} is no measured one: correct its unit"
                )
        # Of two answers at one time neither is the one: what is imposed may jump, the response may
        # not.
        back = np.flatnonzero(np.diff(self.time) <= 0.0)
        if len(back):
            raise DataError(
                f"{self.name}: the time does not rise after sample {back[0] + 1} (t ="
                f" {self.time[back[0]]:g} s): sort the samples, or open one part at a time"
            )
        if self.time[0] < self.loading.time[0]:
            raise DataError(
                f"{self.name}: the first sample at t = {self.time[0]:g} s lies before the load,"
                f" which begins at {self.loading.time[0]:g} s: count the time from there"
            )
        # An answer to no motion asks nothing of a material: any model fits it.
        if np.ptp(self.loading.value) == 0.0:
            raise DataError(f"{self.name}: the {self.control} never moves: nothing was tested")
        # Refuses units of which no stiffness can be made, before anything is worked out in them.
        stiffness_unit(self.displacement_unit, self.force_unit)

    @classmethod
    def of_relaxation(
        cls,
        time: ArrayLike,
        modulus: ArrayLike,
        unit: str = "Pa",
        *,
        rise: float = 0.0,
        temperature: float | ArrayLike | None = None,
        name: str = "relaxation",
        provenance: Mapping[str, str] | None = None,
    ) -> TimeTest:
        """A test of which the relaxation modulus (or stiffness, such as in ``kN/m``) was noted.

        Parameters
        ----------
        time, modulus : array_like, shape (n,)
            In s since the step began, and in `unit`.
        unit : str
            Of the modulus or stiffness.
        rise : float
            Seconds that the step took.
        temperature : float or array_like, shape (n,), optional
            In degC; one for each sample where it moved.
        name, provenance
            As in `TimeTest`.
        """
        return cls._after_step(
            time, modulus, "displacement", unit, rise, temperature, name, provenance
        )

    @classmethod
    def of_compliance(
        cls,
        time: ArrayLike,
        compliance: ArrayLike,
        unit: str = "Pa",
        *,
        rise: float = 0.0,
        temperature: float | ArrayLike | None = None,
        name: str = "creep",
        provenance: Mapping[str, str] | None = None,
    ) -> TimeTest:
        """A test of which the creep compliance was noted, in 1 over `unit`; see `of_relaxation`."""
        return cls._after_step(time, compliance, "force", unit, rise, temperature, name, provenance)

    @classmethod
    def _after_step(
        cls,
        time: ArrayLike,
        response: ArrayLike,
        control: str,
        unit: str,
        rise: float,
        temperature: float | ArrayLike | None,
        name: str,
        provenance: Mapping[str, str] | None,
    ) -> TimeTest:
        """The answer to one unit of what was imposed."""
        force, displacement = _split(unit)
        return cls(
            np.asarray(time, dtype=float),
            np.asarray(response, dtype=float),
            Loading.step(1.0, rise),
            control,
            displacement,
            force,
            name=name,
            provenance=provenance or {},
            **_warm(temperature),
        )

    @classmethod
    def of_history(
        cls,
        time: ArrayLike,
        displacement: ArrayLike,
        force: ArrayLike,
        displacement_unit: str,
        force_unit: str,
        *,
        control: str | None = None,
        rise: float | None = None,
        temperature: float | ArrayLike | None = None,
        name: str = "history",
        provenance: Mapping[str, str] | None = None,
    ) -> TimeTest:
        """A test of which displacement and force were recorded.

        Parameters
        ----------
        time, displacement, force : array_like, shape (n,)
            The record. A displacement in ``%`` is taken as a share. Where it begins later than t =
            0 with what was imposed there already, that is taken to have risen from nothing at t =
            0, in a straight line.
        displacement_unit, force_unit : str
            Their units.
        control : {"displacement", "force"}, optional
            Which of the two was imposed; by default the one that is held, or else the displacement.
        rise : float, optional
            Seconds that the load took from nothing to what was held, if that is known; 0 for a
            step.
        temperature : float or array_like, shape (n,), optional
            In degC; one for each sample where it moved.
        name, provenance
            As in `TimeTest`.
        """
        clock, moved, pulled = (np.asarray(each, float) for each in (time, displacement, force))
        if not clock.shape == moved.shape == pulled.shape or clock.ndim != 1:
            raise DataError(
                f"{name}: {clock.size} times, {moved.size} displacements and {pulled.size} forces: "
                "each sample has one of all"
            )
        _require_samples(len(clock), name)
        # A stress over per cents would be no modulus.
        if displacement_unit == "%":
            moved, displacement_unit = 0.01 * moved, "-"
        # A channel that is held was imposed; the specimen's answer to it is not constant.
        control, notes = control_of(clock, moved, pulled) if control is None else (control, {})
        imposed, response, unit = moved, pulled, force_unit
        if control == "force":
            imposed, response, unit = pulled, moved, displacement_unit
        _require_numbers(clock, imposed, name, control)
        clock = even_clock(clock)
        response, hum = without_hum(response, clock, imposed, unit)
        loading, noise = as_imposed(clock, imposed, rise, control, response)
        return cls(
            clock,
            response,
            loading,
            control,
            displacement_unit,
            force_unit,
            name=name,
            provenance={**(provenance or {}), **notes, **hum, **noise},
            **_warm(temperature),
        )

    @classmethod
    def planned(
        cls,
        time: ArrayLike,
        imposed: ArrayLike,
        unit: str,
        *,
        temperature: float | ArrayLike | None = None,
        name: str = "planned",
    ) -> TimeTest:
        """A test that is only to be predicted.

        Displacement, strain, force or stress against time, by its unit.

        The answer is asked for in N and m, Pa and shares, or N m and rad.
        """
        clock, course = np.asarray(time, dtype=float), np.asarray(imposed, dtype=float)
        if unit == "%":
            course, unit = 0.01 * course, "-"
        control, displacement, force = _planned_units(unit, name)
        _require_samples(len(clock), name)
        _require_numbers(clock, course, name, control)
        # The same reading of a history as for a measured one, so that both are predicted alike.
        clock = even_clock(clock)
        loading = since_nothing(from_rest(clock, course, None), course)
        return cls(
            clock,
            0.0 * clock,
            loading,
            control,
            displacement,
            force,
            name=name,
            measured=False,
            **_warm(temperature),
        )

    def __len__(self) -> int:
        return len(self.time)

    def __reduce__(self) -> tuple[object, tuple[object, ...]]:
        # Mapping proxies cannot cross to a worker process; plain dictionaries can.
        given = {each.name: getattr(self, each.name) for each in fields(self)}
        return TimeTest, tuple((given | {"provenance": dict(self.provenance)}).values())

    def digest(self) -> str:
        """SHA-256 of everything in it that a fit can see, whatever its name."""
        imposed = self.loading
        columns = {"time": self.time, "response": self.response, **self.conditions}
        columns |= {"knots": imposed.time, "imposed": imposed.value}
        units = (self.displacement_unit, self.force_unit)
        about = (self.control, *units, imposed.sampled, imposed.before, *sorted(self.aside))
        about += imposed.unfelt if imposed.unfelt.noise else ()
        return digest_of_columns(about, columns, alone=("time", "knots"))

    def __repr__(self) -> str:
        reach = f"{self.time[0]:.3g} to {self.time[-1]:.3g} s"
        return f"<TimeTest {plain(self.name)}: {self.kind}, {len(self)} samples, {reach}>"

    @property
    def labels(self) -> Mapping[str, NDArray[np.str_]]:
        """Columns of words: none stands beside the samples."""
        return {}

    @property
    def conditions(self) -> dict[str, Real]:
        """What was set beside the load, of each sample: its temperature in degC, where known."""
        found = {name: np.full(len(self), value) for name, value in self.marks.items()}
        if self.temperature is not None:
            found["temperature"] = np.broadcast_to(self.temperature, len(self))
        return found if self.warmth is None else {**found, "temperature": self.warmth}

    @property
    def columns(self) -> dict[str, Real]:
        """The numbers (n,) by which samples are chosen."""
        number = np.arange(1.0, len(self) + 1.0)
        return {"sample": number, "row": number, "time": self.time, **self.conditions}

    def subset(self, rows: NDArray[np.bool_]) -> TimeTest:
        """The same test with some of its samples, under all that was imposed."""
        warmth = None if self.warmth is None else self.warmth[rows]
        _require_samples(int(np.count_nonzero(rows)), self.name)
        place = np.cumsum(rows) - 1
        aside = {int(place[row]): off for row, off in self.aside.items() if rows[row]}
        time, response = self.time[rows], self.response[rows]
        return replace(self, time=time, response=response, warmth=warmth, aside=aside)

    @property
    def answered(self) -> str:
        """Which of displacement and force is the response."""
        return {"displacement": "force", "force": "displacement"}[self.control]

    @property
    def said_of_start(self) -> str:
        """What it is taken to have done before its record; nothing of most."""
        return said_of_start(self.name, self.loading, self.kind, self.time)

    @property
    def words(self) -> tuple[str, str]:
        """What was imposed and what answered, in words.

        Strain and stress, or displacement and force.
        """
        if not self.units.is_modulus:
            return self.control, self.answered
        of_material = {"displacement": "strain", "force": "stress"}
        return of_material[self.control], of_material[self.answered]

    @property
    def response_unit(self) -> str:
        """Its unit."""
        if self.control == "displacement":
            return self.force_unit
        return self.displacement_unit

    @property
    def loading_unit(self) -> str:
        """Unit of what was imposed."""
        if self.control == "displacement":
            return self.displacement_unit
        return self.force_unit

    @cached_property
    def units(self) -> Units:
        """In which the parameters of a model of it are."""
        unit = stiffness_unit(self.displacement_unit, self.force_unit)[1]
        return Units(unit, self.displacement_unit, letter=self.letter)

    @property
    def kelvin(self) -> float | None:
        """The temperature in kelvin."""
        return None if self.temperature is None else self.temperature + KELVIN

    @cached_property
    def duration(self) -> float:
        """Seconds from the first motion of the load to the last sample."""
        return float(self.time[-1] - self.start)

    @cached_property
    def seen(self) -> tuple[float, float]:
        """One over the longest and over the shortest time since the load moved, in rad/s."""
        clock = self.time - self.start
        shortest = float(np.min(clock[clock > 0.0], initial=self.duration))
        # Any other history never comes to rest: the fastest that it shows is what its samples
        # resolve.
        if not self.after_step:
            return 1.0 / self.duration, 1.0 / float(np.median(np.diff(self.time)))
        # While the step still rises, its answer is that of the ramp.
        return 1.0 / self.duration, 1.0 / max(shortest, self.rise, SMALLEST)

    @cached_property
    def start(self) -> float:
        """When the load first moves, in s."""
        # Not the first knot: a record may begin long before the load does.
        loading = self.loading.recorded if self.loading.is_cycled else self.loading
        moving = np.flatnonzero(np.diff(loading.value) != 0.0)
        return float(loading.time[moving[0]])

    @cached_property
    def rise(self) -> float:
        """Seconds that the load takes to its largest value."""
        # A rig holds what was set only so nearly: what it does within that is no rise.
        loading = self.loading.recorded
        size = np.abs(loading.value)
        there = np.flatnonzero(size >= (1.0 - STEADY) * size.max())[0]
        return max(float(loading.time[there]) - self.start, 0.0)

    @property
    def after_step(self) -> bool:
        """Whether it is the answer to one step, relaxation or creep: all decades of time tell."""
        return self.kind in ("relaxation", "creep")

    @cached_property
    def kind(self) -> str:
        """``relaxation``, ``creep``, ``recovery``, ``startup`` or ``history``."""
        loading = self.loading.recorded
        value, clock = loading.value, loading.time
        largest = np.abs(value).max()
        after = value[clock > self.start + self.rise]
        # Told from the load alone: what a test is must not depend on how its specimen answered.
        steady = len(after) == 0 or bool(np.all(np.abs(after - after[-1]) <= STEADY * largest))
        released = len(after) > 0 and abs(after[-1]) < STEADY * largest
        # A rise that was over before the first sample is short beside any of them.
        over = self.start + self.rise <= self.time[0]
        if steady and not released and (over or self.rise <= SHORT * self.duration):
            return {"displacement": "relaxation", "force": "creep"}[self.control]
        # The last value is held for as long as the test goes on.
        until = np.append(clock, max(clock[-1], self.time[-1]))
        if is_released(until, np.append(value, value[-1]), largest):
            return "recovery"
        # A startup is one ramp from its beginning to its end.
        line = (clock - self.start) / max(clock[-1] - self.start, SMALLEST) * value[-1]
        if np.abs(np.where(clock >= self.start, value - line, 0.0)).max() <= STEADY * largest:
            return "startup"
        return "history"

    def in_units(self, units: Units) -> TimeTest:
        """The same test in the units of another one.

        Parameters
        ----------
        units : Units
            Whose amplitude is that of its stiffness, as in every `TimeTest`.

        Raises
        ------
        DataError
            If one is of a stiffness and the other of a modulus, or in units of its file.
        """
        # The same object: what was worked out of it stays.
        if units == self.units:
            return self
        stiffer = self.units.factor_to(units, self.name, "the other test")
        longer = AMPLITUDE_UNITS[self.units.amplitude] / AMPLITUDE_UNITS[units.amplitude]
        return self._carried(stiffer, longer, units.stiffness)

    def as_modulus(self, geometry: Geometry, unit: str = "Pa") -> TimeTest:
        """Strain and stress of the material; see `interface.as_modulus`."""
        return self._through(to_modulus(self, geometry, unit))

    def as_stiffness(
        self, geometry: Geometry, unit: str | None = None, amplitude: str | None = None
    ) -> TimeTest:
        """Displacement and force of a damper of this geometry; see `interface.as_stiffness`."""
        return self._through(to_stiffness(self, geometry, unit, amplitude))

    def _through(self, change: Conversion) -> TimeTest:
        """The other side of a geometry."""
        stiffer, longer = float(change.by(1.0, change.factor)), change.amplitude(np.ones(1))[0]
        other = self._carried(stiffer, float(longer), change.units.stiffness)
        told = {**self.provenance, "geometry": words_of(change.geometry)}
        return replace(other, letter=change.units.letter, provenance=told)

    def _carried(self, stiffer: float, longer: float, stiffness: str) -> TimeTest:
        """The same test with so many times the stiffness and the displacement, in other units."""
        # A force is stiffness times displacement: its factor is that of both. Where the force was
        # imposed, the two change places.
        by_load, by_response = longer, stiffer * longer
        if self.control == "force":
            by_load, by_response = by_response, by_load
        force, displacement = _split(stiffness)
        return replace(
            self,
            response=self.response * by_response,
            loading=self.loading.scaled(by_load),
            displacement_unit=displacement,
            force_unit=force,
        )


def _planned_units(unit: str, name: str) -> tuple[str, str, str]:
    """What is imposed in that unit, and the units of displacement and force."""
    for lengths, length, forces, force in PLANNED_IN:
        if unit in lengths:
            return "displacement", unit, force
        if unit in forces:
            return "force", length, unit
    raise DataError(f"{name}: [{unit}] is no unit of a displacement, strain, force or stress")


def _warm(temperature: float | ArrayLike | None) -> dict[str, Any]:
    """One temperature, or one for each sample."""
    if temperature is None or np.ndim(temperature) == 0:
        return {"temperature": temperature}
    return {"warmth": temperature}


def _split(unit: str) -> tuple[str, str]:
    """Units of force and displacement of a stiffness, or of stress and strain of a modulus."""
    if unit in PRESSURE_UNITS or unit == FILE_UNITS:
        return unit, "-"
    if unit not in MODULUS_UNITS:
        raise DataError(
            f"[{unit}] is no unit of a modulus or stiffness: write Pa, MPa, kN/m or N/mm"
        )
    force, _, displacement = unit.partition("/")
    return force, displacement


def _require_samples(count: int, name: str) -> None:
    if count < 2:
        raise DataError(f"{name}: {count} samples with all of their numbers are no test in time")


def _require_numbers(clock: Real, imposed: Real, name: str, what: str) -> None:
    for column, values in (("time", clock), (what, imposed)):
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            raise DataError(
                f"{name}: the {column} of sample {bad[0] + 1} is no number: leave that sample out"
            )
    # A jump is two samples at one time: only a step back is a fault here.
    back = np.flatnonzero(np.diff(clock) < 0.0)
    if len(back):
        raise DataError(
            f"{name}: the time does not rise after sample {back[0] + 1} (t = {clock[back[0]]:g} s):"
            " sort the samples, or open one part at a time"
        )
