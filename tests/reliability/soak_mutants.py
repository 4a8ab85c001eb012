"""Whether the tests of a room notice a changed line of it."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from mutation import PACKAGE, Copy, drawn
from soak import Row

COUNT = 100
LEAST = 0.85
"""Share of the changes that the room's own tests are to notice.

Some change nothing that anybody could see.
"""
LEFT_ALONE = "texts, annotations, guards, tolerances and numbers that have a name"
"""What is never changed; `mutation` says why."""


def rows(rng: np.random.Generator, scale: float) -> Iterator[Row]:
    """One promise: enough of the changes are noticed; those that were not are named."""
    count = max(1, round(scale * COUNT))
    unnoticed = []
    with tempfile.TemporaryDirectory() as folder:
        copy = Copy(Path(folder))
        for number, mutant in enumerate(drawn(rng, count), 1):
            change, by = mutant.change, copy.notices(mutant)
            place = mutant.path.relative_to(PACKAGE)
            told = f"{place}:{change.line} `{change.before}` to `{change.after}`"
            # A hundred take an hour.
            print(f"{number} of {count}: {told}: {by or 'NOT NOTICED'}", flush=True)
            if not by:
                unnoticed.append(told)
    noticed = count - len(unnoticed)
    told = f"{noticed} of {count}, of all but {LEFT_ALONE}"
    told += f"; not noticed: {'; '.join(unnoticed) or 'none'}"
    if copy.failing:
        told += f"; left out, as they fail without any change: {', '.join(sorted(copy.failing))}"
    kept = noticed >= LEAST * count
    what = f"{100 * LEAST:.0f} % of single-line changes are noticed by the tests of their room"
    yield Row(what, 1, int(kept), told.replace("|", "\\|"))
