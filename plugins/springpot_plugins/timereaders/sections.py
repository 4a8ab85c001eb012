"""A text as sections: each a line of names, perhaps a line of units, and rows of numbers below."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from springpot.errors import DataError
from springpot.measurement import TEMPERATURE_UNITS, normal_unit
from springpot.rheology import Real

from ..readers.channels import channel_of
from ..readers.clock import seconds_of
from ..readers.grid import is_number
from ..readers.names import fold
from ..readers.signal_layout import labview_units
from ..readers.titles import heading, is_unit

SEPARATORS = ("\t", ";", ",", " ")
DYNAMIC = frozenset({"omega", "frequency", "storage", "loss", "phase", "loss_factor", "magnitude"})
"""Columns of a sweep, which may well list the time of each point."""
RELAXATION = frozenset(
    map(
        fold,
        (
            "relaxation",
            "relaxation modulus",
            "relaxation stiffness",
            "relaxation function",
            "G(t)",
            "E(t)",
            "Gt",
        ),
    )
)
COMPLIANCE = frozenset(
    map(
        fold,
        (
            *(
                "compliance",
                "creep compliance",
                "creep function",
                "J(t)",
                "D(t)",
                "kriechnachgiebigkeit",
            ),
            *(
                "complaisance",
                "complaisance de fluage",
                "recoverable compliance",
                "creep recovery compliance",
            ),
        ),
    )
)
_CHANNEL = re.compile(r"^(?:ch|channel|kanal|voie|canal)\s*\d+\s+", re.IGNORECASE)
_BRACKETED = re.compile(r"^(.*?)\s*[\[(]([^\[\]()]*)[\])]\s*$")
_AFTER = re.compile(r"^(.+?)(?:\s+/\s+|\s+in\s+)(\S+)$")
_UNITS_WITHIN = 3
"""Lines between names and numbers that may hold units or nothing."""
_SENTENCE = 60
"""Signs from which a line by itself is a sentence, and no name of a test."""
_LONGEST = 20_000
"""Signs beyond which a line names no columns."""
_TITLES = ("test", "result", "name", "sample", "step")


@dataclass(frozen=True)
class Title:
    """What a column is.

    Parameters
    ----------
    text : str
        As written.
    role : str
        ``time``, ``displacement``, ``force``, ``relaxation``, ``compliance``, ``temperature``,
        ``dynamic`` or empty.
    unit : str
        In the usual spelling; empty where none is written.
    sign : float
        Minus one for a channel that counts the other way.
    """

    text: str
    role: str
    unit: str
    sign: float = 1.0


@dataclass(frozen=True, eq=False)
class Section:
    """One table of a text.

    Parameters
    ----------
    name : str
        What the lines above it call it.
    titles : tuple of Title
        Its columns.
    numbers : sequence of int
        Line numbers of its rows.
    lines : sequence of str
        Its lines of numbers.
    separator : str
        Between cells.
    """

    name: str
    titles: tuple[Title, ...]
    numbers: Sequence[int]
    lines: Sequence[str]
    separator: str

    @property
    def roles(self) -> set[str]:
        """What there is."""
        return {title.role for title in self.titles} - {""}

    def column(self, place: int) -> Real:
        """The numbers of a column; nan where a cell is empty.

        Raises
        ------
        DataError
            If a cell is no number, with its line.
        """
        values = np.full(len(self.lines), np.nan)
        cells = [_cell(line, self.separator, place) for line in self.lines]
        began = None
        if cells:
            began = seconds_of(cells[0])
        for i, cell in enumerate(cells):
            if not cell:
                continue
            if began is not None and (now := seconds_of(cell)) is not None:
                # Counted from the first: seconds since a date would leave no digits for
                # milliseconds.
                values[i] = now - began
                continue
            try:
                values[i] = float(cell.replace(",", "."))
            except ValueError:
                where = f"line {self.numbers[i]}, column '{self.titles[place].text}'"
                raise DataError(f"{where}: '{cell:.30}' is no number") from None
        return self.titles[place].sign * values


def _cell(line: str, separator: str, place: int) -> str:
    cells = cells_of(line, separator)
    if place >= len(cells):
        # The row ends early.
        return ""
    return cells[place]


def sections_of(text: str) -> list[Section]:
    """All tables of a text that name a time and something that was measured."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    sections: list[Section] = []
    above: list[str] = []
    i = 0
    while i < len(lines):
        named = _named(lines, i)
        if named is None:
            above.append(lines[i])
            i += 1
            continue
        titles, start, separator = named
        stop = start
        while stop < len(lines) and _goes_on(lines, stop, separator, len(titles)):
            stop += 1
        numbers = range(start + 1, stop + 1)
        rows = [
            (number, line)
            for number, line in zip(numbers, lines[start:stop], strict=True)
            if line.strip()
        ]
        titles = _with_clock(titles, cells_of(lines[start], separator))
        titles = _with_units_above(titles, [cells_of(line, separator) for line in above])
        sections.append(
            Section(
                _name(above),
                titles,
                [number for number, _ in rows],
                [line for _, line in rows],
                separator,
            )
        )
        above, i = [], stop
    return sections


def _with_clock(titles: tuple[Title, ...], first: Sequence[str]) -> tuple[Title, ...]:
    """The columns, where timestamps are in seconds whatever stands above them."""
    timed = list(titles)
    for i, cell in enumerate(first[: len(titles)]):
        if timed[i].role == "time" and seconds_of(cell) is not None:
            timed[i] = replace(timed[i], unit="s")
    return tuple(timed)


