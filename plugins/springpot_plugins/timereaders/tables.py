"""The tables of tests in time in a file, found as those of sweeps are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.measurement import Choice
from springpot.rheology import Real

from ..readers.blocks import Block, blocks_of
from ..readers.channels import found_in
from ..readers.choices import with_choice
from ..readers.clock import sample_rate, seconds_of
from ..readers.conditions_above import with_conditions_above
from ..readers.dynamic import columns_of
from ..readers.excel import called_by_sheet, recognises as is_workbook, sheets_in
from ..readers.generic import without_names
from ..readers.grid import Grid, grid_of, head_grid
from ..readers.side_by_side import apart
from ..readers.signal_layout import labview_units
from ..readers.table import Column
from ..readers.text import head_text, text_of
from ..readers.transposed import upright
from .words import DYNAMIC, IN_TIME, MEASURED, STRETCH, with_strain

_BOOK = 0.3
"""Confidence of a workbook's reader from which a file is looked into."""
MOST_TIED = 0.5
"""Share of rows that may repeat the printed time of the row before.

More is no rounding, but another table.
"""
_FEW = 0.5
"""Share of rows that may begin another run: more are no tests one below the other."""


def recognises(head: bytes) -> float:
    """High for a table that names a time and what was measured, unless it names frequencies too."""
    if is_workbook(head) >= _BOOK:
        # What is in it is seen when it is opened.
        return 0.6
    text = head_text(head)
    grid = head_grid(text)
    named = tables_in(grid, Choice())
    # A sweep may list time, force and displacement of each of its points.
    if any(block.roles & DYNAMIC for block in named) or holds_sweep(grid):
        return 0.0
    if any(is_test(block) for block in named):
        return 0.9
    # Whether numbers without a name that is known are a test only their user can say.
    return 0.6 * (not named and any(len(row) > 1 for row in grid.rows))


def is_test(block: Block) -> bool:
    """Whether a table holds what was measured against time, or a loop without its time."""
    loop = {"displacement", "force"} <= with_strain(block.roles) and not block.roles & DYNAMIC
    # Of relaxation times it is asked whether they are the clock, when they are read.
    clocks = block.roles & {"time", "relaxation_time"}
    return loop or (bool(clocks) and bool(block.roles & MEASURED))


def holds_sweep(grid: Grid) -> bool:
    """Whether any table is a sweep.

    Of a job with a pre-shear or a rest, the sweep is what is meant.
    """
    try:
        return any(block.is_dynamic for block in blocks_of(grid, stacked=True)[0])
    except DataError:
        return False


def tables_of(path: Path, choice: Choice) -> list[Block]:
    """The tests in a file, one table for each; none where it holds something else.

    Raises
    ------
    DataError
        If a table lacks what would make it a test, with how to say it.
    """
    with path.open("rb") as stream:
        head = stream.read(1 << 13)
    if is_workbook(head) >= _BOOK:
        return _in_workbook(path, choice)
    text = text_of(path)
    grid = grid_of(text)
    tables = tables_in(grid, choice)
    if any(block.roles & DYNAMIC for block in tables):
        # Farther below than what the file was recognised by.
        return []
    named = [block for block in tables if is_test(block)]
    if not named and (unnamed := _unnamed(grid, choice)) is not None:
        named = apart([unnamed], choice)
    timed = [_with_time(block, choice, text[: 1 << 13]) for block in named]
    return [run for block in timed for run in _runs(block, choice)]


def _in_workbook(path: Path, choice: Choice) -> list[Block]:
    try:
        sheets = sheets_in(path)
    except DataError:
        # Told by the reader of sweeps.
        return []
    if any(holds_sweep(grid) for _, grid in sheets):
        return []
    made: list[Block] = []
    for title, grid in sheets:
        named = [block for block in tables_in(grid, choice) if is_test(block)]
        made += [run for block in called_by_sheet(title, named) for run in _runs(block, choice)]
    if made:
        return made
    unnamed = ((title, _unnamed(grid, choice)) for title, grid in sheets)
    said = [
        called_by_sheet(title, apart([block], choice))
        for title, block in unnamed
        if block is not None
    ]
    return [run for blocks in said for block in blocks for run in _runs(block, choice)]


def tables_in(grid: Grid, choice: Choice) -> list[Block]:
    """All tables with names of a test in time, each curve of those side by side by itself."""
    try:
        blocks, _ = blocks_of(grid, stacked=True, words=IN_TIME)
    except DataError:
        return []
    if not blocks and (turned := upright(grid, IN_TIME)) is not None:
        blocks, _ = blocks_of(turned, words=IN_TIME)
    return with_conditions_above(apart(map(_with_units_above, blocks), choice))


def _with_units_above(block: Block) -> Block:
    """The table with the units that a LabVIEW header lists."""
    units = labview_units(block.above)
    if not units or any(each.unit for each in block.headings):
        return block
    units += [""] * (len(block.headings) - len(units))
    named = zip(block.headings, units, strict=False)
    return replace(block, headings=tuple(IN_TIME.heading(each.title, unit) for each, unit in named))


