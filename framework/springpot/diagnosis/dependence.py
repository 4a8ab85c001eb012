"""How a misfit changes with amplitude and temperature, in words."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from springpot.measurement import HELD, Measurement
from springpot.rheology import Real

from .regions import Axis, Rows
from .sweeps import temperatures_differ

SWEPT = 10.0
"""Span, in units of how nearly a rig holds a value, from which close values are a sweep, not a drift."""
CHANCE = 0.01
"""Chance below which levels are held to differ."""
ALIKE = 0.3
"""Share of a misfit by which it may differ between levels and be called the same."""
POWERS = {-2.0: "falling as 1/amplitude^2", -1.0: "falling as 1/amplitude", 1.0: "growing as amplitude",
          2.0: "growing as amplitude^2"}  # fmt: skip
CLOSE = 0.25
"""Distance of an exponent from a whole one at which it is called by it."""


@dataclass(frozen=True, eq=False)
class Part:
    """K' or K'' of a fit.

    Attributes
    ----------
    word : str
        What to call it.
    residual, relative, whitened : ndarray, shape (n,)
        Measured minus modelled: in the unit of K, as a share of |K|, in units of the noise.
    """

    word: str
    residual: Real
    relative: Real
    whitened: Real


def condition_axes(measurement: Measurement, most: int) -> list[Axis]:
    """The conditions that vary, with `most` levels at most."""
    found = []
    for name in HELD:
        column = measurement.conditions.get(name)
        if column is None or (name == "temperature" and not temperatures_differ(measurement)):
            continue
        number = _set_values(measurement, name, most)
        count = int(number.max()) + 1
        if count > 1:
            found.append(Axis(name, number if count <= most else number * most // count))
    return found


def _set_values(measurement: Measurement, name: str, most: int) -> Rows:
    """Number of the value that was set, ascending; of a sweep without steps, of the part of it, `most` at most."""
    column, number = measurement.conditions[name], measurement.levels(name)
    x = np.log(np.maximum(np.abs(column), 1e-300)) if name == "amplitude" else column
    part = np.zeros_like(number)
    for value in range(int(number.max()) + 1):
        rows = np.flatnonzero(number == value)
        span = float(np.ptp(x[rows])) / HELD[name]
        if span > SWEPT:
            distinct, rank = np.unique(x[rows], return_inverse=True)
            part[rows] = rank.ravel() * min(most, int(span), len(distinct)) // len(distinct)
    return np.asarray(np.unique(number * most + part, return_inverse=True)[1].ravel(), dtype=np.int64)


def level_words(measurement: Measurement, axis: Axis, rows: Rows) -> str:
    """Which levels some points hold: ``at 40 degC and above``; nothing where they hold all."""
    column, level = measurement.conditions[axis.name], axis.level[rows]
    if level.min() == 0 and level.max() == axis.count - 1:
        return ""
    low, high = float(column[rows].min()), float(column[rows].max())
    start = "at " if axis.name == "temperature" else "at amplitudes of "
    if _number(low) == _number(high):
        return f"{start.replace('amplitudes', 'an amplitude')}{with_unit(measurement, axis.name, low)}"
    if level.min() == 0:
        return f"{start}{with_unit(measurement, axis.name, high)} and below"
    if level.max() == axis.count - 1:
        return f"{start}{with_unit(measurement, axis.name, low)} and above"
    return f"{start}{_number(low)} to {with_unit(measurement, axis.name, high)}"


def with_unit(measurement: Measurement, name: str, value: float) -> str:
    """A temperature or an amplitude as it is printed."""
    unit = "degC" if name == "temperature" else measurement.units.amplitude
    return f"{_number(value)}{'' if unit == '-' else f' {unit}'}"


def _number(value: float) -> str:
    return f"{value:.3g}"


def dependences(measurement: Measurement, axes: list[Axis], part: Part, rows: Rows) -> Iterator[str]:
    """Whether the misfit of some points changes with the conditions; nothing where the data cannot tell."""
    for axis in axes:
        _, level = np.unique(axis.level[rows], return_inverse=True)
        if level.max() > 0:
            yield _dependence(measurement, axis.name, part, rows, level.ravel())


def _dependence(measurement: Measurement, name: str, part: Part, rows: Rows, level: Rows) -> str:
    count = np.bincount(level)
    relative = np.bincount(level, part.relative[rows]) / count
    whitened = np.bincount(level, part.whitened[rows]) / count
    middle = float(np.average(whitened, weights=count))
    uneven = float(chi2.sf(np.sum(count * (whitened - middle) ** 2), len(count) - 1)) < CHANCE
    if np.ptp(relative) <= ALIKE * np.abs(np.mean(relative)):
        these = "these " if _some(measurement, name, rows) else ""
        return f"the same at all {these}{name}s"
    if not uneven:
        return ""
    at = np.bincount(level, measurement.conditions[name][rows]) / count
    size = np.abs(relative)
    # A misfit that changes sign elsewhere is the difference of two laws and follows neither.
    lawful = name == "amplitude" and not _some(measurement, name, rows)
    law = _power(at, np.bincount(level, part.residual[rows]) / count) if lawful else ""
    rank = float(np.corrcoef(np.arange(len(size)), size)[0, 1])
    if not law and abs(rank) < 0.5:
        return f"varying with {name}"
    ends = ", ".join(f"{100 * size[i]:.2g} % at {with_unit(measurement, name, float(at[i]))}" for i in (0, -1))
    trend = f"{'larger' if rank > 0 else 'smaller'} at higher {name}s"
    return f"{law or trend} ({ends})"


def _some(measurement: Measurement, name: str, rows: Rows) -> bool:
    """Whether some points hold only a part of the range of a condition."""
    column = measurement.conditions[name]
    return float(np.ptp(column[rows])) < 0.999 * float(np.ptp(column))


def _power(amplitude: Real, residual: Real) -> str:
    """The law by which a residual changes with the amplitude, where there are levels enough to say."""
    same = residual * np.sign(np.sum(residual)) > 0
    if len(amplitude) < 4 or not np.all(same) or amplitude[-1] < 3.0 * amplitude[0] or amplitude[0] <= 0:
        return ""
    slope = float(np.polyfit(np.log(amplitude), np.log(np.abs(residual)), 1)[0])
    power = min(POWERS, key=lambda each: abs(each - slope))
    return POWERS[power] if abs(power - slope) < CLOSE else ""
