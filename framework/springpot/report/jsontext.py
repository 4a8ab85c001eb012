"""JSON that every reader accepts: finite numbers only, no library's own types."""

from __future__ import annotations

import json
import re
from typing import Any

from springpot.plain_data import jsonable
from springpot.terminal_safe import plain_json

NUMBERS = re.compile(r"\[\n\s*((?:-?\d[\d.eE+-]*|null|,\s+)+)\n\s*\]")
"""A list of numbers on lines of their own; within a string there is no line end."""


def to_json(value: Any, indent: int | None = 2) -> str:
    """Strict JSON text of `value`; ``indent=None`` gives one line, for JSON lines.

    Lists of numbers stand in one line each, so that people still see the rest.
    """
    text = json.dumps(jsonable(value), indent=indent, ensure_ascii=False, allow_nan=False)
    in_lines = NUMBERS.sub(lambda numbers: f"[{' '.join(numbers[1].split())}]", text)
    # Names in it come from strangers, and JSON is printed on terminals too.
    return plain_json(in_lines)
