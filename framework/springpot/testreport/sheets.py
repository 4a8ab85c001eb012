"""Tables as files: a workbook with a sheet for each, or one CSV with all below each other."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from math import isfinite
from pathlib import Path
from typing import IO

from springpot.errors import OutputError
from springpot.files import require_writable, write_text, write_with
from springpot.writing import csv_text

SUFFIXES = (".xlsx", ".csv")
_FORBIDDEN = re.compile(r"[\[\]:*?/\\\x00-\x1f]")
"""What the name of a sheet cannot hold."""
LONGEST = 31
"""Letters of the name of a sheet."""


@dataclass(frozen=True)
class Sheet:
    """One table.

    Parameters
    ----------
    name : str
        Of the sheet.
    header : sequence of str
        Above the columns.
    rows : sequence of sequences of float or str
        Its cells.
    notes : sequence of str
        Below the table.
    """

    name: str
    header: Sequence[str]
    rows: Sequence[Sequence[float | str]]
    notes: Sequence[str] = ()


def check_sheets_path(path: str | Path, suffixes: Sequence[str] = SUFFIXES) -> Path:
    """`path`, after a check that tables can be written there; called before long work.

    Raises
    ------
    OutputError
        If its name ends otherwise, openpyxl is missing, or the place cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() not in suffixes:
        raise OutputError(f"cannot write {path}: its name must end in {' or '.join(suffixes)}")
    if path.suffix.lower() == ".xlsx":
        try:
            import openpyxl  # noqa: F401
        except ImportError:
            raise OutputError(
                "Excel files need openpyxl: pip install 'springpot[instruments]'"
            ) from None
    return require_writable(path)


def write_sheets(sheets: Sequence[Sheet], path: str | Path) -> Path:
    """Write tables to .xlsx or .csv.

    Raises
    ------
    OutputError
        If that cannot be.
    """
    path = check_sheets_path(path)
    if path.suffix.lower() == ".csv":
        blocks = [[[], [sheet.name], *_lines(sheet)] for sheet in sheets]
        # All below each other, an empty line between them.
        return write_text(path, csv_text(list(chain(*blocks))[1:]))
    return write_with(path, lambda stream: _workbook(sheets, stream))


def _lines(sheet: Sheet) -> list[Sequence[float | str]]:
    return [sheet.header, *sheet.rows, *([note] for note in sheet.notes)]


def _workbook(sheets: Sequence[Sheet], stream: IO[bytes]) -> None:
    from openpyxl import Workbook
    from openpyxl.styles import Font

    book = Workbook()
    book.remove(book.active)
    taken: set[str] = set()
    for sheet in sheets:
        page = book.create_sheet(_title(sheet.name, taken))
        for number, row in enumerate(_lines(sheet), 1):
            for column, value in enumerate(row, 1):
                cell = page.cell(number, column)
                if isinstance(value, str):
                    # Control signs cannot stand in a workbook.
                    cell.value = re.sub(r"[\x00-\x08\x0b\x0c\x0e-\x1f]", " ", value)
                    # Text stays text, whatever sign it begins with.
                    cell.data_type = "s"
                elif isfinite(value):
                    cell.value = value
                if number == 1:
                    cell.font = Font(bold=True)
        page.freeze_panes = "B2"
        # As wide as most names are.
        page.column_dimensions["A"].width = 24
    book.save(stream)


def _title(name: str, taken: set[str]) -> str:
    """A name that a sheet can have, and no other has."""
    stem = _FORBIDDEN.sub(" ", name).strip("' ")[:LONGEST] or "test"
    title, number = stem, 2
    while title.casefold() in taken:
        end = f" {number}"
        title, number = f"{stem[: LONGEST - len(end)]}{end}", number + 1
    taken.add(title.casefold())
    return title
