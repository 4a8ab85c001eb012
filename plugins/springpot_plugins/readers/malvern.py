"""Malvern rSpace: one table for all actions of a sequence, units in parentheses."""

from __future__ import annotations

from dataclasses import replace
from itertools import groupby
from pathlib import Path

from .blocks import Block, blocks_of
from .dynamic import reader_of_blocks
from .grid import grid_of
from .text import head_text, text_of

_MARKS = (
    "(sequence)(s)",
    "(action)(s)",
    "(elastic component)",
    "(viscous component)",
    "Action Name",
)


def recognises(head: bytes) -> float:
    """High for the names of an rSpace table."""
    first = head_text(head[:8000]).lstrip("\ufeff \r\n").splitlines()[:1]
    # Two of these names are enough, one alone may be anybody's.
    marks = [mark for line in first for mark in _MARKS if mark in line]
    return min(1.0, 0.49 * len(marks))


def _parsed(path: Path) -> tuple[list[Block], dict[str, str]]:
    """One block for each action, in order; the file says nothing of the instrument."""
    blocks, _ = blocks_of(grid_of(text_of(path)))
    made: list[Block] = []
    for block in blocks:
        place = next(
            (i for i, h in enumerate(block.headings) if h.title.startswith("Action")), None
        )
        if place is None:
            made.append(block)
            continue
        start = 0
        # Only rows that follow one another: the same action may come again later in a sequence.
        for name, run in groupby(row[place].strip() for row in block.rows):
            stop = start + len(list(run))
            made.append(
                replace(
                    block, name=name, rows=block.rows[start:stop], lines=block.lines[start:stop]
                )
            )
            start = stop
    # The columns of all actions stand in one table: those of the others are empty.
    return [_without_blank_columns(block) for block in made], {}


def _without_blank_columns(block: Block) -> Block:
    """The columns that hold anything, so that an action shows what it measured."""
    filled = [any(row[i].strip() for row in block.rows) for i in range(len(block.headings))]
    keep = [i for i, there in enumerate(filled) if there]
    rows = [[row[i] for i in keep] for row in block.rows]
    return replace(block, headings=tuple(block.headings[i] for i in keep), rows=rows)


READER = reader_of_blocks(
    "malvern", "Malvern rSpace, exported as CSV", recognises, _parsed, "Malvern rSpace"
)
