"""A parameter as it is printed: value, interval and unit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

from springpot.measurement.units import Units
from springpot.plain_data import jsonable, number
from springpot.rheology.model import Model
from springpot.rheology.parameters import Parameter
from springpot.rheology.points import Real

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
    tied : str
        How it follows from other parameters, if it does.

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
    tied: str = ""

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
        if self.tied:
            words.append(f"({self.tied})")
        return " ".join(words)

    def to_dict(self) -> dict[str, Any]:
        """As in the schemas, where an interval without an end has None."""
        entries = jsonable(vars(self))
        if not self.fixed:
            del entries["fixed"]
        if not self.tied:
            del entries["tied"]
        return dict(entries)

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> Value:
        """What `to_dict` gave."""
        low, high = number(row["low"], -inf), number(row["high"], inf)
        fixed, tied = bool(row.get("fixed")), str(row.get("tied", ""))
        return cls(float(row["value"]), low, high, row["unit"], fixed, tied)


def values_of(rows: Mapping[str, Mapping[str, Any]]) -> dict[str, Value]:
    """Parameters by name, as their `to_dict` gave them."""
    return {name: Value.from_dict(row) for name, row in rows.items()}


def printed(
    parameters: Sequence[Parameter], values: Real, low: Real, high: Real, units: Units
) -> dict[str, Value]:
    """Parameters with their intervals in printed units.

    Lines of a spectrum are told as a whole and left out.

    Parameters
    ----------
    parameters : sequence of Parameter
        Length p.
    values, low, high : ndarray, shape (p,)
        In the units of the measurement.
    units : Units
        Those of the measurement.
    """
    rows = {}
    for i, parameter in enumerate(parameters):
        # Lines of a spectrum are told as a whole elsewhere: a list of fifty weights tells nobody
        # anything.
        if parameter.detail:
            continue
        factor, label = units.of(parameter.unit)
        value, below, above = (factor * float(column[i]) for column in (values, low, high))
        rows[parameter.name] = Value(value, below, above, label)
    return rows


def all_parameters(
    model: Model,
    theta: Real,
    low: Real,
    high: Real,
    units: Units,
    tied: Mapping[str, tuple[str, Value]] | None = None,
) -> dict[str, Value]:
    """All parameters of a fit, those that were held or are tied in their places; see `printed`.

    What is tied is given by its name, with that of the parameter that it is a level's own of.
    """
    free = printed(model.parameters, theta, low, high, units)
    held, tied = model.held, tied or {}
    if not (held or tied):
        return free
    rows, known_as = {}, dict(zip(model.names, model.origins, strict=True))
    for parameter in model.released().parameters:
        name = parameter.name
        if name in held:
            factor, label = units.of(parameter.unit)
            value = factor * held[name]
            rows[name] = Value(value, value, value, label, fixed=True)
        rows |= {own: row for own, row in free.items() if known_as[own] == name}
        rows |= {own: row for own, (origin, row) in tied.items() if origin == name}
    # Shares of orders are none of the released model's.
    return {**rows, **free}
