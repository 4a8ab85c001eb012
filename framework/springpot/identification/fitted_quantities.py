"""Quantities of a fit, with the exact derivative of each by the model's parameters.

Those of its material, and those that its sweeps say by themselves.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from springpot.distributions import student
from springpot.errors import DataError
from springpot.measurement.measurement import Measurement, points_at
from springpot.measurement.opening import Test
from springpot.numerics import ALIKE, DECADE
from springpot.rheology.effect import Layer
from springpot.rheology.nodes import FULL
from springpot.rheology.parameters import STIFFNESS, VISCOSITY
from springpot.rheology.points import KELVIN, Real
from springpot.thresholds import INTERVAL

from .material import is_material
from .measured_quantities import of_amplitude
from .prediction import Known
from .value import Quantities, Quantity, energy_unit, in_logarithm, noun

REACH = 3.0 * DECADE
"""How far beyond the measured frequencies a crossover or a plateau is looked for."""
FINE = 60.0
"""Places a decade at which it is looked for."""
FARTHEST = 30
"""Decades beyond the measured frequencies at which a limit must have been reached."""
FLAT = 1e-3
"""Slope in double logarithmic axes of what has reached its limit."""
RISEN = 1e-4
"""Share by which a solid's storage exceeds its value at rest, where its first rise is read.

