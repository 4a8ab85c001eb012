"""Tables of values in rows, set upright with a column for each quantity.

One value in each row with a word for what it is, as storage beside loss; or a row for each
quantity, its name in front.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from springpot.errors import DataError
from springpot.measurement import normal_unit

from .grid import COMMENT, MISSING, SEARCHED, Grid, holds_number, is_number
from .names import FREQUENCIES, fold, names_a_modulus
from .table import value_of
from .titles import SWEEPS, UNITS, VALUES, Vocabulary, heading, is_dynamic

_FEWEST = 4
"""Rows of such a table: two points of two quantities."""
_FEWEST_CELLS = 3
"""Cells of a row: a condition, a word and a value."""
_IN_COMMON = 0.5
"""Share of a column's values that all quantities have, from which it may tell points apart.

As specimens do, of one of which a quantity lacks.
"""
_MOST_NAMES = 20
"""Different words of a column beyond which it names samples or runs rather than quantities."""
_VALUE = frozenset(
    fold(word) for word in ("value", "values", "result", "wert", "valeur", "valor", "valore", "y")
)
"""What a column of values is called."""
_CONDITIONS = FREQUENCIES | {"temperature", "amplitude", "repeat"}
"""What makes two rows of different quantities one point, where it is the same."""
_Conditions: TypeAlias = tuple[tuple[str, str], ...]
"""Title and cell of each condition of a point."""


@dataclass(frozen=True)
class Value:
    """One number of a table.

    Parameters
    ----------
    keys : tuple of pairs of str
        Title and cell of each condition under which it was measured.
    quantity : str
        What it is, with its unit: ``G' [Pa]``.
    text : str
        The cell.
    line : int
        Where it stands in the file.
    """

    keys: tuple[tuple[str, str], ...]
    quantity: str
    text: str
    line: int


def makes_modulus(quantities: Sequence[str]) -> bool:
    """Whether these titles are storage and loss, or what stands for them, beside a frequency."""
    return is_dynamic({*(str(heading(title).role) for title in quantities), "omega"})


def side_by_side(values: Sequence[Value]) -> Grid:
    """The values with one row for each set of conditions and one column for each quantity.

    A value that comes again under the same conditions makes a further row, as a repeat does in any
    table. Where one of the quantities lacks, its cell is empty.

    Raises
    ------
    DataError
        If no row has a value of all quantities, as where curves were read off at frequencies of
        their own; or if it is open which values of several under the same conditions belong
        together.
    """
    titles = list(dict.fromkeys(title for value in values for title, _ in value.keys))
    quantities = list(dict.fromkeys(value.quantity for value in values))
    seen: Counter[tuple[_Conditions, str]] = Counter()
    rows: dict[tuple[_Conditions, int], dict[str, str]] = {}
    lines: dict[tuple[_Conditions, int], int] = {}
    for value in values:
        conditions = tuple((title, _same(cell)) for title, cell in value.keys)
        seen[(conditions, value.quantity)] += 1
        point = (conditions, seen[(conditions, value.quantity)])
        rows.setdefault(point, dict(value.keys))[value.quantity] = value.text
        lines.setdefault(point, value.line)
    if not any(all(row.get(quantity) for quantity in quantities) for row in rows.values()):
        _require_one_name(quantities)
        raise DataError(
            f"{' and '.join(quantities)} stand at different {' and '.join(titles)}, so that no"
            " point has both; bring them to the same values, in columns beside each other"
        )
    _require_pairs(seen)
    order = [*titles, *quantities]
    cells = [[row.get(title, "") for title in order] for row in rows.values()]
    return Grid([order, *cells], [min(lines.values()) - 1, *lines.values()])


def _require_one_name(quantities: Sequence[str]) -> None:
    """Refuse a quantity that goes by two names, or stands in two units."""
    first: dict[str, str] = {}
    for quantity in quantities:
        role = str(heading(quantity).role)
        other = first.setdefault(role, quantity)
        if other != quantity and role in VALUES:
            raise DataError(
                f"{other} and {quantity} are both {role}; call it by one name, in one unit"
            )


def _require_pairs(seen: Counter[tuple[_Conditions, str]]) -> None:
    """Refuse several values of one quantity where another has fewer.

    Nobody knows which of them it belongs to.
    """
    # Of a quantity that lacks altogether there is nothing that could be put beside a wrong one.
    counts: dict[_Conditions, dict[str, int]] = {}
    for (conditions, quantity), count in seen.items():
        counts.setdefault(conditions, {})[quantity] = count
    for conditions, count_of in counts.items():
        fewest, most = (
            min(count_of, key=count_of.__getitem__),
            max(count_of, key=count_of.__getitem__),
        )
        if count_of[fewest] < count_of[most]:
            where = " and ".join(f"{title} {cell}" for title, cell in conditions)
            raise DataError(
                f"at {where} there are {count_of[most]} values of {most} and {count_of[fewest]} of"
                f" {fewest}; say which belong together in a column repeat, with the same number for"
                " both"
            )


def _same(cell: str) -> str:
    """A cell by its value: ``1`` and ``1.0`` are one frequency."""
    if is_number(cell):
        return f"{value_of(cell):.12g}"
    return cell


def from_rows(grid: Grid) -> tuple[Grid, str] | None:
    """A table whose rows say in words what their value is, and a note on how it was read.

    None for other tables.

    Raises
    ------
    DataError
        If several columns may hold the values.
    """
    for i, row in enumerate(grid.rows[:SEARCHED]):
        titles = [cell.strip().lstrip("# ") for cell in row]
        if len(titles) < 3 or any(map(holds_number, titles)):
            continue
        below = _rows_as_wide(grid, i)
        if len(below) < _FEWEST:
            return None
        columns = [
            [cell.strip() for cell in cells]
            for cells in zip(*(cells for cells, _ in below), strict=True)
        ]
        named = next((j for j, column in enumerate(columns) if _names_quantities(column)), None)
        if named is not None:
            return _from_columns(titles, columns, [line for _, line in below], named)
        _require_all_parts(titles, columns)
    return None


def _rows_as_wide(grid: Grid, i: int) -> list[tuple[list[str], int]]:
    """The rows below that of the names, as wide as it, with their lines."""
    width = len(grid.rows[i])
    found = []
    for row, line in zip(grid.rows[i + 1 :], grid.lines[i + 1 :], strict=True):
        cells, further = row[:width], row[width:]
        # Remarks may stand behind the last name; numbers there tell that the row was parted at the
        # wrong signs.
        if (
            len(cells) < _FEWEST_CELLS
            or cells[0].strip().startswith(COMMENT)
            or any(map(holds_number, further))
        ):
            continue
        # A row of a sheet ends with its last filled cell.
        found.append(([*cells, *[""] * (width - len(cells))], line))
    return found


def _require_all_parts(titles: Sequence[str], columns: Sequence[Sequence[str]]) -> None:
    """Refuse a table whose rows all say that they are one part of a modulus."""
    for title, column in zip(titles, columns, strict=True):
        words = set(column) - MISSING
        if len(words) == 1 and heading(min(words)).role in VALUES:
            raise DataError(
                f"all rows of '{title}' say {min(words)}; add rows of what lacks: loss beside"
                " storage, phase beside a magnitude"
            )


def _names_quantities(column: Sequence[str]) -> bool:
    if holds_number(column[0]):
        return False
    words = set(column) - MISSING
    return len(words) <= _MOST_NAMES and makes_modulus(sorted(words))


def _from_columns(
    titles: Sequence[str], columns: Sequence[Sequence[str]], lines: Sequence[int], named: int
) -> tuple[Grid, str]:
    names = columns[named]
    place = _place_of_values(titles, columns, named)
    others = [j for j in range(len(titles)) if j not in (named, place)]
    units = next((j for j in others if _holds_units(columns[j], names)), None)
    keys = _keys(titles, columns, names, [j for j in others if j != units])
    values = []
    for k, line in enumerate(lines):
        if names[k] in MISSING:
            continue
        unit = heading(titles[place]).unit or ""
        if units is not None:
            unit = columns[units][k]
        conditions = tuple((titles[j], columns[j][k]) for j in keys)
        values.append(Value(conditions, _with_unit(names[k], unit), columns[place][k], line))
    note = (
        f"the words of '{titles[named]}' say what '{titles[place]}' is in each row: put in columns"
        " of their own"
    )
    # A column without a name counts the rows.
    left_out = [f"'{titles[j]}'" for j in others if titles[j] and j not in (units, *keys)]
    if left_out:
        note += f"; left out, as not the same in all rows of a point: {', '.join(left_out)}"
    return side_by_side(values), note


def _keys(
    titles: Sequence[str],
    columns: Sequence[Sequence[str]],
    names: Sequence[str],
    others: Sequence[int],
) -> list[int]:
    """Columns by which values of different quantities are one point."""
    known = [j for j in others if heading(titles[j]).role in _CONDITIONS]
    named = [k for k, name in enumerate(names) if name not in MISSING]
    points = {k: tuple(_same(columns[j][k]) for j in known) for k in named}
    # Where one quantity comes again something tells its values apart, be it not quite complete.
    if len({(names[k], points[k]) for k in named}) < len(named):
        return [j for j in others if j in known or _in_common(columns[j], names) >= _IN_COMMON]
    return [j for j in others if j in known or _is_one_at_each(columns[j], points)]


def _is_one_at_each(column: Sequence[str], points: Mapping[int, tuple[str, ...]]) -> bool:
    """Whether all rows of a point have the same cell, unlike a remark on one of its quantities."""
    first: dict[tuple[str, ...], str] = {}
    return all(first.setdefault(point, column[k]) == column[k] for k, point in points.items())


def _holds_units(column: Sequence[str], names: Sequence[str]) -> bool:
    """Whether each cell is a unit of what its row names: a sample that is called A is no ampere."""
    pairs = set(zip(column, names, strict=True))
    known = [(unit, heading(name).role) for unit, name in pairs if heading(name).role in UNITS]
    return bool(known) and all(normal_unit(unit) in UNITS[str(role)] for unit, role in known)


def _place_of_values(titles: Sequence[str], columns: Sequence[Sequence[str]], named: int) -> int:
    """The column that holds the values: by its name, else the only one that could."""
    numeric = [
        j
        for j, column in enumerate(columns)
        if j != named and heading(titles[j]).role not in _CONDITIONS and all(map(_is_value, column))
    ]
    sure = [j for j in numeric if _is_called_value(titles[j])]
    # A column that is the same beside each quantity is a condition, such as a current or a number
    # of the sample.
    moving = [j for j in numeric if not _is_condition(titles[j], columns[j], columns[named])]
    for places in (sure, moving, numeric):
        if len(places) == 1:
            return places[0]
    for title, column in zip(titles, columns, strict=True):
        wrong = [cell for cell in column if not _is_value(cell)]
        # A few words among numbers: the column is known, and its name is not what is to be mended.
        if _is_called_value(title) and 0 < 2 * len(wrong) <= len(column):
            raise DataError(
                f"'{title}' holds '{wrong[0]}', which is no number; leave that cell empty"
            )
    shown = ", ".join(titles[j] for j in numeric) or "none holds numbers"
    raise DataError(
        f"'{titles[named]}' says which rows are storage and which loss, but not which column holds"
        f" their values ({shown}); call it value, with its unit, as in value [Pa]"
    )


def _is_value(cell: str) -> bool:
    return cell in MISSING or is_number(cell)


def _is_called_value(title: str) -> bool:
    named = heading(title)
    return named.role in VALUES or fold(named.name) in _VALUE or names_a_modulus(named.name)


def _is_condition(title: str, column: Sequence[str], names: Sequence[str]) -> bool:
    """Whether a column tells points apart: each quantity was measured at the same of its values."""
    return heading(title).role in _CONDITIONS or _in_common(column, names) == 1.0


def _in_common(column: Sequence[str], names: Sequence[str]) -> float:
    """Share of a column's values at which every quantity was measured."""
    beside: dict[str, set[str]] = {}
    for cell, name in zip(column, names, strict=True):
        if name not in MISSING:
            beside.setdefault(name, set()).add(_same(cell))
    everywhere = set.intersection(*beside.values())
    return len(everywhere) / len(set.union(*beside.values()))


