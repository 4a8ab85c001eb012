"""Amounts as people write them into a code: a number with a unit of any spelling that fits."""

from __future__ import annotations

import re

from springpot.errors import DataError
from springpot.measurement.units import (
    ANGLE_UNITS,
    FORCE_UNITS,
    LENGTH_UNITS,
    PRESSURE_UNITS,
    TIME_UNITS,
)

_NUMBER = r"[+-]?\d+(?:\.\d*)?(?:[eE][+-]?\d{1,2})?"
_AMOUNT = re.compile(rf"\s*({_NUMBER})\s*(.*?)\s*")
_RANGE = re.compile(rf"\s*({_NUMBER})?\s*\.\.\s*({_NUMBER})?\s*(.*?)\s*")
Dimension = tuple[int, int, int]
"""Powers of force, length and time."""

_KINDS: tuple[tuple[dict[str, float], Dimension], ...] = (
    (FORCE_UNITS, (1, 0, 0)),
    (LENGTH_UNITS, (0, 1, 0)),
    (TIME_UNITS, (0, 0, 1)),
    (ANGLE_UNITS, (0, 0, 0)),
    (PRESSURE_UNITS, (1, -2, 0)),
    ({"J": 1.0, "kJ": 1e3}, (1, 1, 0)),
    ({"-": 1.0, "1": 1.0, "%": 0.01, "": 1.0}, (0, 0, 0)),
    ({"Hz": 1.0, "mHz": 1e-3, "kHz": 1e3}, (0, 0, -1)),
    # Of no power of the others: a temperature is compared with temperatures alone.
    ({"degC": 1.0}, (7, 7, 7)),
)


def _factor(unit: str) -> tuple[float, Dimension]:
    """Factor to SI and dimension of a product of units, with what stands behind a slash below."""
    for table, dimension in _KINDS:
        if unit in table:
            return table[unit], dimension
    factor, total = 1.0, (0, 0, 0)
    parts = re.split(r"\s*([/*]|\s)\s*", unit)
    side = 1
    for word in parts:
        if word == "/":
            # All that stands behind it is divided by.
            side = -1
        if word in {"", " ", "*", "/"}:
            continue
        if word == unit:
            raise DataError(f"unit '{unit:.20}' is not known")
        one, dimension = _factor(word)
        factor *= one**side
        total = (
            total[0] + side * dimension[0],
            total[1] + side * dimension[1],
            total[2] + side * dimension[2],
        )
    return factor, total


def ratio_of_units(written: str, wanted: str) -> float:
    """Factor from one unit to another.

    Raises
    ------
    DataError
        If one is unknown, or they are units of different things.

    Examples
    --------
    >>> round(ratio_of_units("kJ", "kN mm")), ratio_of_units("kN/m", "N/mm")
    (1000, 1.0)
    """
    if written == wanted:
        return 1.0
    (one, first), (other, second) = _factor(written), _factor(wanted)
    if first != second:
        raise DataError(f"'{written:.20}' is no unit of what is in {wanted}")
    return one / other


def amount(value: object, wanted: str) -> float:
    """A number in a unit, from text such as ``0.5 kN/mm``; a bare number is one of no unit.

    Raises
    ------
    DataError
        If it is none, or of another unit.
    """
    if isinstance(value, int | float) and not isinstance(value, bool):
        if wanted in {"-", "1"}:
            try:
                return float(value)
            except OverflowError:
                raise DataError("a number is too large") from None
        raise DataError(f"{value!s:.40} has no unit: write '{value} {wanted}'")
    match = _AMOUNT.fullmatch(str(value)[:80]) if isinstance(value, str) else None
    if match is None:
        raise DataError(f"'{value!s:.40}' is no number with a unit, such as '1 {wanted}'")
    if not match[2] and wanted not in {"-", "1"}:
        raise DataError(f"{value} has no unit: write '{value} {wanted}'")
    return float(match[1]) * ratio_of_units(match[2], wanted)


def between(value: object, wanted: str) -> tuple[float, float]:
    """The ends of text such as ``0.9..1.1 Hz``; one that is missing is infinite.

    Raises
    ------
    DataError
        If it is none, or of another unit.
    """
    match = _RANGE.fullmatch(value[:80]) if isinstance(value, str) else None
    if match is None or (match[1] is None and match[2] is None):
        raise DataError(f"'{value!s:.40}' is no range, such as '0.9..1.1 {wanted}'")
    factor = ratio_of_units(match[3], wanted)
    low = float("-inf") if match[1] is None else factor * float(match[1])
    high = float("inf") if match[2] is None else factor * float(match[2])
    if not low < high:
        raise DataError(f"'{value!s:.40}' runs backwards")
    return low, high
