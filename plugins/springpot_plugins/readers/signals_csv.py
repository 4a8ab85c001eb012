"""Time signals as delimited text: columns of time, displacement and force, read in pieces.

Names are ``time [s]``, ``displacement [mm]``, ``force [N]``, or joined as ``t_s``, ``disp_mm``,
``force_N``, or have their units in the row below; a test report may stand above them. Strain and
stress, angle and torque serve as well, and names in other languages. Other columns are left alone;
a unit that is missing is said by ``FILE?force=kN``. A file of any size takes little memory: its
numbers go to a temporary file that is mapped, and all that follows works block by block.
"""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path
from typing import IO

import numpy as np

from springpot.errors import DataError
from springpot.measurement import Choice, Signals

from .channels import (
    UNITS,
    Places,
    channel_of,
    found_in,
    places_of,
    reader_of_signals,
    signals_from,
)
from .cleaning import unit_behind
from .clock import sample_rate, seconds_of
from .signal_layout import Layout, layout_of
from .signal_rows import Rows
from .text import encoding_of, head_text
from .titles import heading, is_dynamic

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
    named = found_in(titles)
    if len(named) == len(UNITS):
        return 0.95
    if "time" in named and len(named) == 2:
        return 0.3
    if named == {"displacement", "force"}:
        # Loops without their time, which a sample rate gives.
        return 0.25
    # Any other table may be said to be signals.
    return 0.02 * (len(titles) > 2)


def signals(path: Path, choice: Choice) -> Signals:
    """The signals in a file; missing samples are nan.

    Raises
    ------
    DataError
        If a channel or its unit is missing, or a cell is no number.
    """
    try:
        # The names stand in the head; the rest is never in memory as a whole.
        with path.open("rb") as stream:
            head = stream.read(1 << 16)
        encoding = encoding_of(head)
        if encoding is None:
            raise DataError("this is no text file; save the signals as CSV in UTF-8")
        with path.open(encoding=encoding, newline=None) as text:
            return _signals_in(
                text, head_text(head), path.stat().st_size <= IN_MEMORY, path, choice, "text"
            )
    except UnicodeDecodeError as error:
        raise DataError(
            f"byte {error.start} is no {error.encoding} text; save it as CSV in UTF-8"
        ) from None
    except OSError as error:
        raise DataError(f"cannot be read: {error.strerror or error}") from None


def signals_of_sheet(lines: list[str], path: Path, choice: Choice, origin: str) -> Signals:
    """The signals in lines of cells that are separated by tabs, as a sheet of a workbook is."""
    text = "\n".join(lines)
    return _signals_in(io.StringIO(text), text[: 1 << 16], True, path, choice, origin)


def _signals_in(
    text: IO[str], head: str, in_memory: bool, path: Path, choice: Choice, origin: str
) -> Signals:
    """The signals in a text that begins with `head`."""
    layout = layout_of(head)
    titles, units = _with_units_of_cells(layout)
    rate, choice = sample_rate(choice, head, titles)
    if rate is not None:
        # No column of the file: it is counted below, and stands in for one here.
        titles, units = [*titles, "time"], [*units, *[""] * (len(titles) - len(units)), "s"]
    places = places_of(titles, units, choice)
    if rate is not None:
        places = replace(
            places, columns=(places.columns[1], *places.columns[1:]), signs=(1.0, *places.signs[1:])
        )
    rows = Rows(layout, places, CHUNK)
    channels = rows.read(text, in_memory)
    notes = [*places.notes, *rows.notes]
    if rate is not None:
        channels[0] = np.arange(len(channels[0])) / rate
        notes.append(f"no column of time: counted at {rate:g} samples a second")
    # Time is in seconds by now, and all count as they should.
    final = Places(places.columns, ("s", *places.units[1:]), notes=tuple(notes))
    return signals_from(channels, final, path, origin)


def _with_units_of_cells(layout: Layout) -> tuple[list[str], list[str]]:
    """Names and units of the columns, those that stand in the cells as well: ``1.5 mm``.

    Timestamps are in seconds whatever their names say.
    """
    titles = list(layout.titles)
    units = [*layout.units, *[""] * (len(titles) - len(layout.units))]
    for i, cell in enumerate(layout.first[: len(titles)]):
        if seconds_of(cell) is not None:
            titles[i], units[i] = channel_of(titles[i])[2], "s"
        units[i] = units[i] or unit_behind(cell)
    return titles, units


READER = reader_of_signals(
    "signals-csv",
    "CSV of displacement and force against time: time [s], displacement [mm], force [N]",
    recognises,
    signals,
)
