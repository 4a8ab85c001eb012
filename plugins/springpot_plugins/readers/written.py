"""Numbers that a file writes in another form.

Logarithms, levels in decibel, a period instead of a frequency.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .grid import MISSING, is_number
from .table import Column

DECIBEL, INVERSE, OPPOSITE = "dB", "1/x", "-x"
PER_PERIOD = {"s": "Hz", "ms": "kHz", "min": "1/min"}
"""Unit of the frequency that is one over a period in this unit."""
_LEVEL = re.compile(
    r"dB\s*[\[(]?\s*(?:ref|rel|re)\.?\s*:?\s*(?:1\s+|1(?=[A-Za-z]))?([A-Za-z][^\[\]()]*?)\s*[\])]?\Z"
)

_FORMS: dict[str, Callable[[float], float]] = {
    "10": lambda number: float(np.power(10.0, number)),
    "e": lambda number: float(np.exp(number)),
    # The level of a field quantity is 20 lg of it over the reference (ISO 80000-3), also of a
    # dynamic stiffness (ISO 10846-1: L_k = 20 lg(|k| / 1 N/m)).
    DECIBEL: lambda number: float(np.power(10.0, number / 20.0)),
    INVERSE: lambda number: float(np.divide(1.0, number)),
    OPPOSITE: lambda number: -number,
}


def decibel_of(unit: str) -> str:
    """The reference of a level, ``N/m`` of ``dB re 1 N/m``; empty for any other unit."""
    match = _LEVEL.match(unit.strip())
    if match is None:
        return ""
    return match[1]


def as_measured(column: Column, written: str) -> Column:
    """The column of plain numbers of one that holds them in another form; others as they are."""
    if not written:
        return column
    cells = [_as_measured(cell, _FORMS[written]) for cell in column.cells]
    return replace(column, cells=cells, decimal_comma=False)


def _as_measured(cell: str, form: Callable[[float], float]) -> str:
    """The number that a cell stands for; what is no number is told later, as the file has it."""
    if cell.strip() in MISSING or not is_number(cell):
        return cell
    with np.errstate(all="ignore"):
        value = form(value_of(cell))
    if not np.isfinite(value):
        # A mere "inf" would pass for a gap; this is refused later, with its line.
        return "infinity"
    return repr(value)


def value_of(cell: str) -> float:
    """The number in a cell that holds one."""
    return float(
        cell.strip().replace(",", ".").replace("−", "-").replace("D", "E").replace("d", "e")
    )
