"""Blocks: the tables within a file, each with its names, its units and the lines above it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from springpot.errors import DataError
from springpot.measurement import FORCE_UNITS, LENGTH_UNITS, MOST_TABLES, normal_unit

from .cleaning import unit_behind, with_pairs_apart
from .grid import COMMENT, MISSING, Grid, holds_number
from .headings import beside, headings_of, is_remark, named_above, uncommented, units_in, unquoted
from .names import FREQUENCIES, MODULI, names_a_modulus
from .titles import SWEEPS, Heading, Vocabulary, is_dynamic

_UNITS_WITHIN = 3
"""Lines between names and numbers that may hold units or remarks."""
_STACKED = 2
"""Lines between two tables of the same names."""
FREQUENCY = "frequency [Hz] or omega [rad/s]"
ANGLE = "phase [deg] or loss_factor [-]"
"""What a table lacks: of these the second makes a complex modulus of its size."""
SINGLE_AMPLITUDE = "amplitude [mm] of the displacement"
WIDEST = 500
"""Cells of a line in which names are sought."""
_KEPT = 1000
"""Lines of numbers without names that are kept above a table: what is said of it stands nearer."""
_NEAR, _SENTENCE = 4, 80
"""Lines above a table in which its name is sought, and signs from which such a line is a sentence.
"""
_DRIVEN = frozenset({"amplitude", "stress", "torque", "displacement"})
"""What is set or followed in a test in time."""
_COUNT = re.compile(r"\s*\d+\s*")
"""The number of a sensor, which has no decimals."""
_PATIENCE = 50_000
"""Cells without any number that are tried as names of columns before giving up."""


@dataclass(frozen=True, eq=False)
class Block:
    """One table of a file: a step, an interval, a sweep or a sheet.

    Parameters
    ----------
    name : str
        As the file calls it.
    headings : tuple of Heading
        What the columns are.
    rows : sequence of sequence of str
        The cells.
    lines : sequence of int
        Line number of each row.
    above : list of list of str
        The lines above the table, as cells.
    constants : mapping of str to str
        What holds for all rows: ``temperature [degC]`` and its value.
    words : Vocabulary
        What its titles mean.
    """

    name: str
    headings: tuple[Heading, ...]
    rows: Sequence[Sequence[str]]
    lines: Sequence[int]
    above: list[list[str]] = field(default_factory=list)
    constants: Mapping[str, str] = field(default_factory=dict)
    words: Vocabulary = SWEEPS

    @cached_property
    def roles(self) -> set[str]:
        """What there is; a column without any value is not there."""
        # Backwards, so that of several columns of one role the first remains.
        named = {each.role: i for i, each in reversed(list(enumerate(self.headings))) if each.role}
        filled = {
            str(role) for role, i in named.items() if not self.rows or self._is_filled(i, str(role))
        }
        return filled | {str(self.words.heading(title).role) for title in self.constants}

    def _is_filled(self, place: int, role: str) -> bool:
        """Whether this column, or another of its role, has a value in any row."""
        places = [i for i, each in enumerate(self.headings) if i == place or each.role == role]
        return any(row[i].strip() not in MISSING for i in places for row in self.rows)

    @property
    def untitled(self) -> list[int]:
        """The numbers, from 1, of columns without a title that hold numbers."""
        places = [i for i, each in enumerate(self.headings) if not each.title]
        return [i + 1 for i in places if any(holds_number(row[i]) for row in self.rows)]

    @property
    def is_dynamic(self) -> bool:
        """Whether there are a frequency and a complex modulus."""
        return is_dynamic(self.roles)

    @property
    def is_steady(self) -> bool:
        """Whether it is a flow curve or the characteristic of a damper, over speeds alone."""
        if self.roles & FREQUENCIES:
            return False
        units = {normal_unit(each.unit or "") for each in self.headings}
        by_speed = units & {f"{unit}/s" for unit in LENGTH_UNITS} and units & set(FORCE_UNITS)
        return "flow" in self.roles or (bool(by_speed) and "time" not in self.roles)

    def lacks(self) -> str:
        """What a table that is no dynamic test holds instead, in one line."""
        roles = self.roles
        if "shift" in roles:
            return "shift factors, no measurement"
        if "relaxation" in roles:
            return "a relaxation test in time, no dynamic test"
        if "compliance" in roles:
            return "creep in time, no dynamic test"
        if self.is_steady:
            if "flow" in roles:
                return "steady flow, no dynamic test; give a sweep, a creep or a relaxation of it"
            return (
                "force over velocity, as of the peaks of many strokes: no dynamic test; give the"
                " strokes themselves, force and displacement over time"
            )
        if "time" in roles and roles & _DRIVEN and not roles & {*FREQUENCIES, *MODULI}:
            return "a test in time, such as creep or a rest, no dynamic test"
        # A frequency in the titles of the columns does not lack: their parts are told apart by it.
        return lacking(roles | {each.curve.role for each in self.headings if each.curve})

    def holds(self) -> str:
        """The first titles, for errors."""
        titles = [heading.title for heading in self.headings if heading.title][:6]
        return f"found {', '.join(titles) or 'no names'}; {self.lacks()}"


def lacking(roles: set[str]) -> str:
    """What columns of these roles need to be a dynamic test."""
    if is_dynamic({*roles, "omega"}):
        return f"missing {FREQUENCY}"
    missing = []
    if not roles & FREQUENCIES:
        missing.append(FREQUENCY)
    if (
        "force_amplitude" in roles
        and roles & {"phase", "loss_factor"}
        and not roles & {*MODULI, "amplitude"}
    ):
        return f"missing {' and '.join([*missing, SINGLE_AMPLITUDE])}"
    angles = {"phase", "loss_factor", "damping_ratio", "damping"}
    if not roles & {"storage", "magnitude", "loss", "viscosity"} and roles & angles:
        missing.append("storage [unit] or magnitude [unit]")
    elif not roles & MODULI:
        missing.append("storage [unit] and loss [unit]")
    elif "loss" in roles:
        missing.append("storage [unit]")
    elif roles & {"magnitude", "viscosity"} and "storage" not in roles:
        # The size alone is neither part of the modulus; only the angle parts it.
        missing.append(ANGLE)
    else:
        missing.append("loss [unit], phase [deg] or loss_factor [-]")
    return f"missing {', and '.join(missing)}"


def blocks_of(
    grid: Grid, strict: bool = False, stacked: bool = False, words: Vocabulary = SWEEPS
) -> tuple[list[Block], list[list[str]]]:
    """The tables in a grid, and the lines below the last one.

    Parameters
    ----------
    grid : Grid
        The file.
    strict : bool
        Whether rows must be as long as the names above them, and nothing may follow a table but
        another.
    stacked : bool
        Whether rows below a line of one cell, such as ``T = 40 °C``, go on under the names of the
        table before.
    words : Vocabulary
        What the titles mean.

    Raises
    ------
    DataError
        If a row has more cells than there are names.
    """
    blocks: list[Block] = []
    above: list[list[str]] = []
    i, rows, tried = 0, grid.rows, 0
    while i < len(rows):
        require_tables(len(blocks))
        worded = _is_worded(rows[i])
        start = None
        if worded:
            tried += len(rows[i])
            # Each trial looks up every cell as a name: a long text without a table must end soon.
            if tried < _PATIENCE and is_header(rows[i], words):
                start = _first_row(rows, i, words)
        if start is None and stacked and _goes_on(blocks, rows, i, above):
            stop = _last_row(rows, i, rows[i])
            width = len(blocks[-1].headings)
            cells = _rectangle(rows[i:stop], grid.lines[i:stop], width, strict)
            name = _name(above)
            blocks.append(
                replace(blocks[-1], name=name, rows=cells, lines=grid.lines[i:stop], above=above)
            )
            above, i, tried = [], stop, 0
            continue
        if start is None:
            # Remarks above a table are kept, numbers without names beyond some are of no further
            # use.
            most = _KEPT
            if worded:
                most = _PATIENCE
            if len(above) < most:
                above.append([cell.strip() for cell in rows[i]])
            i += 1
            continue
        stop = _last_row(rows, start, rows[i])
        names, between = beside(rows[i], rows[i + 1 : start], rows[start:stop])
        headings = headings_of(names, between, len(rows[start]), words)
        if above:
            headings = named_above(headings, above[-1], words)
        above += [[cell.strip() for cell in row] for row in between if is_remark(row)]
        cells = _rectangle(rows[start:stop], grid.lines[start:stop], len(headings), strict)
        headings, cells = with_pairs_apart(headings, cells)
        lines = grid.lines[start:stop]
        blocks.append(Block(_name(above), headings, cells, lines, above, words=words))
        above, i, tried = [], stop, 0
    return blocks, above


def require_tables(count: int) -> None:
    """Refuse more tables below one another than anybody chooses from.

    Raises
    ------
    DataError
        With what to do.
    """
    if count > MOST_TABLES:
        raise DataError(
            f"more than {MOST_TABLES} tables below one another; save those that matter alone"
        )


def _goes_on(
    blocks: Sequence[Block], rows: Sequence[Sequence[str]], i: int, above: Sequence[list[str]]
) -> bool:
    """Whether a row of numbers belongs to the names of the last table.

    One or two lines of words may stand between, such as a temperature or the head of a page.
    """
    return (
        bool(blocks)
        and 0 < len(above) <= _STACKED
        and not any(map(is_data, above))
        and is_data(rows[i])
        and len(rows[i]) == len(blocks[-1].rows[0])
        and not rows[i][0].strip().startswith(COMMENT)
    )


def is_header(row: Sequence[str], words: Vocabulary = SWEEPS) -> bool:
    """Whether a row names columns: at least two roles and no number."""
    if len(row) < 2 or not _is_worded(row):
        return False
    headings = [words.heading(unquoted(cell.strip())) for cell in uncommented(row)[:WIDEST]]
    roles = {each.role for each in headings if each.role}
    if any(each.unit is not None and names_a_modulus(each.name) for each in headings):
        roles.add("modulus")
    # A table of several curves may have but the frequency in common: G'_A, G''_A, G'_B, G''_B.
    return len(roles) > 1 or len({words.plainly(each).role for each in headings} - {None}) > 2


def _is_worded(row: Sequence[str]) -> bool:
    """Whether a row holds words and no number; a sensor may be called by that of its kind."""
    numbers = [cell for cell in row[:WIDEST] if holds_number(cell)]
    return not numbers or (len(numbers) <= len(row) // 3 and all(map(_COUNT.fullmatch, numbers)))


def is_data(row: Sequence[str]) -> bool:
    """Whether a row holds numbers, rather than a key and its value."""
    numbers = sum(1 for cell in row if holds_number(cell))
    if numbers < 2 and not (numbers == 1 and len(row) == 1):
        return False
    # More words than numbers are a line of a report.
    words = sum(1 for cell in row if cell.strip() not in MISSING) - numbers
    return words <= numbers


def _with_units(row: Sequence[str]) -> bool:
    """Whether all cells are numbers with their units, ``1.5 mm``, or without any."""
    filled = [cell for cell in row if cell.strip() not in MISSING]
    return len(filled) > 1 and all(holds_number(cell) or unit_behind(cell) for cell in filled)


def _first_row(rows: Sequence[Sequence[str]], i: int, words: Vocabulary) -> int | None:
    for j in range(i + 1, min(i + 2 + _UNITS_WITHIN, len(rows))):
        measured = is_data(rows[j]) or _with_units(rows[j])
        if measured and not rows[j][0].strip().startswith(COMMENT):
            return j
        if is_header(rows[j], words) and not units_in(rows[j]):
            return None
    return None


def _last_row(rows: Sequence[Sequence[str]], start: int, names: Sequence[str]) -> int:
    """Behind the last row of a table: rows of one width whose first number is one go quickly."""
    width = len(rows[start])
    key = next((k for k, cell in enumerate(rows[start]) if holds_number(cell)), 0)
    for j in range(start + 1, len(rows)):
        row = rows[j]
        # Nearly all rows go by this quick test; those that it does not know are looked at closely.
        if len(row) == width and row[0][-1:] != ":" and _is_plain(row[key]):
            continue
        if (is_data(row) or _with_units(row)) and not _ends(row):
            continue
        if (
            len(row) == width
            and width > 1
            and any(holds_number(cell) for cell in row)
            # Words where the numbers began are a line of a report, such as the head of a page.
            and (holds_number(row[key]) or row[key].strip() in MISSING)
            and not _ends(row)
        ):
            continue
        return j
    return len(rows)


def _is_plain(cell: str) -> bool:
    """Whether a cell is a number to Python: quicker than to match all ways of writing one."""
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True


def _ends(row: Sequence[str]) -> bool:
    """Whether a row with numbers is a line above the next table, such as ``Interval:  2  17``."""
    return row[0].strip().endswith(":") or row[0].strip().startswith((*COMMENT, "["))


def _rectangle(
    rows: Sequence[list[str]], lines: Sequence[int], width: int, strict: bool
) -> Sequence[list[str]]:
    """The rows, all of one width."""
    if set(map(len, rows)) == {width}:
        return rows
    made = []
    for row, number in zip(rows, lines, strict=True):
        if len(row) > width and any(cell.strip() for cell in row[width:]):
            raise DataError(f"line {number}: {len(row)} cells where the header has {width}")
        if strict and len(row) < width - 1:
            raise DataError(f"line {number}: {len(row)} cells where the header has {width}")
        made.append([*row[:width], *[""] * (width - len(row))])
    return made


def _name(above: list[list[str]]) -> str:
    """What the lines above a table call it."""
    for row in reversed(above[-_NEAR:]):
        filled = [cell for cell in row if cell]
        if len(filled) != 1:
            continue
        # Brackets open a section of a report, a colon waits for a value, a tab in a cell has one,
        # and asterisks frame what a program says to itself.
        is_name = not filled[0].startswith("[") and not filled[0].endswith(":")
        is_name = is_name and "\t" not in filled[0] and not filled[0][0] == filled[0][-1] == "*"
        if is_name and len(filled[0]) < _SENTENCE:
            return filled[0].lstrip("#% ")
    return ""
