"""Sheets of the Excel workbooks of before 2007 (.xls), through xlrd.

Many instruments still write them.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from springpot.errors import DataError

from .grid import LONGEST_CELL, Grid, Unpacked, grid_of_sheet

SIGNATURE = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
"""First bytes of a compound file (Microsoft, MS-CFB, section 2.2)."""
MOST_SHEETS = 200


def sheets_of(path: Path) -> list[tuple[str, Grid]]:
    """Title and cells of each sheet.

    Raises
    ------
    DataError
        If xlrd is not installed, or the file is no workbook or broken.
    """
    try:
        import xlrd
    except ImportError:
        raise DataError(
            "old Excel files (.xls) need xlrd: pip install 'springpot[instruments]'"
        ) from None
    try:
        # What xlrd would print of a file that is not quite right is of no use to anybody here.
        with xlrd.open_workbook(path, logfile=io.StringIO(), on_demand=True) as book:
            unpacked = Unpacked()
            chosen = range(min(book.nsheets, MOST_SHEETS))
            return [(str(book.sheet_names()[i]), _grid(book, i, unpacked)) for i in chosen]
    except (DataError, MemoryError):
        raise
    except Exception as error:
        # Broken workbooks fail within xlrd in many ways, and the projects of instruments are
        # compound files as well.
        reason = (str(error).splitlines() or [""])[0]
        raise DataError(
            f"no readable Excel file: {reason:.80}; export the results as .xlsx or CSV"
        ) from None


def _grid(book: Any, number: int, unpacked: Unpacked) -> Grid:
    sheet = book.sheet_by_index(number)
    rows = ([_text(cell, book.datemode) for cell in sheet.row(i)] for i in range(sheet.nrows))
    grid = grid_of_sheet(unpacked.counted(rows))
    # Each sheet's cells are let go before the next one's come, or all would be held at once.
    book.unload_sheet(number)
    return grid


def _text(cell: Any, datemode: int) -> str:
    from xlrd import (
        XL_CELL_BOOLEAN,
        XL_CELL_DATE,
        XL_CELL_ERROR,
        XL_CELL_NUMBER,
        xldate_as_datetime,
    )

    if cell.ctype == XL_CELL_NUMBER:
        return repr(cell.value)
    if cell.ctype == XL_CELL_DATE:
        return str(xldate_as_datetime(cell.value, datemode).isoformat())
    if cell.ctype in (XL_CELL_BOOLEAN, XL_CELL_ERROR):
        return ""
    return str(cell.value).strip()[:LONGEST_CELL]
