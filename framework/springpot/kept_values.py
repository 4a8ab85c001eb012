"""Numbers and parameters as a file of JSON tells them."""

from __future__ import annotations

from collections.abc import Mapping
from math import nan
from typing import Any

from springpot.diagnosis import Value
from springpot.identification import kept_interval


def number(value: float | None) -> float:
    """A number; JSON has no word for one that is not finite."""
    if value is None:
        return nan
    return float(value)


def values(rows: Mapping[str, Mapping[str, Any]]) -> dict[str, Value]:
    """Parameters by name, with their intervals."""
    return {name: Value(number(row["value"]), *kept_interval(row), row["unit"]) for name, row in rows.items()}
