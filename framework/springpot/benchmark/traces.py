"""Improvement traces as compact bytes, and what is read off them.

Between its improvements a trace is flat, so they hold its value at every evaluation;
`geometric_grid` chooses some. Those of many trials are read together, as `Traces`.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.points import Real

from ..numerics import ROUNDING

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
    return zlib.compress(steps.tobytes() + np.array(values, dtype=_VALUE).tobytes(), 6)


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
        words = np.frombuffer(b"".join(raw), _STEP)
        # Of a trial with n improvements n words are steps, and the next two n their values.
        before = np.cumsum(counts) - counts
        rows = np.arange(counts.sum())
        steps = words[rows + np.repeat(2 * before, counts)]
        halves = 2 * rows + np.repeat(before + counts, counts)
        values = words[np.column_stack([halves, halves + 1])].view(_VALUE).ravel()
        # Counted on from the trials before, whose sum is then taken off again.
        along = np.concatenate([[0], np.cumsum(steps, dtype=np.int64)])
        return cls(counts, along[1:] - np.repeat(along[before], counts), values)

    @cached_property
    def owners(self) -> NDArray[np.int64]:
        """Whose each improvement is (N,)."""
        return np.repeat(np.arange(len(self.counts)), self.counts)

    def at(self, worth: Real, grid: NDArray[np.int64]) -> Real:
        """What of `worth` (N,) is seen (n, g) at `grid` (g,), infinite before an improvement."""
        # Each is seen from one place of the grid on until the next is: before them all, infinity.
        places = np.arange(len(worth)) + self.owners + 1
        first = np.cumsum(self.counts + 1) - self.counts - 1
        shown = np.full(len(worth) + len(first), inf)
        begin = np.zeros(len(shown), dtype=np.int64)
        shown[places], begin[places] = worth, np.searchsorted(grid, self.evaluations)
        end = np.roll(begin, -1)
        end[first - 1] = len(grid)
        return np.repeat(shown, end - begin).reshape(len(first), len(grid))

    def reached(self, excess: Real, targets: Real, grid: NDArray[np.int64]) -> Real:
        """How many falling `targets` an `excess` (N,) of all trials reached by `grid`, (g,)."""
        reached = np.searchsorted(-targets, -excess, side="right")
        before = np.roll(reached, 1)
        before[(np.cumsum(self.counts) - self.counts)[self.counts > 0]] = 0
        seen = np.searchsorted(grid, self.evaluations)
        new = np.bincount(seen, reached - before, minlength=len(grid) + 1)
        return np.cumsum(new, dtype=float)[: len(grid)]

    def hits(self, goals: Real) -> Real:
        """Evaluation at which each trial reached its goal (n,), infinite where it did not."""
        found = np.full(len(self.counts), inf)
        there = np.flatnonzero(self.values <= goals[self.owners])
        trials, first = np.unique(self.owners[there], return_index=True)
        found[trials] = self.evaluations[there[first]]
        return found

    def means(self, values: Real, last: int) -> Real:
        """Means (n,) over evaluations 1 to `last` of what each improvement is worth (N,).

        Nothing is worth anything before the first one.
        """
        following = np.roll(self.evaluations, -1)
        following[np.cumsum(self.counts)[self.counts > 0] - 1] = last + 1
        lasting = following - self.evaluations
        return np.bincount(self.owners, lasting * values, len(self.counts)) / last
