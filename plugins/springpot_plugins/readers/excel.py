"""Excel workbooks, .xlsx through openpyxl and .xls, of before 2007, through xlrd.

Tables as in CSV, one or more on each sheet. What openpyxl may see is an archive of bounded size and
depth.
"""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from datetime import date, datetime, time
from pathlib import Path
from typing import IO, Any
from xml.parsers.expat import ExpatError, ParserCreate

from springpot.errors import DataError
from springpot.measurement import (
    Choice,
    Measurement,
    OpenQuestion,
    Part,
    Reader,
    Signals,
    budget_of,
    measurement_from_signals,
)

from .above import facts_of, pairs_in, with_conditions_above
from .blocks import Block, blocks_of
from .channels import UNITS as CHANNELS, found_in
from .dynamic import measurement_from, parts_from
from .generic import numbers_said
from .grid import LONGEST_CELL, SEARCHED, Grid, Unpacked, grid_of_sheet
from .rearranged import needs_rearranging, rearranged
from .side_by_side import apart, has_condition
from .signals_csv import signals_of_sheet
from .title_words import CurveName, curve_in_cell

_MOST_ENTRIES = 10_000
"""Files in a workbook: one has some ten, and a list of millions would take long to read."""
_DEEPEST = 100
"""Elements of XML within one another: a sheet has six, its charts some thirty."""


