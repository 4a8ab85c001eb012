"""Whether rows of several tests stand together in one table, and which columns tell them apart.

Nobody fits them as one without a word, and nobody takes what sets them apart for noise.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.levels import levels_of
from springpot.rheology.points import Real
from springpot.thresholds import COURSE

from .measurement import CONDITIONS, Measurement
from .one_frequency import frequency_numbers

NOTE = "note together"
"""Key of the note in a measurement's provenance."""
RUNS = frozenset(
    (
        *(
            "run",
            "set",
            "test",
            "series",
            "specimen",
            "sample",
            "file",
            "batch",
            "cycle",
            "dataset",
            "measurement",
        ),
        *("probe", "lauf", "serie", "versuch", "messung", "essai", "prueba", "prova"),
    )
)
"""Names of columns that tell one test from another, also where they hold numbers."""
_ANSWERS = frozenset(
    {"normal_force", "torque", "stress", "gap", "time", "axial_force", "displacement"}
)
"""Names of columns that hold what a specimen answered, or when.

Rounded in the file they look like settings.
"""
TIME = "time"
"""The column in which files hold when a point was measured."""
MOST_NAMES = 0.5
"""Share of rows that distinct words may be, to be names of runs and not remarks on rows."""
_ROWS_OF_A_SETTING = 3
"""Rows of each value of a setting, on average, at least: a sweep of fewer has no course of its own.
"""

_HELD = 0.01
"""Share of the largest within which numbers with a fraction are one that was held.

A rig's own rounding, 0.400 and
0.401 mrad, is no setting. Rheometers hold what was set within 1 to 2 %."""


class Rows(Hashable, Protocol):
    """What of a measurement tells its tests and its sweeps."""

    @property
    def omega(self) -> Real:
        """Angular frequency (n,) in rad/s."""

    @property
    def conditions(self) -> Mapping[str, Real]:
        """Columns (n,) beside the frequency."""

    @property
    def labels(self) -> Mapping[str, NDArray[np.str_]]:
        """Columns (n,) of words."""

    @property
    def repeat(self) -> NDArray[np.int64] | None:
        """Which repetition a row (n,) belongs to."""


def runs_together(
    numbers: Mapping[str, Real],
    words: Mapping[str, NDArray[np.str_]],
    known: frozenset[str] = frozenset(),
) -> dict[str, str]:
    """A note where a column says that the rows are of several tests.

    They are fitted as one set of data.

    Parameters
    ----------
    numbers, words : mapping of str to ndarray, shape (n,)
        Conditions and labels of the rows.
    known : frozenset of str
        Columns of which another note tells already.
    """
    columns = []
    for key, column in {**words, **{key: numbers[key] for key in numbers if key in RUNS}}.items():
        values = np.unique(column[column == column])  # not those that are missing
        # A word on nearly every row is a remark, such as a time of day, and names no test.
        several = 1 < len(values) <= max(2, MOST_NAMES * len(column))
        if (
            several
            and key not in known
            and not _names_a_condition(np.unique(column, return_inverse=True)[1], numbers)
        ):
            columns.append(
                f"{len(values)} values of {key}, choose one by '@{_chosen(key, values[0])}'"
            )
    if not columns:
        return {}
    return {NOTE: f"rows of several tests are together: {'; '.join(columns)}"}


def _chosen(column: str, value: np.str_ | np.float64) -> str:
    """How a user chooses the rows of one value: ``current=0.5``."""
    if isinstance(value, np.str_):
        return f"{column}={value}"
    return f"{column}={value:g}"


def largest_test(measurement: Measurement, column: str) -> str:
    """How a user chooses the rows of a column's most frequent value, such as ``current=0.5``.

    Parameters
    ----------
    measurement : Measurement
        The data.
    column : str
        One of its conditions or labels.

    Examples
    --------
    >>> from springpot import Measurement
    >>> from springpot.measurement import largest_test
    >>> data = Measurement([1.0, 2.0, 1.0], [1j, 2j, 3j], conditions={"current": [0.0, 0.0, 0.5]})
    >>> largest_test(data, "current")
    'current=0'
    """
    words = {**measurement.conditions, **measurement.labels}[column]
    values, count = np.unique(words, return_counts=True)
    return _chosen(column, values[np.argmax(count)])


