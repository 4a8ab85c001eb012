"""Time signals as delimited text: columns of time, displacement and force, read in pieces.

Names are ``time [s]``, ``displacement [mm]``, ``force [N]``, or joined as ``t_s``, ``disp_mm``, ``force_N``, or
have their units in the row below; a test report may stand above them. Strain and stress, angle and torque serve as
well, and names in other languages.
Other columns are left alone; a unit that is missing is said by ``FILE?force=kN``. A file of any size takes little
memory: its numbers go to a temporary file that is mapped, and all that follows works block by block.
"""

from __future__ import annotations

from pathlib import Path

from springpot.errors import DataError
from springpot.measurement import Choice, Measurement, Reader, Signals, measurement_from_signals

from .blocks import is_dynamic
from .channels import UNITS, Places, channel_of, found_in, places_of, signals_from
from .clock import seconds_of
from .signal_layout import Layout, layout_of
from .signal_rows import Rows
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
    named = found_in(titles)
    if len(named) == len(UNITS):
        return 0.95
    if "time" in named and len(named) == 2:
        return 0.3
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
        layout = layout_of(head_text(head))
        titles, units = _with_clock(layout)
        places = places_of(titles, units, choice)
        rows = Rows(layout, places, CHUNK)
        with path.open(encoding=encoding, newline=None) as text:
            channels = rows.read(text, path.stat().st_size <= IN_MEMORY)
    except UnicodeDecodeError as error:
        raise DataError(f"byte {error.start} is no {error.encoding} text; save it as CSV in UTF-8") from None
    except OSError as error:
        raise DataError(f"cannot be read: {error.strerror or error}") from None
    # Time is in seconds by now, and all count as they should.
    final = Places(places.columns, ("s", *places.units[1:]), notes=(*places.notes, *rows.notes))
    return signals_from(channels, final, path, "text")


def _with_clock(layout: Layout) -> tuple[list[str], list[str]]:
    """Names and units of the columns, where those of timestamps are in seconds whatever their names say."""
    titles = list(layout.titles)
    units = [*layout.units, *[""] * (len(titles) - len(layout.units))]
    for i, cell in enumerate(layout.first[: len(titles)]):
        if seconds_of(cell) is not None:
            titles[i], units[i] = channel_of(titles[i])[2], "s"
    return titles, units


def read(path: Path, choice: Choice) -> Measurement:
    """The measurement of one row that the signals give."""
    return measurement_from_signals([signals(path, choice)])


READER = Reader(
    "signals-csv",
    "CSV of displacement and force against time: time [s], displacement [mm], force [N]",
    recognises,
    read,
    signals=signals,
)
