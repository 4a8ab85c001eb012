"""Parameters or quantities as a table for a paper or a spreadsheet: value, half-width, unit."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isfinite
from pathlib import Path
from typing import IO, TYPE_CHECKING

from springpot.errors import OutputError
from springpot.files import write_text, write_with
from springpot.format_numbers import number
from springpot.identification.value import Value
from springpot.measurement.csv_safe import guarded

from .numbers import halved
from .tables import FORMATS, Entry, Table, to_csv

if TYPE_CHECKING:
    from springpot.identification.result import Identification

ENDINGS = {".csv", ".xlsx", *(f".{suffix}" for suffix, _ in FORMATS.values())}
"""Of files, by which the format of a table is chosen."""


def write_parameters(path: str | Path, fits: Sequence[Identification]) -> Path:
    """Write the parameters of fits to a file; see `write_values`."""
    rows: list[tuple[tuple[str, ...], Value]] = []
    for fit in fits:
        # One fit is named in the title.
        data = (fit.name,) if len(fits) > 1 else ()
        rows += [((*data, name), value) for name, value in fit.parameters.items()]
    heads = ("data", "parameter") if len(fits) > 1 else ("parameter",)
    title = fits[0].model.name
    if len(fits) == 1:
        title = f"{title} fitted to {fits[0].name}"
    return write_values(Path(path), title, heads, rows)


def require_ending(path: Path) -> None:
    """Refuse a file whose ending tells no format, before time is spent on what goes there.

    Raises
    ------
    OutputError
        If it has none of `ENDINGS`.
    """
    if path.suffix.lower() not in ENDINGS:
        known = ", ".join(sorted(ENDINGS))
        raise OutputError(f"{path}: the ending tells the format of a table: one of {known}")


def write_values(
    path: Path,
    title: str,
    heads: Sequence[str],
    rows: Iterable[tuple[tuple[str, ...], Value]],
) -> Path:
    """Write values to a file, in the format of its ending.

    For people (.md, .tex, .html) with the digits that the interval justifies; for programs (.csv,
    .xlsx) in full, with both ends.

    Parameters
    ----------
    path : Path
        The file.
    title : str
        One line above the table.
    heads : sequence of str
        Headings of the names.
    rows : iterable
        Names and values.

    Raises
    ------
    OutputError
        If the ending tells no format, or the file cannot be written.
    """
    require_ending(path)
    rows, suffix = list(rows), path.suffix.lower()
    if suffix in (".csv", ".xlsx"):
        table = _in_full(title, heads, rows)
        if suffix == ".csv":
            return write_text(path, to_csv(table))
        return write_with(path, lambda stream: _workbook(table, stream))
    write = {f".{ending}": writer for ending, writer in FORMATS.values()}[suffix]
    return write_text(path, write(_for_people(title, heads, rows)))


def _in_full(
    title: str, heads: Sequence[str], rows: Iterable[tuple[tuple[str, ...], Value]]
) -> Table:
    columns = (*heads, "value", "half_width", "low", "high", "unit")
    return Table(title, columns, [(*names, *_numbers(value)) for names, value in rows])


def _numbers(value: Value) -> tuple[Entry, ...]:
    ends = [end if isfinite(end) else None for end in (value.low, value.high)]
    half = None if None in ends else 0.5 * (value.high - value.low)
    return (value.value, half, *ends, value.unit)


def _for_people(
    title: str, heads: Sequence[str], rows: Iterable[tuple[tuple[str, ...], Value]]
) -> Table:
    columns = (*heads, "value", "± (95 %)", "unit")
    cells = [(*names, *_words(value), value.unit) for names, value in rows]
    return Table(title, columns, cells)


def _words(value: Value) -> tuple[str, str]:
    if value.fixed:
        return number(value.value), "fixed"
    if not (isfinite(value.low) and isfinite(value.high)):
        return number(value.value), "open"
    return halved(value.value, value.low, value.high)


def _workbook(table: Table, stream: IO[bytes]) -> None:
    """An Excel workbook of one sheet.

    Raises
    ------
    OutputError
        If openpyxl is not installed.
    """
    try:
        from openpyxl import Workbook
    except ModuleNotFoundError:
        raise OutputError(
            "an Excel table needs openpyxl: pip install 'springpot[instruments]'"
        ) from None
    book = Workbook()
    sheet = book.active
    sheet.title = "springpot"
    for row in (table.columns, *table.rows):
        sheet.append([guarded(cell) if isinstance(cell, str) else cell for cell in row])
    book.save(stream)
