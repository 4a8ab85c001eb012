"""Delimited text as named columns that know where they came from.

So that every error names file, line and column. Numbers that a file writes in another form
(logarithms, levels in decibel, a period instead of a frequency) are brought into the usual one.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from springpot.errors import DataError
from springpot.rheology import Real

from .grid import LONGEST_CELL, MISSING, is_number, require_columns

_BRACKETED = re.compile(r"^(.*?)\s*[\[(]([^\[\]()]*)[\])]\s*$")
_EXPONENT = re.compile(r"(\d\.?)[dD]([-+]?\d+\s*)\Z")
_COMMENT = re.compile(r"^#+\s*([\w][\w .-]{0,40}?)\s*:\s+(.*)$")


@dataclass(frozen=True, eq=False)
class Column:
    """One column of a table.

    Parameters
    ----------
    title : str
        The header as written, for errors.
    name : str
        The name in lower case, with underscores.
    unit : str or None
        What stood in brackets; None where there were none.
    cells : sequence of str
        The cells.
    lines : sequence of int
        Line number of every cell, for errors.
    decimal_comma : bool
        Whether 1,5 may mean 1.5.
    """

    title: str
    name: str
    unit: str | None
    cells: Sequence[str]
    lines: Sequence[int]
    decimal_comma: bool = False

    @property
    def is_empty(self) -> bool:
        """Whether no cell holds anything."""
        return not any(cell.strip() for cell in self.cells)

    def error(self, message: str, row: int | None = None) -> DataError:
        """An error at this column, and at a row of it."""
        where = f"column '{self.title}'"
        if row is not None:
            where = f"line {self.lines[row]}, {where}"
        return DataError(f"{where}: {message}")

    def numbers(self, gaps: bool = False) -> Real:
        """The cells as finite numbers; empty ones as nan where `gaps` are allowed.

        Raises
        ------
        DataError
            At the first cell that is no number.
        """
        cells: Sequence[str] = self.cells
        if self.decimal_comma and any("," in cell for cell in cells):
            cells = list(map(_with_point, cells))
        if gaps:
            cells = [cell if cell.strip() else "nan" for cell in cells]
        try:
            values = np.fromiter(map(float, cells), float, len(cells))
        except ValueError:
            # The slow way tells which cells are no numbers, and reads what typesetting and Fortran
            # write.
            values = np.array([_number(cell) for cell in cells])
        # Python reads 1_000 as a number; in a table it is a slip.
        wrong = ~np.isfinite(values)
        wrong |= np.fromiter(("_" in cell for cell in cells), bool, len(cells))
        if gaps:
            wrong &= np.fromiter((bool(cell.strip()) for cell in self.cells), bool, len(cells))
        if wrong.any():
            row = int(np.argmax(wrong))
            raise self.error(_complaint(self.cells[row]), row)
        return values

    def is_numeric(self) -> bool:
        """Whether all cells that hold anything are numbers."""
        try:
            self.numbers(gaps=True)
        except DataError:
            return False
        return True


def _with_point(cell: str) -> str:
    """A decimal comma as a point.

    Beside a point a comma may part thousands, which is left to be told.
    """
    if "." in cell:
        return cell
    return cell.replace(",", ".")


def _number(cell: str) -> float:
    """A number, also with the minus of typesetting or the exponent of Fortran: −40, 1.0D+03."""
    try:
        return float(_EXPONENT.sub(r"\1e\2", cell.replace("−", "-")))
    except ValueError:
        return np.nan


def _complaint(cell: str) -> str:
    if not cell.strip():
        return "the cell is empty; give a number or leave out the row"
    shown = cell.strip()
    if len(cell) > 30:
        # An error is one line, however long the cell.
        shown = shown[:27] + "..."
    if "," in cell and "." in cell:
        return f"'{shown}' has both comma and point; write it without thousands separators"
    if shown.lower().lstrip("+-") in ("nan", "inf", "infinity"):
        return f"'{shown}' is no finite number; leave out the row"
    return f"'{shown}' is no number"


@dataclass(frozen=True, eq=False)
class ParsedTable:
    """A delimited text file.

    Parameters
    ----------
    columns : tuple of Column
        Its columns in order.
    comments : mapping of str to str
        Lines ``# key: value``; other comment lines under ``comment``.
    """

    columns: tuple[Column, ...]
    comments: dict[str, str] = field(default_factory=dict)


def separator_of(header: str) -> str:
    """The sign between the cells: a semicolon, a tab, or else a comma."""
    # What stands within brackets or quotes belongs to a title: "strain [%; peak]".
    plain = re.sub(r"\[[^\[\]]*\]|\([^()]*\)|\"[^\"]*\"", "", header)
    return next((sign for sign in (";", "\t") if sign in plain), ",")


def split_header(header: str, separator: str) -> list[str]:
    """Titles of the columns; separators within brackets or quotes belong to a title."""
    titles, depth, quoted, title = [], 0, False, ""
    for sign in header:
        quoted ^= sign == '"'
        depth = max(0, depth + (sign in "[(") - (sign in "])"))
        if sign == separator and not quoted and depth == 0:
            titles.append(title)
            title = ""
        else:
            title += sign
    return [text.strip().strip('"').replace('""', '"').strip() for text in [*titles, title]]


def name_and_unit(title: str) -> tuple[str, str | None]:
    """``Storage modulus [kN/m]`` as (``storage_modulus``, ``kN/m``)."""
    name, unit = title, None
    if len(title) <= LONGEST_CELL and (match := _BRACKETED.match(title)) and match[1]:
        name, unit = match[1], match[2]
    return re.sub(r"[\s-]+", "_", name.strip().lower()), unit


def header_of(text: str) -> tuple[str, list[str]]:
    """Separator and titles of the first line that is neither empty nor a comment.

    No titles if there is none.
    """
    for line in re.split(r"\r\n|\n|\r", text):
        if (
            line.strip()
            and not line.lstrip().startswith("#")
            and not re.fullmatch(r"sep=.", line.strip())
        ):
            separator = separator_of(line)
            return separator, split_header(line, separator)
    return ",", []


def table_of(text: str) -> ParsedTable:
    """The table that a text holds.

    Raises
    ------
    DataError
        If there is no header, no row, two columns of one title, or a row of the wrong length.
    """
    lines = re.split(r"\r\n|\n|\r", text)
    comments = _comments(line for line in lines if line.lstrip().startswith("#"))
    filled = [
        (number, line)
        for number, line in enumerate(lines, 1)
        if line
        and not line.isspace()
        and not line.lstrip().startswith("#")
        and not line.startswith("sep=")
    ]
    if not filled:
        raise DataError("the file holds no table")
    separator = separator_of(filled[0][1])
    # Before the header is taken apart sign by sign.
    require_columns(filled[0][1].count(separator) + 1)
    titles = split_header(filled[0][1], separator)
    # Spreadsheets end each line with the separators of columns that were once used.
    while len(titles) > 1 and not titles[-1]:
        titles.pop()
    if len(filled) == 1:
        raise DataError("there is a header but no row of numbers below it")
    numbers = [number for number, _ in filled[1:]]
    rows = [_cells(line, separator, number) for number, line in filled[1:]]
    _check_lengths(rows, len(titles), numbers, separator)
    columns = []
    for title, column in zip(titles, zip(*rows, strict=True), strict=False):
        name, unit = name_and_unit(title)
        columns.append(Column(title, name, unit, column, numbers, separator != ","))
    _check_names(columns)
    return ParsedTable(tuple(columns), comments)


def _cells(line: str, separator: str, number: int) -> list[str]:
    if '"' not in line:
        # Most lines are like this one, with nothing to unquote.
        return line.split(separator)
    try:
        return next(csv.reader([line], delimiter=separator))
    except (csv.Error, StopIteration) as error:
        raise DataError(f"line {number}: {error}") from None


def _check_lengths(rows: list[list[str]], width: int, numbers: list[int], separator: str) -> None:
    if set(map(len, rows)) == {width}:
        return
    for row, number in zip(rows, numbers, strict=True):
        while len(row) > width and not row[-1].strip():
            row.pop()
        if len(row) != width:
            hint = ""
            if separator == ",":
                # Then 1,5 counts as two cells.
                hint = "; with a decimal comma, separate the columns by semicolons"
            raise DataError(f"line {number}: {len(row)} cells where the header has {width}{hint}")


def _check_names(columns: list[Column]) -> None:
    seen: dict[str, Column] = {}
    for column in columns:
        if not column.name and not column.is_empty:
            raise DataError("a column has no title; write name [unit] above it")
        if column.name and column.name in seen:
            raise DataError(f"two columns are called '{column.name}'; rename one")
        seen[column.name] = column


def _comments(lines: Iterable[str]) -> dict[str, str]:
    # Lists that are joined at the end: text that grows line by line takes the square of the time.
    comments: dict[str, list[str]] = {}
    for line in map(str.strip, lines):
        key, value = "comment", line.lstrip("#").strip()
        if match := _COMMENT.match(line):
            key, value = match[1], match[2].strip()
        if value:
            comments.setdefault(key, []).append(value)
    return {key: " ".join(values) for key, values in comments.items()}


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
