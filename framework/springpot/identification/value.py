"""A parameter, or a quantity that follows from some, as it is printed: value, interval and unit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from math import inf, isfinite, nan
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from springpot.lazy import Printed
from springpot.measurement.units import (
    AMPLITUDE_UNITS,
    FILE_UNITS,
    LENGTH_UNITS,
    MODULUS_UNITS,
    STRAIN_UNITS,
    Units,
)
from springpot.numerics import ENDLESS
from springpot.plain_data import Plain, as_declared, json_number, jsonable, some
from springpot.rheology.parameters import Parameter
from springpot.rheology.points import Real
from springpot.thresholds import VERDICT
from springpot.writing import csv_text

if TYPE_CHECKING:
    from springpot.rheology.model import Model

LOST = 1000.0
"""An interval of three decades says nothing.

Sizes of one kind of parameter differ by less among all dampers.
"""


@dataclass(frozen=True)
class Value:
    """A parameter with its 95 % interval, in the unit in which it is printed.

    Attributes
    ----------
    value : float
        The value.
    low, high : float
        Ends of the interval; infinite where the data give none.
    unit : str
        Such as ``kN/m`` or ``kg``; ``-`` for a pure number.
    fixed : bool
        Whether it was given rather than identified.
    tied : str
        How it follows from other parameters, if it does.

    Examples
    --------
    >>> from springpot.identification import Value
    >>> print(Value(0.5985, 0.5912, 0.6059, "kg"))
    0.5985 [0.5912, 0.6059] kg
    """

    value: float
    low: float
    high: float
    unit: str
    fixed: bool = False
    tied: str = ""

    @property
    def determined(self) -> bool:
        """Whether the data say how large it is: both ends exist, three decades apart at most."""
        if not (isfinite(self.low) and isfinite(self.high)):
            return False
        return self.low <= 0.0 or self.high < LOST * self.low

    def __str__(self) -> str:
        words = [f"{self.value:.4g}"]
        if not self.fixed:
            words.append(f"[{self.low:.4g}, {self.high:.4g}]")
        if self.unit != "-":
            words.append(self.unit)
        if self.fixed:
            words.append("(fixed)")
        if self.tied:
            words.append(f"({self.tied})")
        return " ".join(words)

    def to_dict(self) -> dict[str, Any]:
        """As in the schemas, where an interval without an end has None."""
        entries = jsonable(vars(self))
        if not self.fixed:
            del entries["fixed"]
        if not self.tied:
            del entries["tied"]
        return dict(entries)

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> Value:
        """What `to_dict` gave."""
        low, high = json_number(row["low"], -inf), json_number(row["high"], inf)
        fixed, tied = bool(row.get("fixed")), str(row.get("tied", ""))
        return cls(float(row["value"]), low, high, row["unit"], fixed, tied)


def values_of(rows: Mapping[str, Mapping[str, Any]]) -> dict[str, Value]:
    """Parameters by name, as their `to_dict` gave them."""
    return {name: Value.from_dict(row) for name, row in rows.items()}


def printed(
    parameters: Sequence[Parameter], values: Real, low: Real, high: Real, units: Units
) -> dict[str, Value]:
    """Parameters with their intervals in printed units.

    Lines of a spectrum are told as a whole and left out.

    Parameters
    ----------
    parameters : sequence of Parameter
        Length p.
    values, low, high : ndarray, shape (p,)
        In the units of the measurement.
    units : Units
        Those of the measurement.
    """
    rows = {}
    for i, parameter in enumerate(parameters):
        # Lines of a spectrum are told as a whole elsewhere: a list of fifty weights tells nobody
        # anything.
        if parameter.detail:
            continue
        factor, label = units.of(parameter.unit)
        value, below, above = (factor * float(column[i]) for column in (values, low, high))
        rows[parameter.name] = Value(value, below, above, label)
    return rows


def all_parameters(
    model: Model,
    theta: Real,
    low: Real,
    high: Real,
    units: Units,
    tied: Mapping[str, tuple[str, Value]] | None = None,
) -> dict[str, Value]:
    """All parameters of a fit, those that were held or are tied in their places; see `printed`.

    What is tied is given by its name, with that of the parameter that it is a level's own of.
    """
    free = printed(model.parameters, theta, low, high, units)
    held, tied = model.held, tied or {}
    if not (held or tied):
        return free
    rows, known_as = {}, dict(zip(model.names, model.origins, strict=True))
    for parameter in model.released().parameters:
        name = parameter.name
        if name in held:
            factor, label = units.of(parameter.unit)
            value = factor * held[name]
            rows[name] = Value(value, value, value, label, fixed=True)
        rows |= {own: row for own, row in free.items() if known_as[own] == name}
        rows |= {own: row for own, (origin, row) in tied.items() if origin == name}
    # Shares of orders are none of the released model's.
    return {**rows, **free}


SWEEP = "sweep"
"""Kind of a test at frequencies."""

MOST_POINTS = 2**53
"""Samples of all tests together: what a float counts exactly."""


@dataclass(frozen=True)
class PartResult(Plain):
    """One test of an answer, the same for a sweep and a test in time.

    Attributes
    ----------
    name, kind : str
        Of the test; ``sweep`` for one at frequencies.
    points : int
        Its points or samples.
    relative_rms, noise_floor : float
        Root mean square of the residual and of the noise, each over that of the signal: point by
        point of a sweep, and of a test in time shared among its samples as its noise is, which
        comes to the same where the noise goes with the signal. The floor is nan where the data are
        too few to tell.
    over_floor : float
        Root mean square of the residuals over their noise.
    over_floor_alone : float
        The same with parameters of its own.
    """

    name: str
    kind: str
    points: int
    relative_rms: float
    noise_floor: float
    over_floor: float
    over_floor_alone: float

    @classmethod
    def of_sweep(cls, name: str, points: int, error: float, floor: float) -> PartResult:
        """A sweep that stands alone."""
        ratio = in_floors(error, floor)
        return cls(name, SWEEP, points, error, floor, ratio, ratio)

    @property
    def agrees(self) -> bool:
        """Whether the common parameters serve this test nearly as well as its own would."""
        # What cannot be told disagrees with nothing; to leave less than the noise is chance: no
        # test is asked for that.
        return not self.over_floor > VERDICT.agrees * max(self.over_floor_alone, 1.0)

    def to_dict(self) -> dict[str, Any]:
        """As in the schemas."""
        return {**super().to_dict(), "agrees": self.agrees}


def parts_of(rows: Sequence[Mapping[str, Any]]) -> tuple[PartResult, ...]:
    """All tests of an answer, as their `to_dict` gave them."""
    return some(PartResult.from_dict(row) for row in rows)


def spare(tests: Sequence[PartResult], theta: Real) -> int:
    """Samples beyond the parameters (p,), one at least.

    Raises
    ------
    ValueError
        If no test can have so many.
    """
    points = sum(test.points for test in tests)
    if not 0 < points < MOST_POINTS:
        raise ValueError(f"{points} samples are none that tests can have")
    return max(points - len(theta), 1)


def in_time(tests: Sequence[PartResult]) -> bool:
    """Whether a test in time is among them."""
    return any(test.kind != SWEEP for test in tests)


def in_floors(error: float, floor: float) -> float:
    """An error in noise floors: infinite beside no noise, unknown beside an unknown one."""
    if floor > 0.0:
        return error / floor
    if error == 0.0 or floor != floor:
        return nan
    return inf


SCHEMA = "springpot.quantities/1"
Source = Literal["data", "model"]


@dataclass(frozen=True)
class Quantity:
    """A quantity with its 95 % interval.

    Attributes
    ----------
    name : str
        Such as ``crossover frequency``.
    value : Value
        With its interval and unit.
    source : {"data", "model"}
        Whether measured points around it say it, or a fitted model.
    at : mapping of str to float or str
        Frequency in Hz, temperature in degC, amplitude in the unit of the data, that it belongs to;
        of a column whose levels have names, such as that of the files, the name.
    outside : bool
        Whether it lies, or the model was asked, outside of what was measured.
    says : str
        What it is.
    """

    name: str
    value: Value
    source: Source
    at: Mapping[str, float | str] = field(default_factory=dict)
    outside: bool = False
    says: str = ""

    def to_dict(self) -> dict[str, Any]:
        """A row of the answer."""
        row = {"name": self.name, **self.value.to_dict(), "source": self.source}
        row |= {"at": dict(self.at), "outside_measured": self.outside, "says": self.says}
        return row

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> Quantity:
        """What `to_dict` gave."""
        name, at = str(row["name"]), dict(row["at"])
        told = bool(row["outside_measured"]), str(row["says"])
        return as_declared(cls(name, values_of({name: row})[name], row["source"], at, *told))

    def place(self, units: Units) -> str:
        """Where it belongs to, as people say it."""
        told = []
        for name, value in self.at.items():
            if isinstance(value, str):
                told.append(f"{name} {value}")
            elif name == "frequency":
                told.append(units.at(value))
            else:
                told.append(f"{name} {value:.4g} {units.of_condition(name)}".removesuffix(" -"))
        return ", ".join(told)


@dataclass(frozen=True, eq=False)
class Quantities(Printed):
    """The quantities of a fit, or of data.

    Attributes
    ----------
    name : str
        Of the data.
    model : str
        The model expression; empty where none was asked.
    units : Units
        Those of the data.
    rows : tuple of Quantity
        The quantities.
    notes : tuple of str
        What there is none of, and why.
    without : tuple of str
        Effects of the model that are left out: of the rig, the signal and the test.
    """

    name: str
    model: str
    units: Units
    rows: tuple[Quantity, ...]
    notes: tuple[str, ...] = ()
    without: tuple[str, ...] = ()

    def __iter__(self) -> Iterator[Quantity]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, name: str) -> Value:
        """The first quantity of that name.

        Raises
        ------
        KeyError
            If there is none, with those that there are.
        """
        for row in self.rows:
            if row.name == name:
                return row.value
        known = ", ".join(dict.fromkeys(row.name for row in self.rows)) or "none"
        raise KeyError(f"no '{name}' (there are: {known})")

    @property
    def kept(self) -> dict[str, Any]:
        """What another answer must hold beside the rows, to be read by `within`."""
        return {"units": asdict(self.units), "without": list(self.without)}

    @classmethod
    def within(cls, answer: Mapping[str, Any]) -> Quantities | None:
        """Those that another answer holds as plain data; None where it has none."""
        if "quantities" not in answer:
            return None
        rows, kept = tuple(map(Quantity.from_dict, answer["quantities"])), answer["kept"]
        units, without = Units(**kept["units"]), tuple(map(str, kept["without"]))
        return cls(str(answer["data"]), str(answer["model"]), units, rows, (), without)

    @property
    def title(self) -> str:
        """The model and the data, in one line."""
        return f"{self.model} fitted to {self.name}" if self.model else self.name

    def to_dict(self) -> dict[str, Any]:
        """Plain data, schema ``springpot.quantities/1``; an end that there is none of is None."""
        answer = {"schema": SCHEMA, "data": self.name, "model": self.model or None}
        told = {"without": self.without, "quantities": self.rows, "notes": self.notes}
        return dict(jsonable({**answer, **told}))

    def to_csv(self) -> str:
        """A table with a row for each quantity."""
        unit = self.units.amplitude
        at = ["frequency [Hz]", "temperature [degC]", f"amplitude [{unit}]"]
        rows = [["quantity", "value", "low", "high", "unit", "source", *at, "outside_measured"]]
        for row in self.rows:
            value = row.value
            cells = [row.name, repr(value.value), repr(value.low), repr(value.high), value.unit]
            cells += [row.source, *(repr(row.at[n]) if n in row.at else "" for n in AT)]
            rows.append([*cells, str(row.outside).lower()])
        return csv_text(rows)

    def __repr__(self) -> str:
        return f"<Quantities of {self.name}: {', '.join(row.name for row in self.rows)}>"


AT = ("frequency", "temperature", "amplitude")
"""What a quantity may belong to, in the order of the table."""


def in_logarithm(log: float, reach: float, unit: str, factor: float = 1.0) -> Value:
    """A positive value by its logarithm, with half the width of the interval of that."""
    value = factor * float(np.exp(log))
    if not reach < ENDLESS:
        return Value(value, 0.0, float("inf"), unit)
    return Value(value, value * float(np.exp(-reach)), value * float(np.exp(reach)), unit)


def noun(units: Units) -> str:
    """What storage is, at a place."""
    return "modulus" if units.is_modulus else "stiffness"


def energy_unit(units: Units) -> tuple[float, str]:
    """Factor and unit of the energy that a cycle takes: of a modulus that of a volume."""
    stiffness, amplitude = MODULUS_UNITS[units.stiffness], AMPLITUDE_UNITS[units.amplitude]
    if units.stiffness == FILE_UNITS:
        return amplitude**2, FILE_UNITS
    if units.is_modulus and units.amplitude in STRAIN_UNITS:
        return stiffness * amplitude**2, "J/m^3"
    if not units.is_modulus and (units.amplitude in LENGTH_UNITS or "rad" in units.stiffness):
        return stiffness * amplitude**2, "J"
    return 1.0, f"{units.stiffness} {units.amplitude}^2"
