"""What is left of columns that a file gives.

Rows in which something was measured, numbers in one style.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.measurement import normal_unit

from .grid import APOSTROPHES, BLANKS, MISSING, POINTS, THOUSANDS, is_number
from .table import Column
from .titles import heading, is_unit

_WITH_UNIT = re.compile(r"\s*[-+−]?\d[\d.,]*(?:[eE][-+]?\d+)?\s*((?:[^\W\d]|[°%]).*)\Z")
_PARTED = re.compile(r"\s*[-+−]?[1-9]\d{0,2}(?:,\d{3}|\.\d{3})\s*\Z")
"""A number with three digits behind its only mark, which may part thousands: 1,234 or 1.234."""
_FILLED = re.compile(r"[-−]9{3,}(?:[.,](?:0*|9+|250*))?\Z")
"""What programs write where nothing was measured: -999, -9999.0, -999.25."""
_WHOLE = ("temperature", "amplitude", "storage_sd", "loss_sd")


def cleaned(
    roles: dict[str, Column], others: list[Column]
) -> tuple[dict[str, Column], list[Column], dict[str, str]]:
    """Rows in which something was measured, the columns complete there, and what was left out."""
    roles, notes = _with_one_decimal_sign(roles)
    keep = np.ones(len(next(iter(roles.values())).cells), dtype=bool)
    for role, column in roles.items():
        if role not in (*_WHOLE, "repeat"):
            column = roles[role] = _without_thousands(column)
            _one_style(column)
            keep &= _present(column)
    if not keep.any():
        raise DataError(f"no row has a number for {', '.join(c.title for c in roles.values())}")
    if not keep.all():
        notes["note rows"] = (
            f"{int((~keep).sum())} of {len(keep)} rows without a measured value were left out"
        )
    roles = {role: rows_of(column, keep) for role, column in roles.items()}
    for role in [role for role in (*_WHOLE, "repeat") if role in roles]:
        # A point was measured without its temperature too, so that the column goes and the row
        # stays.
        if not _present(roles[role]).all():
            notes[f"note {role}"] = f"column '{roles[role].title}' has gaps and was left out"
            del roles[role]
    if ("storage_sd" in roles) != ("loss_sd" in roles):
        # One of the two weighs nothing: an objective needs both.
        roles.pop("storage_sd", roles.pop("loss_sd", None))
    return roles, _named_apart([rows_of(column, keep) for column in others], roles), notes


def with_unit_of_cells(column: Column) -> Column:
    """A column whose cells carry one unit, ``23 °C``, as plain numbers in that unit.

    Others as they are.
    """
    first = next((cell for cell in column.cells if cell.strip() not in MISSING), "")
    behind = unit_behind(first)
    if not behind:
        return column
    cells = [cell.strip() for cell in column.cells]
    if column.unit not in (None, normal_unit(behind)) or not all(
        cell.endswith(behind) or cell in MISSING for cell in cells
    ):
        return column
    return replace(
        column,
        unit=normal_unit(behind),
        cells=[cell.removesuffix(behind).rstrip() for cell in cells],
    )


def unit_behind(cell: str) -> str:
    """The unit behind a number, as in ``23 °C``; empty where there is none."""
    match = _WITH_UNIT.match(cell)
    return match[1].strip() if match is not None and is_unit(match[1]) else ""


def _present(column: Column) -> NDArray[np.bool_]:
    cells = [cell.strip() for cell in column.cells]
    known = np.array([cell not in MISSING for cell in cells], dtype=bool)
    filled = np.array([_FILLED.match(cell) is not None for cell in cells], dtype=bool)
    # Of values that are never negative, -999 is none.
    if filled.any() and not any(cell[:1] in "-−" for cell in np.array(cells)[known & ~filled]):
        known &= ~filled
    return known


def _without_thousands(column: Column) -> Column:
    """Numbers such as 1,234.5, where all commas plainly part thousands, without them; 1.234,5.

    1 234,5; 1'234.5.
    """
    quoted = [cell for cell in column.cells if "'" in cell or "’" in cell]
    if quoted and all(map(APOSTROPHES.match, quoted)):
        column = replace(
            column, cells=[cell.replace("'", "").replace("’", "") for cell in column.cells]
        )
    parted = [cell for cell in column.cells if len(cell.split()) > 1]
    if parted and all(map(BLANKS.match, parted)):
        column = replace(column, cells=["".join(cell.split()) for cell in column.cells])
    for sign, pattern in ((",", THOUSANDS), (".", POINTS)):
        marked = [cell for cell in column.cells if sign in cell]
        # 1,234 alone may be a decimal comma: only a cell with both signs tells which is which.
        if (
            marked
            and any({",", "."} <= set(cell) for cell in marked)
            and all(map(pattern.match, marked))
        ):
            return replace(column, cells=[cell.replace(sign, "") for cell in column.cells])
    return column


def _with_one_decimal_sign(roles: dict[str, Column]) -> tuple[dict[str, Column], dict[str, str]]:
    """The columns without the sign that parts thousands, where others show the decimal sign.

    ``1,500`` beside ``900.2``. Where nothing shows it, a comma is the decimal sign, with a note.
    """
    as_written = {role: column for role, column in roles.items() if column.decimal_comma}
    shown = {
        sign
        for sign in ",."
        for column in as_written.values()
        if any(
            sign in cell and is_number(cell) and not _PARTED.match(cell) for cell in column.cells
        )
    }
    notes = {}
    made = dict(roles)
    for role, column in as_written.items():
        signs = {sign for cell in column.cells for sign in ",." if sign in cell} - shown
        marked = [cell for cell in column.cells if signs & {*cell}]
        if len(signs) != 1 or not all(map(_PARTED.match, marked)):
            continue
        [sign] = signs
        value, read_as = marked[0].strip(), "."
        if shown:
            read_as = ""
            made[role] = replace(column, cells=[cell.replace(sign, "") for cell in column.cells])
        if shown or sign == ",":
            notes["note thousands"] = (
                f"column '{column.title}': '{value}' is read as {value.replace(sign, read_as)}"
            )
    return made, notes


def _one_style(column: Column) -> None:
    """Numbers with commas and numbers with points in one column can be read in two ways."""
    numbers = [cell for cell in column.cells if any(map(str.isdigit, cell))]
    commas = next((cell for cell in numbers if "," in cell), None)
    points = next((cell for cell in numbers if "." in cell), None)
    if commas is not None and points is not None:
        raise column.error(
            f"'{commas.strip():.20}' and '{points.strip():.20}' have comma and point; write one"
            " decimal sign"
        )


def rows_of(column: Column, keep: NDArray[np.bool_]) -> Column:
    """The rows of a column that are kept, gaps as empty cells."""
    if keep.all():
        cells: Sequence[str] = column.cells
        lines = column.lines
    else:
        places = np.flatnonzero(keep).tolist()
        cells = [column.cells[i] for i in places]
        lines = [column.lines[i] for i in places]
    if any(cell in MISSING for cell in cells):
        cells = list(map(_without_sign_of_gap, cells))
    return replace(column, cells=cells, lines=lines)


def _without_sign_of_gap(cell: str) -> str:
    if cell.strip() in MISSING:
        return ""
    return cell


def _named_apart(columns: list[Column], taken: Collection[str]) -> list[Column]:
    """Further columns, each with a name of its own.

    Of two that mean alike, the second keeps the file's words.
    """
    made: dict[str, Column] = {}
    for column in columns:
        words = re.sub(r"[\W_]+", "_", bare_name(column).lower()).strip("_")
        stem = column.name
        # A second temperature must not take the place of the one that was chosen.
        if (column.name in made or column.name in taken) and words:
            stem = words
        name, number = stem, 2
        while name in made or name in taken:
            name, number = f"{stem}_{number}", number + 1
        made[name] = replace(column, name=name)
    return list(made.values())


def is_blank(column: Column) -> bool:
    """Whether a column holds nothing."""
    return all(cell.strip() in MISSING for cell in column.cells)


def bare_name(column: Column) -> str:
    """The name of a column without its unit."""
    return heading(column.title).name
