"""The runs of a measurement.

Rows in which one thing was swept while all that is said of the others stayed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.levels import levels_of
from springpot.rheology.points import Real
from springpot.thresholds import VARIED

from .mixed_tests import MOST_NAMES, RUNS, Rows, told_apart
from .one_frequency import held_frequency_numbers


@dataclass(frozen=True, eq=False)
class Run:
    """Rows that were measured under one set of conditions.

    Parameters
    ----------
    conditions : dict of str to str or float
        What tells them from other rows: step, run, repeat, temperature and amplitude (the means),
        as far as known.
    rows : ndarray of int
        Their numbers.
    """

    conditions: dict[str, str | float]
    rows: NDArray[np.int64]

    @property
    def name(self) -> str:
        """Such as ``temperature 20, repeat 1``; ``all`` where nothing tells the rows apart."""
        parts = []
        for name, value in self.conditions.items():
            if not isinstance(value, str):
                value = f"{value:.4g}"
            parts.append(f"{name} {value}")
        return ", ".join(parts) or "all"


def runs_of(data: Rows) -> Iterator[Run]:
    """The sweeps, by runs and conditions.

    By the names of parts and runs in the order of the file, then by temperature, amplitude and
    repeat.

    A condition that was itself swept or only wandered does not part them: a temperature ramp is one
    sweep, and so is a frequency sweep in which the strain follows the frequency.

    Parameters
    ----------
    data : Measurement
        The data.
    """
    # Names first, since they were given; levels of conditions are only read off the numbers.
    parts = [np.arange(len(data.omega))]
    for column in _named(data):
        parts = _split(parts, partial(_by_value, column))
    for name in ("temperature", "amplitude"):
        if name in data.conditions:
            parts = _split(parts, partial(_by_level, data, name))
    # Last: a repeat is one of a sweep, under conditions that are the same.
    if data.repeat is not None:
        parts = _split(parts, partial(_by_repeat, data.repeat))
    for rows in parts:
        yield Run(_conditions(data, rows, len(parts)), rows)


def _split(
    parts: list[NDArray[np.int64]], divide: Callable[[NDArray[np.int64]], list[NDArray[np.int64]]]
) -> list[NDArray[np.int64]]:
    """The finer parts that each of some parts consists of."""
    finer: list[NDArray[np.int64]] = []
    for rows in parts:
        finer += divide(rows)
    return finer


def _by_value(column: NDArray[np.str_] | Real, rows: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """The rows of each value, in the order of the file."""
    return [rows[column[rows] == value] for value in dict.fromkeys(column[rows].tolist())]


def _by_repeat(repeat: NDArray[np.int64], rows: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """The rows of each repeat, ascending."""
    return [rows[repeat[rows] == value] for value in np.unique(repeat[rows])]


def _named(data: Rows) -> list[NDArray[np.str_] | Real]:
    """Columns that name parts and runs."""
    columns: list[NDArray[np.str_] | Real] = []
    for name, words in data.labels.items():
        if name == "step" or len(np.unique(words)) <= MOST_NAMES * len(words):
            columns.append(words)
    apart = told_apart(data)
    return [
        *columns,
        *(column for name, column in data.conditions.items() if name in RUNS or name in apart),
    ]


def _by_level(data: Rows, name: str, rows: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """The rows of each level, ascending, where frequencies were swept at each.

    Else all as they are.
    """
    level = levels_of(name, data.conditions[name][rows])
    count = int(level.max()) + 1
    frequency = held_frequency_numbers(data.omega[rows])
    pairs = len(np.unique(np.column_stack([level, frequency]), axis=0))
    # A level at which one frequency was measured is no sweep.
    if count == 1 or pairs < 2 * count:
        return [rows]
    if name == "amplitude" and pairs < VARIED.recurs * len(np.unique(frequency)):
        return [rows]
    return [rows[level == number] for number in range(count)]


def _conditions(data: Rows, rows: NDArray[np.int64], count: int) -> dict[str, str | float]:
    """What holds for all of the rows."""
    shared: dict[str, str | float] = {}
    for name, words in data.labels.items():
        if name == "step" or (
            count > 1 and len(set(words[rows])) == 1 and len(np.unique(words)) > 1
        ):
            shared[name] = str(words[rows[0]])
    for name in ("temperature", "amplitude"):
        column = data.conditions.get(name)
        # The amplitude is told only where it was set: it wanders in every sweep.
        if column is not None and (name == "temperature" or _is_set(column, rows)):
            shared[name] = float(np.mean(column[rows]))
    names = RUNS | told_apart(data).keys()
    shared |= {
        name: float(data.conditions[name][rows[0]]) for name in data.conditions if name in names
    }
    if data.repeat is not None:
        shared["repeat"] = float(data.repeat[rows[0]])
    return shared


def _is_set(column: Real, rows: NDArray[np.int64]) -> bool:
    """Whether the rows are one level of an amplitude that has several."""
    return (
        int(levels_of("amplitude", column[rows]).max()) == 0
        and int(levels_of("amplitude", column).max()) > 0
    )