def _with_unit(name: str, unit: str) -> str:
    """The name of a quantity with a unit of its own, or that of the values where it fits.

    An angle is not in Pa.
    """
    named = heading(name)
    if named.unit is None and normal_unit(unit) in UNITS.get(str(named.role), {}):
        return f"{name} [{unit}]"
    return name


_MOST_ROWS = 60


def upright(grid: Grid, words: Vocabulary = SWEEPS) -> Grid | None:
    """The table set upright, if each row begins with a name and goes on with numbers.

    None for other tables.
    """
    rows = [row for row in grid.rows if not row[0].strip().startswith(COMMENT)]
    rows = [_without_end(row) for row in rows]
    if (
        not 2 < len(rows) <= _MOST_ROWS
        or len(rows[0]) < 3
        or {len(row) for row in rows} != {len(rows[0])}
    ):
        return None
    # Every cell behind a name must be a number: a table that stands upright has names in its first
    # row.
    if any(is_number(row[0]) or not all(map(is_number, row[1:])) for row in rows):
        return None
    if not words.complete({str(words.heading(row[0].strip()).role) for row in rows}):
        return None
    upright = [list(cells) for cells in zip(*rows, strict=True)]
    # Lines are no longer rows: errors name the column of the table as its line.
    return Grid(upright, range(1, len(upright) + 1), grid.separator)


def _without_end(row: list[str]) -> list[str]:
    end = len(row)
    while end and not row[end - 1].strip():
        end -= 1
    return row[:end]
