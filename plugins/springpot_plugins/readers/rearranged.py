"""Tables in which storage and loss do not stand beside each other, set in columns of their own.

Among them tables of one quantity each, one below the other: storage and then loss, or |E*| and then
phase with a column for each frequency, as tests of asphalt are written.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from springpot.errors import DataError
from springpot.measurement import Choice, OpenQuestion, Question, normal_unit

from .blocks import Block
from .choices import CURVES
from .grid import COMMENT, MISSING, Grid, holds_number, is_number
from .headings import headings_of, units_in, unquoted
from .names import FREQUENCIES
from .side_by_side import apart
from .title_words import curve_in_cell
from .titles import UNITS, VALUES, Heading, heading
from .values_in_rows import Value, from_rows, makes_modulus, side_by_side

_AXES = FREQUENCIES | {"temperature"}
"""What stands along the two sides of a table of one quantity."""
_CONDITIONS = _AXES | {"amplitude", "repeat"}
_ABOVE = 3
"""Lines above the names in which the quantity is sought."""
_FEWEST = 2
"""Columns of a table that go by values of one condition."""
_MOST_LINES = 5000
"""Lines beyond which a file is no such table: a sweep has some hundred points."""
_NAMES = {True: "temperature [degC],25 Hz,10 Hz", False: "frequency [Hz],20 degC,40 degC"}
"""Names of a table whose columns go by frequency, and of one whose columns go by temperature."""
_PARTNERS = {
    "storage": "loss [MPa]",
    "loss": "storage [MPa]",
    "magnitude": "phase [deg]",
    "viscosity": "phase [deg]",
    "dynamic_viscosity": "eta'' [Pa s]",
    "out_of_phase_viscosity": "eta' [Pa s]",
    "storage_compliance": "J'' [1/MPa]",
    "loss_compliance": "J' [1/MPa]",
}
"""What makes a modulus of one quantity alone, as the line above a table says it."""
_MODULUS = "|E*| [MPa]"
"""The same beside an angle, and beside whatever else is no modulus."""
_CORNER = re.compile(r"\s*[\\/|]\s+|\s+[\\/|]\s*|\\")
"""Between the names of both sides in the first cell: ``T [degC] \\ f [Hz]``."""


@dataclass(frozen=True)
class _Columns:
    """What the names of a table say: its conditions by column, and what each other column holds."""

    keys: dict[int, str]
    quantities: dict[int, str]
    conditions: dict[int, tuple[str, str]]


def from_tables_of_one(grid: Grid, choice: Choice) -> Grid | None:
    """The tables of one quantity each as one table; None for other files.

    Raises
    ------
    DataError
        If columns go by frequencies or temperatures, but it is not said of what or against what, or
        a part lacks.
    """
    if len(grid.rows) > _MOST_LINES:
        return None
    values: list[Value] = []
    wide = False
    i, end = 0, 0
    while i < len(grid.rows) - 1:
        row = [unquoted(cell.strip()) for cell in grid.rows[i]]
        start = _first_number(grid, i)
        if start is None or (is_number(row[0]) and row[0]):
            i += 1
            continue
        above = [[cell.strip() for cell in line] for line in grid.rows[max(end, i - _ABOVE) : i]]
        columns = _wide(row, above, choice)
        wide |= columns is not None
        if columns is None:
            columns = _narrow(row, grid.rows[i + 1 : start], above)
        if columns is None:
            return None
        end = _end(grid, start)
        values += _values(grid, start, end, columns)
        i = end
    quantities = list(dict.fromkeys(value.quantity for value in values))
    if wide and not makes_modulus(quantities):
        raise DataError(
            f"its columns go by frequency or temperature, and hold {' and '.join(quantities)}"
            f" alone; add below it a line '{_lacking(quantities)}', and a table with the same names"
        )
    if len(quantities) < 2 or not makes_modulus(quantities):
        return None
    return side_by_side(values)


def _lacking(quantities: Sequence[str]) -> str:
    """The line above the table that lacks, such as ``phase [deg]`` beside ``|E*| [MPa]``."""
    roles = [heading(title).role for title in quantities]
    return next((_PARTNERS[role] for role in roles if role in _PARTNERS), _MODULUS)


def is_wide(grid: Grid) -> bool:
    """Whether numbers stand right below names that are frequencies or temperatures."""
    for i, row in enumerate(grid.rows[:_MOST_LINES]):
        if len(row) <= _FEWEST or is_number(row[0]) or _first_number(grid, i) is None:
            continue
        filled = [unquoted(cell.strip()) for cell in row[1:] if cell.strip()]
        if len(filled) >= _FEWEST and all(
            heading(curve_in_cell(cell).title).role in _AXES for cell in filled
        ):
            return True
    return False


def _first_number(grid: Grid, i: int) -> int | None:
    """The first row of numbers below at least two names, with a row of units between at most."""
    row = grid.rows[i]
    if len(row) < 2 or row[0].strip().startswith(COMMENT):
        return None
    for j in (i + 1, i + 2):
        if j >= len(grid.rows):
            return None
        cells = grid.rows[j]
        if is_number(cells[0]) and 1 < len(cells) <= len(row):
            return j
        if not units_in(cells):
            return None
    return None


def _end(grid: Grid, start: int) -> int:
    """Behind the last row whose cells are numbers."""
    for j in range(start, len(grid.rows)):
        cells = grid.rows[j]
        if not is_number(cells[0]) or not all(
            is_number(cell) or cell.strip() in MISSING for cell in cells
        ):
            return j
    return len(grid.rows)


def _values(grid: Grid, start: int, end: int, columns: _Columns) -> list[Value]:
    values = []
    for row, line in zip(grid.rows[start:end], grid.lines[start:end], strict=True):
        cells = [cell.strip() for cell in row]
        shared = tuple((title, cells[j]) for j, title in columns.keys.items())
        for j, quantity in columns.quantities.items():
            if j >= len(cells) or cells[j] in MISSING:
                continue
            own = shared
            if j in columns.conditions:
                own = (*shared, columns.conditions[j])
            values.append(Value(own, quantity, cells[j], line))
    return values


def _narrow(
    row: Sequence[str], units: Sequence[Sequence[str]], above: Sequence[Sequence[str]]
) -> _Columns | None:
    """A table of conditions and one column of values, which a line above may name."""
    if any(map(holds_number, row)):
        return None
    headings = headings_of(row, units, len(row))
    keys = {j: _title(each) for j, each in enumerate(headings) if each.role in _CONDITIONS}
    others = [j for j, each in enumerate(headings) if j not in keys and each.title]
    if not _AXES & {str(headings[j].role) for j in keys} or len(others) != 1:
        return None
    value = headings[others[0]]
    if value.role in VALUES:
        return _Columns(keys, {others[0]: _title(value)}, {})
    title = _named_above(above)
    # What the column itself is called must not contradict the line above: an unknown name does not.
    if title is None or value.role is not None:
        return None
    named = heading(title)
    if named.unit is None and normal_unit(value.unit or "") in UNITS[str(named.role)]:
        title = f"{title} [{value.unit}]"
    return _Columns(keys, {others[0]: title}, {})


def _title(each: Heading) -> str:
    if each.unit is None:
        return each.name
    return f"{each.name} [{each.unit}]"


def _named_above(above: Sequence[Sequence[str]]) -> str | None:
    """The quantity that a line of one cell names, the nearest first."""
    for line in reversed(above):
        filled = [cell.lstrip("#% ").rstrip(": ") for cell in line if cell]
        if len(filled) == 1 and heading(filled[0]).role in VALUES:
            return filled[0]
    return None


def _wide(row: Sequence[str], above: Sequence[Sequence[str]], choice: Choice) -> _Columns | None:
    """A table whose columns go by values of one condition and its rows by those of another.

    Raises
    ------
    DataError
        If the columns do so, but it is not said of what or against what.
    """
    key, across = _sides(row, above, choice)
    filled = [cell for cell in row[1:] if cell]
    quantities = _quantities(row, above)
    conditions = _conditions(row, across)
    if (
        quantities
        and heading(key).role in _AXES
        and not across
        and len(filled) > 1
        and all(map(is_number, filled))
    ):
        raise _ask_across(filled, heading(key).role)
    if len(conditions) < max(_FEWEST, len(filled)):
        others = [heading(cell) for j, cell in enumerate(row) if j and cell and j not in conditions]
        if len(conditions) >= _FEWEST and all(
            each.curve is not None and each.role in VALUES for each in others
        ):
            raise DataError(
                f"'{filled[0]}' says at what, but not which quantity it holds: write it before,"
                f" with its unit, as in '|E*| {filled[0]} [MPa]', above each such column"
            )
        return None
    columns = f"its columns go by {', '.join(filled[:3])} ..."
    role = heading(next(iter(conditions.values()))[0]).role
    remedy = (
        f"write a line '|E*| [MPa]', below it '{_NAMES[role in FREQUENCIES]},...' and the numbers,"
        " then a line 'phase [deg]' and its table in the same way"
    )
    if heading(key).role not in _AXES or (heading(key).role in FREQUENCIES) == (
        role in FREQUENCIES
    ):
        raise DataError(f"{columns}, but it is not said what its rows go by; {remedy}")
    if quantities is None:
        raise DataError(f"{columns}, but it is not said which quantity they hold; {remedy}")
    return _Columns({0: key}, quantities, conditions)


def _ask_across(filled: Sequence[str], along: str | None) -> OpenQuestion:
    """The question what the numbers above the columns are, where the rows go by `along`."""
    meaning = "frequency[Hz]"
    if along in FREQUENCIES:
        meaning = "temperature[degC]"
    said = f"{CURVES}={meaning}"
    says = (
        f"its columns go by {', '.join(filled[:3])} ...; if that is {meaning}, open 'FILE?{said}'"
    )
    return OpenQuestion(says, [Question("columns", "meaning", {meaning: said})])


def _sides(row: Sequence[str], above: Sequence[Sequence[str]], choice: Choice) -> tuple[str, str]:
    """The titles of what stands in the first column and of what the columns go by.

    The second may be empty.
    """
    cells = [row[0]]
    for line in above[-1:]:
        # "Temp (°C)", "Frequency (Hz)" in the row above, whose cells stand for the sides.
        cells += [cell for cell in line if heading(cell).role in _AXES]
    cells = [
        part
        for cell in cells
        for part in (_CORNER.split(cell) if _CORNER.search(cell) else [cell])
        if part
    ]
    named = [cell for cell in cells if heading(cell).role in _AXES]
    key = next(iter(named), "")
    across = next(
        (cell for cell in named[1:] if heading(cell).unit), choice.columns.get(CURVES, "")
    )
    return key, across


def _conditions(row: Sequence[str], across: str) -> dict[int, tuple[str, str]]:
    """What each column goes by: ``25 Hz``, or a number where it is said of what."""
    found: dict[int, tuple[str, str]] = {}
    meaning = heading(across)
    for j, cell in enumerate(row[1:], 1):
        curve = curve_in_cell(cell)
        if heading(curve.title).role in _AXES:
            found[j] = (curve.title, curve.value)
        elif is_number(cell) and meaning.role in _AXES and meaning.unit:
            found[j] = (f"{meaning.role} [{normal_unit(meaning.unit)}]", cell.replace(",", "."))
    if len({title for title, _ in found.values()}) != 1:
        return {}
    return found


def _quantities(row: Sequence[str], above: Sequence[Sequence[str]]) -> dict[int, str] | None:
    """What the columns hold.

    Said by the row above, one cell for those to its right, or by a line of one cell.
    """
    for line in reversed(above):
        marked = {j: cell for j, cell in enumerate(line) if cell and heading(cell).role in VALUES}
        if len(marked) < 2 and not (
            marked and min(marked) > 0 and len([cell for cell in line if cell]) == 1
        ):
            continue
        quantities: dict[int, str] = {}
        current = ""
        for j in range(1, len(row)):
            current = marked.get(j, current)
            if row[j] and not current:
                return None
            quantities[j] = current
        return {j: name for j, name in quantities.items() if row[j]}
    title = _named_above(above)
    if title is None:
        return None
    return {j: title for j in range(1, len(row)) if row[j]}


def needs_rearranging(grid: Grid, blocks: Iterable[Block]) -> bool:
    """Whether a table is no dynamic test as it stands, or its columns are no quantities."""
    return not any(block.is_dynamic for block in apart(blocks)) or is_wide(grid)


def rearranged(grid: Grid, choice: Choice) -> tuple[Grid, str] | None:
    """The table with a column for each quantity, and a note on how it was read.

    None for other files.

    Raises
    ------
    DataError
        If it is such a table but leaves open which values are what: one line with how to mend it.
    """
    found = from_rows(grid)
    if found is not None:
        return found
    together = from_tables_of_one(grid, choice)
    if together is None:
        return None
    return together, "tables of one quantity each were put side by side"
