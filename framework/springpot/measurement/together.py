"""Whether rows of several tests stand together in one table, which nobody fits as one without a word."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from springpot.rheology import Real

NOTE = "note together"
"""Key of the note in a measurement's provenance."""
RUNS = frozenset(
    (
        *("run", "set", "test", "series", "specimen", "sample", "file", "batch", "cycle", "dataset", "measurement"),
        *("probe", "lauf", "serie", "versuch", "messung", "essai", "prueba", "prova"),
    )
)
"""Names of columns that tell one test from another, also where they hold numbers."""
_MOST_RUNS = 0.5
"""Share of the rows that distinct words may be, to be names of runs rather than a remark on each row."""


def runs_together(
    numbers: Mapping[str, Real], words: Mapping[str, NDArray[np.str_]], known: frozenset[str] = frozenset()
) -> dict[str, str]:
    """A note where a column says that the rows are of several tests: they are fitted as one set of data.

    Parameters
    ----------
    numbers, words : mapping of str to ndarray, shape (n,)
        Further conditions and labels of the rows.
    known : frozenset of str
        Columns of which another note tells already.
    """
    found = []
    for key, column in {**words, **{key: numbers[key] for key in numbers if key in RUNS}}.items():
        values = np.unique(column[column == column])  # not those that are missing
        if key not in known and 1 < len(values) <= max(2, _MOST_RUNS * len(column)):
            first = str(values[0])
            if key not in words:
                first = f"{values[0]:g}"
            found.append(f"{len(values)} values of {key}, choose one by '@{key}={first}'")
    if not found:
        return {}
    return {NOTE: f"rows of several tests are together: {'; '.join(found)}"}
