"""A parameter as it is printed: value, interval and unit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

LOST = 1000.0
"""An interval of three decades says nothing.

Sizes of one kind of parameter differ by less among all dampers.
"""


@dataclass(frozen=True)
class Value:
    """A parameter with its 95 % interval, in the unit in which it is printed.

    Attributes
    ----------
    value : float
        The value.
    low, high : float
        Ends of the interval; infinite where the data give none.
    unit : str
        Such as ``kN/m`` or ``kg``; ``-`` for a pure number.
    fixed : bool
        Whether it was given rather than identified.

    Examples
    --------
    >>> from springpot.identification import Value
    >>> print(Value(0.5985, 0.5912, 0.6059, "kg"))
    0.5985 [0.5912, 0.6059] kg
    """

    value: float
    low: float
    high: float
    unit: str
    fixed: bool = False

    @property
    def determined(self) -> bool:
        """Whether the data say how large it is: both ends exist, three decades apart at most."""
        if not (isfinite(self.low) and isfinite(self.high)):
            return False
        return self.low <= 0.0 or self.high < LOST * self.low

    def __str__(self) -> str:
        words = [f"{self.value:.4g}"]
        if not self.fixed:
            words.append(f"[{self.low:.4g}, {self.high:.4g}]")
        if self.unit != "-":
            words.append(self.unit)
        if self.fixed:
            words.append("(fixed)")
        return " ".join(words)

    def to_dict(self) -> dict[str, float | str | bool | None]:
        """As in the schemas, where an interval without an end has None."""
        entries: dict[str, float | str | bool | None] = {
            "value": finite(self.value),
            "low": finite(self.low),
            "high": finite(self.high),
            "unit": self.unit,
        }
        if self.fixed:
            entries["fixed"] = True
        return entries


def finite(value: float) -> float | None:
    """The number, or None where it is none that JSON has."""
    if not isfinite(value):
        return None
    return float(value)


def kept_interval(row: Mapping[str, Any]) -> tuple[float, float]:
    """Ends of an interval as JSON holds them, which has no word for infinity.

    Without an end it is infinite there.

    Examples
    --------
    >>> from springpot.identification import kept_interval
    >>> kept_interval({"low": 1.0, "high": None})
    (1.0, inf)
    """
    low, high = row["low"], row["high"]
    if low is None:
        low = -inf
    if high is None:
        high = inf
    return low, high
