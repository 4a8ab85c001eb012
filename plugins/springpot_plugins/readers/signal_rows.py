"""The numbers of a text of time signals, read in pieces, so that any size takes little memory."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from tempfile import TemporaryFile
from typing import IO

import numpy as np

from springpot.errors import DataError
from springpot.measurement import TIME_UNITS, normal_unit
from springpot.rheology import Real

from .channels import Places
from .cleaning import unit_behind
from .clock import seconds_of
from .grid import MISSING, is_number
from .signal_layout import Layout

_LETTERS = re.compile(r"[^\W\d_]{2}")


@dataclass
class Rows:
    """The rows of one file, and what was found on the way.

    Parameters
    ----------
    layout : Layout
        Where the numbers begin, and what separates them.
    places : Places
        Which columns are the channels.
    chunk : int
        Characters parsed at a time.
    notes : list of str
        What a user should know of the rows.
    """

    layout: Layout
    places: Places
    chunk: int
    notes: list[str] = field(default_factory=list)
    _ended: bool = False
    _start: float | None = None

    @property
    def _is_timed(self) -> bool:
        """Whether times are timestamps."""
        place = self.places.columns[0]
        first = self.layout.first
        return place < len(first) and seconds_of(first[place]) is not None

    def read(self, text: IO[str], in_memory: bool) -> list[Real]:
        """The three channels, time in seconds.

        Mapped from temporary files where they are not to be in memory.

        Raises
        ------
        DataError
            If there are no rows, or a cell is no number.
        """
        factors = np.array([TIME_UNITS[self.places.units[0]], 1.0, 1.0]) * self.places.signs
        pieces: list[Real] = []
        with TemporaryFile() as a, TemporaryFile() as b, TemporaryFile() as c:
            rows = 0
            for piece in self._pieces(text):
                rows += len(piece)
                if (factors != 1.0).any():
                    piece = piece * factors
                if in_memory:
                    pieces.append(piece)
                else:
                    for stream, column in zip((a, b, c), piece.T, strict=True):
                        column.tofile(stream)
            if not rows:
                raise DataError("there is a header but no row of numbers below it")
            if in_memory:
                return list(np.concatenate(pieces).T.copy())
            # The mapping outlives the closed file.
            return [np.memmap(stream, dtype=float, mode="r", shape=(rows,)) for stream in (a, b, c)]

    def _pieces(self, text: IO[str]) -> Iterator[Real]:
        """Rows (m, 3) below the names, piece by piece."""
        for _ in range(self.layout.start):
            text.readline()
        line = self.layout.start
        while not self._ended and (lines := text.readlines(self.chunk)):
            first, line = line + 1, line + len(lines)
            yield self._piece(lines, first)

    def _piece(self, lines: list[str], first: int) -> Real:
        filled = [raw for raw in lines if not raw.isspace()]
        if not filled:
            return np.empty((0, 3))
        if not self._is_timed:
            delimiter: str | None = self.layout.separator
            if delimiter != ",":
                filled = [raw.replace(",", ".") for raw in filled]
            if delimiter == " ":
                # As numpy says: white space of any length.
                delimiter = None
            places = list(self.places.columns)
            try:
                values: Real = np.loadtxt(
                    filled,
                    delimiter=delimiter,
                    usecols=places,
                    ndmin=2,
                    comments="#",
                    quotechar='"',
                )
                return values
            except ValueError:
                # Something is missing or misspelt: go slowly and say where.
                pass
        return self._slowly(lines, first)

    def _slowly(self, lines: list[str], first: int) -> Real:
        """Row by row, to the end of the table: a line of words, such as names of the next one."""
        rows = []
        for number, raw in enumerate(lines, first):
            if not raw.strip() or raw.lstrip().startswith("#"):
                continue
            cells = self._cells(raw)
            if self._is_behind(cells, raw):
                self._ended = True
                self.notes.append(f"the table ends above line {number}; what follows is left out")
                break
            rows.append(
                [
                    self._number(cells[i], i, place, number)
                    for i, place in enumerate(self.places.columns)
                ]
            )
        return np.array(rows, dtype=float).reshape(-1, 3)

    def _cells(self, raw: str) -> list[str]:
        """The cells of the three channels; empty where the row has none."""
        bare = raw.rstrip("\r\n")
        parts = bare.split(self.layout.separator)
        if self.layout.separator == " ":
            parts = bare.split()
        cells = [cell.strip().strip('"') for cell in parts]
        cells += [""] * (max(self.places.columns) + 1 - len(cells))
        channels = zip(self.places.columns, self.places.units, strict=True)
        return [_bare(cells[place], unit) for place, unit in channels]

    def _is_behind(self, cells: list[str], raw: str) -> bool:
        """Whether a line is of words: no time in it, at most one number where the channels are."""
        numbers = [is_number(cell) or seconds_of(cell) is not None for cell in cells]
        # "nan" is no word, and a slip in one cell is an error rather than the end of the table.
        return (
            not numbers[0]
            and sum(numbers) < 2
            and bool(_LETTERS.search(re.sub("nan", "", raw, flags=re.I)))
        )

    def _number(self, cell: str, channel: int, place: int, number: int) -> float:
        if cell in MISSING:
            return np.nan
        if channel == 0 and self._is_timed and (moment := seconds_of(cell)) is not None:
            # Counted from the first of the file, whatever piece it is in: else no digits are left
            # for milliseconds.
            if self._start is None:
                self._start = moment
            return moment - self._start
        plain = cell
        if self.layout.separator != ",":
            plain = cell.replace(",", ".")
        try:
            return float(plain)
        except ValueError:
            raise DataError(
                f"line {number}, column '{self.layout.titles[place]}': '{cell:.30}' is no number"
            ) from None


def _bare(cell: str, unit: str) -> str:
    """A cell without the unit of its column, which may stand behind each number: ``1.5 mm``."""
    behind = unit_behind(cell)
    return cell.removesuffix(behind).rstrip() if normal_unit(behind) == unit else cell