def tests_together(measurement: Measurement) -> list[str]:
    """Columns that name the tests of which rows stand together, those of few values first."""
    settings = settings_of(measurement)
    apart = told_apart(measurement)
    return [
        name for name in settings if name in measurement.labels or name in RUNS or name in apart
    ]


def settings_of(data: Rows) -> dict[str, NDArray[np.int64]]:
    """Columns that no effect knows and that hold a setting, test or specimen, few values first.

    Parameters
    ----------
    data : Measurement
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
    columns: dict[str, NDArray[np.float64] | NDArray[np.str_]] = dict(data.labels)
    columns |= {
        name: column
        for name, column in data.conditions.items()
        if name not in {*CONDITIONS, *_ANSWERS}
    }
    if TIME in data.conditions and _is_an_age(data):
        columns[TIME] = data.conditions[TIME]
    numbered = {}
    for name, column in columns.items():
        values, number = np.unique(column, return_inverse=True)
        number = number.ravel().astype(np.int64)
        # What differs from row to row was measured, as a torque is, and not set.
        if not 1 < len(values) <= len(column) // _ROWS_OF_A_SETTING:
            continue
        if not _was_held(np.asarray(values)) and not _names_a_condition(number, data.conditions):
            numbered[name] = number
    return dict(sorted(numbered.items(), key=lambda each: int(each[1].max())))


def _is_an_age(data: Rows) -> bool:
    """Whether a time stands for whole sweeps, few of them.

    A waiting time that was chosen, not that of a point.

    Within one sweep a time that is rounded stands still too, but no frequency comes again.
    """
    time = data.conditions[TIME]
    ages, number = np.unique(time, return_inverse=True)
    # More tell a course in time.
    if not 1 < len(ages) < COURSE.fewest_times:
        return False
    frequency = frequency_numbers(data)
    seen = np.unique(np.column_stack([number.ravel(), frequency]), axis=0)
    # Each frequency at most of the ages, on average.
    return bool(2 * len(seen) > len(ages) * len(np.unique(frequency)))


def _was_held(values: NDArray[np.generic]) -> bool:
    """Whether distinct values, ascending, are one that was held.

    Whole numbers may count specimens or years.
    """
    if values.dtype.kind not in "fi" or np.all(np.round(values.astype(float)) == values):
        return False
    return bool(np.ptp(values) <= _HELD * np.max(np.abs(values)))


def _names_a_condition(number: NDArray[np.intp], conditions: Mapping[str, Real]) -> bool:
    """Whether each level of temperature or amplitude has one value of a column, as a step has."""
    for name in CONDITIONS:
        if name not in conditions:
            continue
        level = levels_of(name, conditions[name])
        pairs = np.unique(np.column_stack([level, number.ravel()]), axis=0)
        if len(pairs) == len(np.unique(level)) < len(level):
            return True
    return False


# Every look at neighbours asks anew, of the same data: of a few it is remembered.
@lru_cache(maxsize=8)
def told_apart(data: Rows) -> dict[str, NDArray[np.int64]]:
    """The settings (n,) without which rows alike in frequency and conditions would be one point.

    Such rows are neither repeats of each other nor points of one sweep. Names set apart what is no
    other repeat already: a column of specimens that are the repeats themselves stays out. Numbers
    are sizes of something that was changed, whether or not the rows are numbered as repeats.

    Parameters
    ----------
    data : Measurement
        The data.
    """
    settings = settings_of(data)
    if not settings:
        return {}
    same = [frequency_numbers(data)]
    same += [
        levels_of(name, data.conditions[name]) for name in CONDITIONS if name in data.conditions
    ]
    repeat = np.zeros(len(data.omega), dtype=np.int64)
    if data.repeat is not None:
        repeat = data.repeat
    apart: dict[str, NDArray[np.int64]] = {}

    def points(beside: Sequence[NDArray[np.int64]], name: str) -> int:
        columns = [*same, *apart.values(), *beside]
        # A name and a repeat are two words for one thing; a size and a repeat are not.
        if name in data.labels or name in RUNS:
            columns.append(repeat)
        return len(np.unique(np.column_stack(columns), axis=0))

    while more := sorted(settings.keys() - apart.keys()):
        left = {name: points([settings[name]], name) - points([], name) for name in more}
        # Whatever tells most rows apart first: beside it others, such as the number of cycles, say
        # nothing more.
        name = min(left, key=lambda name: (-left[name], int(settings[name].max()), name))
        if left[name] == 0:
            break
        apart[name] = settings[name]
    return apart
