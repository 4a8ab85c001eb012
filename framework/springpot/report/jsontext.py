"""JSON that every reader accepts: finite numbers only, no library's own types."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from math import isfinite
from typing import Any

from springpot.plain import plain_json

NUMBERS = re.compile(r"\[\n\s*((?:-?\d[\d.eE+-]*|null|,\s+)+)\n\s*\]")
"""A list of numbers on lines of their own; within a string there is no line end."""


def jsonable(value: Any) -> Any:
    """`value` in JSON's own types; what is not a finite number becomes null.

    Arrays become lists and complex numbers a pair ``[real, imaginary]``.
    """
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return float(value) if isfinite(value) else None
    if isinstance(value, complex):
        return [jsonable(value.real), jsonable(value.imag)]
    if isinstance(value, Mapping):
        return {str(key): jsonable(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [jsonable(item) for item in value]
    if hasattr(value, "tolist"):  # NumPy's arrays and scalars
        return jsonable(value.tolist())
    if hasattr(value, "to_dict"):
        return jsonable(value.to_dict())
    return str(value)


def to_json(value: Any, indent: int | None = 2) -> str:
    """Strict JSON text of `value`; ``indent=None`` gives one line, for JSON lines.

    Lists of numbers stand in one line each, so that people still see the rest.
    """
    text = json.dumps(jsonable(value), indent=indent, ensure_ascii=False, allow_nan=False)
    return plain_json(NUMBERS.sub(lambda found: f"[{' '.join(found[1].split())}]", text))
