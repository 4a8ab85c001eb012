"""Stores with one flipped bit.

Told or harmless, never another number, and mended by ``--retry-failed``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from flipped_stores import HARMLESS, SAME, copy_of, flip, mended, pristine, verdict
from soak import Row

FLIPS = 300


def rows(rng: np.random.Generator, scale: float) -> Iterator[Row]:
    """A row for reading and one for mending."""
    seen: Counter[str] = Counter()
    whole_again = 0
    with TemporaryDirectory() as name:
        folder = Path(name)
        path, sound = pristine(folder / "sound")
        for i in range(max(1, round(scale * FLIPS))):
            target = copy_of(path, folder / str(i))
            flip(path.read_bytes(), target, rng)
            found = verdict(target, sound)
            seen[found] += 1
            if found != SAME:
                whole_again += mended(target, sound)
    told = ", ".join(f"{count} {what}" for what, count in sorted(seen.items()))
    yield Row("a bit flipped in a store", seen.total(), sum(seen[what] for what in HARMLESS), told)
    damaged = seen.total() - seen[SAME]
    says = "or left alone where it no longer looks like a store"
    yield Row("those that were told, brought back by --retry-failed", damaged, whole_again, says)
