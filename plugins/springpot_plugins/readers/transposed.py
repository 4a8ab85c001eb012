"""Tables that lie on their side: a row for each quantity, its name in front."""

from __future__ import annotations

from .grid import COMMENT, Grid, is_number
from .titles import SWEEPS, Vocabulary

_MOST_ROWS = 60


def upright(grid: Grid, words: Vocabulary = SWEEPS) -> Grid | None:
    """The table set upright, if each row begins with a name and goes on with numbers.

    None for other tables.
    """
    rows = [row for row in grid.rows if not row[0].strip().startswith(COMMENT)]
    rows = [_without_end(row) for row in rows]
    if (
        not 2 < len(rows) <= _MOST_ROWS
        or len(rows[0]) < 3
        or {len(row) for row in rows} != {len(rows[0])}
    ):
        return None
    # Every cell behind a name must be a number: a table that stands upright has names in its first
    # row.
    if any(is_number(row[0]) or not all(map(is_number, row[1:])) for row in rows):
        return None
    if not words.complete({str(words.heading(row[0].strip()).role) for row in rows}):
        return None
    upright = [list(cells) for cells in zip(*rows, strict=True)]
    # Lines are no longer rows: errors name the column of the table as its line.
    return Grid(upright, range(1, len(upright) + 1), grid.separator)


def _without_end(row: list[str]) -> list[str]:
    end = len(row)
    while end and not row[end - 1].strip():
        end -= 1
    return row[:end]
