"""What could be measured next: frequencies, amplitudes, temperatures, specimens, repeats."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from springpot.measurement import KELVIN, Measurement
from springpot.rheology import Points, Real

from .words import plain

POINTS = 20
"""Points of a new sweep."""
STEPS = (20.0, 40.0)
"""Kelvin by which the range of temperatures is widened at least and at most."""
COLDEST = -180.0
"""Temperature in degC that liquid nitrogen reaches in a test chamber."""


@dataclass(frozen=True, eq=False)
class Action:
    """A measurement that could be made.

    Attributes
    ----------
    says : str
        What to do.
    points : Points
        Where the new points would lie.
    effort : float
        Relative cost, by which the expected separation is divided when actions are compared.
    scale : float
        Factor by which the specimen is larger.
    repeats : int
        How often every new point is measured.
    action : dict of str to list of float
        The new conditions: ``omega`` in rad/s, ``temperature`` in degC, ``amplitude``, ``repeats``.
    """

    says: str
    points: Points
    effort: float = 1.0
    scale: float = 1.0
    repeats: int = 1
    action: dict[str, list[float]] = field(default_factory=dict)


def actions(measurement: Measurement) -> Iterator[Action]:
    """What could be measured next, the cheap things first."""
    omega = np.geomspace(measurement.omega.min(), measurement.omega.max(), POINTS)
    at, typical = measurement.points, _typical(measurement)
    hertz = omega / (2.0 * np.pi)
    yield Action("repeat the same measurement four times", at, 2.0, 1.0, 4, {"repeats": [4.0]})
    for factor, word in ((10.0, "up"), (0.1, "down")):
        wider = omega * factor
        ends = f"{plain(hertz.min() * factor)} to {plain(hertz.max() * factor)} Hz"
        yield Action(f"extend the frequencies {word}wards: {ends}", _at(wider, typical), 1.5, action=_omega(wider))
    amplitude = measurement.conditions.get("amplitude")
    if amplitude is not None:
        for factor in (3.0, 1.0 / 3.0):
            new = float((amplitude.max() if factor > 1 else amplitude.min()) * factor)
            where = replace(_at(omega, typical), amplitude=np.full(POINTS, new))
            unit = measurement.units.amplitude
            says = f"measure a sweep at the amplitude {new:.3g}{'' if unit == '-' else f' {unit}'}"
            yield Action(says, where, 1.0, action=_omega(omega) | {"amplitude": [new]})
    temperature = measurement.conditions.get("temperature")
    if temperature is not None:
        step = float(np.clip(0.5 * np.ptp(temperature), *STEPS))
        for new in (float(temperature.max()) + step, max(float(temperature.min()) - step, COLDEST)):
            where = replace(_at(omega, typical), temperature=np.full(POINTS, new + KELVIN))
            yield Action(
                f"measure a sweep at {new:.3g} degC", where, 1.5, action=_omega(omega) | {"temperature": [new]}
            )
    yield Action("measure a specimen of twice the area, in the same rig", _at(omega, typical), 2.0, scale=2.0)
    yield Action("measure the rig without a specimen", _at(omega, typical), 1.5, scale=0.0)


def _omega(omega: Real) -> dict[str, list[float]]:
    return {"omega": omega.tolist()}


def _typical(measurement: Measurement) -> Points:
    """Middle conditions of the data."""
    at = measurement.points
    middle = [None if c is None else np.array([float(np.median(c))]) for c in (at.amplitude, at.temperature)]
    return Points(np.zeros(1), middle[0], middle[1], at.reference_temperature)


def _at(omega: Real, typical: Points) -> Points:
    columns = [None if c is None else np.full(len(omega), c[0]) for c in (typical.amplitude, typical.temperature)]
    return Points(np.log(omega), columns[0], columns[1], typical.reference_temperature)
