"""Tables in which storage and loss do not stand beside each other, set in columns of their own."""

from __future__ import annotations

from collections.abc import Iterable

from springpot.measurement import Choice

from .blocks import Block
from .grid import Grid
from .one_quantity import from_tables_of_one, is_wide
from .side_by_side import apart
from .values_in_rows import from_rows


def needs_rearranging(grid: Grid, blocks: Iterable[Block]) -> bool:
    """Whether a table is no dynamic test as it stands, or its columns are no quantities."""
    return not any(block.is_dynamic for block in apart(blocks)) or is_wide(grid)


def rearranged(grid: Grid, choice: Choice) -> tuple[Grid, str] | None:
    """The table with a column for each quantity, and a note on how it was read.

    None for other files.

    Raises
    ------
    DataError
        If it is such a table but leaves open which values are what: one line with how to mend it.
    """
    found = from_rows(grid)
    if found is not None:
        return found
    together = from_tables_of_one(grid, choice)
    if together is None:
        return None
    return together, "tables of one quantity each were put side by side"
