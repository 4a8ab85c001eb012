"""Whether rows of several tests stand together in one table, and which columns tell them apart.

Nobody fits them as one without a word, and nobody takes what sets them apart for noise.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from springpot.rheology import Real

from .measurement import CONDITIONS, Measurement

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
_ROWS_OF_A_SETTING = 3
"""Rows of each value of a setting, on average, at least: a sweep of fewer has no course of its own."""


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
            found.append(f"{len(values)} values of {key}, choose one by '@{_chosen(key, values[0])}'")
    if not found:
        return {}
    return {NOTE: f"rows of several tests are together: {'; '.join(found)}"}


def _chosen(column: str, value: np.str_ | np.float64) -> str:
    """How a user chooses the rows of one value: ``current=0.5``."""
    if isinstance(value, np.str_):
        return f"{column}={value}"
    return f"{column}={value:g}"


def largest_test(measurement: Measurement, column: str) -> str:
    """How a user chooses the rows of the value that most rows of a column have, such as ``current=0.5``.

    Parameters
    ----------
    measurement : Measurement
        The data.
    column : str
        One of its conditions or labels.
    """
    words = {**measurement.conditions, **measurement.labels}[column]
    values, count = np.unique(words, return_counts=True)
    return _chosen(column, values[np.argmax(count)])


def tests_together(measurement: Measurement) -> list[str]:
    """Columns that name the tests of which rows stand together, those of few values first."""
    return [name for name in settings_of(measurement) if name in measurement.labels or name in RUNS]


def settings_of(measurement: Measurement) -> dict[str, NDArray[np.int64]]:
    """Columns that no effect knows and that hold a setting, a test or a specimen, those of few values first.

    Parameters
    ----------
    measurement : Measurement
        The data.

    Returns
    -------
    dict of str to ndarray of int, shape (n,)
        For each column the number of the value of each row.

    Examples
    --------
    >>> import numpy as np
    >>> current = {"current": np.repeat([0.0, 1.0], 4)}
    >>> data = Measurement(np.tile([1.0, 2.0, 4.0, 8.0], 2), np.ones(8) + 1j, conditions=current)
    >>> settings_of(data)["current"].tolist()
    [0, 0, 0, 0, 1, 1, 1, 1]
    """
    columns: dict[str, NDArray[np.float64] | NDArray[np.str_]] = dict(measurement.labels)
    columns |= {name: column for name, column in measurement.conditions.items() if name not in CONDITIONS}
    numbered = {}
    for name, column in columns.items():
        values, number = np.unique(column, return_inverse=True)
        # What differs from row to row was measured, as a torque is, and not set.
        if 1 < len(values) <= len(column) // _ROWS_OF_A_SETTING:
            numbered[name] = np.asarray(number.ravel(), dtype=np.int64)
    return dict(sorted(numbered.items(), key=lambda each: int(each[1].max())))
