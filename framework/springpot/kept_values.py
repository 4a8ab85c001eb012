"""Places and numbers as a file of JSON tells them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from springpot.plain_data import number

P = TypeVar("P")


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
