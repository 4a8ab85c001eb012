"""Any table of a frequency and a complex modulus, with any separator and in any language.

Units stand in brackets, after `` / ``, a comma or an underscore, or in a row of their own; decimals
have a point or, where commas do not separate cells, a comma. What a file leaves open is asked for:
``FILE?frequency=Hz,storage=MPa``. Columns without names are named by number:
``FILE?1=omega[rad/s],2=storage[Pa],3=loss[Pa]``.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.measurement import Choice, Measurement, OpenQuestion, Part, Reader
from springpot.measurement.instrument import is_even

from .above import facts_of, pairs_in, with_conditions_above
from .blocks import Block, blocks_of, is_data, is_header, lacking
from .channels import UNITS as CHANNELS, found_in
from .choices import (
    CLOCK,
    FIRST_COLUMNS,
    LOOP,
    all_called,
    ask_clock,
    ask_columns,
    ask_each,
    numbered,
    unknown_in,
    with_choice,
)
from .cleaning import with_pairs_apart
from .dynamic import columns_of, measurement_from, parts_from
from .grid import (
    COMMENT,
    MISSING,
    Grid,
    grid_of,
    head_grid,
    head_text,
    holds_number,
    is_number,
    text_of,
)
from .headings import headings_of, units_in
from .names import FREQUENCIES, MODULI
from .proposals import proposal
from .rearranged import needs_rearranging, rearranged
from .side_by_side import apart
from .signals_csv import READER as RECORD
from .titles import SWEEPS, Heading, Vocabulary, is_dynamic
from .values_in_rows import upright

_REARRANGED = 0.5
"""Confidence in a table whose quantities stand below each other."""
_BACK = 0.2
"""Share of the steps of a displacement that at least go either way."""
_LOOKED_AT = 10
"""Rows below the names that tell whether a column holds complex numbers."""


def recognises(head: bytes) -> float:
    """High for a frequency and a modulus with units, low for any other table."""
    grid = head_grid(head_text(head))
    best = 0.0
    if any(is_data(row) for row in grid.rows[:50]):
        # Numbers without names: a user may still say what they are.
        best = 0.1
    for i, row in enumerate(grid.rows[:100]):
        if is_header(row):
            below = grid.rows[i + 1 : i + 3]
            width = max(map(len, [row, *below[:1]]))
            headings = headings_of(row, below, width)
            rows = [
                each for each in grid.rows[i + 1 : i + 1 + _LOOKED_AT] if len(each) == len(headings)
            ]
            best = max(best, _confidence(with_pairs_apart(headings, rows)[0]))
    if best < _REARRANGED and _is_rearranged(grid):
        best = _REARRANGED
    return best


def _is_rearranged(grid: Grid) -> bool:
    """Whether storage and loss, which are known, stand below each other."""
    try:
        return rearranged(grid, Choice()) is not None
    except DataError:
        # What it leaves open is told when it is read.
        return True


def _confidence(headings: Sequence[Heading]) -> float:
    """Below that of the readers of one maker's format, which know more of such a file."""
    named = [heading for heading in headings if heading.role]
    roles = {str(heading.role) for heading in named}
    # A unit makes it likely that the names mean what they say; without any, other readers may know
    # better.
    if is_dynamic(roles) and any(heading.unit for heading in named):
        return 0.8
    if is_dynamic(roles):
        return 0.55
    if roles & FREQUENCIES or roles & MODULI:
        return 0.3
    return 0.2


def read(path: Path, choice: Choice) -> Measurement:
    """The measurement in a file.

    Raises
    ------
    DataError
        One line that says what was recognised and what is missing.
    """
    if _names_channels(choice):
        return RECORD.read(path, choice)
    grid = grid_of(text_of(path))
    blocks, pairs, notes = _blocks(grid, choice)
    return measurement_from(blocks, choice, path, {**facts_of(pairs), **notes}, further=True)


def _names_channels(choice: Choice) -> bool:
    """Whether the user says which columns are time, displacement and force: it is a record then."""
    return found_in(list(choice.columns.values())) >= {*CHANNELS}


def parts(path: Path) -> tuple[Part, ...]:
    """The tables in a file, where there are several."""
    grid = grid_of(text_of(path))
    blocks, _ = blocks_of(grid, stacked=True)
    if needs_rearranging(grid, blocks) and _is_rearranged(grid):
        # Its tables are parts of one, and none of them opens by itself.
        return ()
    return parts_from(with_conditions_above(apart(blocks)))


