"""What could be measured next.

The sweeps, amplitudes, temperatures and specimens that a rig may have to spare.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from springpot.measurement.measurement import Measurement
from springpot.measurement.one_frequency import distinct_log_omega
from springpot.measurement.units import Units
from springpot.misfit.words import plain
from springpot.rheology.parameters import INERTANCE
from springpot.rheology.points import KELVIN, Points, Real

TYPED_IN, WAITED_FOR, WORKED_FOR = 1.0, 1.5, 2.0
"""Effort of an amplitude, which is a number.

Of frequencies, a temperature or an empty rig, which take a while; of a
specimen that must be made, or of several repeats."""
FARTHER = 10.0
"""Factor by which the frequencies are extended: a decade is what a rig has to spare, if anything.
"""
STRONGER = 3.0
"""Factor by which amplitudes go beyond what was measured.

Nonlinear effects go with a power of it, and show there.
"""
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
        The new conditions: ``omega`` in rad/s, ``temperature`` in degC, ``amplitude``, ``repeats``,
        and for a specimen of another size ``specimen`` (its factor, zero without one) and ``mass``
        in kg.
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
    again = "repeat the same measurement four times"
    # Always feasible; its effort lets any other win that tells as much.
    yield Action(again, measurement.points, WORKED_FOR, repeats=DENSER, action={"repeats": [4.0]})
    yield from _frequencies(measurement)
    yield from _amplitudes(measurement)
    yield from _temperatures(measurement)
    yield from _specimens(measurement)


def _sweep(says: str, measurement: Measurement, omega: Real, effort: float) -> Action:
    """A sweep of frequencies under the middle conditions of the data."""
    at = measurement.points
    middle = [
        None if c is None else np.full(len(omega), np.median(c))
        for c in (at.amplitude, at.temperature)
    ]
    # A model may have factors by any column: at its middle there is a level, or two to lie between.
    columns = {name: np.full(len(omega), np.median(column)) for name, column in at.columns.items()}
    points = Points(np.log(omega), middle[0], middle[1], at.reference_temperature, columns)
    return Action(says, points, effort, action={"omega": omega.tolist()})


def _usual(measurement: Measurement) -> Real:
    """Frequencies over the range of the data, in rad/s."""
    return np.geomspace(measurement.omega.min(), measurement.omega.max(), POINTS)


def _frequencies(measurement: Measurement) -> Iterator[Action]:
    omega, clock, distinct = (
        _usual(measurement),
        measurement.units,
        len(distinct_log_omega(measurement)),
    )
    hertz = omega / (2.0 * np.pi)
    if distinct == 1:
        new = np.geomspace(1.0 / FARTHER, FARTHER, POINTS) * omega[0]
        band = _range(1.0 / FARTHER * hertz[0], FARTHER * hertz[0], clock)
        yield _sweep(
            f"measure a sweep of frequencies: {POINTS} points {band}", measurement, new, WAITED_FOR
        )
        return
    for factor, word in ((FARTHER, "up"), (1.0 / FARTHER, "down")):
        band = _range(hertz[0] * factor, hertz[-1] * factor, clock)
        says = f"extend the frequencies {word}wards: {POINTS} points {band}"
        yield _sweep(says, measurement, omega * factor, WAITED_FOR)
    count = min(DENSER * distinct, MOST_POINTS)
    # Of so many points already, no denser sweep is on offer.
    if count <= distinct:
        return
    dense = np.geomspace(omega[0], omega[-1], count)
    says = (
        f"measure the same frequencies more densely: {count} points"
        f" {_range(hertz[0], hertz[-1], clock)}"
    )
    yield _sweep(says, measurement, dense, TYPED_IN + count / (DENSER * POINTS))


def _amplitudes(measurement: Measurement) -> Iterator[Action]:
    amplitude = measurement.conditions.get("amplitude")
    if amplitude is None:
        return
    unit = ""
    if measurement.units.amplitude != "-":
        unit = f" {measurement.units.amplitude}"
    for new in (STRONGER * float(amplitude.max()), float(amplitude.min()) / STRONGER):
        says = f"measure {POINTS} points at the amplitude {new:.3g}{unit}"
        swept = _sweep(says, measurement, _usual(measurement), TYPED_IN)
        points = replace(swept.points, amplitude=np.full(POINTS, new))
        yield replace(swept, points=points, action=swept.action | {"amplitude": [new]})


def _temperatures(measurement: Measurement) -> Iterator[Action]:
    temperature = measurement.conditions.get("temperature")
    if temperature is None:
        return
    step = float(np.clip(0.5 * np.ptp(temperature), *STEPS))
    for new in (float(temperature.max()) + step, max(float(temperature.min()) - step, COLDEST)):
        swept = _sweep(
            f"measure {POINTS} points at {new:.3g} degC",
            measurement,
            _usual(measurement),
            WAITED_FOR,
        )
        points = replace(swept.points, temperature=np.full(POINTS, new + KELVIN))
        yield replace(swept, points=points, action=swept.action | {"temperature": [new]})


def _specimens(measurement: Measurement) -> Iterator[Action]:
    omega = _usual(measurement)
    says = f"measure a specimen of twice the area, in the same rig, at {POINTS} points"
    larger = _sweep(says, measurement, omega, WORKED_FOR)
    yield replace(larger, scale=2.0, action=larger.action | {"specimen": [2.0]})
    without = _sweep(
        f"measure the rig without a specimen, at {POINTS} points", measurement, omega, WAITED_FOR
    )
    without = replace(without, scale=0.0, action=without.action | {"specimen": [0.0]})
    yield without
    factor, unit = measurement.units.of(INERTANCE)
    if unit != "kg":  # a mass cannot take the place of a modulus or of a torsional stiffness
        return
    # Heavy enough to be as stiff as the specimen at the highest frequency.
    mass = float(np.median(measurement.magnitude)) / float(omega[-1]) ** 2
    about = f"a known mass of about {factor * mass:.2g} kg"
    says = f"measure {about} in place of the specimen, at {POINTS} points"
    yield replace(without, says=says, mass=mass, action=without.action | {"mass": [factor * mass]})


def _range(low: float, high: float, units: Units) -> str:
    """Frequencies in Hz, as the data tell them."""
    return f"from {plain(units.on_clock(low))} to {plain(units.on_clock(high))} {units.clock}"
