"""Columns that a law may go with: what was set, and not what only repeats the rest of the file."""

from __future__ import annotations

import re

import numpy as np

from springpot.measurement.independence import HELD_ALIKE, held_frequency_numbers, telling
from springpot.measurement.measurement import CONDITIONS, Measurement, numbers_of_levels
from springpot.rheology.points import Real
from springpot.thresholds import INVENTION

SMOOTH = 3
"""Degree of the polynomial in the logarithm of the frequency that a column may repeat."""
_COLUMN = re.compile(r"[A-Za-z][A-Za-z0-9]*(?:_[A-Za-z0-9]+)*")


def conditions_of(measurement: Measurement) -> list[str]:
    """Columns that were varied by themselves and whose name may stand in a formula.

    Examples
    --------
    >>> import springpot
    >>> from springpot.invention.conditions import conditions_of
    >>> data = springpot.read("nist-srm2491")
    >>> sorted(data.conditions), conditions_of(data)
    (['nist_loss', 'nist_storage', 'temperature'], ['temperature'])
    """
    told = telling(measurement)
    return [
        name
        for name in varied(measurement)
        if name in told and (name in CONDITIONS or not repeats(measurement, name))
    ]


def varied(measurement: Measurement) -> list[str]:
    """Columns that were varied at all and whose name may stand in a formula."""
    columns = measurement.conditions
    return [name for name in sorted(columns) if _COLUMN.fullmatch(name) and np.ptp(columns[name])]


def repeats(measurement: Measurement, name: str) -> bool:
    """Whether a column tells again what others do: a force, a velocity, a nominal frequency.

    What follows from frequency and amplitude does. What follows from the stiffness as well may be
    its cause, if it was held at several frequencies; else it was measured with it.

    Parameters
    ----------
    measurement : Measurement
        The data.
    name : str
        A column beside amplitude and temperature.
    """
    column = _lengths(measurement.conditions[name])
    known = [*_of_frequency(measurement)]
    known += [
        _lengths(measurement.conditions[n]) for n in CONDITIONS if n in measurement.conditions
    ]
    if _follows(column, known):
        return True
    k = measurement.stiffness
    measured = [_lengths(part) for part in (k.real, k.imag, np.abs(k))]
    measured += [*_of_runs(measurement)]
    return not _was_held(measurement, column) and _follows(column, [*known, *measured])


def _lengths(values: Real) -> Real:
    """Logarithms, in which products are sums; of what has no one sign, shares of the largest."""
    if np.all(values > 0.0) or np.all(values < 0.0):
        return np.asarray(np.log(np.abs(values)))
    return values / (np.max(np.abs(values)) or 1.0)


def _of_frequency(measurement: Measurement) -> Real:
    """Whatever goes with the frequency (m, n): a step at each, or of many a smooth course."""
    number = held_frequency_numbers(measurement.omega)
    if 3 * (int(number.max()) + 1) <= len(number):
        return np.asarray(number == np.unique(number)[:, None], dtype=np.float64)
    log_omega = np.log(measurement.omega)
    scaled = 2.0 * (log_omega - log_omega.min()) / (float(np.ptp(log_omega)) or 1.0) - 1.0
    return np.asarray(np.polynomial.legendre.legvander(scaled, SMOOTH).T, dtype=np.float64)


def _of_runs(measurement: Measurement) -> Real:
    """A step (m, n) at each run or specimen: each has a geometry of its own."""
    shapes = [np.zeros((0, len(measurement)))]
    for label in measurement.labels.values():
        names = np.unique(label)
        if 3 * len(names) <= len(label):
            shapes.append(np.asarray(label == names[1:, None], dtype=np.float64))
    return np.concatenate(shapes)


def _follows(column: Real, known: list[Real]) -> bool:
    """Whether nearly all of its spread is a sum of others; of too few rows anything would be."""
    basis = np.stack(known, axis=1)
    free = len(column) - basis.shape[1]
    if free < basis.shape[1]:
        return False
    left = column - basis @ np.linalg.lstsq(basis, column, rcond=None)[0]
    spread = np.sqrt(np.sum(left**2) / free)
    return bool(spread < INVENTION.repeated * np.std(column))


def _was_held(measurement: Measurement, column: Real) -> bool:
    """Whether most rows have their value in common with one at another frequency."""
    level = numbers_of_levels(column, HELD_ALIKE)
    frequency = held_frequency_numbers(measurement.omega)
    met = [len(np.unique(frequency[level == number])) for number in range(int(level.max()) + 1)]
    return bool(np.mean(np.array(met)[level] > 1) > 0.5)