def _blocks(
    grid: Grid, choice: Choice
) -> tuple[list[Block], list[tuple[str, str]], dict[str, str]]:
    """The tables of a file, what it says above them, and notes on how they were read."""
    notes: dict[str, str] = {}
    if not choice.part and needs_rearranging(grid, blocks_of(grid, stacked=True)[0]):
        found = rearranged(grid, choice)
        if found is not None:
            grid, notes = found[0], {"note layout": found[1]}
    # Strict: of a file that no maker's reader knows, a row of another length may be anything.
    blocks, below = blocks_of(grid, strict=True, stacked=True)
    if not blocks and (turned := upright(grid)) is not None:
        blocks, below = blocks_of(turned, strict=True)
    if not blocks:
        return apart([numbers_said(grid, choice)], choice), [], notes
    rest = [row for row in below if any(map(is_number, row)) and not row[0].startswith(COMMENT)]
    # Numbers that would be lost without a word are an error; words below a table are remarks.
    if rest:
        shown = " ".join(rest[0])
        raise DataError(f"'{shown:.40}' below the table is no row of it: {len(rest[0])} cells")
    above = [row for block in blocks for row in block.above]
    return with_conditions_above(apart(blocks, choice)), pairs_in(above), notes


def numbers_said(grid: Grid, choice: Choice) -> Block:
    """The numbers of a table without names for its columns, which the user gives.

    Raises
    ------
    DataError
        The question for them, or what is no table of numbers.
    """
    block = without_names(grid)
    if choice.columns:
        return block
    width = len(block.headings)
    # With names the question can show them; without, only the number of the columns is known.
    if block.headings == numbered(width):
        leading = _leading(block, choice)
        # A clock that begins at 0 needs no other.
        first = 1 if leading == CLOCK else _set_column(block, choice)
        raise ask_columns(width, leading, grid.separator, first)
    if block.is_steady:
        raise DataError(block.holds())
    terms = [i for i, each in enumerate(block.headings) if each.role == "relaxation_time"]
    if terms and not block.roles & {"time", *FREQUENCIES}:
        raise ask_clock(block.headings[terms[0]], terms[0] + 1)
    raise _ask_which(block.headings, block.untitled)


def _leading(block: Block, choice: Choice) -> str:
    """What the first column can be: the words of `ask_columns`, or "" where it may be anything."""
    try:
        first = columns_of(block, with_choice(block.headings, choice))[0].numbers(gaps=True)
    except DataError:
        return ""
    first = first[np.isfinite(first)]
    steps = np.diff(first)
    back, onward = int((steps < 0.0).sum()), int((steps > 0.0).sum())
    # Blocks one below the other only begin anew, and go neither back nor forth.
    if min(back, onward) > _BACK * (back + onward):
        return LOOP
    if onward and not back and first[0] == 0.0:
        return CLOCK
    return ""


def _set_column(block: Block, choice: Choice) -> int:
    """The number of the column that was set: the first in even steps, of three or more; else 1."""
    try:
        columns = columns_of(block, with_choice(block.headings, choice))
        values = [each.numbers(gaps=True) for each in columns]
    except DataError:
        return 1
    if len(values) < len(FIRST_COLUMNS):
        return 1
    return next((i for i, each in enumerate(values, 1) if _is_set(each)), 1)


def _is_set(values: NDArray[np.float64]) -> bool:
    """Whether a column goes in even steps or in even factors, up or down; the last may be cut."""
    inner = values[:-1]
    # A few may be even by chance.
    if len(inner) < 2 * len(FIRST_COLUMNS) or not np.isfinite(inner).all():
        return False
    if inner[-1] < inner[0]:
        inner = inner[::-1]
    return is_even(inner) or bool((inner > 0.0).all() and is_even(np.log(inner)))


