"""Time signals as delimited text: columns of time, displacement and force, read in pieces.

Names are ``time [s]``, ``displacement [mm]``, ``force [N]``, or joined as ``t_s``, ``disp_mm``,
``force_N``, or have their units in the row below; a test report may stand above them. Strain and
stress, angle and torque serve as well, and names in other languages, and times of day and
timestamps with a date, as data loggers write them. Other columns are left alone; a unit that is
missing is said by ``FILE?force=kN``. A file of any size takes little memory: its numbers go to a
temporary file that is mapped, and all that follows works block by block.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO

import numpy as np

from springpot.errors import DataError
from springpot.measurement import TIME_UNITS, Choice, Signals, normal_unit
from springpot.rheology import Real

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
from .grid import (
    MISSING,
    SEARCHED,
    SEPARATORS,
    encoding_of,
    head_text,
    is_number,
    lines_of,
    separator_in,
    split_line,
)
from .headings import uncommented, unquoted
from .titles import heading, is_dynamic, is_unit

_TIME = r"(\d{1,2}):(\d{2})(?::(\d{2})(?:[.,](\d+))?)?\s*([AaPp][Mm])?"
_DATE = r"(\d{1,4})[-./](\d{1,2})[-./](\d{1,4})"
_DATED = re.compile(rf"\s*{_DATE}[T\s,]+{_TIME}\s*(?:Z|[+-]\d{{2}}:?\d{{2}})?\s*\Z")
_OF_DAY = re.compile(rf"\s*{_TIME}\s*\Z")


_RATE = re.compile(
    r"(?:sampl\w*[ _-]?(?:rate|freq\w*)|abtast(?:rate|frequenz)|messrate"
    r"|fréquence d.échantillonnage)"
    r"[\s:;,=\t\"]{1,8}(?:[\[(](?P<before>k?Hz)[\])][\s:;,=\t]*)?"
    r"(?P<number>\d+(?:[.,]\d+)?)[\s;,\t\"]*(?P<unit>k?Hz|1/s|S/s)?",
    re.IGNORECASE,
)
"""A line of a header such as ``Sample rate: 400 Hz`` or ``Abtastrate [Hz];400``."""
_SAID = re.compile(r"(\d+(?:\.\d+)?(?:[eE][-+]?\d+)?)\s*\[?\s*(k?Hz|1/s|)\s*\]?\Z")
RATE = "rate"
"""What a user says of signals without a column of time: ``FILE?rate=400[Hz]``."""


def sample_rate(choice: Choice, head: str, titles: Sequence[str]) -> tuple[float | None, Choice]:
    """Samples a second where time is counted by them, and the choice without what it says of them.

    Parameters
    ----------
    choice : Choice
        What the user says.
    head : str
        The beginning of the file.
    titles : sequence of str
        Names of the columns.

    Raises
    ------
    DataError
        If what the user says is no rate.
    """
    said = choice.columns.get(RATE)
    if said is not None:
        match = _SAID.match(said)
        if match is None or not float(match[1]) > 0:
            raise DataError(f"'{said:.20}' is no sample rate; write 'FILE?{RATE}=400[Hz]'")
        others = {name: meaning for name, meaning in choice.columns.items() if name != RATE}
        return _hertz(match[1], match[2]), replace(choice, columns=others)
    named = found_in(titles)
    if choice.columns or "time" in named or not named >= {"displacement", "force"}:
        return None, choice
    stated = _RATE.search(head)
    unit = ""
    if stated is not None:
        unit = stated["before"] or stated["unit"] or ""
    if stated is None or not unit or not float(stated["number"].replace(",", ".")) > 0:
        return None, choice
    return _hertz(stated["number"], unit), choice


def _hertz(number: str, unit: str) -> float:
    rate = float(number.replace(",", "."))
    if unit.casefold().startswith("k"):
        return 1000.0 * rate
    return rate


def seconds_of(cell: str) -> float | None:
    """Seconds of a timestamp since some moment that is the same for all of one style.

    None for what is no timestamp.

    Examples
    --------
    >>> seconds_of("01.09.2014 13:25:39,5") - seconds_of("01.09.2014 13:25:38")
    1.5
    """
    if match := _OF_DAY.match(cell):
        return _of_day(*match.groups())
    match = _DATED.match(cell)
    if match is None:
        return None
    day = _day(match[1], match[2], match[3])
    if day is None:
        return None
    return day * 86400.0 + _of_day(*match.groups()[3:])


@lru_cache(maxsize=64)
def _day(first: str, second: str, third: str) -> int | None:
    """Number of the day.

    Year first, or else last with the month in the middle unless it can be none.
    """
    year, month, day = int(third), int(second), int(first)
    if len(first) == 4:
        year, day = int(first), int(third)
    if month > 12:
        # Written the American way; a date that may be either is read as the rest of the world
        # writes it.
        month, day = day, month
    if year < 100:
        # Two digits are of this century: only differences are used, but there is no year 0.
        year += 2000
    try:
        return datetime(year, month, day).toordinal()
    except ValueError:
        return None


def _of_day(
    hour: str, minute: str, second: str | None, fraction: str | None, half: str | None
) -> float:
    hours = int(hour)
    if half:
        # 12 am is midnight, and 12 pm is noon.
        hours %= 12
        if half.lower() == "pm":
            hours += 12
    return hours * 3600.0 + int(minute) * 60.0 + float(f"{second or 0}.{fraction or 0}")


_WORDS = re.compile(r"[^\W\d_eE]")
"""What no row of numbers has."""
MOST_UNITS = 0.6
"""Share of the cells of a row of units that are known ones."""
_LABVIEW = "Y_Unit_Label"
"""Before the units in a LabVIEW measurement file (.lvm), with columns X_Value and so on."""


@dataclass(frozen=True)
class Layout:
    """How a table of signals is laid out.

    Parameters
    ----------
    separator : str
        Between cells; a space for any white space.
    titles : list of str
        Names of the columns; empty where there is no table.
    units : list of str
        Of a row below the names; empty where there is none.
    start : int
        Lines above the first row of numbers.
    first : sequence of str
        The cells of that row.
    """

    separator: str
    titles: list[str]
    units: list[str]
    start: int
    first: Sequence[str] = ()


def layout_of(head: str) -> Layout:
    """The layout of the file that begins with `head`.

    Below names of all channels, or else of the first numbers.
    """
    lines = lines_of(head)[:SEARCHED]
    # A report above the table may have more of another sign: then any sign that shows all three
    # names will do.
    surest = separator_in([line for line in lines if line.strip()])
    worded = [i for i, line in enumerate(lines) if _WORDS.search(line)]
    for separator in dict.fromkeys((surest, *SEPARATORS)):
        named = next((i for i in worded if _names_all(_cells(lines[i], separator))), None)
        if named is not None:
            return _named(
                [_cells(line, separator) for line in lines[: named + 3]], named, separator
            )
    return _unnamed([_cells(line, surest) for line in lines], surest)


def _named(rows: Sequence[list[str]], named: int, separator: str) -> Layout:
    units: list[str] = []
    start = named + 1
    if start < len(rows) and _are_units(rows[start]):
        units = rows[start]
        start += 1
    first = next(iter(rows[start:]), ())
    return Layout(separator, rows[named], units or labview_units(rows[:named]), start, first)


def labview_units(above: Sequence[list[str]]) -> list[str]:
    """Units from a LabVIEW header, whose line has those of the channels; its time is in seconds."""
    named = next((row for row in above if row and row[0] == _LABVIEW), None)
    if named is None:
        return []
    return ["s", *named[1:]]


def _names_all(row: Sequence[str]) -> bool:
    # Sensors may be called by a number of their own, which has no decimals.
    return len(found_in(row)) == len(UNITS) and all(
        cell.isdigit() for cell in row if is_number(cell)
    )


def _unnamed(rows: Sequence[list[str]], separator: str) -> Layout:
    """The first row of numbers, with what stands above it as names."""
    start = next((i for i, row in enumerate(rows) if sum(map(is_number, row)) > 1), None)
    if start is None:
        return Layout(separator, [], [], 0)
    # Names and units: what is higher up, or too narrow, is a report.
    above = [row for row in rows[max(0, start - 2) : start] if len(row) >= len(rows[start])]
    units: list[str] = []
    if above and _are_units(above[-1]):
        units = above.pop()
    names = [str(i) for i in range(1, len(rows[start]) + 1)]
    if above:
        names = above[-1]
    return Layout(separator, names, units, start, rows[start])


def _cells(line: str, separator: str) -> list[str]:
    if separator == " ":
        # Names with their units in brackets hang together, and so do words that one blank
        # separates.
        line = re.sub(r"(?<!\s)\s+(?=[\[(])", "", line.strip())
        cells = [cell for cell in re.split(r"\s{2,}|\t", line) if cell]
        if len(cells) <= 2:
            # Time, displacement and force are three: so each blank separates.
            cells = line.split()
        return uncommented(cells)
    return uncommented([unquoted(cell.strip()) for cell in split_line(line, separator)])


def _are_units(row: Sequence[str]) -> bool:
    filled = [cell.strip("[]() ") for cell in row if cell.strip()]
    # A channel that is none of the three may have a unit of its own, such as the day of a date.
    known = sum(1 for cell in filled if is_unit(cell))
    return known >= max(1, MOST_UNITS * len(filled)) and not any(map(is_number, filled))


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
