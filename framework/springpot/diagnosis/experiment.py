"""The next experiment: which feasible measurement would tell the leading explanations apart.

For every feasible action the two explanations are evaluated where the new points would lie, the second one is allowed
to follow the first with all its parameters (linearly, at its own fit), and what is left between them is expressed in
standard deviations (the T-criterion of Atkinson and Fedorov 1975, doi:10.1093/biomet/62.1.57).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from springpot.identification import weighted
from springpot.measurement import KELVIN, Measurement
from springpot.rheology import GRADIENT, Complex, Points, Real

from .frame import orthonormal
from .refit import Refit
from .result import NextExperiment

POINTS = 20
"""Points of a new sweep."""
SETTLED = 5.0
"""Separation in standard deviations that settles the matter."""


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
        ends = f"{_plain(hertz.min() * factor)} to {_plain(hertz.max() * factor)} Hz"
        yield Action(f"extend the frequencies {word}wards: {ends}", _at(wider, typical), 1.5, action=_omega(wider))
    amplitude = measurement.conditions.get("amplitude")
    if amplitude is not None:
        for factor in (3.0, 1.0 / 3.0):
            new = float((amplitude.max() if factor > 1 else amplitude.min()) * factor)
            where = replace(_at(omega, typical), amplitude=np.full(POINTS, new))
            says = f"measure a sweep at the amplitude {new:.3g} {measurement.units.amplitude}"
            yield Action(says, where, 1.0, action=_omega(omega) | {"amplitude": [new]})
    temperature = measurement.conditions.get("temperature")
    if temperature is not None:
        for step in (20.0, -20.0):
            new = float((temperature.max() if step > 0 else temperature.min()) + step)
            where = replace(_at(omega, typical), temperature=np.full(POINTS, new + KELVIN))
            yield Action(
                f"measure a sweep at {new:.3g} degC", where, 1.5, action=_omega(omega) | {"temperature": [new]}
            )
    yield Action("measure a specimen of twice the area, in the same rig", _at(omega, typical), 2.0, scale=2.0)
    yield Action("measure the rig without a specimen", _at(omega, typical), 1.5, scale=0.0)


def _plain(value: float, digits: int = 3) -> str:
    """A number with few significant digits, written out up to a million: 890, not 8.9e+02."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and value < 1e6 else text


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


def next_experiment(first: Refit, second: Refit, names: tuple[str, str]) -> NextExperiment | None:
    """The action that best separates two explanations for its effort; None where they are one model.

    Parameters
    ----------
    first, second : Refit
        The two fitted explanations, the likelier one first.
    names : tuple of str
        The effects that set them apart.
    """
    measurement = first.fit.measurement
    found = [(action, separation(first, second, action)) for action in actions(measurement)]
    ranked = sorted(found, key=lambda pair: -min(pair[1], 3.0 * SETTLED) / pair[0].effort)
    best, sigma = ranked[0]
    if sigma < 1.0:
        says = f"no single further measurement here tells {names[0]} from {names[1]}"
        return NextExperiment(says, names, sigma)
    says = f"{best.says}: it separates {names[0]} from {names[1]} by {_plain(sigma, 2)} sigma"
    return NextExperiment(says, names, sigma, best.action)


def separation(first: Refit, second: Refit, action: Action) -> float:
    """Standard deviations between two explanations after an action, both following the old data.

    Parameters
    ----------
    first, second : Refit
        The explanations.
    action : Action
        What would be measured.
    """
    old = first.fit.measurement.points
    noise = first.noise.sd
    size = np.abs(first.stiffness)
    relative = complex(np.median(noise.real / size), np.median(noise.imag / size))
    target, _ = _evaluated(first, action)
    value, by_theta = _evaluated(second, action)
    floor = np.abs(target) if action.scale else np.full(len(target), float(np.median(size)))
    new_weights = np.sqrt(action.repeats) / np.maximum(floor, 1e-300)
    weights = np.concatenate([first.noise.weights, new_weights / relative.real + 1j * new_weights / relative.imag])
    response = second.model.network.respond(second.theta, old, GRADIENT)
    difference = weighted(np.concatenate([first.stiffness - second.stiffness, target - value]), weights)
    slopes = weighted(np.concatenate([response.by_theta, by_theta], axis=1), weights)
    usable = np.all(np.isfinite(slopes), axis=1) & (np.sum(slopes**2, axis=1) > 0)
    if not np.all(np.isfinite(difference)):
        return 0.0
    absorbed = orthonormal(slopes[usable].T)
    left = difference - absorbed @ (absorbed.T @ difference)
    return float(np.sqrt(left @ left))


def _evaluated(refit: Refit, action: Action) -> tuple[Complex, Complex]:
    """K and dK/dtheta of an explanation where an action would measure, the specimen being larger or absent."""
    network = refit.model.network if action.scale == 1.0 else refit.model.resized(max(action.scale, 1e-9))
    with np.errstate(all="ignore"):
        response = network.respond(refit.theta, action.points, GRADIENT)
    return response.value, response.by_theta
