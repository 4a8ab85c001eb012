"""Numbers and parameters as a file of JSON tells them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import nan
from typing import Any, TypeVar

from springpot.identification.value import kept_interval
from springpot.misfit.values import Value

P = TypeVar("P")


def number(value: float | None) -> float:
    """A number; JSON has no word for one that is not finite."""
    if value is None:
        return nan
    return float(value)


def values(rows: Mapping[str, Mapping[str, Any]]) -> dict[str, Value]:
    """Parameters by name, with their intervals."""
    by_name = {}
    for name, row in rows.items():
        low, high = kept_interval(row)
        by_name[name] = Value(number(row["value"]), low, high, row["unit"])
    return by_name


def place(kind: Callable[[str, str, float, float, float, str], P], row: Mapping[str, Any]) -> P:
    """A place at which a model fails, of the kind that sweeps or tests in time have."""
    return kind(
        row["plane"],
        row["condition"],
        number(row["from"]),
        number(row["to"]),
        row["size"],
        row["says"],
    )
