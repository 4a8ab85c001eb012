"""Files whose structure was repeated, nested, padded and widened.

Each is read or refused, within its budget.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "plugins"))

from opening_cost import Cost
from soak import Row

import structure
from springpot.files import FILES

CASES = 250
"""Of each operation."""
LARGEST = 8_000_000
"""Bytes that an operation adds at most."""


def rows(rng: np.random.Generator, scale: float) -> Iterator[Row]:
    """A row for each operation."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "data"
        for operation in structure.OPERATIONS:
            yield _row(operation, rng, max(1, round(scale * CASES)), path)


def _row(operation: str, rng: np.random.Generator, cases: int, path: Path) -> Row:
    found: list[tuple[str, Cost]] = []
    for case in range(cases):
        name, content = structure.made(operation, rng, LARGEST)
        both = structure.costs(path, content, FILES.seconds + len(content) / 1e7)
        found += [(f"case {case}, {name}", cost) for cost in both]
    time, memory = (
        max(getattr(cost, key) for _, cost in found) for key in ("time_share", "memory_share")
    )
    read = sum(not cost.said and not cost.fault for _, cost in found)
    worst = (
        f"at most {time:.0%} of the time and {memory:.0%} of the memory allowed; "
        f"{read} read, the rest refused"
    )
    faults = [f"{what}: {cost.fault}" for what, cost in found if cost.fault]
    return Row(
        f"files, {operation} first",
        len(found),
        len(found) - len(faults),
        "; ".join([worst, *faults[:3]]),
    )
