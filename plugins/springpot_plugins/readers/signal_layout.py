"""Where the table of a text of time signals begins: its names, units and separator of cells."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from .channels import UNITS, found_in
from .grid import SEARCHED, SEPARATORS, is_number, lines_of, separator_in, split_line
from .headings import uncommented, unquoted
from .titles import is_unit

_WORDS = re.compile(r"[^\W\d_eE]")
"""What no row of numbers has."""
MOST_UNITS = 0.6
"""Share of the cells of a row of units that are known ones."""
_LABVIEW = "Y_Unit_Label"
"""Before the units in a LabVIEW measurement file (.lvm), with columns X_Value and so on."""


@dataclass(frozen=True)
class Layout:
    """How a table of signals is laid out.

    Parameters
    ----------
    separator : str
        Between cells; a space for any white space.
    titles : list of str
        Names of the columns; empty where there is no table.
    units : list of str
        Of a row below the names; empty where there is none.
    start : int
        Lines above the first row of numbers.
    first : sequence of str
        The cells of that row.
    """

    separator: str
    titles: list[str]
    units: list[str]
    start: int
    first: Sequence[str] = ()


def layout_of(head: str) -> Layout:
    """The layout of the file that begins with `head`.

    Below names of all channels, or else of the first numbers.
    """
    lines = lines_of(head)[:SEARCHED]
    # A report above the table may have more of another sign: then any sign that shows all three
    # names will do.
    surest = separator_in([line for line in lines if line.strip()])
    worded = [i for i, line in enumerate(lines) if _WORDS.search(line)]
    for separator in dict.fromkeys((surest, *SEPARATORS)):
        named = next((i for i in worded if _names_all(_cells(lines[i], separator))), None)
        if named is not None:
            return _named(
                [_cells(line, separator) for line in lines[: named + 3]], named, separator
            )
    return _unnamed([_cells(line, surest) for line in lines], surest)


def _named(rows: Sequence[list[str]], named: int, separator: str) -> Layout:
    units: list[str] = []
    start = named + 1
    if start < len(rows) and _are_units(rows[start]):
        units = rows[start]
        start += 1
    first = next(iter(rows[start:]), ())
    return Layout(separator, rows[named], units or labview_units(rows[:named]), start, first)


def labview_units(above: Sequence[list[str]]) -> list[str]:
    """Units from a LabVIEW header, whose line has those of the channels; its time is in seconds."""
    named = next((row for row in above if row and row[0] == _LABVIEW), None)
    if named is None:
        return []
    return ["s", *named[1:]]


def _names_all(row: Sequence[str]) -> bool:
    # Sensors may be called by a number of their own, which has no decimals.
    return len(found_in(row)) == len(UNITS) and all(
        cell.isdigit() for cell in row if is_number(cell)
    )


def _unnamed(rows: Sequence[list[str]], separator: str) -> Layout:
    """The first row of numbers, with what stands above it as names."""
    start = next((i for i, row in enumerate(rows) if sum(map(is_number, row)) > 1), None)
    if start is None:
        return Layout(separator, [], [], 0)
    # Names and units: what is higher up, or too narrow, is a report.
    above = [row for row in rows[max(0, start - 2) : start] if len(row) >= len(rows[start])]
    units: list[str] = []
    if above and _are_units(above[-1]):
        units = above.pop()
    names = [str(i) for i in range(1, len(rows[start]) + 1)]
    if above:
        names = above[-1]
    return Layout(separator, names, units, start, rows[start])


def _cells(line: str, separator: str) -> list[str]:
    if separator == " ":
        # Names with their units in brackets hang together, and so do words that one blank
        # separates.
        line = re.sub(r"(?<!\s)\s+(?=[\[(])", "", line.strip())
        cells = [cell for cell in re.split(r"\s{2,}|\t", line) if cell]
        if len(cells) <= 2:
            # Time, displacement and force are three: so each blank separates.
            cells = line.split()
        return uncommented(cells)
    return uncommented([unquoted(cell.strip()) for cell in split_line(line, separator)])


def _are_units(row: Sequence[str]) -> bool:
    filled = [cell.strip("[]() ") for cell in row if cell.strip()]
    # A channel that is none of the three may have a unit of its own, such as the day of a date.
    known = sum(1 for cell in filled if is_unit(cell))
    return known >= max(1, MOST_UNITS * len(filled)) and not any(map(is_number, filled))
