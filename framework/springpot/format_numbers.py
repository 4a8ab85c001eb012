"""How numbers are written everywhere: as many digits as are known, and no more.

And how things are counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import floor, isfinite, log10

from .numerics import SMALLEST

DIGITS = 4
"""Significant digits of a number whose uncertainty is not known."""

NAMED = 3
"""Of a list in a sentence, how many are named; the rest is counted."""
LISTED = 8
"""Rows of a table, or names where one of many is wanted; the rest is counted."""
PLAIN = 4
"""Decimals of what rounds to zero.

``0.00`` beside ``0.12`` says how nearly it is known, a row of them nothing.
"""


def number(value: float | None, digits: int = DIGITS) -> str:
    """`value` with `digits` significant digits; a hyphen where there is none."""
    # Only nan differs from itself.
    if value is None or value != value:
        return "-"
    if not isfinite(value):
        if value > 0:
            return "inf"
        return "-inf"
    # Nothing has no first digit to count from.
    if value == 0:
        return "0"
    return at_place(value, exponent_of(value, digits) - digits + 1)


def exponent_of(value: float, digits: int = DIGITS) -> int:
    """Power of ten of the first digit, after rounding to `digits`: 9.9999 is printed as 10.00."""
    if abs(value) < SMALLEST:
        return 0
    exponent = floor(log10(abs(value)))
    return exponent + (round(abs(value) / 10.0**exponent, digits - 1) >= 10)


def at_place(value: float, place: int) -> str:
    """`value` rounded at 10**place; scientific where plain digits would be long."""
    if not isfinite(value):
        return number(value)
    # Nothing from below is nothing: without the sum, -0.001 would be printed as -0.00.
    rounded = round(value, -place) + 0.0
    # Nothing has no decimals, and what rounds to it would have as many as the place is small.
    if value == 0.0 or (rounded == 0.0 and -place > PLAIN):
        return "0"
    exponent = exponent_of(rounded)
    # Plain as long as people read it at a glance, and as every digit that is written is known.
    if rounded and (exponent >= 6 or exponent < -3) and exponent >= place:
        return f"{rounded:.{exponent - place}e}"
    return f"{rounded:.{max(0, -place)}f}"


def listed(names: Sequence[object], most: int | None = None) -> str:
    """Names in a row; of more than `most` it says how many more there are.

    Examples
    --------
    >>> from .format_numbers import listed
    >>> listed(["k", "c", "alpha"], 2)
    'k, c and 1 more'
    """
    shown = ", ".join(map(str, names[:most]))
    if most is not None and len(names) > most:
        shown += f" and {len(names) - most} more"
    return shown


def counted(count: int, noun: str) -> str:
    """A number with its noun, such as ``1 point`` or ``3 points``.

    Examples
    --------
    >>> from .format_numbers import counted
    >>> counted(1, "point"), counted(3, "point")
    ('1 point', '3 points')
    """
    if count == 1:
        return f"1 {noun}"
    return f"{count} {noun}s"