def check_archive(path: Path) -> None:
    """Refuse what is no workbook, or would take long to unpack or to parse.

    Raises
    ------
    DataError
        If the file is no workbook, unpacks to far too much, or holds XML nested too deeply.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            entries = archive.infolist()
            _check_sizes(entries, budget_of(path).memory)
            for entry in entries:
                with archive.open(entry) as stream:
                    _check_depth(stream)
    except (
        zipfile.BadZipFile,
        OSError,
        ValueError,
        NotImplementedError,
        EOFError,
        RuntimeError,
        zlib.error,
    ) as error:
        raise DataError(f"no readable Excel file: {error}") from None


def _check_sizes(entries: list[zipfile.ZipInfo], most: int) -> None:
    if not any(entry.filename.startswith("xl/") for entry in entries):
        raise DataError("a zip archive without an Excel workbook; unpack it, or save it as .xlsx")
    size = sum(entry.file_size for entry in entries)
    # Before anything is unpacked: a small archive may hold terabytes of zeros.
    if size > most or len(entries) > _MOST_ENTRIES:
        raise DataError(
            f"the workbook unpacks to {size} bytes; save the one sheet that matters, or CSV"
        )


def _check_depth(stream: IO[bytes]) -> None:
    """Refuse elements nested without end.

    A tree of them is built and freed within C, where no clock is heard.
    """
    depth = 0

    def enter(name: str, attributes: Any) -> None:
        nonlocal depth
        depth += 1
        if depth > _DEEPEST:
            raise DataError("the workbook is nested too deeply; save it anew, or as CSV")

    def leave(name: str) -> None:
        nonlocal depth
        depth -= 1

    parser = ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = enter, leave
    # A picture ends it at its first byte, and what is broken as it will end openpyxl.
    with suppress(ExpatError):
        parser.ParseFile(stream)


SIGNATURE = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
"""First bytes of a compound file (Microsoft, MS-CFB, section 2.2)."""
MOST_SHEETS = 200


def _old_sheets(path: Path) -> list[tuple[str, Grid]]:
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
            return [(str(book.sheet_names()[i]), _old_grid(book, i, unpacked)) for i in chosen]
    except (DataError, MemoryError):
        raise
    except Exception as error:
        # Broken workbooks fail within xlrd in many ways, and the projects of instruments are
        # compound files as well.
        reason = (str(error).splitlines() or [""])[0]
        raise DataError(
            f"no readable Excel file: {reason:.80}; export the results as .xlsx or CSV"
        ) from None


def _old_grid(book: Any, number: int, unpacked: Unpacked) -> Grid:
    sheet = book.sheet_by_index(number)
    rows = ([_old_text(cell, book.datemode) for cell in sheet.row(i)] for i in range(sheet.nrows))
    grid = grid_of_sheet(unpacked.counted(rows))
    # Each sheet's cells are let go before the next one's come, or all would be held at once.
    book.unload_sheet(number)
    return grid


def _old_text(cell: Any, datemode: int) -> str:
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


def recognises(head: bytes) -> float:
    """High for a zip archive of spreadsheets, or the compound file that old workbooks are."""
    if head.startswith(SIGNATURE):
        # The projects of instruments are compound files as well.
        return 0.5
    if not head.startswith(b"PK\x03\x04"):
        return 0.0
    if b"xl/" in head or b"[Content_Types].xml" in head:
        return 0.95
    # The names that would tell may lie beyond the head.
    return 0.3


def _parsed(
    path: Path, choice: Choice | None = None
) -> tuple[list[Block], list[tuple[str, str]], dict[str, str]]:
    """The tables of all sheets, pairs of key and value, and notes.

    The pairs stand above the tables or on sheets of their own.

    Raises
    ------
    DataError
        If what reads it is not installed, or the file is no workbook, broken, or unpacks to far too
        much; or if no sheet is a dynamic test before the user says more.
    """
    made: list[Block] = []
    pairs: list[tuple[str, str]] = []
    notes: dict[str, str] = {}
    doubts: list[DataError] = []
    for title, grid in sheets_in(path):
        blocks, below = blocks_of(grid, stacked=True)
        if needs_rearranging(grid, blocks):
            try:
                found = rearranged(grid, choice or Choice())
            except DataError as error:
                # What one sheet leaves open must not keep the others from opening.
                doubts.append(error)
                found = None
            if found is not None:
                blocks, below = blocks_of(found[0], stacked=True)
                notes["note layout"] = found[1]
        for block in blocks:
            pairs += pairs_in(block.above)
        if not blocks:
            # A sheet of its own for instrument and sample.
            pairs += pairs_in(below)
        made += called_by_sheet(title, with_conditions_above(apart(blocks, choice)))
    if doubts and choice is not None and not any(block.is_dynamic for block in made):
        raise doubts[0]
    return made, pairs, notes


def _said(sheets: Sequence[tuple[str, Grid]], choice: Choice) -> list[Block]:
    """The numbers of all sheets of whose columns none is known, as the user says.

    Raises
    ------
    DataError
        The question for the columns, of the first sheet that has any.
    """
    made: list[Block] = []
    for title, grid in sheets:
        try:
            made += called_by_sheet(title, apart([numbers_said(grid, choice)], choice))
        except OpenQuestion:
            raise
        except DataError:
            # A sheet of words, beside those of numbers.
            continue
    return made


def sheets_in(path: Path) -> list[tuple[str, Grid]]:
    """Title and cells of each sheet, by what wrote the file."""
    with path.open("rb") as stream:
        is_old = stream.read(len(SIGNATURE)) == SIGNATURE
    if is_old:
        return _old_sheets(path)
    return _sheets(path)


def _sheets(path: Path) -> list[tuple[str, Grid]]:
    """Title and cells of each sheet of a new workbook."""
    check_archive(path)
    try:
        from openpyxl import load_workbook
    except ImportError:
        raise DataError("Excel files need openpyxl: pip install 'springpot[instruments]'") from None
    try:
        with path.open("rb") as stream:
            # What formulas came to, not the formulas; and no links, which lead out of the file.
            book = load_workbook(stream, read_only=True, data_only=True, keep_links=False)
            unpacked = Unpacked()
            sheets = [
                (str(sheet.title), _grid(sheet, unpacked))
                for sheet in book.worksheets[:MOST_SHEETS]
            ]
            book.close()
    except (DataError, MemoryError):
        # The limits within which a file is read, told as such: the workbook need not be broken.
        raise
    except Exception as error:
        # Broken workbooks fail within openpyxl in many ways.
        reason = (str(error).splitlines() or [""])[0]
        raise DataError(f"no readable Excel file: {type(error).__name__}: {reason:.80}") from None
    return sheets


def signals(path: Path, choice: Choice) -> Signals:
    """The time signals on the first sheet that holds some, or on the one that the user names.

    Raises
    ------
    DataError
        If a channel or its unit is missing, or a cell is no number.
    """
    sheets = sheets_in(path)
    if choice.part:
        sheets = [sheet for i, sheet in enumerate(sheets, 1) if choice.part in (str(i), sheet[0])]
        if not sheets:
            raise DataError(f"there is no sheet '{choice.part:.40}'")
    # Where no sheet names all channels the user says which columns they are, of the longest one.
    _, grid = max(sheets, key=lambda sheet: (_holds_signals(sheet[1]), len(sheet[1].rows)))
    return signals_of_sheet(_as_lines(grid), path, choice, "Excel")


def _holds_signals(grid: Grid) -> bool:
    return any(len(found_in(row)) == len(CHANNELS) for row in grid.rows[:SEARCHED])


def _as_lines(grid: Grid) -> list[str]:
    """The rows as lines of text at their own numbers, so that errors name the right one."""
    lines = [""] * grid.lines[-1]
    for number, row in zip(grid.lines, grid.rows, strict=True):
        # A tab within a cell would begin another one.
        lines[number - 1] = "\t".join(cell.replace("\t", " ") for cell in row)
    return lines


def called_by_sheet(sheet: str, blocks: list[Block]) -> list[Block]:
    """Blocks called by their sheet, and numbered where it has several.

    ``40 °C`` as a name is a temperature.
    """
    curve = curve_in_cell(sheet)
    if curve.title:
        blocks = [_with_condition(block, curve) for block in blocks]
    if len(blocks) == 1:
        return [replace(blocks[0], name=sheet)]
    return [replace(block, name=f"{sheet} {block.name or i}") for i, block in enumerate(blocks, 1)]


def _with_condition(block: Block, curve: CurveName) -> Block:
    """The block with what the sheet's name states; what the sheet itself says goes before it."""
    if has_condition(curve, block.roles):
        return block
    return replace(block, constants={curve.title: curve.value, **block.constants})