def _with_units_above(titles: tuple[Title, ...], above: Sequence[list[str]]) -> tuple[Title, ...]:
    """The columns with the units that a LabVIEW header lists."""
    units = labview_units(above)
    if not units or any(title.unit for title in titles):
        return titles
    more = [""] * (len(titles) - len(units))
    return tuple(
        replace(title, unit=_tidied(unit))
        for title, unit in zip(titles, [*units, *more], strict=False)
    )


def cells_of(line: str, separator: str) -> list[str]:
    """The cells of a line, without quotes and blanks around them."""
    parts = line.split(separator)
    if separator == " ":
        # It stands for white space of any length.
        parts = line.split()
    return [part.strip().strip('"').strip() for part in parts]


def title_of(text: str, unit: str = "") -> Title:
    """Role and unit of a title, such as ``time [s]`` or ``Ch 1 Kraft`` above ``kN``."""
    bare = _CHANNEL.sub("", " ".join(text.lstrip("#% ").split()))
    stem, own_unit = apart(bare)
    named = heading(bare)
    for role, names in (("relaxation", RELAXATION), ("compliance", COMPLIANCE)):
        if fold(bare) in names:
            return Title(text, role, _tidied(unit))
        if fold(stem) in names or named.role == role:
            return Title(text, role, _tidied(unit or own_unit or named.unit or ""))
    channel, written, _ = channel_of(bare)
    if channel is not None:
        told = _tidied(unit or written or own_unit)
        # A letter stands for both, and the unit says which.
        if channel == "time" and told in TEMPERATURE_UNITS:
            channel = "temperature"
        return Title(text, channel, told)
    role = named.role or ""
    if role in DYNAMIC:
        return Title(text, "dynamic", _tidied(unit or own_unit))
    # In a table against time a strain is the displacement, by whatever name.
    known = {"amplitude": "displacement", "stress": "force", "torque": "force"}
    known |= {"temperature": "temperature", "time": "time"}
    return Title(text, known.get(role, ""), _tidied(unit or own_unit))


def apart(title: str) -> tuple[str, str]:
    """Name and unit of ``relaxation [kPa]``, ``Nachgiebigkeit / 1/Pa``, ``compliance in 1/Pa``."""
    match = _BRACKETED.match(title) or _AFTER.match(title)
    if not match or not match[1]:
        return title, ""
    return match[1], match[2].strip()


def _tidied(unit: str) -> str:
    """A unit in the usual spelling; nothing stays nothing, and is no pure number."""
    if not unit:
        return ""
    return normal_unit(unit)


def _named(lines: Sequence[str], i: int) -> tuple[tuple[Title, ...], int, str] | None:
    """Columns, place of the first row and separator, where line i names those of a test in time."""
    line = lines[i]
    # No line of names is as long; a file without line ends must not be searched as one.
    if not line.strip() or len(line) > _LONGEST:
        return None
    for separator in SEPARATORS:
        cells = cells_of(line, separator)
        # Channels may be called by the number of their transducer, but not most of them.
        if len(cells) < 2 or sum(map(is_number, cells)) > len(cells) // 3:
            continue
        roles = {title_of(cell).role for cell in cells} - {""}
        if "time" not in roles or len(roles) < 2:
            continue
        start, units = i + 1, [""] * len(cells)
        while (
            start < len(lines)
            and start <= i + _UNITS_WITHIN
            and not _is_row(lines[start], separator)
        ):
            below = cells_of(lines[start], separator)
            if any(is_unit(cell.strip("[]()")) for cell in below) and len(below) <= len(cells) + 1:
                units = [cell.strip("[]()").strip() for cell in below] + [""] * len(cells)
            start += 1
        if start < len(lines) and _is_row(lines[start], separator):
            return (
                tuple(title_of(cell, unit) for cell, unit in zip(cells, units, strict=False)),
                start,
                separator,
            )
    return None


def _is_row(line: str, separator: str) -> bool:
    cells = [cell for cell in cells_of(line, separator) if cell]
    return bool(cells) and sum(map(_countable, cells)) >= min(2, len(cells))


def _goes_on(lines: Sequence[str], i: int, separator: str, width: int) -> bool:
    """Whether line i belongs to a table: a row, a row with a slip, or a gap before another row."""
    if not lines[i].strip():
        return i + 1 < len(lines) and _is_row(lines[i + 1], separator)
    cells = cells_of(lines[i], separator)
    return _is_row(lines[i], separator) or (len(cells) == width and any(map(_countable, cells)))


def _countable(cell: str) -> bool:
    return is_number(cell) or cell.lower() in ("nan", "-nan", "inf", "-inf")


def _name(above: Sequence[str]) -> str:
    """What the lines above a table call it.

    The values of ``Test:`` and its like, or a line of one cell.
    """
    pairs = [[cell.strip() for cell in re.split(r"[\t;,]", line) if cell.strip()] for line in above]
    named = [
        cells[1] for cells in pairs if len(cells) == 2 and fold(cells[0].rstrip(":")) in _TITLES
    ]
    if named:
        # The nearest two: above them stand those of the whole file.
        return ", ".join(named[-2:]).strip("# ")
    alone = [
        cells[0]
        for cells in pairs
        if len(cells) == 1 and len(cells[0]) < _SENTENCE and not cells[0].startswith("[")
    ]
    if alone:
        return alone[-1].strip("# ")
    return ""
