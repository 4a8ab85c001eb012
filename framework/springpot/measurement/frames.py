"""Measurements as tables of other libraries: pandas and xarray, loaded when asked for."""

from __future__ import annotations

import re
from importlib import import_module
from typing import Any

import numpy as np

from springpot.errors import DataError, OptionError

from .units import FREQUENCY_UNITS, TEMPERATURE_UNITS, Units, known_unit, temperature_in_celsius

_HEADING = re.compile(r"\s*([^\[\]]+?)\s*(?:\[([^\[\]]*)\])?\s*")
PARTS = ("storage", "loss", "storage_sd", "loss_sd")


def library(name: str) -> Any:
    """A library that is no part of springpot.

    Raises
    ------
    OptionError
        If it is not installed.
    """
    try:
        return import_module(name)
    except ModuleNotFoundError:
        raise OptionError(f"this needs {name}: pip install 'springpot[frames]'") from None


def columns_of(data: Any) -> dict[str, Any]:
    """The columns of a measurement under the headings of its CSV file: ``storage [kN/m]``."""
    units = data.units
    columns: dict[str, Any] = {"omega [rad/s]": data.omega}
    if units.clock == "Hz":
        columns = {"frequency [Hz]": data.omega / (2.0 * np.pi)}
    columns |= {
        f"storage [{units.stiffness}]": data.storage,
        f"loss [{units.stiffness}]": data.loss,
    }
    if data.sd is not None:
        columns[f"storage_sd [{units.stiffness}]"] = data.sd.real
        columns[f"loss_sd [{units.stiffness}]"] = data.sd.imag
    for name, column in data.conditions.items():
        columns[f"{name} [{units.of_condition(name)}]"] = column
    if data.repeat is not None:
        columns["repeat"] = data.repeat
    return {**columns, **data.labels}


def dataframe(data: Any) -> Any:
    """The measurement as a `pandas.DataFrame`."""
    frame = library("pandas").DataFrame(columns_of(data))
    frame.attrs["name"] = data.name
    return frame


def dataset(data: Any) -> Any:
    """The measurement as an `xarray.Dataset` along ``point``."""
    xarray, units = library("xarray"), data.units
    columns = {**data.conditions, **data.labels}
    if data.repeat is not None:
        columns["repeat"] = data.repeat
    coordinates = {"omega": ("point", data.omega, {"units": "rad/s"})}
    for name, column in columns.items():
        coordinates[name] = ("point", column, {"units": units.of_condition(name)})
    values = {"stiffness": data.stiffness}
    if data.sd is not None:
        values["sd"] = data.sd
    told = {"units": units.stiffness}
    variables = {name: ("point", column, told) for name, column in values.items()}
    return xarray.Dataset(variables, coordinates, {"name": data.name})


def arguments_of(frame: Any) -> dict[str, Any]:
    """What a `Measurement` is made of, from a table whose headings are those of a CSV file.

    Raises
    ------
    DataError
        If frequency, storage or loss is missing, or has no unit or an unknown one.
    """
    columns: dict[str, tuple[Any, str | None]] = {}
    for heading in frame.columns:
        match = _HEADING.fullmatch(str(heading))
        if match is None:
            raise DataError(f"'{heading!s:.40}' is no heading such as 'storage [kN/m]'")
        columns[match[1]] = (frame[heading].to_numpy(), match[2])
    missing = [name for name in ("storage", "loss") if name not in columns]
    rates = [name for name in ("frequency", "omega") if name in columns]
    if missing or not rates:
        raise DataError(f"the table has no column '{[*missing, 'frequency'][0]}' with its unit")
    rate, clock = columns.pop(rates[0])
    clock = known_unit(clock or "", FREQUENCY_UNITS, f"the {rates[0]}")
    stiffness = columns["storage"][1] or ""
    parts = {name: columns.pop(name)[0].astype(float) for name in PARTS if name in columns}
    amplitude = columns.get("amplitude", (None, None))[1] or "-"
    units = Units(stiffness, amplitude, "rad/s" if clock == "rad/s" else "Hz")
    found: dict[str, Any] = {
        "omega": rate.astype(float) * FREQUENCY_UNITS[clock],
        "stiffness": parts["storage"] + 1j * parts["loss"],
        "units": units,
        "name": str(frame.attrs.get("name", "table")),
    }
    if "storage_sd" in parts and "loss_sd" in parts:
        found["sd"] = parts["storage_sd"] + 1j * parts["loss_sd"]
    if "repeat" in columns:
        found["repeat"] = columns.pop("repeat")[0].astype(np.int64)
    return found | _conditions(columns)


def _conditions(columns: dict[str, tuple[Any, str | None]]) -> dict[str, Any]:
    """Columns of numbers are conditions, those of words labels."""
    numbers, words = {}, {}
    for name, (column, unit) in columns.items():
        if not np.issubdtype(column.dtype, np.number):
            words[name] = column.astype(str)
            continue
        numbers[name] = column.astype(float)
        if name == "temperature":
            unit = known_unit(unit or "", TEMPERATURE_UNITS, "the temperature")
            numbers[name] = temperature_in_celsius(numbers[name], unit)
    return {"conditions": numbers, "labels": words}
