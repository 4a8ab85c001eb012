"""A digest of data that every processor agrees on.

Exponentials and sines differ from one processor to the next in their last bit, so that data which
are computed have other bytes where they are opened. The digest is of their numbers as far as a fit
can tell them apart.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from hashlib import sha256
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.points import Real

TOLD = 24
"""Binary digits of a number that count, as many as single precision has.

They tell 1e-7 apart; whatever is nearer than that is arithmetic, see `scatter.LEAST_RELATIVE`. Half
of the digits of a double lie behind them: the chance that rounding leads a computed number over the
edge between two of them is 1e-8.
"""
DEEPEST = 40
"""Binary digits below the largest of what is read together, 1e-12 of it, that count.

A zero that is computed is any number of some 1e-16 of it, as where a sine crosses zero.
"""


def digest_of_columns(
    about: object, columns: Mapping[str, NDArray[Any]], alone: Collection[str]
) -> str:
    """SHA-256 of columns by name, and of the words that go with them.

    Parameters
    ----------
    about : object
        What is plain text as its own representation.
    columns : mapping of str to ndarray
        Numbers, words or whole numbers, in an order that is no accident.
    alone : collection of str
        Those of which each number stands for itself, over however many decades: of any other a
        number is read beside the largest, of complex ones its two parts beside each other.
    """
    seen = sha256(f"{about!r}\n".encode())
    for key, column in columns.items():
        values = np.ascontiguousarray(column)
        kind = values.dtype.newbyteorder("<")
        # Kind and shape too, as the same bytes may be other numbers.
        seen.update(f"{key!r} {kind.str} {values.shape}\n".encode())
        if kind.kind == "c":
            values = told(values.view(float).reshape(*values.shape, 2))
        elif kind.kind == "f":
            values = told(values[..., np.newaxis] if key in alone else values)
        seen.update(values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes())
    return seen.hexdigest()


def told(values: Real) -> Real:
    """Numbers (..., n) to the digits that count, those along the last axis read together.

    Examples
    --------
    >>> import numpy as np
    >>> turns = np.sin([0.0, np.pi / 2.0, np.pi])
    >>> turns.tolist(), told(turns).tolist()
    ([0.0, 1.0, 1.2246467991473532e-16], [0.0, 1.0, 0.0])
    """
    finite = np.isfinite(values)
    plain = np.where(finite, values, 0.0)
    power = np.frexp(plain)[1] - TOLD
    # The largest to its own digits first: beside 0.99999999999999989 the same counts as beside 1.
    largest = np.max(np.abs(_multiples(plain, power)), axis=-1, keepdims=True, initial=0.0)
    numbers = _multiples(plain, np.maximum(power, np.frexp(largest)[1] - DEEPEST))
    # Nothing has one sign, and so has what is no number.
    return np.where(finite, numbers + 0.0, np.where(np.isnan(values), np.nan, values))


def _multiples(numbers: Real, power: NDArray[np.int32]) -> Real:
    """The nearest multiples of powers of two, which no rounding of its own makes inexact."""
    return np.ldexp(np.rint(np.ldexp(numbers, -power)), power)


def told_of(number: float) -> float:
    """One number to the digits that count."""
    return float(told(np.array([number]))[0])
