"""The tables of tests in time in a file, found as those of sweeps are.

What their titles mean; and what a table with a time lacks to be a test, with what to write.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.measurement import (
    LENGTH_UNITS,
    MODULUS_UNITS,
    STRAIN_UNITS,
    TEMPERATURE_UNITS,
    TIME_UNITS,
    Choice,
    known_unit,
    normal_unit,
)
from springpot.rheology import Real

from .above import with_conditions_above
from .blocks import Block, blocks_of
from .channels import UNITS as CHANNELS, channel_of, found_in
from .choices import all_called, ask_clock, called, with_choice
from .dynamic import columns_of
from .excel import called_by_sheet, recognises as is_workbook, sheets_in
from .generic import without_names
from .grid import Grid, grid_of, head_grid, head_text, text_of
from .names import EXACT, fold, names_a_modulus, role_of
from .proposals import stated_unit
from .side_by_side import apart
from .signals_csv import labview_units, sample_rate, seconds_of
from .table import Column
from .titles import COMPLIANCE_UNITS, UNITS, Heading, Vocabulary, plain_title
from .values_in_rows import upright

MEASURED = frozenset({"relaxation", "compliance", "displacement", "force"})
"""What stands against time."""
DYNAMIC = frozenset({"omega", "frequency", "storage", "loss", "phase", "loss_factor", "magnitude"})
"""Columns of a sweep, which may well list the time of each point."""
STRETCH = "stretch"
"""Of lengths, deformed over undeformed: what rubber is often told by, one more than the strain."""
_STRETCHES = frozenset(
    (
        *("stretch", "stretchratio", "extensionratio", "elongationratio", "lambda", "λ"),
        *("streckung", "verstreckung", "streckverhaltnis", "tauxdelongation", "伸长比", "拉伸比"),
    )
)
_UNITS = {
    **CHANNELS,
    STRETCH: {"-": 1.0},
    "relaxation": MODULUS_UNITS,
    "compliance": COMPLIANCE_UNITS,
    "temperature": TEMPERATURE_UNITS,
}
_OWN = ("relaxation", "compliance", "relaxation_time")
"""What a name as a whole says, though a part of it may name a channel."""
# In a table against time a strain is the displacement, by whatever name.
_AS_IN_SWEEPS = {
    "amplitude": "displacement",
    # Of a rheometer it stands beside the test; only against a length is it one.
    **dict.fromkeys(("stress", "torque", "normal_force"), "force"),
}
_SYMBOLS = {
    **dict.fromkeys(("G", "E", "M", "K"), ("relaxation", MODULUS_UNITS)),
    **dict.fromkeys(("J", "D"), ("compliance", COMPLIANCE_UNITS)),
}
"""Letters that a unit of theirs makes known, as K may be a temperature."""
_WITHOUT_UNIT = {"G": "relaxation", "E": "relaxation", "J": "compliance"}
"""Letters that against time are nothing else."""


def _role(name: str) -> str | None:
    """What a name stands for."""
    if fold(name) in _STRETCHES:
        return STRETCH
    role = role_of(name)
    if role in _OWN or EXACT.get(name) == "temperature":
        return role
    return channel_of(name)[0] or _AS_IN_SWEEPS.get(str(role), role)


def _plain(title: str) -> Heading:
    """The heading of ``time [s]``, or of ``Ch 1 Kraft`` above ``kN``."""
    named = plain_title(" ".join(title.lstrip("# ").split()))
    role = _role(named.name)
    channel, unit, bare = channel_of(title)
    if role not in (*_OWN, "temperature") and channel is not None:
        return Heading(title, bare, channel, unit or named.unit)
    return replace(named, title=title, role=role)


def _by_unit(named: Heading) -> Heading:
    """The heading whose unit tells what its name leaves open: t is a time or a temperature."""
    role, unit = named.role, normal_unit(named.unit or "")
    known, units = _SYMBOLS.get(named.name, (None, {}))
    if role in ("time", "temperature"):
        if unit in TEMPERATURE_UNITS:
            role = "temperature"
        elif unit in TIME_UNITS:
            role = "time"
    elif role == STRETCH and named.unit and unit in CHANNELS["displacement"] and unit != "-":
        # In mm or per cent it counts from nothing.
        role = "displacement"
    elif role == "compliance" and named.unit and unit in STRAIN_UNITS:
        # A creep may be noted as the strain itself.
        role = "displacement"
    elif unit in units:
        role = known
    elif role is None and not named.unit:
        role = _WITHOUT_UNIT.get(named.name)
    elif names_a_modulus(named.name) and unit in MODULUS_UNITS:
        # Against time a modulus is that of a relaxation.
        role = "relaxation"
    elif role is None and unit in COMPLIANCE_UNITS:
        role = "compliance"
    elif role in CHANNELS and named.unit and unit not in CHANNELS[role]:
        other = role_of(named.name)
        if unit in UNITS.get(str(other), {}):
            role = other
        elif role == "displacement" and unit in CHANNELS["force"]:
            # G_A [Pa] is no amplitude gamma_a.
            role = None
    return replace(named, role=role)


def with_strain(roles: set[str]) -> set[str]:
    """These roles, with a displacement where there is a stretch, of which it is made."""
    return roles | ({"displacement"} if STRETCH in roles else set())


def _is_test(roles: set[str]) -> bool:
    """Whether columns of these roles are a test in time."""
    return "time" in roles and (
        bool(roles & {"relaxation", "compliance"})
        or with_strain(roles) >= {"displacement", "force"}
    )


IN_TIME = Vocabulary(
    _role, _plain, _by_unit, _UNITS, tuple(_UNITS), frozenset({"time"}), MEASURED, _is_test
)
"""Tables of what a specimen did against time."""


EXAMPLES = {
    "time": "s",
    "relaxation": "Pa",
    "compliance": "1/Pa",
    "displacement": "mm",
    "force": "N",
}
"""What to write in a hint."""
_THERE_AND_BACK = 2
"""Passages of the middle by a record that is no oscillation."""


def lacking(block: Block, columns: Sequence[Column]) -> DataError:
    """What a table with a time needs to be a test."""
    titles = all_called(block.headings, block.untitled)
    first, rest = titles[:12], titles[12:]
    there = ", ".join(first)
    if rest:
        there += f" and {len(rest)} more"
    roles = {each.name for each in columns}
    if roles >= {"displacement", "force"}:
        for each in columns:
            if each.name in ("displacement", "force") and each.unit is not None:
                known_unit(each.unit, CHANNELS[each.name], each.name)
        says = "displacement and force are in units that make no stiffness"
        if "time" not in roles:
            says = (
                "displacement and force without their time; of samples that are evenly spaced say"
                " how many there are a second: 'FILE?rate=1000[Hz]'"
            )
        return DataError(f"{says} (columns: {there})")
    for number, title in enumerate(block.headings, 1):
        if title.role == "relaxation_time" and "time" not in roles:
            return ask_clock(title, number)
    if any(each.role == "flow" for each in block.headings):
        # A rate or a viscosity beside a stress: no column of it, whatever it is called, would make
        # it a test.
        return DataError(
            "steady flow, neither an oscillation nor a test in time; give the step that"
            f" oscillates, creeps or relaxes (columns: {there})"
        )
    if "force" in roles and (place := _distance(block, columns)) is not None:
        return DataError(f"{_instead(block, columns, place)} (columns: {there})")
    lacks = [role for role in ("displacement", "force") if role not in roles]
    says = "no column of what was measured"
    if len(lacks) == 1:
        [has] = {"displacement", "force"} - {*lacks}
        says = f"a {has} without a {lacks[0]} is no test"
    # No column is proposed: read as another quantity its numbers would be wrong without a word.
    spec = ",".join(f"NAME={role}[{EXAMPLES[role]}]" for role in lacks)
    others = (
        ", or, of a modulus that relaxes, 'FILE?NAME=relaxation[Pa]', of a compliance that grows,"
        " 'FILE?NAME=compliance[1/Pa]'"
    )
    if len(lacks) > 1:
        others = f", 'FILE?NAME=strain[-],NAME=stress[Pa]'{others}"
    return DataError(
        f"{says}; say which, with its name or number and unit, such as 'FILE?{spec}'{others}"
        f" (columns: {there})"
    )


def _distance(block: Block, columns: Sequence[Column]) -> int | None:
    """The first column with a length that is no displacement by its name, such as a gap."""
    filled = {each.title for each in columns}
    lengths = (
        i
        for i, each in enumerate(block.headings)
        if each.role not in MEASURED and stated_unit(each) in LENGTH_UNITS and each.title in filled
    )
    return next(lengths, None)


def _instead(block: Block, columns: Sequence[Column], place: int) -> str:
    """What to make of a force against a distance, as of a sample compressed at a constant speed."""
    title = block.headings[place]
    unit = stated_unit(title)
    named = f"'{title.title}'" if title.title else called(block.headings, place + 1)
    what = f"no column of displacement beside the force, but {named}"
    distance = _numbers(columns, title.title)
    if _moves_once(distance):
        what += (
            ", which moves one way, or once there and back: a compression or pull is no oscillation"
            " and has no storage and loss modulus"
        )
    if title.role == "gap" or _falls_where_it_presses(distance, columns):
        # A gap is there before the specimen is touched, and falls where the force rises.
        return (
            f"{what}; for a test in time at small deformations add a column displacement"
            f" [{unit}], the gap at first contact less each gap"
        )
    return (
        f"{what}; if it counts from the first contact,"
        f" 'FILE?{place + 1}=displacement[{unit}]' opens it as a test in time, for small"
        " deformations"
    )


def _numbers(columns: Sequence[Column], title: str) -> Real:
    """What stands below a title; columns without numbers are not among these."""
    return next(each.numbers(gaps=True) for each in columns if each.title == title)


def _falls_where_it_presses(distance: Real, columns: Sequence[Column]) -> bool:
    """Whether a distance goes down while the force goes up."""
    pressed = next(each for each in columns if each.name == "force").numbers(gaps=True)
    known = np.isfinite(distance) & np.isfinite(pressed)
    apart = [each[known] - np.mean(each[known]) for each in (distance, pressed)]
    return bool(known.any() and np.dot(*apart) < 0.0)


def _moves_once(distance: Real) -> bool:
    """Whether a distance passes its middle at most twice: there, and perhaps back.

    A swing begins and ends between its extremes and passes it as seldom: one way has an extreme at
    an end.
    """
    known = distance[np.isfinite(distance)]
    if len(known) < 2:
        return False
    low, high = known.min(), known.max()
    ends = (known[[0, -1]] - low) / (high - low or 1.0)
    beyond = known > 0.5 * (high + low)
    # Nearer to an extreme than a tenth of the way, a record begins or ends there.
    swings = np.all((ends > 0.1) & (ends < 0.9))
    return not swings and int(np.count_nonzero(np.diff(beyond))) <= _THERE_AND_BACK


_BOOK = 0.3
"""Confidence of a workbook's reader from which a file is looked into."""
MOST_TIED = 0.5
"""Share of rows that may repeat the printed time of the row before.

More is no rounding, but another table.
"""
_FEW = 0.5
"""Share of rows that may begin another run: more are no tests one below the other."""


def recognises_table(head: bytes) -> float:
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
