"""What a table with a time lacks to be a test, and what to write."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from springpot.errors import DataError
from springpot.measurement import LENGTH_UNITS, known_unit
from springpot.numerics import SMALLEST
from springpot.rheology import Real

from ..readers.blocks import Block
from ..readers.channels import UNITS as CHANNELS
from ..readers.choices import ask_clock
from ..readers.proposals import stated_unit
from ..readers.table import Column
from .words import MEASURED

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
    there = ", ".join(each.title for each in block.headings[:12])
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
    what = f"no column of displacement beside the force, but '{title.title}'"
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
    ends = (known[[0, -1]] - low) / max(high - low, SMALLEST)
    beyond = known > 0.5 * (high + low)
    swings = np.all(np.abs(ends - 0.5) < 0.4)
    return not swings and int(np.count_nonzero(np.diff(beyond))) <= _THERE_AND_BACK
