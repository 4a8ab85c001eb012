"""What is told of a quantity, and of all of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

import numpy as np

from springpot.lazy import html_of, text_of
from springpot.measurement.units import (
    AMPLITUDE_UNITS,
    LENGTH_UNITS,
    MODULUS_UNITS,
    STRAIN_UNITS,
    Units,
)
from springpot.plain_data import as_declared, jsonable
from springpot.writing import csv_text

from ..value import Value, values_of

SCHEMA = "springpot.quantities/1"
Source = Literal["data", "model"]
ENDLESS = 30.0
"""Half of an interval in natural logarithms, from which it has no end."""


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
                unit = {"temperature": "degC", "amplitude": units.amplitude}.get(name, "-")
                told.append(f"{name} {value:.4g} {unit}".removesuffix(" -"))
        return ", ".join(told)


@dataclass(frozen=True, eq=False)
class Quantities:
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

    def __str__(self) -> str:
        return text_of(self)

    def _repr_html_(self) -> str:
        return html_of(self)


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
    if units.is_modulus and units.amplitude in STRAIN_UNITS:
        return stiffness * amplitude**2, "J/m^3"
    if not units.is_modulus and (units.amplitude in LENGTH_UNITS or "rad" in units.stiffness):
        return stiffness * amplitude**2, "J"
    return 1.0, f"{units.stiffness} {units.amplitude}^2"
