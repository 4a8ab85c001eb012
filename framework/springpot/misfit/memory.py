"""Whether what a fit leaves goes on from point to point: noise with a memory, or a misfit."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from springpot.measurement.independence import SMOOTH_DEGREE
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_tests import sweeps_of
from springpot.rheology.points import Real

from ..numerics import SMALLEST
from .frame import FEWEST_OWN, LEAST_SEEN, NoiseFrame, orthonormal


class Remembering(NamedTuple):
    """Noise of which neighbours share a part.

    Attributes
    ----------
    memory : float
        Correlation of neighbours in a sweep.
    new : ndarray, shape (2n,)
        What is new with each number, of the size of the noise.
    free : int
        Numbers that nothing follows.
    """

    memory: float
    new: Real
    free: int


def remembering(frame: NoiseFrame, kept: NDArray[np.bool_]) -> Remembering | None:
    """Noise with a first-order memory along the sweeps; None where white noise is as likely.

    Either may lie beside the likeliest of `_misfits`. A number more costs what the Bayesian
    information criterion charges. What `kept` (2n,) leaves out has a number of its own.
    """
    alone = np.eye(frame.size)[:, ~kept]
    followed = orthonormal(np.concatenate([frame.absorbed, alone], axis=1))
    if frame.size - followed.shape[1] < FEWEST_OWN:
        return None
    gain, found = _against_white(frame, followed)
    # A misfit goes on from point to point as well: what seems white beside none is.
    if gain <= 0.0:
        return None
    change, misfit = _best_misfit(frame, followed)
    gain_beside, found_beside = _against_white(frame, np.column_stack([followed, misfit]))
    if max(gain_beside, 0.0) - change > gain:
        gain, found = gain_beside, found_beside
    return found if gain > 0.0 else None


def _against_white(frame: NoiseFrame, followed: Real) -> tuple[float, Remembering]:
    """By how much a memory changes twice the log-likelihood, and the noise that has it.

    Beside what is followed, orthonormal columns (2n, q), and with the price of a number.
    """
    columns = np.column_stack([followed, frame.residual])
    free = frame.size - followed.shape[1]
    # What is alike over as long as slow structure is that.
    longest = max(len(sweep.rows) for sweep in sweeps_of(frame.measurement))
    most = float(np.exp(-SMOOTH_DEGREE / longest))
    found = minimize_scalar(lambda m: _cost(frame, columns, m)[0], bounds=(0.0, most))
    cost, new = _cost(frame, columns, float(found.x))
    gain = _cost(frame, columns, 0.0)[0] - cost - float(np.log(free))
    return gain, Remembering(float(found.x), new, free)


def _cost(frame: NoiseFrame, columns: Real, memory: float) -> tuple[float, Real]:
    """Minus twice the log-likelihood of a memory, and what is new with each point (2n,).

    Of what curves leave of the last of some columns (2n, q + 1), the others being these curves
    (Harville 1977, doi:10.1080/01621459.1977.10480998).
    """
    basis, sizes = np.linalg.qr(frame.forgetting(columns, memory))
    size = np.abs(np.diag(sizes)) + SMALLEST
    free = len(columns) - len(size) + 1
    logs = 2.0 * (free * np.log(size[-1]) + np.sum(np.log(size[:-1])))
    return float(logs + frame.links * np.log1p(-(memory**2))), basis[:, -1] * size[-1]


def _best_misfit(frame: NoiseFrame, followed: Real) -> tuple[float, Real]:
    """By how much the best misfit changes minus twice the log-likelihood, and its columns (2n, q).

    Of gain or phase or both, with the price of its numbers and of which of all it is.
    """
    rest = frame.residual - followed @ (followed.T @ frame.residual)
    free, tried = frame.size - followed.shape[1], 0
    best, found = 0.0, np.zeros((frame.size, 0))
    for shapes in _misfits(frame.measurement):
        tried += len(shapes)
        whole = frame.relative(shapes.reshape(-1, shapes.shape[-1]))
        whole = whole / np.maximum(np.linalg.norm(whole, axis=0), SMALLEST)
        left = whole - followed @ (followed.T @ whole)
        # (2n, shapes, gain and phase, functions)
        left = np.moveaxis(left.reshape(frame.size, 2, len(shapes), -1), 1, 2)
        for columns in (left[:, :, :1], left[:, :, 1:], left):
            each = np.moveaxis(columns.reshape(*columns.shape[:2], -1), 1, 0)
            explained, ranks = _explained(each, rest)
            gains = free * np.log(np.maximum(1.0 - explained, SMALLEST)) + ranks * np.log(free)
            if np.min(gains) < best:
                best, found = float(np.min(gains)), orthonormal(each[np.argmin(gains)], LEAST_SEEN)
    return best + 2.0 * float(np.log(tried)), found


def _explained(columns: Real, rest: Real) -> tuple[Real, NDArray[np.int64]]:
    """Shares (s,) of squares of values (2n,) that some columns (s, 2n, q) follow, and ranks."""
    turned = np.swapaxes(columns, 1, 2)
    sizes, ways = np.linalg.eigh(turned @ columns)
    seen = sizes > LEAST_SEEN**2
    along = np.einsum("sqk,sq->sk", ways, turned @ rest) ** 2
    squares = np.sum(np.where(seen, along / np.where(seen, sizes, 1.0), 0.0), axis=1)
    return squares / float(rest @ rest), np.sum(seen, axis=1)


def _misfits(measurement: Measurement) -> Iterator[Real]:
    """Shapes (s, m, n) that a misfit may have: slow ones, humps and ripples of m functions.

    Alike in all sweeps, or of another size in each.
    """
    sweeps = [sweep.rows for sweep in sweeps_of(measurement)]
    longest = max(len(rows) for rows in sweeps)
    inside = np.array([np.isin(np.arange(len(measurement)), rows) for rows in sweeps])
    x = np.log(measurement.omega)
    x = (x - x.min()) / max(float(np.ptp(x)), SMALLEST)
    alike = [np.polynomial.legendre.legvander(2.0 * x - 1.0, SMOOTH_DEGREE).T[None]]
    alike = [alike[0][:, : degree + 1] for degree in range(SMOOTH_DEGREE + 1)]
    width = 0.25
    while width * longest > 0.5:
        places = np.arange(0.0, 1.0 + width, 0.5 * width)
        alike.append(np.exp(-0.5 * ((x - places[:, None]) / width) ** 2)[:, None])
        width *= 0.5
    # In half waves along a sweep, and twice as fine as these are independent.
    turns = np.pi * x * np.arange(2.0, longest + 0.5, 0.5)[:, None]
    alike += np.array_split(np.stack([np.cos(turns), np.sin(turns)], axis=1), 1 + longest // 16)
    for shapes in alike:
        yield shapes
        if len(sweeps) > 1:
            yield (shapes[:, :, None] * inside).reshape(len(shapes), -1, len(x))
