"""Noise of a sweep that remembers the point before, weighed against misfits that look alike."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from springpot.measurement.independence import SMOOTH_DEGREE
from springpot.measurement.measurement import Measurement
from springpot.measurement.memory import likeliest, surprise
from springpot.measurement.mixed_tests import settings_of, sweeps_of
from springpot.rheology.points import Real
from springpot.thresholds import REPEATS

from ..numerics import SMALLEST
from .frame import FEWEST_OWN, LEAST_SEEN, NoiseFrame, orthonormal

Sums: TypeAlias = tuple[Real, Real]
"""Of shapes (s, m, ...) over lines: of their products with columns (l, s, m, 2, c), and with one
another (l, s, m, m, 2, 2)."""


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
    gain : float
        Twice the logarithm of how much likelier it is than white noise, less the price of a number.
    slow : bool
        It is alike over as long as slow structure, which it is then.
    """

    memory: float
    new: Real
    free: int
    gain: float
    slow: bool


def remembering(frame: NoiseFrame, kept: NDArray[np.bool_]) -> Remembering | None:
    """Noise with a first-order memory along the sweeps; None where white noise is as likely.

    Or white noise beside one of `_misfits`. A number more costs what the Bayesian information
    criterion charges. What `kept` (2n,) leaves out has a number of its own.
    """
    single = np.arange(frame.size)[:, None] == np.flatnonzero(~kept)
    followed = orthonormal(np.concatenate([frame.absorbed, single], axis=1))
    # By itself where other sweeps show that it is no misfit, and beside all slow structure.
    alone = [np.zeros((frame.size, 0))] if frame.shared.shape[1] else []
    for curves in (*alone, frame.structured):
        beside = orthonormal(np.concatenate([followed, curves], axis=1))
        found = _against_white(frame, beside)
        told = found.gain > 0.0 and not found.slow
        if told and found.gain > _best_misfit(frame, beside):
            return found
    return None


def _against_white(frame: NoiseFrame, followed: Real) -> Remembering:
    """The likeliest memory beside what is followed, orthonormal columns (2n, q)."""
    columns = np.column_stack([followed, frame.residual])
    free = frame.size - followed.shape[1]
    if free < FEWEST_OWN:
        return Remembering(0.0, frame.residual, free, 0.0, False)
    told = likeliest(columns, frame.links)
    longest = max(len(rows) for rows, _ in sweeps_of(frame.measurement))
    most = float(np.exp(-SMOOTH_DEGREE / longest))
    memory = min(told, most)
    cost, new = surprise(columns, memory, frame.links)
    gain = surprise(columns, 0.0, frame.links)[0] - cost - float(np.log(free))
    # Unless other sweeps show that it is not.
    slow = told > most and not frame.shared.shape[1]
    return Remembering(memory, new, free, gain, slow)


