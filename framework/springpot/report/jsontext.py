"""JSON that every reader accepts: finite numbers only, no library's own types."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from math import isfinite
from typing import Any

from springpot.terminal_safe import plain_json

NUMBERS = re.compile(r"\[\n\s*((?:-?\d[\d.eE+-]*|null|,\s+)+)\n\s*\]")
"""A list of numbers on lines of their own; within a string there is no line end."""


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


def to_json(value: Any, indent: int | None = 2) -> str:
    """Strict JSON text of `value`; ``indent=None`` gives one line, for JSON lines.

    Lists of numbers stand in one line each, so that people still see the rest.
    """
    text = json.dumps(jsonable(value), indent=indent, ensure_ascii=False, allow_nan=False)
    in_lines = NUMBERS.sub(lambda numbers: f"[{' '.join(numbers[1].split())}]", text)
    # Names in it come from strangers, and JSON is printed on terminals too.
    return plain_json(in_lines)
