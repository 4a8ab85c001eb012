"""What could be measured next: frequencies, amplitudes, temperatures, specimens, a known mass, repeats."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from springpot.measurement import KELVIN, Measurement
from springpot.rheology import INERTANCE, Points, Real

from .words import plain

POINTS = 20
"""Points of a new sweep."""
DENSER = 4
"""How many times as many frequencies, or repeats, an action takes as there were."""
MOST_POINTS = 400
"""Points of a denser sweep at most."""
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
        Factor by which the specimen is larger; zero where it is taken out.
    repeats : int
        How often every new point is measured.
    mass : float
        Known mass in place of the specimen, in units of stiffness times s^2.
    action : dict of str to list of float
        The new conditions: ``omega`` in rad/s, ``temperature`` in degC, ``amplitude``, ``repeats``, and for a
        specimen of another size ``specimen`` (its factor, zero without one) and ``mass`` in kg.
    """

    says: str
    points: Points
    effort: float = 1.0
    scale: float = 1.0
    repeats: int = 1
    mass: float = 0.0
    action: dict[str, list[float]] = field(default_factory=dict)


def actions(measurement: Measurement) -> Iterator[Action]:
    """What could be measured next, the cheap things first."""
    yield Action(
        "repeat the same measurement four times", measurement.points, 2.0, 1.0, DENSER, action={"repeats": [4.0]}
    )
    yield from _frequencies(measurement)
    yield from _amplitudes(measurement)
    yield from _temperatures(measurement)
    yield from _specimens(measurement)


def _usual(measurement: Measurement) -> Real:
    """A sweep over the range of the data, in rad/s."""
    return np.geomspace(measurement.omega.min(), measurement.omega.max(), POINTS)


def _frequencies(measurement: Measurement) -> Iterator[Action]:
    typical, omega = _typical(measurement), _usual(measurement)
    hertz, distinct = omega / (2.0 * np.pi), len(np.unique(np.round(np.log(measurement.omega), 6)))
    if distinct == 1:
        new = np.geomspace(0.1, 10.0, POINTS) * omega[0]
        says = f"measure a sweep of frequencies: {POINTS} points {_range(0.1 * hertz[0], 10.0 * hertz[0])}"
        yield Action(says, _at(new, typical), 1.5, action=_omega(new))
        return
    for factor, word in ((10.0, "up"), (0.1, "down")):
        says = f"extend the frequencies {word}wards: {POINTS} points {_range(hertz[0] * factor, hertz[-1] * factor)}"
        yield Action(says, _at(omega * factor, typical), 1.5, action=_omega(omega * factor))
    count = min(DENSER * distinct, MOST_POINTS)
    if count <= distinct:
        return
    dense = np.geomspace(omega[0], omega[-1], count)
    says = f"measure the same frequencies more densely: {count} points {_range(hertz[0], hertz[-1])}"
    yield Action(says, _at(dense, typical), 1.0 + count / (DENSER * POINTS), action=_omega(dense))


def _amplitudes(measurement: Measurement) -> Iterator[Action]:
    amplitude, omega = measurement.conditions.get("amplitude"), _usual(measurement)
    if amplitude is None:
        return
    unit = "" if measurement.units.amplitude == "-" else f" {measurement.units.amplitude}"
    for factor in (3.0, 1.0 / 3.0):
        new = float((amplitude.max() if factor > 1 else amplitude.min()) * factor)
        where = replace(_at(omega, _typical(measurement)), amplitude=np.full(POINTS, new))
        says = f"measure {POINTS} points at the amplitude {new:.3g}{unit}"
        yield Action(says, where, 1.0, action=_omega(omega) | {"amplitude": [new]})


def _temperatures(measurement: Measurement) -> Iterator[Action]:
    temperature, omega = measurement.conditions.get("temperature"), _usual(measurement)
    if temperature is None:
        return
    step = float(np.clip(0.5 * np.ptp(temperature), *STEPS))
    for new in (float(temperature.max()) + step, max(float(temperature.min()) - step, COLDEST)):
        where = replace(_at(omega, _typical(measurement)), temperature=np.full(POINTS, new + KELVIN))
        says = f"measure {POINTS} points at {new:.3g} degC"
        yield Action(says, where, 1.5, action=_omega(omega) | {"temperature": [new]})


def _specimens(measurement: Measurement) -> Iterator[Action]:
    omega = _usual(measurement)
    at = _at(omega, _typical(measurement))
    says = f"measure a specimen of twice the area, in the same rig, at {POINTS} points"
    yield Action(says, at, 2.0, 2.0, action=_omega(omega) | {"specimen": [2.0]})
    says = f"measure the rig without a specimen, at {POINTS} points"
    yield Action(says, at, 1.5, 0.0, action=_omega(omega) | {"specimen": [0.0]})
    factor, unit = measurement.units.of(INERTANCE)
    if unit != "kg":  # a mass cannot take the place of a modulus or of a torsional stiffness
        return
    # Heavy enough to be as stiff as the specimen at the highest frequency.
    mass = float(np.median(measurement.magnitude)) / float(omega[-1]) ** 2
    says = f"measure a known mass of about {factor * mass:.2g} kg in place of the specimen, at {POINTS} points"
    known = {"specimen": [0.0], "mass": [factor * mass]}
    yield Action(says, at, 1.5, 0.0, mass=mass, action=_omega(omega) | known)


def _range(low: float, high: float) -> str:
    return f"from {plain(low)} to {plain(high)} Hz"


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
