"""How numbers are printed in reports: values with their intervals, ranges and durations."""

from __future__ import annotations

from math import floor, isfinite, log10
from typing import TYPE_CHECKING

from springpot.format_numbers import at_place, exponent_of, number

from ..numerics import SMALLEST

if TYPE_CHECKING:
    from springpot.measurement.measurement import Measurement

APART = 5.0
"""Ratio of the ends of an interval from which each has its own digits.

Rounded alike, the lower one would vanish.
"""

MOST_DIGITS = 8
"""Significant digits of a number known to the last bit, as from noise-free artificial data."""


def percent(fraction: float | None, digits: int = 3) -> str:
    """A fraction as per cent, such as ``0.31 %``."""
    if fraction is None or not isfinite(fraction):
        return "-"
    return f"{number(100 * fraction, digits)} %"


def with_interval(value: float, low: float | None, high: float | None) -> tuple[str, str]:
    """A value and its interval, rounded alike to what the interval's width justifies.

    The half-width keeps two digits where they start with 10 to 35 and one above: the rule of the
    Particle Data Group's Review of Particle Physics (introduction, section 5.3).

    Returns
    -------
    tuple of str
        Such as ``("400.1", "[399.2, 401.0]")``; the interval is empty where there is none.
    """
    if low is None or high is None or low != low or high != high:
        return number(value), ""
    width = 0.5 * abs(high - low)
    # Neither an open end nor an interval of no width tells how many digits are known.
    if not isfinite(width) or width == 0:
        return number(value), f"[{number(low)}, {number(high)}]"
    # A value of nothing has no size to count digits from: its interval has.
    sized = value
    if abs(value) < SMALLEST:
        sized = width
    size = exponent_of(sized)
    place = max(_place(width), size - MOST_DIGITS + 1)
    wide = low > 0.0 and high > APART * low
    # The interval says little more than the size of the value.
    if place > size or wide:
        return number(value, 2), f"[{number(low, 2)}, {number(high, 2)}]"
    return at_place(value, place), f"[{at_place(low, place)}, {at_place(high, place)}]"


def halved(value: float, low: float, high: float) -> tuple[str, str]:
    """A value and half the width of its interval, with the digits that `with_interval` keeps."""
    width = 0.5 * (high - low)
    if width <= 0.0:
        return number(value), "0"
    place = max(_place(width), exponent_of(value if value else width) - MOST_DIGITS + 1)
    size = at_place(value, place)
    # With the decimals that the value has, however small it is.
    if "e" not in size and place <= 0:
        return size, f"{width:.{-place}f}"
    return size, at_place(width, place)


def told_range(data: Measurement) -> str:
    """The frequencies of data as the file tells them, such as ``1.00 to 48.0 Hz``."""
    first, last = float(min(data.frequency)), float(max(data.frequency))
    low, high = number(data.units.on_clock(first), 3), number(data.units.on_clock(last), 3)
    clock = data.units.clock
    if low == high:
        return f"at {low} {clock}"
    return f"{low} to {high} {clock}"


def seconds(value: float) -> str:
    """A duration in the unit that fits."""
    for limit, factor, unit in ((1e-3, 1e6, "us"), (1.0, 1e3, "ms"), (120.0, 1.0, "s")):
        if value < limit:
            return f"{number(value * factor, 3)} {unit}"
    return f"{value / 60:.1f} min"


def _place(width: float) -> int:
    """The decimal place, as a power of ten, to which a quantity with this half-width is known."""
    exponent = floor(log10(width))
    leading = round(width / 10.0 ** (exponent - 2))
    # Two digits up to 354; up to 949 one; beyond, the width rounds to 1000 and keeps two again.
    if 355 <= leading < 950:
        return exponent
    return exponent - 1
