"""Settings of parameters before anything is fitted.

Where an effect's own may lie, given where the data lie.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from springpot.measurement.measurement import Measurement
from springpot.rheology.parameters import Parameter
from springpot.rheology.points import Real

from .starts import low_discrepancy

DECADES = 5.0
"""How far below and above the natural size of the data the size of an effect is tried."""
BEYOND = 0.7
"""Decades beyond the measured times and amplitudes to which an effect's own are tried."""
EDGE = 1e-3
"""Share of its range within which a bounded parameter counts as at its bound."""


@dataclass(frozen=True)
class Window:
    """Natural sizes of a measurement.

    Where its stiffness, time and amplitude lie, and how far they reach.
    """

    stiffness: float
    time: float
    amplitude: float
    time_decades: float
    amplitude_decades: float

    @classmethod
    def of(cls, measurement: Measurement) -> Window:
        """The window of a measurement."""
        log_omega = np.log10(measurement.omega)
        amplitude = np.log10(
            np.maximum(measurement.conditions.get("amplitude", np.ones(1)), 1e-300)
        )
        return cls(
            float(np.exp(np.mean(np.log(measurement.magnitude)))),
            float(10.0 ** -np.mean(log_omega)),
            float(10.0 ** np.mean(amplitude)),
            float(np.ptp(log_omega)),
            float(np.ptp(amplitude)),
        )


def settings(parameters: tuple[Parameter, ...], window: Window, count: int) -> Real:
    """Quasi-random settings (count, q) of an effect's parameters, over all that is physical.

    Examples
    --------
    >>> import springpot
    >>> from springpot.identification import Window, settings
    >>> effect = springpot.plugins().effect("inertia")
    >>> settings(effect.element.parameters, Window.of(springpot.read("artificial-hidden")), 3).shape
    (3, 1)
    """
    unit = low_discrepancy(count, len(parameters))
    columns: dict[str, Real] = {}
    # Last those whose unit hangs on an order: its value must be there before theirs has a size.
    for u, parameter in sorted(
        zip(unit.T, parameters, strict=True), key=lambda pair: isinstance(pair[1].unit.time, str)
    ):
        columns[parameter.name] = _setting(parameter, u, window, columns)
    grid = np.empty(unit.shape)
    # An effect with a factor for each level has no parameters before it knows the levels.
    for place, parameter in enumerate(parameters):
        grid[:, place] = columns[parameter.name]
    return grid


def _setting(parameter: Parameter, u: Real, window: Window, done: dict[str, Real]) -> Real:
    unit = parameter.unit
    power: Real | float
    if isinstance(unit.time, str):
        power = done[unit.time]
    else:
        power = unit.time
    natural: Real | float = (
        window.stiffness**unit.stiffness * window.time**power * window.amplitude**unit.amplitude
    )
    natural = natural * parameter.typical
    if parameter.scale == "linear" and parameter.upper < inf and parameter.lower > -inf:
        return parameter.lower + (parameter.upper - parameter.lower) * u
    # What may have either sign has no logarithm: half the settings go to each side, by decades of
    # the size.
    if parameter.scale == "linear":
        sign = np.where(u < 0.5, -1.0, 1.0)
        reach = np.abs(2.0 * u - 1.0)
        return np.clip(
            sign * natural * 10.0 ** (DECADES * (reach - 1.0)), parameter.lower, parameter.upper
        )
    decades = _reach(parameter, window)
    return np.clip(
        natural * 10.0 ** (decades * (2.0 * u - 1.0)), max(parameter.lower, 1e-300), parameter.upper
    )


def _reach(parameter: Parameter, window: Window) -> float:
    """Decades to either side of the natural size in which a positive parameter is tried."""
    unit = parameter.unit
    # A plugin's may have a power of time that hangs on an order and no stiffness: it may lie as far
    # off.
    if unit.stiffness or isinstance(unit.time, str):
        return DECADES
    if unit.amplitude or unit.time:
        # A rate lies anywhere between the lowest frequency and amplitude, and the highest.
        reached = (
            abs(unit.time) * window.time_decades + abs(unit.amplitude) * window.amplitude_decades
        )
        return 0.5 * reached + BEYOND
    return 1.5


def shown(parameter: Parameter, window: Window) -> tuple[float, float]:
    """Where the data would show a parameter: further off its effect has become a simpler one.

    Parameters
    ----------
    parameter : Parameter
        One of an effect's own.
    window : Window
        Where and how far the data reach.

    Returns
    -------
    tuple of float
        The ends of the range; empty where its unit depends on another parameter.

    Examples
    --------
    >>> from springpot.identification import Window, shown
    >>> from springpot.rheology import relaxation_time
    >>> low, high = shown(relaxation_time(), Window(1.0, 0.1, 1.0, 2.0, 0.0))
    >>> round(low, 4), round(high, 4)
    (0.01, 1.0)
    """
    unit = parameter.unit
    if parameter.scale == "linear":
        room = EDGE * (parameter.upper - parameter.lower)
        return parameter.lower + room, parameter.upper - room
    # Its size hangs on an order that is not known here: nothing is said of it.
    if isinstance(unit.time, str):
        return inf, -inf
    natural: Real | float = (
        window.stiffness**unit.stiffness * window.time**unit.time * window.amplitude**unit.amplitude
    )
    decades = 1.0 + BEYOND
    if not unit.stiffness:
        decades = _reach(parameter, window)
    reach = 10.0 ** (decades - BEYOND)
    return natural * parameter.typical / reach, natural * parameter.typical * reach
