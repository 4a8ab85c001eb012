"""What a figure shows: the column along its axis, the sweeps, and smooth curves of fitted models."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from springpot.measurement import Measurement
from springpot.rheology import Complex, Model, Points, Real

SMOOTH = 200
"""Points on each curve."""

MOST_SWEEPS = 40
"""More sweeps than this are drawn as one cloud: the condition was not held, so there are no sweeps."""

VARIES = 1.2
"""A frequency or amplitude varies if its largest value exceeds its smallest by this factor."""

WARMS = 1.0
"""A temperature varies if it spans more than this, in kelvin."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A model with its identified parameters.

    Parameters
    ----------
    model : Model
        The model.
    theta : ndarray, shape (p,)
        Its element parameters, in the units of the measurement.
    label : str
        Shown in legends; the model's name by default.
    """

    model: Model
    theta: Real
    label: str = ""

    @property
    def name(self) -> str:
        """The label, or the model's name."""
        return self.label or self.model.name

    def at(self, points: Points) -> Complex:
        """Complex stiffness (n,) at `points`."""
        return self.model.stiffness(self.theta, points)


@dataclass(frozen=True, eq=False)
class Axis:
    """The column against which data are drawn.

    Parameters
    ----------
    column : str
        ``frequency``, ``amplitude`` or ``temperature``.
    label : str
        With its unit.
    values : ndarray, shape (n,)
        Where each measured point stands.
    logarithmic : bool
        How the axis is scaled.
    """

    column: str
    label: str
    values: Real
    logarithmic: bool = True


@dataclass(frozen=True, eq=False)
class Sweep:
    """Rows measured under the same conditions, in order along the axis.

    Parameters
    ----------
    label : str
        The conditions.
    rows : ndarray of int
        Which rows.
    """

    label: str
    rows: NDArray[np.int64]


def axis_of(measurement: Measurement) -> Axis:
    """The frequency if it varies, else the amplitude or the temperature, whichever does."""
    along_frequency = Axis("frequency", "frequency f [Hz]", measurement.frequency)
    if _varies("frequency", measurement.frequency):
        return along_frequency
    labels = {"amplitude": f"amplitude [{measurement.units.amplitude}]", "temperature": "temperature [°C]"}
    for name, label in labels.items():
        column = measurement.conditions.get(name)
        if column is not None and _varies(name, column):
            return Axis(name, label, column, logarithmic=name == "amplitude" and bool(np.all(column > 0)))
    return along_frequency


def sweeps_of(measurement: Measurement, axis: Axis) -> list[Sweep]:
    """The sweeps along `axis`; one of everything where the conditions were not held."""
    conditions = measurement.conditions.items()
    held = {name: column for name, column in conditions if name != axis.column and _varies(name, column)}
    found = list(replace(measurement, conditions=held).sweeps())
    if len(found) > min(MOST_SWEEPS, max(1, len(measurement) // 2)):
        found = [("all", np.arange(len(measurement)))]
    ordered = [(label, rows[np.argsort(axis.values[rows], kind="stable")]) for label, rows in found]
    return [Sweep(_with_units(label, measurement), rows) for label, rows in ordered]


def _varies(name: str, column: Real) -> bool:
    low, high = float(np.min(column)), float(np.max(column))
    return high - low > WARMS if name == "temperature" else high > VARIES * low


def smooth(measurement: Measurement, axis: Axis, sweep: Sweep) -> tuple[Real, Points]:
    """Places along the axis between a sweep's ends, and the conditions there, interpolated."""
    along = axis.values[sweep.rows]
    place = np.log(along) if axis.logarithmic else along
    known, first = np.unique(place, return_index=True)
    fine = np.linspace(known[0], known[-1], SMOOTH) if len(known) > 1 else known

    def between(column: Real | None) -> Real | None:
        return None if column is None else np.interp(fine, known, column[sweep.rows][first])

    points = measurement.points
    log_omega = np.interp(fine, known, points.log_omega[sweep.rows][first])
    there = replace(
        points, log_omega=log_omega, amplitude=between(points.amplitude), temperature=between(points.temperature)
    )
    return np.exp(fine) if axis.logarithmic else fine, there


def _with_units(label: str, measurement: Measurement) -> str:
    """``temperature 20, amplitude 0.5`` as ``20 °C, 0.5 mm``."""
    parts = []
    for part in label.split(", "):
        name, _, value = part.partition(" ")
        unit = {"temperature": "°C", "amplitude": measurement.units.amplitude}.get(name)
        parts.append(part if unit is None else f"strain {value}" if unit == "-" else f"{value} {unit}")
    return ", ".join(parts)
