"""Excel workbooks, .xlsx through openpyxl and .xls through xlrd.

Tables as in CSV, one or more on each sheet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from datetime import date, datetime, time
from pathlib import Path
from typing import Any

from springpot.errors import DataError
from springpot.measurement import (
    Choice,
    Measurement,
    OpenQuestion,
    Part,
    Reader,
    Signals,
    measurement_from_signals,
)

from .archive import check_archive
from .blocks import Block, blocks_of
from .channels import UNITS as CHANNELS, found_in
from .conditions_above import with_conditions_above
from .curve_names import CurveName, curve_in_cell
from .dynamic import measurement_from, parts_from
from .generic import numbers_said
from .grid import LONGEST_CELL, SEARCHED, Grid, Unpacked, grid_of_sheet
from .header_facts import facts_of, pairs_in
from .old_excel import MOST_SHEETS, SIGNATURE, sheets_of
from .rearranged import needs_rearranging, rearranged
from .side_by_side import apart, has_condition
from .signals_csv import signals_of_sheet


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
        return sheets_of(path)
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
