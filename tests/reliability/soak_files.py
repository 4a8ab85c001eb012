"""Hostile files at full size, and at shares of it.

Each is read or refused in one line, within its budget.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import hostile
import numpy as np
from opening_cost import cost_of, parts_cost
from soak import Row

from springpot.measurement import budget_of
from springpot.registry import signals_to_measurement

SIZES = (1.0, 0.5, 0.1, 0.01)
LITTLE = 300 << 20
"""Bytes of memory that signals of any length may take."""


def rows(rng: np.random.Generator, scale: float) -> Iterator[Row]:
    """A row for each kind of file; with four sizes they are a hundred."""
    for make in hostile.FILES:
        found = []
        for size in SIZES:
            with TemporaryDirectory() as folder:
                path = make(Path(folder), size * scale)
                found += [cost_of(path), parts_cost(path)]
        time, memory = (
            max(getattr(cost, key) for cost in found) for key in ("time_share", "memory_share")
        )
        said = f"at most {time:.0%} of the time and {memory:.0%} of the memory allowed"
        read = sum(not cost.said and not cost.fault for cost in found)
        faults = "; ".join(sorted({cost.fault for cost in found if cost.fault}))
        what = (make.__doc__ or make.__name__).strip().rstrip(".")
        yield Row(
            what,
            len(found),
            sum(cost.held for cost in found),
            f"{said}; {read} read  {faults}".strip(),
        )
    with TemporaryDirectory() as folder:
        yield _signals(hostile.long_signals(Path(folder), scale))


def _signals(path: Path) -> Row:
    """Whether a long record opens, rightly and in little memory, and what that takes."""
    found: list[complex] = []
    cost = cost_of(path, lambda: found.append(complex(signals_to_measurement([path]).stiffness[0])))
    right = len(found) == 1 and np.isclose(found[0], 3 * np.exp(0.5j), rtol=1e-5)
    size, allowed = path.stat().st_size / 1e6, budget_of(path).seconds
    time = f"{cost.seconds:.0f} s with the harmonics ({allowed:.0f} s allowed)"
    said = f"{size:.0f} MB, {time}, {cost.memory / 2**20:.0f} MiB {cost.fault}"
    return Row(
        "Time signals of any length still open",
        1,
        int(right and cost.memory < LITTLE),
        said.strip(),
    )
