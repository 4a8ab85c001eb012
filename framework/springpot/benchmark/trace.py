"""Improvement traces as compact bytes, and what is read off them.

Between its improvements a trace is flat, so they hold its value at every evaluation;
`geometric_grid` chooses some.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from math import inf

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.points import Real

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
    if not blob:
        return np.empty(0, dtype=np.int64), np.empty(0)
    raw = zlib.decompress(blob)
    n = len(raw) // (_STEP.itemsize + _VALUE.itemsize)
    steps = np.frombuffer(raw, _STEP, n)
    return np.cumsum(steps, dtype=np.int64), np.frombuffer(
        raw, _VALUE, n, offset=n * _STEP.itemsize
    )


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
    numbers = np.floor(10.0 ** (steps / per_decade) * (1 + 1e-12)).astype(np.int64)
    return np.unique(np.append(numbers[numbers <= last], last))


def at(evaluations: NDArray[np.int64], values: Real, grid: NDArray[np.int64]) -> Real:
    """Value (m,) of a trace at evaluation numbers `grid` (m,), infinite before its first point."""
    index = np.searchsorted(evaluations, grid, side="right")
    return np.concatenate([[inf], values])[index]
