"""Whether the amplitude matters, and how, without a model.

A material for each amplitude beside one for all.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from springpot.format_numbers import number
from springpot.measurement.measurement import Measurement
from springpot.measurement.sweeps import temperatures_differ
from springpot.rheology.points import Real

from .material import (
    Level,
    each_alone,
    error_of_each,
    fitted_together,
    levels_of_no_material,
    needs_each,
    strange_in_words,
)
from .refit import Refit
from .where import with_unit
from .words import percent

FEWEST_COMMON = 3
"""Frequencies shared by the lowest amplitude and all others, at which moduli are compared."""
STAYS = 0.05
"""Share of a loss factor by which it may differ over amplitudes and be one in two digits."""
TURNS = 0.1
"""Share of its range by which a course goes beyond both of its ends to be told as one that turns.
"""


def notes_on_amplitudes(base: Refit) -> Iterator[str]:
    """Sentences on what the amplitude does.

    None where it was not varied, or where temperatures differ as well.

    Parameters
    ----------
    base : Refit
        A fit that leaves structure; its data and their noise are used, its model is not.
    """
    measurement = base.fit.measurement
    # At several temperatures one material could not follow them at one amplitude either.
    if "amplitude" not in measurement.conditions or temperatures_differ(measurement):
        return
    levels = each_alone(base, "amplitude")
    if len(levels) < 2:
        return
    one, each = fitted_together(base, levels), error_of_each(levels)
    beside = f"one material for all {len(levels)} amplitudes is {percent(one.relative_rms)} off"
    if not needs_each(one, levels):
        yield f"{beside}, one for each {percent(each)}: the amplitude does not matter"
        return
    yield f"{beside}, one for each {percent(each)}: {_course(measurement, levels)}"
    strange = levels_of_no_material(levels)
    if len(levels) > 2 and strange:
        yield strange_in_words(measurement, "amplitude", levels, strange)


def _course(measurement: Measurement, levels: Sequence[Level]) -> str:
    """How modulus and loss factor go with the amplitude, at frequencies that all levels share."""
    low = max(float(measurement.omega[level.rows].min()) for level in levels)
    high = min(float(measurement.omega[level.rows].max()) for level in levels)
    own = measurement.omega[levels[0].rows]
    omega = np.unique(own[(own >= low) & (own <= high)])
    if len(omega) < FEWEST_COMMON:
        return "the amplitude matters"
    curves = [level.fitted.model.stiffness(level.fitted.theta, omega) for level in levels]
    places = [with_unit(measurement, "amplitude", level.value) for level in levels]
    # In logarithms: a modulus is compared by ratios, over frequencies at which it differs by
    # decades.
    sizes = np.array(
        [float(np.exp(np.mean(np.log(np.abs(curve / curves[0]))))) for curve in curves]
    )
    tangents = np.array([float(np.tan(np.mean(np.angle(curve)))) for curve in curves])
    change = "rises"
    if sizes[-1] < 1.0:
        change = "falls"
    size = (
        f"{measurement.units.magnitude} {change} by"
        f" {percent(abs(sizes[-1] - 1.0))}{_turn(sizes, places)}"
    )
    loss = (
        f"the loss factor goes from {number(tangents[0], 2)} to"
        f" {number(tangents[-1], 2)}{_turn(tangents, places)}"
    )
    if float(np.ptp(tangents)) < STAYS * float(np.max(tangents)):
        loss = f"the loss factor stays at {number(float(np.mean(tangents)), 2)}"
    return f"from {places[0]} to {places[-1]} {size}, and {loss}"


def _turn(values: Real, places: Sequence[str]) -> str:
    """Where between its ends a course lies beyond both of them; empty where it goes one way."""
    inner = values[1:-1]
    ends = min(values[0], values[-1]), max(values[0], values[-1])
    beyond = np.maximum(inner - ends[1], ends[0] - inner)
    if not len(inner) or float(np.max(beyond)) < TURNS * float(np.ptp(values)):
        return ""
    at = int(np.argmax(beyond))
    extreme = "least"
    if inner[at] > ends[1]:
        extreme = "most"
    return f" ({extreme} at {places[1 + at]})"
