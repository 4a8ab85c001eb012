"""The next experiment.

Which feasible measurement would tell the leading explanations apart, or what is unknown.

What could be measured next.

The sweeps, amplitudes, temperatures and specimens that a rig may have to spare.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from springpot.identification.problem import weighted
from springpot.measurement.independence import distinct_log_omega, moved_along, spread_of
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_tests import sweeps_of
from springpot.measurement.units import Units
from springpot.misfit.error import plain
from springpot.misfit.outliers import Outlier
from springpot.misfit.refit import Refit
from springpot.rheology.nodes import GRADIENT
from springpot.rheology.parameters import INERTANCE
from springpot.rheology.points import KELVIN, Complex, Points, Real
from springpot.writing import NAMED

from ..numerics import ALIKE, SMALLEST
from .contest import TYPED_IN, WAITED_FOR, WORKED_FOR, Contest, Pair, most_telling
from .grown import COLUMN, Untold
from .result import NextExperiment

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


BESIDE = (0.97, 1.0, 1.03)
"""Factors of a frequency at which a point was bad.

So near that no material changes, and off the line of a hum.
"""


@dataclass(frozen=True, eq=False)
class Clash(Contest):
    """Two explanations after an action, both of which follow the old data.

    Attributes
    ----------
    truth, rival : Refit
        The one that holds, and the one that may change its parameters to follow it.
    action : Action
        What would be measured.
    """

    truth: Refit
    rival: Refit
    action: Action

    @cached_property
    def _target(self) -> tuple[Complex, Complex]:
        """K of the truth at old and new points (n,), and their weights."""
        new = self._evaluated(self.truth, self.truth.theta)[0]
        # The new points are taken to be as noisy as the median of the old ones.
        noise, size = self.truth.noise.sd, np.abs(self.truth.stiffness)
        relative = (
            complex(np.median(noise.real / size), np.median(noise.imag / size)) * self._quieter()
        )
        floor = np.abs(new)
        if self.action.scale == 0.0:
            # Without a specimen the force is small, and its noise is not.
            floor = np.maximum(floor, float(np.median(size)))
        # The mean of so many repeats is quieter by the root of their number.
        weights = np.sqrt(self.action.repeats) / np.maximum(floor, SMALLEST)
        weights = weights / relative.real + 1j * weights / relative.imag
        return np.concatenate([self.truth.stiffness, new]), np.concatenate(
            [1.0 / noise.real + 1j / noise.imag, weights]
        )

    def _quieter(self) -> float:
        """How much smaller the new amplitude is than the usual one.

        At worst the noise is a force of fixed size.
        """
        usual, new = self.truth.fit.measurement.points.amplitude, self.action.points.amplitude
        if usual is None or new is None:
            return 1.0
        return max(1.0, float(np.median(usual) / np.median(new)))

    def seen(self, theta: Real) -> tuple[Real, Real]:
        """Whitened difference of truth and rival, and the rival's slopes, at old and new points.

        Their shapes are (2n,) and (p, 2n).
        """
        old = self.truth.fit.measurement.points
        with np.errstate(all="ignore"):
            response = self.rival.model.network.respond(theta, old, GRADIENT)
        value, by_theta = self._evaluated(self.rival, theta)
        target, weights = self._target
        with np.errstate(over="ignore", invalid="ignore"):  # steps too far are cut off by `far`
            slopes = weighted(np.concatenate([response.by_theta, by_theta], axis=1), weights)
            return weighted(target - np.concatenate([response.value, value]), weights), slopes

    def _evaluated(self, refit: Refit, theta: Real) -> tuple[Complex, Complex]:
        """K and dK/dtheta where the action would measure.

        The specimen may be larger there, absent or a known mass.
        """
        scale, mass = self.action.scale, self.action.mass
        network = refit.model.network
        if scale != 1.0:
            # No specimen is one of hardly any size, as a network cannot be empty.
            network = refit.model.resized(max(scale, ALIKE), mass)
        with np.errstate(all="ignore"):
            response = network.respond(theta, self.action.points, GRADIENT)
        return response.value, response.by_theta


def next_experiment(
    first: Refit, second: Refit, names: tuple[str, str], chances: Pair
) -> NextExperiment:
    """The action that should best separate two explanations for its effort.

    Parameters
    ----------
    first, second : Refit
        The two fitted explanations.
    names : tuple of str
        The effects that set them apart.
    chances : tuple of float
        Their probabilities: who holds decides what a measurement can show, as a larger model
        follows a smaller one.
    """
    fits = (first, second)

    def clash(action: Action, holds: int) -> Clash:
        return Clash(fits[holds], fits[1 - holds], action)

    return most_telling(list(actions(first.fit.measurement)), clash, names, chances)


def experiment_on_confounded(measurement: Measurement, names: Sequence[str]) -> NextExperiment:
    """What to measure where a condition moved with the frequency.

    The same frequencies with the condition held.

    Parameters
    ----------
    measurement : Measurement
        The data in which it moved.
    names : sequence of str
        Effects of that condition which would explain the data.
    """
    moved, *_ = sorted(moved_along(measurement))
    middle = float(np.median(measurement.conditions[moved]))
    omega = np.exp(distinct_log_omega(measurement))[:MOST_POINTS]
    says = (
        f"measure the same frequencies at one {moved}, and again at another: only then can an"
        f" effect of it ({', '.join(names[:NAMED])}) be told from one of the frequency"
    )
    return NextExperiment(says, (), None, {"omega": omega.tolist(), moved: [middle]})


def experiment_on_points(outliers: Sequence[Outlier]) -> NextExperiment:
    """What to measure where nothing but single points is wrong.

    Parameters
    ----------
    outliers : sequence of Outlier
        The points that were set aside.
    """
    places = " and ".join(outlier.at for outlier in outliers[:NAMED])
    says = (
        f"measure again at {places}, and close beside: a bad point does not come back, an"
        " interference or a resonance does"
    )
    omega = [2.0 * np.pi * outlier.frequency * factor for outlier in outliers for factor in BESIDE]
    return NextExperiment(says, (), None, {"omega": omega})


def experiment_on_untold(untold: Untold, measurement: Measurement) -> NextExperiment:
    """What tells an effect from those of an amplitude that no column tells.

    Parameters
    ----------
    untold : Untold
        The effect, and the others.
    measurement : Measurement
        The data.
    """
    says = (
        f"measure the same points at another {COLUMN} too, and write both in a column {COLUMN}:"
        f" {untold.effect} stays as it is, {' or '.join(untold.others)} changes with it"
    )
    return NextExperiment(says, (), None, {"omega": measurement.omega[:MOST_POINTS].tolist()})


def experiment_on_unknown(measurement: Measurement) -> NextExperiment:
    """What to measure where something is missing that no effect explains.

    Whether it is there again, and with what.

    Parameters
    ----------
    measurement : Measurement
        The data as measured, with their repeats.
    """
    longest = max(sweeps_of(measurement), key=lambda sweep: len(sweep.rows))
    # As they stand in the file, which is the order in which they were measured.
    omega = measurement.omega[np.sort(longest.rows)][:MOST_POINTS]
    again: dict[str, list[float]] = {"omega": omega[::-1].tolist()}
    # The cheapest question first: nothing else is worth asking of what is gone the next time.
    if measurement.repeat is None:
        says = (
            "measure the same points again in the opposite order: what comes back is the specimen's"
            " or the rig's, what does not is drift or ageing"
        )
        return NextExperiment(says, (), None, again)
    amplitude = spread_of(measurement, "amplitude")
    if amplitude is not None and not amplitude.varied:
        half = 0.5 * float(np.median(measurement.conditions["amplitude"]))
        says = (
            "measure the same points at half the amplitude:"
            " what then changes is no linear material's"
        )
        return NextExperiment(says, (), None, {"omega": omega.tolist(), "amplitude": [half]})
    says = (
        "measure something known in place of the specimen, such as a steel spring or a standard"
        " fluid: what it shows too is the rig's"
    )
    return NextExperiment(says, (), None)