def without_names(grid: Grid, words: Vocabulary = SWEEPS) -> Block:
    """The numbers of a file of which too few names are known, or none stand above them.

    Raises
    ------
    DataError
        If there is no table of numbers.
    """
    kept = [
        (row, n)
        for row, n in zip(grid.rows, grid.lines, strict=True)
        if not row[0].strip().startswith(COMMENT)
    ]
    start = next(
        (i for i, (row, _) in enumerate(kept) if len(row) > 1 and (is_data(row) or _is_gappy(row))),
        None,
    )
    if start is None:
        if any(len(row) == 1 and holds_number(row[0]) for row, _ in kept):
            raise DataError(
                "a single column of numbers; put what belongs together side by side, such as"
                " displacement [mm] and force [N], each with its title"
            )
        raise DataError(
            "there is no table of numbers; write frequency [Hz], storage [Pa], loss [Pa] above them"
        )
    kept = _without_margins(kept, start)
    width = len(kept[start][0])
    # A row of numbers above the names is no data: it tells the curves apart.
    if start + 2 < len(kept) and _names(kept[start + 1][0], width):
        start += 2
    rows, lines = [row for row, _ in kept[start:]], [n for _, n in kept[start:]]
    for row, number in zip(rows, lines, strict=True):
        if len(row) != width:
            raise DataError(f"line {number}: {len(row)} cells where the first row has {width}")
    above = [[cell.strip() for cell in row] for row, _ in kept[:start]]
    headings, above = _headings(above, width, words)
    return Block("", headings, rows, lines, above, words=words)


def _headings(
    above: list[list[str]], width: int, words: Vocabulary
) -> tuple[tuple[Heading, ...], list[list[str]]]:
    """The names of columns in the rows above them, and the rows that are none."""
    # What is said of the specimen may stand between the names and the numbers.
    place = next((i for i in reversed(range(len(above))) if _names(above[i], width)), None)
    if above and len(above[-1]) == width and not units_in(above[-1]):
        place = len(above) - 1
    if place is None:
        return numbered(width), above
    # A row of units alone belongs to the names above it, whatever these mean.
    if units_in(above[place]) and place and _names(above[place - 1], width):
        place -= 1
    below = place + 1
    units = [row for row in above[below : below + 1] if len(row) == width and units_in(row)]
    rest = [*above[:place], *above[below + len(units) :]]
    return headings_of(above[place], units, width, words), rest


def _without_margins(kept: list[tuple[list[str], int]], start: int) -> list[tuple[list[str], int]]:
    """The rows without the columns at either side that hold nothing and have no name."""
    width = len(kept[start][0])
    # Names may lack the separator with which each line of numbers begins.
    above = [row for row, _ in kept[:start] if len(row) == width]
    # A row may hold no more than separators, fewer than are taken off.
    while not any("".join(row[:1]).strip() for row in (*above, *(row for row, _ in kept[start:]))):
        kept = [*kept[:start], *((row[1:], n) for row, n in kept[start:])]
        width, above = width - 1, [row for row, _ in kept[:start] if len(row) == width - 1]
    # Cells behind the last separator of each line, which no name stands above, are no column.
    if not any("".join(row[width - 1 : width]).strip() for row, _ in kept):
        kept = [(row[: width - 1], n) for row, n in kept]
    return kept


def _is_gappy(row: Sequence[str]) -> bool:
    """Whether a row holds a number, and else what a program writes where it has none, as NaN."""
    gaps = [cell.strip() for cell in row if not holds_number(cell)]
    return len(gaps) < len(row) and all(gaps) and MISSING.issuperset(gaps)


def _names(row: Sequence[str], width: int) -> bool:
    """Whether all cells of a row are filled, and none with a number."""
    filled = all(cell.strip() for cell in row)
    return len(row) == width and filled and not any(map(holds_number, row))


def _ask_which(headings: Sequence[Heading], untitled: Sequence[int]) -> OpenQuestion:
    """The question for columns with names of which too few are known."""
    shown = ", ".join(dict.fromkeys(all_called(headings, untitled)))
    hint = proposal(headings) or "say which, such as 'FILE?1=omega[rad/s],2=storage[Pa],3=loss[Pa]'"
    roles = {str(heading.role) for heading in headings if heading.role}
    lacks = "no frequency, storage and loss"
    if roles:
        lacks = lacking(roles)
    says = f"{lacks} among the columns {shown:.120}; {hint}"
    return OpenQuestion(says, ask_each(unknown_in(headings)))


READER = Reader(
    "table",
    "CSV, TSV or text with named columns in many languages and units; asks for what it leaves open",
    recognises,
    read,
    parts=parts,
)
