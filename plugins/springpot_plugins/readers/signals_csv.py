"""Time signals as delimited text: columns of time, displacement and force, read in pieces.

Names are ``time [s]``, ``displacement [mm]``, ``force [N]``, or joined as ``t_s``, ``disp_mm``, ``force_N``, or
have their units in the row below; a test report may stand above them. Strain and stress, angle and torque serve as
well, and names in other languages.
Other columns are left alone; a unit that is missing is said by ``FILE?force=kN``. A file of any size takes little
memory: its numbers go to a temporary file that is mapped, and all that follows works block by block.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO

import numpy as np

from springpot.errors import DataError
from springpot.measurement import TIME_UNITS, Choice, Measurement, Reader, Signals, measurement_from_signals
from springpot.rheology import Real

from .blocks import is_dynamic
from .channels import UNITS, found_in, places_of, signals_from
from .signal_layout import Layout, layout_of
from .text import encoding_of, head_text
from .titles import heading

CHUNK = 1 << 24
"""Characters parsed at a time."""
IN_MEMORY = 1 << 26
"""Larger files go through a temporary file."""


def recognises(head: bytes) -> float:
    """High for a line that names time, displacement and force, wherever it stands."""
    layout = layout_of(head_text(head))
    titles = layout.titles
    if is_dynamic({str(heading(title).role) for title in titles[:200]}):
        # A sweep may list time, deflection and torque of each point.
        return 0.0
    found = found_in(titles)
    if len(found) == len(UNITS):
        return 0.95
    # Any other table may be said to be signals.
    return 0.3 if "time" in found and len(found) == 2 else 0.02 * (len(titles) > 2)


def signals(path: Path, choice: Choice) -> Signals:
    """The signals in a file; missing samples are nan.

    Raises
    ------
    DataError
        If a channel or its unit is missing, or a cell is no number.
    """
    try:
        with path.open("rb") as stream:
            head = stream.read(1 << 16)
        encoding = encoding_of(head)
        if encoding is None:
            raise DataError("this is no text file; save the signals as CSV in UTF-8")
        layout = layout_of(head_text(head))
        places = places_of(layout.titles, layout.units, choice)
        with path.open(encoding=encoding, newline=None) as text:
            channels = _numbers(text, path, layout, list(places.columns), TIME_UNITS[places.units[0]])
    except UnicodeDecodeError as error:
        raise DataError(f"byte {error.start} is no {error.encoding} text; save it as CSV in UTF-8") from None
    except OSError as error:
        raise DataError(f"cannot be read: {error.strerror or error}") from None
    return signals_from(channels[0], channels[1], channels[2], ("s", *places.units[1:]), path, "text")


def read(path: Path, choice: Choice) -> Measurement:
    """The measurement of one row that the signals give."""
    return measurement_from_signals([signals(path, choice)])


def _numbers(text: IO[str], path: Path, layout: Layout, places: list[int], clock: float) -> list[Real]:
    """The three channels, in memory or mapped; time times `clock` is in seconds."""
    small = path.stat().st_size <= IN_MEMORY
    pieces: list[Real] = []
    with TemporaryFile() as a, TemporaryFile() as b, TemporaryFile() as c:
        rows = 0
        for piece in _pieces(text, layout, places):
            rows += len(piece)
            if clock != 1.0:
                piece[:, 0] *= clock
            if small:
                pieces.append(piece)
            else:
                for stream, column in zip((a, b, c), piece.T, strict=True):
                    column.tofile(stream)
        if not rows:
            raise DataError("there is a header but no row of numbers below it")
        if small:
            return list(np.concatenate(pieces).T.copy())
        # The mapping outlives the closed file.
        return [np.memmap(stream, dtype=float, mode="r", shape=(rows,)) for stream in (a, b, c)]


def _pieces(text: IO[str], layout: Layout, places: list[int]) -> Iterator[Real]:
    """Rows (m, 3) below the names, piece by piece."""
    for _ in range(layout.start):
        text.readline()
    line = layout.start
    while lines := text.readlines(CHUNK):
        first, line = line + 1, line + len(lines)
        if layout.separator != ",":
            lines = [raw.replace(",", ".") for raw in lines]
        yield _piece(lines, first, layout, places)


def _piece(lines: list[str], first: int, layout: Layout, places: list[int]) -> Real:
    filled = [raw for raw in lines if not raw.isspace()]
    if not filled:
        return np.empty((0, 3))
    delimiter = None if layout.separator == " " else layout.separator
    try:
        values: Real = np.loadtxt(filled, delimiter=delimiter, usecols=places, ndmin=2, comments="#", quotechar='"')
        return values
    except ValueError:
        # Something is missing or misspelt: go slowly and say where.
        return _slowly(lines, first, layout, places)


def _slowly(lines: list[str], first: int, layout: Layout, places: list[int]) -> Real:
    rows = []
    for number, raw in enumerate(lines, first):
        if not raw.strip() or raw.lstrip().startswith("#"):
            continue
        bare = raw.rstrip("\r\n")
        parts = bare.split() if layout.separator == " " else bare.split(layout.separator)
        cells = [cell.strip().strip('"') for cell in parts]
        row = []
        for place in places:
            cell = cells[place] if place < len(cells) else ""
            try:
                row.append(float(cell) if cell else np.nan)
            except ValueError:
                where = f"line {number}, column '{layout.titles[place]}'"
                raise DataError(f"{where}: '{cell:.30}' is no number") from None
        rows.append(row)
    return np.array(rows, dtype=float).reshape(-1, 3)


READER = Reader(
    "signals-csv",
    "CSV of displacement and force against time: time [s], displacement [mm], force [N]",
    recognises,
    read,
    signals=signals,
)
