"""Improvement traces as compact bytes, and what is read off them.

Between its improvements a trace is flat, so they hold its value at every evaluation;
`geometric_grid` chooses some. Those of many trials are read together, as `Traces`.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import inf

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.points import Real

from ..numerics import AT_ONCE, ROUNDING

# The order of bytes is part of the format: a store may be read on another machine.
_STEP = np.dtype("<u4")
_VALUE = np.dtype("<f8")


def pack(trace: Sequence[tuple[int, float]]) -> bytes:
    """Bytes of a trace of (evaluation, objective) pairs with rising evaluations."""
    if not trace:
        return b""
    # Steps and values apart: small numbers among themselves compress well, and values hardly.
    evaluations, values = zip(*trace, strict=True)
    steps = np.diff(np.array(evaluations, dtype=np.int64), prepend=0).astype(_STEP)
    return _stream(steps.tobytes(), np.array(values, dtype=_VALUE).tobytes())


def _stream(packed: bytes, plain: bytes) -> bytes:
    """A zlib stream (RFC 1950) whose first bytes are compressed, and whose others lie as they are.

    Last digits hardly compress, and steps as well by the format's own table as by one of each
    trace: those of suite_race and suite_rugged are 2 and 4 % longer than by one that tries both,
    made in 0.4 of the time and read in a third.
    """
    head, most = zlib.compressobj(6, strategy=zlib.Z_FIXED), 0xFFFF
    parts = [head.compress(packed), head.flush(zlib.Z_FULL_FLUSH)]
    for first in range(0, len(plain), most):
        block = plain[first : first + most]
        # Whether it is the last, its length and that length's complement (RFC 1951, 3.2.4).
        about = first + most >= len(plain), len(block), len(block) ^ most
        parts += [struct.pack("<BHH", *about), block]
    return b"".join(parts) + struct.pack(">I", zlib.adler32(plain, zlib.adler32(packed)))


def unpack(blob: bytes) -> tuple[NDArray[np.int64], Real]:
    """Evaluations (n,) and values (n,) of a packed trace."""
    raw = zlib.decompress(blob) if blob else b""
    count = len(raw) // (_STEP.itemsize + _VALUE.itemsize)
    # By itself: every trial's is looked at as it comes, and `Traces` is made for many.
    steps = np.frombuffer(raw, _STEP, count)
    return np.cumsum(steps, dtype=np.int64), np.frombuffer(raw, _VALUE, offset=steps.nbytes)


def pack_values(values: Real) -> bytes:
    """Bytes of values (n,) whose evaluation numbers are those of another trace."""
    return zlib.compress(np.asarray(values, dtype=_VALUE).tobytes(), 6)


def unpack_values(blob: bytes) -> Real:
    """Values (n,) of `pack_values`."""
    return np.frombuffer(zlib.decompress(blob), _VALUE)


def improvements(values: Real) -> list[tuple[int, float]]:
    """Trace of the running minimum of `values` (n,), row i being evaluation i + 1."""
    before = np.concatenate([[inf], np.minimum.accumulate(values)[:-1]])
    rows = np.flatnonzero(values < before)
    return list(zip((rows + 1).tolist(), values[rows].tolist(), strict=True))


def geometric_grid(last: int, per_decade: int = 20) -> NDArray[np.int64]:
    """Evaluation numbers (m,) from 1 to `last` in equal ratios, both ends included."""
    steps = np.arange(int(per_decade * np.log10(max(last, 1))) + 1)
    # A power that rounding has left just below a whole number is that number.
    numbers = np.floor(10.0 ** (steps / per_decade) * (1 + ROUNDING)).astype(np.int64)
    return np.unique(np.append(numbers[numbers <= last], last))


def at(evaluations: NDArray[np.int64], values: Real, grid: NDArray[np.int64]) -> Real:
    """Value (m,) of a trace at evaluation numbers `grid` (m,), infinite before its first point."""
    index = np.searchsorted(evaluations, grid, side="right")
    return np.concatenate([[inf], values])[index]


def _places(grid: NDArray[np.int64], evaluations: NDArray[np.int64]) -> NDArray[np.int64]:
    """Where each evaluation (N,) is seen first on a grid, its length where it never is."""
    if grid[-1] < AT_ONCE:
        return _place_of(tuple(grid.tolist())).take(evaluations, mode="clip")
    return np.searchsorted(grid, evaluations)


@lru_cache(maxsize=1)
def _place_of(grid: tuple[int, ...]) -> NDArray[np.int64]:
    """Where each of the numbers 0, 1, ... up to one beyond a grid is seen first on it."""
    return np.searchsorted(grid, np.arange(grid[-1] + 2))


@dataclass(frozen=True, eq=False)
class Traces:
    """The improvements of several trials, one behind the other.

    Parameters
    ----------
    counts : ndarray of int, shape (n,)
        How many each trial has.
    evaluations, values : ndarray, shape (N,)
        Of all of them.
    """

    counts: NDArray[np.int64]
    evaluations: NDArray[np.int64]
    values: Real

    @classmethod
    def of(cls, blobs: Sequence[bytes]) -> Traces:
        """Those of packed traces, an empty one having none."""
        raw = [zlib.decompress(blob) if blob else b"" for blob in blobs]
        each = _STEP.itemsize + _VALUE.itemsize
        counts = np.array([len(one) // each for one in raw], dtype=np.int64)
        ends = (_STEP.itemsize * counts).tolist()
        steps = b"".join([one[:end] for one, end in zip(raw, ends, strict=True)])
        values = b"".join([one[end:] for one, end in zip(raw, ends, strict=True)])
        # Counted on from the trials before, whose sum is then taken off again.
        along = np.zeros(len(steps) // _STEP.itemsize + 1, dtype=np.int64)
        np.cumsum(np.frombuffer(steps, _STEP), out=along[1:])
        begun = np.repeat(along[np.cumsum(counts) - counts], counts)
        return cls(counts, along[1:] - begun, np.frombuffer(values, _VALUE))

    @cached_property
    def owners(self) -> NDArray[np.int64]:
        """Whose each improvement is (N,)."""
        return np.repeat(np.arange(len(self.counts)), self.counts)

    def at(self, worth: Real, grid: NDArray[np.int64]) -> Real:
        """What of `worth` (N,) is seen (n, g) at `grid` (g,), infinite before an improvement."""
        # How many are new at each place of the grid: counted, as to seek each place takes longer.
        trials, width = len(self.counts), len(grid) + 1
        own = _places(grid, self.evaluations) + width * self.owners
        new = np.bincount(own, None, trials * width).reshape(trials, width)[:, :-1]
        seen, before = np.cumsum(new, axis=1), np.cumsum(self.counts) - self.counts
        shown: Real = np.concatenate([[inf], worth])[seen + before[:, None]]
        shown[seen == 0] = inf
        return shown

    def hits(self, goals: Real) -> Real:
        """Evaluation at which each trial reached its goal (n,), infinite where it did not."""
        found = np.full(len(self.counts), inf)
        there = np.flatnonzero(self.values <= goals[self.owners])
        first = there[np.diff(self.owners[there], prepend=-1) > 0]
        found[self.owners[first]] = self.evaluations[first]
        return found

    def means(self, values: Real, last: int) -> Real:
        """Means (n,) over evaluations 1 to `last` of what each improvement is worth (N,).

        Nothing is worth anything before the first one.
        """
        following = np.concatenate([self.evaluations[1:], self.evaluations[:1]])
        following[np.cumsum(self.counts)[self.counts > 0] - 1] = last + 1
        lasting = following - self.evaluations
        return np.bincount(self.owners, lasting * values, len(self.counts)) / last
