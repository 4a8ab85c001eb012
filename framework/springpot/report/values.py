"""A parameter as printed everywhere: its value, its interval, or that the data leave it open."""

from __future__ import annotations

from math import inf, isfinite

from springpot.format_numbers import number
from springpot.identification.value import Value

from .numbers import with_interval

OPEN = "not determined"
NOTHING = 1e-3
"""Share of its upper end below which a parameter that may be zero is printed as zero."""


def shown(value: Value) -> tuple[str, str]:
    """A value and its interval as they are printed.

    Where the data leave an end open, the other end.
    """
    if value.fixed:
        return number(value.value), "fixed"
    # A value that is one thousandth of what it may be is not known to be anything.
    if value.low == 0.0 and value.value < NOTHING * value.high < inf:
        return "0", f"[0, {number(value.high, 2)}]"
    # Zero and what is below it have no decades to count, but an interval without an end says
    # nothing of them either.
    ends = isfinite(value.low) and isfinite(value.high)
    if value.determined or (value.value <= 0.0 and ends):
        return with_interval(value.value, value.low, value.high)
    # One end is known, and may be all that a user needs.
    if value.low > 0.0 and value.high == inf:
        return "-", f"{OPEN}, above {number(value.low, 2)}"
    return "-", OPEN