def _best_misfit(frame: NoiseFrame, followed: Real) -> float:
    """By how much the best misfit raises twice the log-likelihood beside what is followed.

    Of gain or phase or both, with the price of its numbers and of which of all it is.
    """
    rest = frame.residual - followed @ (followed.T @ frame.residual)
    free, tried = frame.size - followed.shape[1], 0
    faults = frame.relative(np.ones((1, frame.size // 2)))
    # A shape is the same in both parts of a point: their sum is taken once for all shapes.
    columns = np.column_stack([rest / max(float(np.linalg.norm(rest)), SMALLEST), followed, faults])
    products = (faults[:, :, None] * columns[:, None, :]).reshape(2, -1, 2, columns.shape[1])
    best = 0.0
    for sums, squares in _misfits(frame.measurement, products.sum(axis=0)):
        # As noise itself is told, beside what leaves enough of it.
        if free - 2 * sums.shape[1] < REPEATS.enough:
            continue
        tried += len(sums)
        for part in (slice(0, 1), slice(1, 2), slice(0, 2)):
            explained, ranks = _explained(sums[:, :, part], squares[:, :, part, :, part])
            gains = -free * np.log(np.maximum(1.0 - explained, SMALLEST)) - ranks * np.log(free)
            best = max(best, float(np.max(gains)))
    return best - 2.0 * float(np.log(max(tried, 1)))


def _explained(sums: Real, squares: Real) -> tuple[Real, NDArray[np.int64]]:
    """Shares (s,) of the first of some columns that shapes follow beside the others, and ranks.

    By their products with the columns (s, m, f, c), and with one another (s, m, f, m, f).
    """
    count = sums.shape[1] * sums.shape[2]
    along, beside = np.split(sums.reshape(len(sums), count, -1), [1], axis=2)
    squares = squares.reshape(-1, count, count)
    size = np.sqrt(np.maximum(np.einsum("sqq->sq", squares), SMALLEST))[:, :, None]
    along, beside, squares = along / size, beside / size, squares / size / np.swapaxes(size, 1, 2)
    sizes, ways = np.linalg.eigh(squares - beside @ np.swapaxes(beside, 1, 2))
    seen = sizes > LEAST_SEEN**2
    told = np.einsum("sqk,sq->sk", ways, along[:, :, 0]) ** 2
    return np.sum(told / np.where(seen, sizes, np.inf), axis=1), np.sum(seen, axis=1)


def _misfits(measurement: Measurement, products: Real) -> Iterator[Sums]:
    """Shapes that a misfit may have: slow ones, humps and ripples of m functions along sweeps.

    Alike in all sweeps, or of another size in each; and those of a column that no effect knows.

    Parameters
    ----------
    measurement : Measurement
        The data.
    products : ndarray, shape (n, 2, c)
        Gain and phase times some columns, of which gain and phase are the last two.

    Yields
    ------
    tuple of ndarray, shape (s, m, 2, c - 2) and (s, m, 2, m, 2)
        Sums over the shapes times these, and over the shapes times one another.
    """
    sweeps = sweeps_of(measurement)
    n, longest = len(measurement), max(len(rows) for rows, _ in sweeps)
    # One row more, an empty one, in which sweeps of fewer points end.
    x, apart = np.zeros(n + 1), np.full((len(sweeps), longest), n)
    for line, (rows, along) in zip(apart, sweeps, strict=True):
        line[: len(rows)], x[rows] = rows, along
    x[n] = x[:n].min()
    x = (x - x[n]) / max(float(np.ptp(x)), SMALLEST)
    products = np.concatenate([products, np.zeros((1, *products.shape[1:]))])
    together = np.arange(n)[None]
    slow = np.polynomial.legendre.legvander(2.0 * x - 1.0, SMOOTH_DEGREE).T
    for lines in (together, apart)[: len(sweeps)]:
        for degree in range(SMOOTH_DEGREE + 1):
            yield _of_lines(*_summed(slow[None, : degree + 1, lines], products[lines]))
        for sums in _along(x[lines], products[lines], longest):
            yield _of_lines(*sums)
    for number in settings_of(measurement).values():
        at_each = (number == np.arange(int(number.max()) + 1)[:, None]).astype(np.float64)
        # At each value of a column a level, a slope or a bend.
        for degree in range(3):
            shapes = (slow[: degree + 1, None, :n] * at_each).reshape(1, -1, 1, n)
            yield _of_lines(*_summed(shapes, products[together]))


def _of_lines(sums: Real, squares: Real) -> Sums:
    """Of shapes that are of another size in each of l lines: so many times as many functions."""
    apart = np.einsum("lk,lsmtab->slmaktb", np.eye(len(squares)), squares)
    s, lines, m = apart.shape[:3]
    inner = np.moveaxis(sums[..., :-2], 0, 1).reshape(s, lines * m, 2, -1)
    return inner, apart.reshape(s, lines * m, 2, lines * m, 2)


def _summed(shapes: Real, products: Real) -> Sums:
    """Of a few shapes (s, m, l, j), with products (l, j, 2, c)."""
    sums = np.einsum("smlj,ljac->lsmac", shapes, products, optimize=True)
    pairs = shapes[:, :, None] * shapes[:, None]
    return sums, np.einsum("smtlj,ljab->lsmtab", pairs, products[..., -2:], optimize=True)


def _along(x: Real, products: Real, longest: int) -> Iterator[Sums]:
    """Of half waves and humps at places (l, j), with products (l, j, 2, c), by one transform."""
    # Cells a quarter as wide as the points are apart, and as many again thrice behind a sweep.
    cells = 4 * max(longest - 1, 1)
    lines = np.zeros((len(x), cells + 1, *products.shape[2:]))
    np.add.at(lines, (np.arange(len(x))[:, None], np.rint(cells * x).astype(np.int64)), products)
    spectrum = np.fft.rfft(lines, 4 * cells, axis=1)
    # In half waves along a sweep, and twice as fine as these are independent.
    turns = np.arange(4, 2 * longest + 1)
    once, twice, mean = spectrum[:, turns], spectrum[:, 2 * turns, :, -2:], spectrum[:, :1, :, -2:]
    pairs = np.stack([mean + twice, 1j * twice, 1j * twice, mean - twice], axis=2).real
    yield (
        np.stack([once.real, -once.imag], axis=2),
        0.5 * pairs.reshape(*pairs.shape[:2], 2, 2, 2, 2),
    )
    # Humps a quarter of a sweep wide, and each time half as wide, down to half a point; in steps of
    # half of it, at which a transform cut off where they have no part is told.
    many = 32
    while 16 * longest > many:
        omega = 4.0 * np.pi / many * np.arange(many // 2 + 1)
        faded = np.exp(-0.5 * omega**2)[:, None, None]
        part = spectrum[:, : many // 2 + 1]
        sums, squares = (
            np.fft.irfft(each, many, axis=1)[:, : many // 4 + 2, None]
            for each in (np.sqrt(2.0) * faded * part, np.sqrt(faded) * part[..., -2:])
        )
        yield np.sqrt(4.0 * np.pi) * sums, np.sqrt(4.0 * np.pi) * squares[:, :, None]
        many *= 2
