"""Seals: a checksum of every row of a store.

So that damage is noticed and named instead of shown as a result.
"""

from __future__ import annotations

from collections.abc import Sequence
from hashlib import blake2b
from typing import Any

SIZE = 8
"""Bytes of a checksum: of 2^64 damaged rows one would pass."""


def seal(values: Sequence[Any]) -> bytes:
    """Checksum of a row's values.

    Texts, numbers, bytes or None, of which each has one way to be written.
    """
    # The representation of a float has all its digits, and tells 1 from 1.0 and both from "1".
    return blake2b(repr(tuple(values)).encode("utf-8", "surrogatepass"), digest_size=SIZE).digest()


def sound(row: Sequence[Any]) -> bool:
    """Whether the last value of a row is the seal of those before it."""
    return bool(row[-1] == seal(row[:-1]))