def _grid(sheet: Any, unpacked: Unpacked) -> Grid:
    # What a sheet says of its own size may be wrong.
    sheet.reset_dimensions()
    rows = ([_text(value) for value in row] for row in sheet.iter_rows(values_only=True))
    return grid_of_sheet(unpacked.counted(rows))


def _text(value: Any) -> str:
    if value is None or isinstance(value, bool):
        return ""
    if isinstance(value, float):
        # The shortest digits that read back as the same bits.
        return repr(value)
    if isinstance(value, datetime | date | time):
        return value.isoformat()
    return str(value).strip()[:LONGEST_CELL]


def read(path: Path, choice: Choice) -> Measurement:
    """The tables of a workbook that are dynamic tests.

    Raises
    ------
    DataError
        One line that says what was recognised and what is missing.
    """
    blocks, pairs, notes = _parsed(path, choice)
    if not choice and not any(block.is_dynamic for block in blocks):
        sheets = [grid for _, grid in sheets_in(path)]
        if any(map(_holds_signals, sheets)):
            return measurement_from_signals([signals(path, choice)])
    blocks = blocks or _said(sheets_in(path), choice)
    return measurement_from(
        blocks, choice, path, {"format": "Excel", **facts_of(pairs), **notes}, further=True
    )


def parts(path: Path) -> tuple[Part, ...]:
    """The tables of a workbook."""
    return parts_from(_parsed(path)[0])


READER = Reader(
    "excel",
    "Excel .xlsx and .xls with named columns on one or more sheets",
    recognises,
    read,
    parts=parts,
    signals=signals,
)
