"""Answers as plain data, and back.

Finite numbers only, no library's own types, and what a file cannot hold is told in one line.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite, nan
from typing import Any, TypeVar

from springpot.errors import DataError

T = TypeVar("T")


def jsonable(value: Any) -> Any:
    """`value` in JSON's own types; what is not a finite number becomes null.

    Arrays become lists and complex numbers a pair ``[real, imaginary]``.
    """
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        # Neither nan nor infinity is a word of JSON, and half of all readers refuse them.
        if not isfinite(value):
            return None
        return float(value)
    if isinstance(value, complex):
        return [jsonable(value.real), jsonable(value.imag)]
    if isinstance(value, Mapping):
        return {str(key): jsonable(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [jsonable(item) for item in value]
    # NumPy's arrays and scalars, without importing NumPy for that.
    if hasattr(value, "tolist"):
        return jsonable(value.tolist())
    if hasattr(value, "to_dict"):
        return jsonable(value.to_dict())
    return str(value)


def number(value: float | None, missing: float = nan) -> float:
    """A number as JSON tells it, which has null for one that is not finite."""
    if value is None:
        return missing
    return float(value)


def alive(part: object, kind: type[T], what: str) -> T:
    """What is behind an answer, where it was asked for in this program.

    Raises
    ------
    DataError
        If there is no such thing behind it: a file holds what was said, and not the fits.
    """
    if not isinstance(part, kind):
        raise DataError(f"{what} of a file, or of tests in time, has no {kind.__name__} behind it")
    return part
