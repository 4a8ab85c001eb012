"""Shapes along sweeps and rows that a residual is held against.

Slow ones, shared ones, waves and drifts.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import svd

from springpot.measurement.measurement import Measurement
from springpot.measurement.one_frequency import frequency_numbers
from springpot.measurement.sweeps import sweeps_of
from springpot.rheology.points import Real

SMOOTH_DEGREE = 5
"""Highest degree of slow polynomials along a sweep that count as structure, not as noise."""
FEWEST_ALIKE = 3
"""Sweeps in which a residual must be alike to count as structure rather than as noise."""
MOST_SHARED = 60
"""Frequencies above which sweeps are dense enough for their neighbours to show what is shared."""
DRIFT_DEGREE = 3
"""Degree of the polynomials by which a gain or a phase may creep from row to row."""
Drawn: TypeAlias = NDArray[np.floating]


def orthonormal(columns: Real, tolerance: float = 1e-9) -> Real:
    """Orthonormal basis of the columns, scaled first, so that their units do not matter."""
    size = np.sqrt(np.sum(columns * columns, axis=0))
    columns = columns[:, size > 0] / size[size > 0]
    if columns.shape[1] == 0:
        return np.zeros((len(columns), 0))
    # By singular values: parameters of a fit are often nearly dependent, and a QR would keep
    # rounding as a direction.
    try:
        u, s, _ = np.linalg.svd(columns, full_matrices=False)
    except np.linalg.LinAlgError:
        # The divide-and-conquer algorithm gives up on rare well-formed matrices; the older one does
        # not.
        u, s, _ = svd(columns, full_matrices=False, lapack_driver="gesvd")
    return u[:, s > tolerance * s[0]]


def slow_shapes(measurement: Measurement, highest: int = SMOOTH_DEGREE) -> Real:
    """Legendre polynomials along each sweep, to a degree, (m, n), zero outside their sweep."""
    shapes: list[Real] = []
    for rows, x in sweeps_of(measurement):
        # Three points for each polynomial: fewer would let them follow the noise.
        degree = min(highest, max(0, len(np.unique(x)) // 3 - 1))
        span = float(np.ptp(x))
        if span > 0:
            x = 2.0 * (x - x.min()) / span - 1.0
        else:
            x = np.zeros(len(rows))
        for polynomial in np.polynomial.legendre.legvander(x, degree).T:
            shape = np.zeros(len(measurement))
            shape[rows] = polynomial
            shapes.append(shape)
    return np.array(shapes)


def shared_shapes(measurement: Measurement) -> Real:
    """For each frequency of several sweeps a shape (m, n): one there in all sweeps, else zero.

    What errs alike at one frequency in sweep after sweep (a ripple, a notch) is no noise, however
    rough it is. None where fewer than `FEWEST_ALIKE` sweeps share their frequencies, or there are
    so many that neighbours tell more.
    """
    # By frequency, not by order: sweeps may lack single points, or run up and down.
    which = frequency_numbers(measurement)
    count = int(which.max()) + 1
    if count > MOST_SHARED or len(sweeps_of(measurement)) < FEWEST_ALIKE:
        return np.zeros((0, len(measurement)))
    together = which == np.arange(count)[:, None]
    shared: Real = together[together.sum(axis=1) >= FEWEST_ALIKE].astype(np.float64)
    return shared


def spectrum(measurement: Measurement, sample: Drawn) -> Drawn:
    """Energy of whitened residuals (m, 2n) along a cosine and a sine.

    All sweeps and both parts together.

    By least squares, not by a Fourier transform: the two waves of a slow or a fast period are not
    at right angles on few points, and their periods would stand out from noise that has none (Lomb
    1976, doi:10.1007/BF00648343).

    Returns
    -------
    ndarray, shape (m, k)
        At periods of infinity, 2 (k - 1), 2 (k - 1) / 2, ..., 2 points.
    """
    n, orders = len(measurement), [sweep.rows for sweep in sweeps_of(measurement)]
    longest = max(len(rows) for rows in orders)
    energy: Drawn = np.zeros((len(sample), longest + 1), dtype=sample.dtype)
    for rows in orders:
        pairs = _paired_waves(len(rows), longest).astype(sample.dtype)
        for offset in (0, n):
            along = (sample[:, rows + offset] @ pairs).reshape(len(sample), longest + 1, 2)
            energy += np.einsum("ijk,ijk->ij", along, along)
    return energy


@lru_cache(maxsize=64)
def _paired_waves(count: int, longest: int) -> Real:
    """Two orthonormal columns (count, 2 (longest + 1)) for each period.

    What a cosine and a sine span.
    """
    turns = np.pi / longest * np.arange(longest + 1)
    phase = turns[:, None] * np.arange(count)
    axes, sizes, _ = np.linalg.svd(
        np.stack([np.cos(phase), np.sin(phase)], axis=-1), full_matrices=False
    )
    # A constant, and the fastest alternation, have no second wave: its column is rounding.
    axes *= sizes[:, None, :] > 1e-6 * sizes[:, None, :1]
    # Nor has a sweep of a single point.
    pairs = np.zeros((longest + 1, count, 2))
    pairs[..., : axes.shape[-1]] = axes
    return np.asarray(pairs.transpose(1, 0, 2).reshape(count, -1))


def waves(measurement: Measurement, period: float) -> Real:
    """Cosine and sine along every sweep, of a period in points.

    Shape (2 sweeps, n), zero outside their sweep.
    """
    shapes = []
    for rows, _ in sweeps_of(measurement):
        phase = 2.0 * np.pi * np.arange(len(rows)) / period
        for wave in (np.cos(phase), np.sin(phase)):
            shape = np.zeros(len(measurement))
            shape[rows] = wave
            shapes.append(shape)
    return np.array(shapes)


def drift_curves(count: int) -> Real:
    """Slow curves from row to row with their constant, columns (n, q).

    What creeps while a measurement is made.
    """
    curves = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, count), DRIFT_DEGREE)
    return np.asarray(curves, dtype=np.float64)


def drift_shapes(count: int) -> Real:
    """The same without the constant, which is no drift, as shapes (q, n)."""
    return drift_curves(count).T[1:]
