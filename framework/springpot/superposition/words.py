"""Levels as people write and read them."""

from __future__ import annotations

import re

from springpot.errors import OptionError
from springpot.measurement.units import TEMPERATURE_UNITS, normal_unit, temperature_in_celsius

_LEVEL = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*")


def unit_of(column: str) -> str:
    """Unit in which levels of a column are told; the data do not say that of others."""
    # Of other columns the data tell no unit.
    if column != "temperature":
        return ""
    return "degC"


def level_of(text: str, column: str = "temperature") -> float:
    """The level that a text such as ``25degC``, ``298.15K`` or ``0.5`` names; temperatures in degC.

    Raises
    ------
    OptionError
        If it is no number, or has a unit that the column does not have.

    Examples
    --------
    >>> from springpot.superposition import level_of
    >>> level_of("298.15K"), level_of("0.5", "humidity")
    (25.0, 0.5)
    """
    parts = _LEVEL.fullmatch(text)
    if parts is None:
        raise OptionError(
            f"reference '{text}' is no number: write a level such as {_example(column)}"
        )
    value, unit = float(parts[1]), parts[2]
    if not unit:
        return value
    if column != "temperature":
        raise OptionError(f"reference '{text}': {column} has no unit here; write the number only")
    known = normal_unit(unit)
    if known not in TEMPERATURE_UNITS:
        raise OptionError(f"reference '{text}': unknown unit '{unit}'; write degC, K or degF")
    return temperature_in_celsius(value, known)


def _example(column: str) -> str:
    if column == "temperature":
        return "25degC"
    return "0.5"