More would bend it, and less would lose digits.
"""
STEP = 1e-3
"""Of differences of exact slopes along ln omega."""


class Logs(NamedTuple):
    """ln K' and ln K'' with their slopes, at ln omega (n,).

    Attributes
    ----------
    storage, loss : ndarray, shape (n,)
        Not a number where the part is not positive.
    storage_x, loss_x : ndarray, shape (n,)
        Derivatives by ln omega.
    storage_t, loss_t : ndarray, shape (p, n)
        Derivatives by the parameters.
    """

    storage: Real
    loss: Real
    storage_x: Real
    loss_x: Real
    storage_t: Real
    loss_t: Real

    @property
    def damping(self) -> tuple[Real, Real, Real]:
        """Ln tan delta and its slopes."""
        return (
            self.loss - self.storage,
            self.loss_x - self.storage_x,
            self.loss_t - self.storage_t,
        )


@dataclass(frozen=True, eq=False)
class OfModel:
    """A fitted model under given conditions.

    Parameters
    ----------
    known : Known
        The fit.
    conditions : mapping of str to float
        Temperature in degC, amplitude and others that the model needs.
    band : tuple of float
        ln omega between which crossover and plateau are looked for.
    limits : bool
        Whether limits beyond the band are told: not of a free spectrum, which ends with the data.
    """

    known: Known
    conditions: Mapping[str, float]
    band: tuple[float, float]
    limits: bool = True

    def logs(self, x: Real) -> Logs:
        """Of ln omega (n,)."""
        known = self.known
        columns = {name: np.full(len(x), value) for name, value in self.conditions.items()}
        points = points_at(x, columns, known.reference)
        with np.errstate(all="ignore"):
            response = known.model.network.respond(known.theta, points, FULL)
            found = []
            for part in (np.real, np.imag):
                value = part(response.value)
                value = np.where(value > 0.0, value, np.nan)
                found.append(
                    (
                        np.log(value),
                        part(response.by_log_omega) / value,
                        part(response.by_theta) / value,
                    )
                )
        (a, a_x, a_t), (b, b_x, b_t) = found
        return Logs(a, b, a_x, b_x, a_t, b_t)

    def told(
        self,
        name: str,
        log: float,
        slope: Real,
        unit: tuple[float, str],
        says: str,
        omega: float | None = None,
        at: Mapping[str, float] | None = None,
    ) -> Quantity:
        """A quantity by its logarithm and the derivative (p,) of that by the parameters."""
        with np.errstate(all="ignore"):
            variance = float(slope @ self.known.theta_covariance @ slope)
        sd = np.array([np.sqrt(max(variance, 0.0))])
        times = student(INTERVAL, self.known.dof)
        below, above = (
            in_logarithm(log, float(times * one[0]), unit[1], unit[0])
            for one in self.known.ways(sd, slope[None])
        )
        outside = True
        if omega is not None:
            columns = {name: np.array([value]) for name, value in self.conditions.items()}
            outside = bool(self.known.covered.outside(np.array([omega]), columns)[0])
        value = replace(above, low=below.low)
        held = {**self.conditions, **(at or {})}
        return Quantity(name, value, "model", held, outside, says)

    def quantities(self) -> Iterator[Quantity]:
        """All that the model has, whatever frequency is asked for."""
        yield from self._crossovers()
        yield from self._plateaus()
        if self.limits:
            yield from self._limits()

    def _roots(self, values: Real, x: Real, rising: bool | None = None) -> Iterator[float]:
        """Where values (n,) of the damping, or of its slope, change their sign."""
        which = 0 if rising is None else 1
        for i in np.flatnonzero(np.sign(values[:-1]) * np.sign(values[1:]) < 0):
            if rising and values[i] > 0.0:
                continue
            # Between neighbours of opposite sign, so that there is a root.
            yield float(brentq(lambda place: self._damping(place)[which], x[i], x[i + 1]))

    def _damping(self, x: float) -> tuple[float, float]:
        """Ln tan delta and its slope at one place."""
        value, slope, _ = self.logs(np.array([x])).damping
        return float(value[0]), float(slope[0])

    @property
    def _grid(self) -> Real:
        low, high = self.band
        return np.linspace(low, high, int((high - low) / DECADE * FINE) + 2)

    def _crossovers(self) -> Iterator[Quantity]:
        units, grid = self.known.units, self._grid
        for x in self._roots(self.logs(grid).damping[0], grid):
            logs = self.logs(np.array([x]))
            _, slope, by_theta = logs.damping
            if abs(slope[0]) < ALIKE:
                continue
            moved = -by_theta[:, 0] / slope[0]
            clock = 1.0 if units.clock == "rad/s" else 0.5 / np.pi
            rate = float(np.exp(x))
            says = "where storage and loss are equal"
            yield self.told("crossover frequency", x, moved, (clock, units.clock), says, rate)
            size = logs.storage_t[:, 0] + logs.storage_x[0] * moved
            unit = units.of(STIFFNESS)
            yield self.told(f"crossover {noun(units)}", logs.storage[0], size, unit, says, rate)

    def _plateaus(self) -> Iterator[Quantity]:
        grid = self._grid
        for x in self._roots(self.logs(grid).damping[1], grid, rising=True):
            here, (before, after) = (
                self.logs(np.array([x])),
                (self.logs(np.array([x + step])).damping for step in (-STEP, STEP)),
            )
            if here.damping[0][0] >= 0.0:
                continue
            bend = after[1][0] - before[1][0]
            # What is flat but for rounding has no place where it is least.
            if bend < ALIKE or not self._rises_from(x, here):
                continue
            moved = -(after[2][:, 0] - before[2][:, 0]) / bend
            size = here.storage_t[:, 0] + here.storage_x[0] * moved
            at = {"frequency": float(np.exp(x)) / (2.0 * np.pi)}
            says = "storage where the loss factor is least"
            unit = self.known.units.of(STIFFNESS)
            yield self.told("plateau", here.storage[0], size, unit, says, float(np.exp(x)), at)

    def _rises_from(self, x: float, here: Logs) -> bool:
        """Whether tan delta rises from its least by more than it is uncertain, on both sides.

        The lines of a spectrum stand apart: between two of them it dips by less than that.
        """
        for way in (-1, 1):
            outwards = self._grid[way * (self._grid - x) > 0.0][::way]
            damping, slope, by_theta = self.logs(outwards).damping
            # Up to where it falls again, or to the end of what was measured.
            falls = way * slope < 0.0
            top = int(np.argmax(falls)) if falls.any() else -1
            change = by_theta[:, top] - here.damping[2][:, 0]
            variance = float(change @ self.known.theta_covariance @ change)
            least = student(INTERVAL, self.known.dof) * np.sqrt(max(variance, 0.0))
            if damping[top] - here.damping[0][0] <= least:
                return False
        return True

    def _limits(self) -> Iterator[Quantity]:
        units, away = self.known.units, DECADE * np.arange(FARTHEST + 1.0)
        slow, fast = self.logs(self.band[0] - away), self.logs(self.band[1] + away)
        rest = _flat(slow.storage_x)
        if rest is not None:
            says = "storage at rest"
            yield self._limit("equilibrium", slow, rest, says)
            yield from self._first_rise(slow, rest)
        elif (place := _flat(slow.loss_x - 1.0)) is not None:
            x = self.band[0] - away[place]
            name = "zero-shear viscosity" if units.is_modulus else "viscous constant at rest"
            says = "loss over the angular frequency, at rest"
            log, slope = slow.loss[place] - x, slow.loss_t[:, place]
            yield self.told(name, log, slope, units.of(VISCOSITY), says)
            if (place := _flat(slow.storage_x - slow.loss_x - 1.0)) is not None:
                x = self.band[0] - away[place]
                log = slow.storage[place] - slow.loss[place] - x
                yield self._mean_time(log, slow.storage_t[:, place] - slow.loss_t[:, place])
        place = _flat(fast.storage_x)
        # Where loss goes on rising a fast change is no matter of storage.
        if place is not None and fast.damping[0][place] < 0.0:
            yield self._limit("instantaneous", fast, place, "storage of fast changes")

    def _limit(self, name: str, logs: Logs, place: int, says: str) -> Quantity:
        unit = self.known.units.of(STIFFNESS)
        name = f"{name} {noun(self.known.units)}"
        return self.told(name, logs.storage[place], logs.storage_t[:, place], unit, says)

    def _first_rise(self, slow: Logs, rest: int) -> Iterator[Quantity]:
        """The mean time of a solid: how its storage begins to rise, over its loss."""
        x = self.band[1] - 0.1 * DECADE * np.arange(10.0 * FARTHEST)
        logs, least = self.logs(x), np.exp(slow.storage[rest])
        risen = np.exp(logs.storage) - least
        with np.errstate(all="ignore"):
            place = int(np.nanargmin(np.abs(np.log(risen / least / RISEN))))
            if not abs(np.log(risen[place] / least / RISEN)) < DECADE:
                return
            slope = np.exp(logs.storage[place]) * logs.storage_x[place] / risen[place]
        if abs(slope - 2.0) > 100.0 * RISEN or abs(logs.loss_x[place] - 1.0) > 100.0 * RISEN:
            return
        by_theta = np.exp(logs.storage[place]) * logs.storage_t[:, place]
        by_theta = (by_theta - least * slow.storage_t[:, rest]) / risen[place]
        log = float(np.log(risen[place]) - logs.loss[place] - x[place])
        yield self._mean_time(log, by_theta - logs.loss_t[:, place])

    def _mean_time(self, log: float, slope: Real) -> Quantity:
        says = "rise of storage over omega times loss, at rest: times weighted by their viscosity"
        return self.told("mean relaxation time", log, slope, (1.0, "s"), says)

    def at(self, hertz: float) -> Iterator[Quantity]:
        """|K|, loss factor and energy of a cycle at a frequency."""
        units, x = self.known.units, np.log(2.0 * np.pi * np.array([hertz]))
        logs, rate, at = self.logs(x), 2.0 * np.pi * hertz, {"frequency": hertz}
        damping, _, by_theta = logs.damping
        storage, loss = np.exp(2.0 * logs.storage[0]), np.exp(2.0 * logs.loss[0])
        size = 0.5 * float(np.log(storage + loss))
        slope = (storage * logs.storage_t[:, 0] + loss * logs.loss_t[:, 0]) / (storage + loss)
        if np.isfinite(size):
            unit, says = units.of(STIFFNESS), "size of the complex value"
            yield self.told(units.magnitude, size, slope, unit, says, rate, at)
            says = "loss over storage"
            damped = float(damping[0]), by_theta[:, 0]
            yield self.told("loss factor", *damped, (1.0, "-"), says, rate, at)
        amplitude = self.conditions.get("amplitude")
        if amplitude is not None and amplitude > 0.0 and np.isfinite(logs.loss[0]):
            log = float(logs.loss[0] + np.log(np.pi * amplitude**2))
            told, unit = (log, logs.loss_t[:, 0]), energy_unit(units)
            yield self.told("energy of a cycle", *told, unit, "area of the loop", rate, at)


def _flat(slope: Real) -> int | None:
    """The place where a slope is least, if what it is of has reached its limit there."""
    size = np.where(np.isfinite(slope), np.abs(slope), np.inf)
    place = int(np.argmin(size))
    return place if size[place] < FLAT else None


def of_fit(
    known: Known,
    name: str,
    tests: Iterable[Test],
    frequency: float | None = None,
    asked: Mapping[str, float] | None = None,
    without: Sequence[str] = (),
) -> Quantities:
    """Those of the material, then those that sweeps of the amplitude say by themselves.

    Parameters
    ----------
    known : Known
        The fit.
    name : str
        Of the data.
    tests : iterable of tests
        What it was fitted to.
    frequency : float, optional
        In Hz, of |K|, loss factor and energy.
    asked : mapping of str to float, optional
        Conditions; by default the reference temperature, and what was the same in all tests.
    without : sequence of str
        Effects that are left out beside those of the rig, the signal and the test.

    Raises
    ------
    SpringpotError
        If the model depends on a condition that was not the same in all tests, or knows none of
        what is asked for.
    """
    # First: which level is meant must be said before anything that depends on it.
    level = known.of_specimen.at_level(asked or {})
    conditions, of = _conditions(known, asked or {}), known.model.name
    known, left = _of_material(level, without)
    low, high = known.covered.rate
    free = is_material(known.model)
    band = float(np.log(low)), float(np.log(high))
    if not free:
        band = band[0] - REACH, band[1] + REACH
    model = OfModel(known, conditions, band, limits=not free)
    found = list(model.quantities())
    rows_at = model.at(frequency or usual((low, high), known.units.clock))
    at: Iterable[Quantity | str] = map(_if_bounded, rows_at) if free else rows_at
    sweeps = [of_amplitude(test) for test in tests if isinstance(test, Measurement)]
    rows, notes = parted([*_lacking(found, free), *found, *at, *chain.from_iterable(sweeps)])
    rows = tuple(replace(row, at=known.named(row.at)) for row in rows)
    return Quantities(name, of, known.units, rows, notes, left)


def _if_bounded(row: Quantity) -> Quantity | str:
    """A quantity of a free spectrum, or what to tell of one that may be anything."""
    if row.value.low > 0.0 or np.isfinite(row.value.high):
        return row
    return f"the {row.name} is not bounded by these data"


def parted(told: Iterable[Quantity | str]) -> tuple[tuple[Quantity, ...], tuple[str, ...]]:
    """Quantities, and the notes among them."""
    whole = list(told)
    rows = tuple(each for each in whole if isinstance(each, Quantity))
    return rows, tuple(each for each in whole if isinstance(each, str))


def in_short(known: Known, name: str, tests: Iterable[Test]) -> Quantities:
    """Those that a fit has where nothing is asked; none where a condition would have to be."""
    try:
        return of_fit(known, name, tests)
    except DataError as error:
        return Quantities(name, known.model.name, known.units, (), (str(error),))


def usual(seen: tuple[float, float], clock: str) -> float:
    """A frequency in Hz to be asked for: one where it was measured, else the middle."""
    unit = 1.0 if clock == "rad/s" else 2.0 * np.pi
    low, high = (rate / unit for rate in seen)
    asked = 1.0
    if not low <= 1.0 <= high:
        middle = float(np.sqrt(low * high))
        step = 10.0 ** np.floor(np.log10(middle))
        asked = float(np.clip(round(middle / step) * step, low, high))
    return asked * unit / (2.0 * np.pi)


def _conditions(known: Known, asked: Mapping[str, float]) -> dict[str, float]:
    """What is asked for, checked and completed by what was the same in all tests."""
    low, high = known.covered.rate
    wanted = dict(asked)
    if "temperature" in known.model.needs:
        least, most = known.covered.conditions.get("temperature", (0.0, 0.0))
        # Where shifts are one, to which their constants refer.
        if least < most:
            wanted.setdefault("temperature", round(known.reference - KELVIN, 2))
    answer = known.predict(omega=[float(np.sqrt(low * high))], **wanted)
    conditions = {name: float(column[0]) for name, column in answer.conditions.items()}
    for name, (least, most) in known.covered.conditions.items():
        if least == most:
            conditions.setdefault(name, least)
    return conditions


def _of_material(known: Known, without: Sequence[str]) -> tuple[Known, tuple[str, ...]]:
    """A fit without what is not the material's, and the names of all that is left out."""
    # A mass or a delay would make crossovers of its own.
    outer = [each.name for each in known.model.effects if each.layer > Layer.TEMPERATURE]
    left = tuple(dict.fromkeys([*without, *outer]))
    return known.without(without).without(name for name in outer if name not in without), left


def _lacking(found: Sequence[Quantity], free: bool) -> Iterator[str]:
    """What a model has none of."""
    names = {row.name for row in found}
    if "crossover frequency" not in names:
        where = "in the measured range" if free else "within three decades of the measured range"
        yield f"no crossover {where}"
    if free:
        yield "a free spectrum ends with the data: it has no limits at rest or of fast changes"
    elif not any("rest" in row.says for row in found):
        yield "at rest the model follows a power of the frequency: neither modulus nor viscosity"
    if "mean relaxation time" not in names and not free:
        yield "the model has no mean relaxation time that is finite"
