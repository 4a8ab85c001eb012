"""What a figure shows: the column along its axis, sweeps, and smooth curves of fitted models."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from springpot.measurement.measurement import Measurement
from springpot.rheology.model import Model
from springpot.rheology.points import Complex, Points, Real

from .sweeps import Sweep, all_sweeps, travels, varies

SMOOTH = 200
"""Points on each curve."""


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

    def of(self, other: Measurement) -> Real:
        """Where the points of another measurement stand on this axis."""
        if self.column == "frequency":
            return other.units.on_clock(other.frequency)
        return other.conditions[self.column]


def axis_of(measurement: Measurement) -> Axis:
    """The frequency if it varies, else the amplitude or the temperature, whichever does."""
    label = {"Hz": "frequency f [Hz]", "rad/s": "angular frequency ω [rad/s]"}[
        measurement.units.clock
    ]
    along_frequency = Axis("frequency", label, measurement.units.on_clock(measurement.frequency))
    if varies("frequency", measurement.frequency):
        return along_frequency
    # Tests at one frequency: what was varied instead is what a reader wants to see.
    labels = {
        "amplitude": f"amplitude [{measurement.units.amplitude}]",
        "temperature": "temperature [°C]",
    }
    for name, label in labels.items():
        column = measurement.conditions.get(name)
        if column is not None and varies(name, column):
            return Axis(
                name, label, column, logarithmic=name == "amplitude" and bool(np.all(column > 0))
            )
    return along_frequency


def sweeps_of(measurement: Measurement, axis: Axis) -> list[Sweep]:
    """Every sweep along `axis`; one of everything where nothing was held."""
    return all_sweeps(measurement, axis.column, axis.values)


def smooth(measurement: Measurement, axis: Axis, sweep: Sweep) -> tuple[Real, Points]:
    """Places along the axis between a sweep's ends, and the conditions there.

    A condition that follows the axis is interpolated; one that only scatters about its setting is
    taken to be held.
    """
    along = axis.values[sweep.rows]
    # Evenly on the paper, not in the numbers: a curve over decades would be coarse at its lower
    # end.
    place = along
    if axis.logarithmic:
        place = np.log(along)
    # Repeats stand at one place, where interpolation can take one value only.
    known, first = np.unique(place, return_index=True)
    fine: Real = known
    if len(known) > 1:
        fine = np.linspace(known[0], known[-1], SMOOTH)

    def between(column: Real) -> Real:
        here = column[sweep.rows]
        # Through values that jump to and fro a curve would jump as well, and no model would follow
        # it.
        if travels(along, here):
            return np.full(len(fine), float(np.median(here)))
        return np.interp(fine, known, here[first])

    points = measurement.points
    # In the logarithm, as the models take it.
    log_omega = np.interp(fine, known, points.log_omega[sweep.rows][first])
    there = replace(points.mapped(between), log_omega=log_omega)
    if axis.logarithmic:
        fine = np.exp(fine)
    return fine, there
