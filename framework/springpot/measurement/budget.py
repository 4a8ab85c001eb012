"""What reading a file may take, stated here and nowhere else.

A reader gets a regular file, and refuses what is beyond sizes that are bounded: bytes of text,
columns, tables, cells, what an archive unpacks to. In a process of springpot's own it is limited as
well: to `TIMES` the file's size plus `SPARE` of memory, and to `SECONDS` plus the time for its size
of the processor. What ends for want of these ends in one line.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from springpot.errors import DataError
from springpot.inputs import require_regular
from springpot.limits import OverTime, limited
from springpot.suggestions import suggested

T = TypeVar("T")

SECONDS = 5.0
"""Of processor time for any file.

The largest instrument export among the tests takes a tenth of it.
"""
BYTES_A_SECOND = 10e6
"""For each of which there is one more second: text is parsed at two to four times this rate."""
TIMES = 10
"""Bytes of memory for each of a file: a table needs about seven while its cells are text."""
SPARE = 200 << 20
"""Bytes of memory for any file: libraries that a reader imports, and an archive that unpacks."""
MOST_COLUMNS = 10_000
"""Of a table: a sheet of Excel can have 16,384, and each is asked for its meaning."""
MOST_CELLS = 1_000_000
"""Of a workbook, whose cells take a thousand times as long as those of a text."""
MOST_TABLES = 10_000
"""Below one another in one file, each of which is a part that can be chosen."""


@dataclass(frozen=True)
class Budget:
    """What reading one file may take.

    Parameters
    ----------
    seconds : float
        Of processor time.
    memory : int
        Bytes, beyond what the process had before.
    """

    seconds: float
    memory: int


def budget_of(path: Path) -> Budget:
    """What reading this file may take."""
    try:
        size = path.stat().st_size
    except (OSError, ValueError):
        size = 0
    return Budget(SECONDS + size / BYTES_A_SECOND, TIMES * size + SPARE)


def within_budget(path: Path, action: Callable[[], T]) -> T:
    """What `action` gives, which reads the file; ended when it takes more than the file is worth.

    In a process that is not springpot's own it is called, and no more: see `springpot.limits`.

    Raises
    ------
    DataError
        If the file is a pipe or device, or time or memory ended.
    """
    require_regular(path)
    budget = budget_of(path)
    try:
        return limited(action, budget.seconds, budget.memory)
    except OverTime:
        spent = f"more than {budget.seconds:.1f} s of processor time"
    except MemoryError:
        spent = f"more than {budget.memory >> 20} MiB of memory"
    raise DataError(
        f"{path}: reading it was ended: it takes {spent}, too much for its size; save only the"
        f" table that matters, in several files if need be ({suggested('signals', 'FILE')} reads"
        " time signals of any length)"
    )
