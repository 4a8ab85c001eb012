"""RepTate .laos: ``omega=0.3;gamma=3.16;`` in the first line, then time, strain and stress."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from springpot.errors import DataError
from springpot.measurement import Choice, Signals

from .channels import channel_of, found_in, places_of, reader_of_signals, signals_from
from .grid import MISSING
from .reptate import CLOCKS, first_line, table_of
from .text import head_text, text_of
from .titles import is_unit

_FORMAT = ("time [s]", "strain [-]", "stress [Pa]")
"""What the columns are by the definition of the format."""


def recognises(head: bytes) -> float:
    """High for a first line with a frequency."""
    header = first_line(head_text(head[:8000]))
    if not header.keys() & CLOCKS:
        return 0.0
    return 0.96


def signals(path: Path, choice: Choice) -> Signals:
    """The signals in a file.

    Raises
    ------
    DataError
        If there are no three columns of numbers.
    """
    rows, lines, above = table_of(text_of(path))
    named = [[cells[0].lstrip("#% "), *cells[1:]] for cells in above]
    titles = next((cells for cells in named if len(found_in(cells)) == 3), list(_FORMAT))
    units = next((cells for cells in named if sum(map(is_unit, cells)) >= 3), [])
    if not units:
        titles = list(map(_with_unit, titles))
    places = places_of(titles, units, choice)
    width = max(places.columns) + 1
    values = []
    for row, line in zip(rows, lines, strict=True):
        padded = [*row, *[""] * width]
        try:
            values.append([_number(padded[i].strip()) for i in places.columns])
        except ValueError:
            raise DataError(f"line {line}: no number in its first {width} columns") from None
    return signals_from(list(np.array(values, dtype=float).T), places, path, "RepTate LAOS")


def _number(cell: str) -> float:
    if cell in MISSING:
        return np.nan
    return float(cell.replace(",", "."))


def _with_unit(title: str) -> str:
    """A name without a unit has that of the format."""
    channel, unit, _ = channel_of(title)
    if unit:
        return title
    return next((known for known in _FORMAT if channel_of(known)[0] == channel), title)


READER = reader_of_signals(
    "reptate-laos",
    "RepTate .laos: strain and stress against time",
    recognises,
    signals,
)
