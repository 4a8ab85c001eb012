"""The lines along which measured points follow one another.

One notion of a sweep for all that look at neighbours.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.points import Real
from springpot.thresholds import VARIED

from .independence import independent
from .measurement import CONDITIONS, Measurement
from .mixed_tests import told_apart
from .one_frequency import DECIMALS, at_one_frequency, held_frequency_numbers

SCALES: dict[str, Callable[[Real], Real]] = {"amplitude": np.log, "temperature": np.asarray}
"""Conditions that can be swept at one frequency, each with the scale on which K changes slowly."""


class Sweep(NamedTuple):
    """Points of one sweep.

    Attributes
    ----------
    rows : ndarray of int, shape (m,)
        Row numbers, in the order of `x`.
    x : ndarray, shape (m,)
        ln omega, or where only a condition varies ln amplitude or the temperature.

    Examples
    --------
    >>> import springpot
    >>> from springpot.measurement import sweeps_of
    >>> sweep = sweeps_of(springpot.read("artificial-hidden"))[0]
    >>> len(sweep.rows), sweep.x[:2].round(3)
    (40, array([1.145, 1.281]))
    """

    rows: NDArray[np.int64]
    x: Real


def temperatures_differ(measurement: Measurement) -> bool:
    """Whether there is more than the drift about one set temperature.

    Examples
    --------
    >>> from springpot import Measurement
    >>> from springpot.measurement import temperatures_differ
    >>> conditions = {"temperature": [20.0, 20.3]}
    >>> temperatures_differ(Measurement([1.0, 2.0], [1j, 2j], conditions=conditions))
    False
    """
    column = measurement.conditions.get("temperature")
    return column is not None and float(np.ptp(column)) >= VARIED.temperature_chosen


def sweeps_of(measurement: Measurement) -> list[Sweep]:
    """Frequency sweeps, else amplitude or temperature sweeps.

    All rows are one sweep where each differs in all.

    Parameters
    ----------
    measurement : Measurement
        The data.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.measurement import Measurement
    >>> omega = np.array([1.0, 2.0, 4.0, 1.0, 2.0, 4.0])
    >>> temperature = np.array([20.0] * 3 + [40.0] * 3)
    >>> data = Measurement(omega, np.ones(6) + 1j, conditions={"temperature": temperature})
    >>> [sweep.rows.tolist() for sweep in sweeps_of(data)]
    [[0, 1, 2], [3, 4, 5]]
    """
    # A sweep of fewer than three points has no course of its own: then the points follow another
    # condition.
    most = max(1, len(measurement) // 3)
    log_omega = np.log(measurement.omega)
    apart = list(told_apart(measurement).values())
    # First by every condition; then an amplitude that moved along with the frequency, as where the
    # force is held, does not part the points of a sweep, of which it would make one for each.
    for held in (CONDITIONS, [name for name in CONDITIONS if independent(measurement, name)]):
        groups = [
            part for _, rows in measurement.sweeps(held=held) for part in _parted(rows, apart)
        ]
        if len(groups) <= most and not at_one_frequency(measurement):
            return [_ordered(rows, log_omega) for rows in groups]
    for name, scale in SCALES.items():
        column = measurement.conditions.get(name)
        if column is None or np.ptp(column) == 0:
            continue
        groups = list(_at_constant(measurement, name))
        if len(groups) <= most:
            return [_ordered(rows, scale(column)) for rows in groups]
    # Nothing was held while something else was swept: all points in the order of frequency are the
    # best there is.
    return [_ordered(np.arange(len(measurement)), log_omega)]


def _parted(
    rows: NDArray[np.int64], columns: list[NDArray[np.int64]]
) -> Iterator[NDArray[np.int64]]:
    """The rows of each set of values of some columns (n,)."""
    if not columns:
        yield rows
        return
    _, which = np.unique(
        np.column_stack([column[rows] for column in columns]), axis=0, return_inverse=True
    )
    for group in range(int(which.max()) + 1):
        yield rows[which.ravel() == group]


def _at_constant(measurement: Measurement, swept: str) -> Iterator[NDArray[np.int64]]:
    """Rows at one frequency and equal conditions but for the swept one."""
    # A frequency that was held is told as it was measured, now a little higher and now a little
    # lower.
    columns = [held_frequency_numbers(measurement.omega).astype(float)]
    for name in SCALES:
        if name != swept and name in measurement.conditions:
            columns.append(np.round(measurement.conditions[name], DECIMALS))
    columns += [number.astype(float) for number in told_apart(measurement).values()]
    if measurement.repeat is not None:
        columns.append(measurement.repeat.astype(float))
    _, which = np.unique(np.column_stack(columns), axis=0, return_inverse=True)
    for group in range(int(which.max()) + 1):
        yield np.flatnonzero(which.ravel() == group)


def _ordered(rows: NDArray[np.int64], x: Real) -> Sweep:
    order = np.argsort(x[rows], kind="stable")
    return Sweep(rows[order], x[rows[order]])