def _unnamed(grid: Grid, choice: Choice) -> Block | None:
    """The numbers of a file of whose columns too few are known, if they are a test in time.

    As the user says, or as the only name that is known says.
    """
    # A rate is said of all rows, and of none of the columns.
    _, of_columns = sample_rate(choice, "", ())
    try:
        block = without_names(grid, IN_TIME)
        chosen = with_choice(block.headings, of_columns, IN_TIME)
    except DataError:
        return None
    roles = with_strain({str(each.role) for each in chosen.headings})
    if roles & DYNAMIC or not ("time" in roles or roles >= {"displacement", "force"}):
        return None
    return block


def _with_time(block: Block, choice: Choice, head: str) -> Block:
    """A loop with the time that a sample rate gives, which is no column of the file."""
    if "time" in block.roles or "time" in found_in(list(choice.columns.values())):
        return block
    rate, _ = sample_rate(choice, head, [each.title for each in block.headings])
    if rate is None:
        return block
    clock = IN_TIME.heading("time [s]")
    rows = [[*row, repr(i / rate)] for i, row in enumerate(block.rows)]
    return replace(block, headings=(*block.headings, clock), rows=rows)


def _runs(block: Block, choice: Choice) -> list[Block]:
    """The tests of a table that has several below one another: the time begins anew at each.

    The time may fall within all of them. What tells them apart is a column, such as a temperature
    or the name of a specimen.
    """
    try:
        chosen = with_choice(block.headings, choice, block.words)
        if any(each.written == "?" for each in chosen.headings):
            return [block]
        columns = columns_of(block, chosen)
        place, clock = next((i, each) for i, each in enumerate(columns) if each.name == "time")
        times = in_seconds(clock).numbers(gaps=True)
    except (DataError, StopIteration):
        # What is wrong with it is told when it is read as one test.
        return [block]
    steps = np.sign(np.diff(times))
    if not (steps < 0.0).any():
        return [block]
    onwards = float(np.median(steps[steps != 0.0])) if (steps != 0.0).any() else 0.0
    starts = np.flatnonzero(steps == -onwards) + 1
    names = None
    if 0 < len(starts) < _FEW * len(times):
        runs = np.split(np.arange(len(times)), starts)
        others = (each for i, each in enumerate(columns) if i != place)
        told = (_told_apart(each, runs) for each in others if each.name not in MEASURED)
        names = next((each for each in told if each is not None), None)
    if names is None:
        # A record whose clock slipped is none of these.
        return [_rows(block, np.argsort(times), "") if _of_one_curve(times, steps) else block]
    return [_rows(block, run[:: int(onwards)], name) for run, name in zip(runs, names, strict=True)]


def _of_one_curve(times: Real, steps: Real) -> bool:
    """Whether pieces that run on or back leave one another's times alone, as when digitised."""
    pieces = np.split(times, np.flatnonzero(np.diff(steps)) + 2)
    ends = sorted((float(piece.min()), float(piece.max())) for piece in pieces)
    return all(last < first for (_, last), (first, _) in pairwise(ends))


def _told_apart(column: Column, runs: Sequence[NDArray[np.intp]]) -> list[str] | None:
    """A name of each run, where this column tells neighbouring ones apart; empty for numbers."""
    if column.is_numeric():
        values = column.numbers(gaps=True)
        each = [values[run] for run in runs]
        moved = min(abs(np.nanmean(b) - np.nanmean(a)) for a, b in pairwise(each))
        if min(map(len, each)) < 2 or not moved > 0.0 or moved < max(map(np.ptp, each)):
            return None
        return [""] * len(runs)
    words = [{column.cells[i].strip() for i in run} for run in runs]
    if any(len(each) > 1 for each in words) or any(a == b for a, b in pairwise(words)):
        return None
    return [next(iter(each)) for each in words]


def _rows(block: Block, run: NDArray[np.intp], name: str) -> Block:
    rows, lines = [block.rows[i] for i in run], [block.lines[i] for i in run]
    return replace(block, name=name or block.name, rows=rows, lines=lines)


def without_ties(clock: Real, origin: dict[str, str]) -> NDArray[np.bool_]:
    """Which rows stay: those whose time is not that of the row before, as printed digits make it.

    Times of a test have to rise.
    """
    tied = np.concatenate([[False], np.diff(clock) == 0.0])
    if not tied.any() or tied.mean() >= MOST_TIED:
        return np.ones(len(clock), dtype=bool)
    origin["note time"] = (
        f"{int(tied.sum())} of {len(clock)} rows have the time of the row before and are left out"
    )
    return ~tied


def in_seconds(clock: Column) -> Column:
    """A column of timestamps as seconds since the first; others as they are."""
    filled = (cell for cell in clock.cells if cell.strip())
    began = seconds_of(next(filled, ""))
    if began is None:
        return clock
    # Counted from the first: seconds since a date would leave no digits for milliseconds.
    now = [seconds_of(cell) for cell in clock.cells]
    cells = [
        cell if moment is None else repr(moment - began)
        for cell, moment in zip(clock.cells, now, strict=True)
    ]
    return replace(clock, cells=cells, unit="s", decimal_comma=False)


def as_strain(moved: Column) -> Column:
    """A column of stretches as strains, which are one less; others as they are."""
    if moved.name != STRETCH or moved.unit not in (None, "-"):
        return moved
    cells = [repr(float(value) - 1.0) for value in moved.numbers(gaps=True)]
    return replace(moved, name="displacement", cells=cells, unit="-", decimal_comma=False)
