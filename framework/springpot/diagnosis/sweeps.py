"""The lines along which measured points follow one another, where neighbours should differ by noise and slowly."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from springpot.measurement import Measurement
from springpot.rheology import Real

SMOOTH_DEGREE = 5
"""Highest degree of the slow polynomials along a sweep that count as structure rather than as noise."""
ALONG: dict[str, Callable[[Real], Real]] = {"amplitude": np.log, "temperature": np.asarray}
"""Conditions that can be swept at one frequency, each with the scale on which K changes slowly."""


FEWEST_ALIKE = 3
"""Sweeps in which a residual must be alike to count as structure rather than as noise."""
MOST_SHARED = 60
"""Frequencies above which sweeps are dense enough for their neighbours to show what is shared."""
DRIFT_DEGREE = 3
"""Degree of the polynomials by which a gain or a phase may creep from row to row."""
DRIFT = 1.0
"""Kelvin by which temperatures differ at least if they were chosen."""


def temperatures_differ(measurement: Measurement) -> bool:
    """Whether there is more than the drift about one set temperature."""
    column = measurement.conditions.get("temperature")
    return column is not None and float(np.ptp(column)) >= DRIFT


class Sweep(NamedTuple):
    """Points of one sweep.

    Attributes
    ----------
    rows : ndarray of int, shape (m,)
        Row numbers, in the order of `x`.
    x : ndarray, shape (m,)
        ln omega, or where only a condition varies ln amplitude or the temperature.
    """

    rows: NDArray[np.int64]
    x: Real


def sweeps_of(measurement: Measurement) -> list[Sweep]:
    """Frequency sweeps, else amplitude or temperature sweeps; all rows are one sweep where each differs in all."""
    most = max(1, len(measurement) // 3)
    log_omega = np.log(measurement.omega)
    found = [rows for _, rows in measurement.sweeps()]
    if len(found) <= most and np.ptp(log_omega) > 0:
        return [_ordered(rows, log_omega) for rows in found]
    for name, scale in ALONG.items():
        column = measurement.conditions.get(name)
        if column is None or np.ptp(column) == 0:
            continue
        groups = list(_at_constant(measurement, log_omega, name))
        if len(groups) <= most:
            return [_ordered(rows, scale(column)) for rows in groups]
    return [_ordered(np.arange(len(measurement)), log_omega)]


def _at_constant(measurement: Measurement, log_omega: Real, swept: str) -> Iterator[NDArray[np.int64]]:
    """Rows at one frequency and equal conditions but for the swept one."""
    columns: list[Real] = [np.round(log_omega, 6)]
    columns += [np.round(measurement.conditions[name], 6) for name in ALONG
                if name != swept and name in measurement.conditions]  # fmt: skip
    if measurement.repeat is not None:
        columns.append(measurement.repeat.astype(float))
    _, which = np.unique(np.column_stack(columns), axis=0, return_inverse=True)
    for group in range(int(which.max()) + 1):
        yield np.flatnonzero(which.ravel() == group)


def _ordered(rows: NDArray[np.int64], x: Real) -> Sweep:
    order = np.argsort(x[rows], kind="stable")
    return Sweep(rows[order], x[rows[order]])


def slow_shapes(measurement: Measurement) -> Real:
    """Legendre polynomials along each sweep, shape (m, n), zero outside their sweep."""
    shapes: list[Real] = []
    for rows, x in sweeps_of(measurement):
        degree = min(SMOOTH_DEGREE, max(0, len(np.unique(x)) // 3 - 1))
        span = float(np.ptp(x))
        x = 2.0 * (x - x.min()) / span - 1.0 if span > 0 else np.zeros(len(rows))
        for polynomial in np.polynomial.legendre.legvander(x, degree).T:
            shape = np.zeros(len(measurement))
            shape[rows] = polynomial
            shapes.append(shape)
    return np.array(shapes)


def shared_shapes(measurement: Measurement) -> Real:
    """For each frequency of several sweeps a shape (m, n) that is one there in all of them and zero elsewhere.

    What errs alike at one frequency in sweep after sweep (a ripple, a notch) is no noise, however rough it is. None
    where fewer than `FEWEST_ALIKE` sweeps share their frequencies, or there are so many that neighbours tell more.
    """
    distinct, which = np.unique(np.round(np.log(measurement.omega), 4), return_inverse=True)
    if len(distinct) > MOST_SHARED or len(sweeps_of(measurement)) < FEWEST_ALIKE:
        return np.zeros((0, len(measurement)))
    together = which.ravel() == np.arange(len(distinct))[:, None]
    shared: Real = together[together.sum(axis=1) >= FEWEST_ALIKE].astype(np.float64)
    return shared


def spectrum(measurement: Measurement, sample: Real) -> Real:
    """Power of whitened residuals (m, 2n) along the sweeps, all of them and both parts together.

    Returns
    -------
    ndarray, shape (m, k)
        At periods of infinity, 2 (k - 1), 2 (k - 1) / 2, ..., 2 points.
    """
    n, orders = len(measurement), [sweep.rows for sweep in sweeps_of(measurement)]
    length = 2 * max(len(rows) for rows in orders)
    power: Real = np.zeros((len(sample), length // 2 + 1))
    for rows in orders:
        for offset in (0, n):
            power += np.abs(np.fft.rfft(sample[:, rows + offset], length)) ** 2
    return power


def waves(measurement: Measurement, period: float) -> Real:
    """Cosine and sine along every sweep, of a period in points, shape (2 sweeps, n), zero outside their sweep."""
    shapes = []
    for rows, _ in sweeps_of(measurement):
        phase = 2.0 * np.pi * np.arange(len(rows)) / period
        for wave in (np.cos(phase), np.sin(phase)):
            shape = np.zeros(len(measurement))
            shape[rows] = wave
            shapes.append(shape)
    return np.array(shapes)


def drift_shapes(count: int) -> Real:
    """Slow curves from row to row, shape (DRIFT_DEGREE, n): what creeps while a measurement is made."""
    curves = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, count), DRIFT_DEGREE).T[1:]
    return np.asarray(curves, dtype=np.float64)
