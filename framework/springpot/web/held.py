"""A model with parameters set, fixed or bounded by hand.

What the page sent, as `springpot.identify` takes it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from springpot.errors import ModelError
from springpot.measurement.units import Units
from springpot.rheology.model import Model
from springpot.rheology.points import Real
from springpot.rheology.tied import allowed


@dataclass(frozen=True)
class Hand:
    """What a user set, in printed units.

    Parameters
    ----------
    values : dict of str to float
        Where each parameter stands.
    fix : dict of str to float
        Those that stay.
    bounds : dict of str to (float, float)
        Ends, of those that have any by hand.
    """

    values: dict[str, float]
    fix: dict[str, float] = field(default_factory=dict)
    bounds: dict[str, tuple[float, float]] = field(default_factory=dict)


def hand_of(model: Model, given: object) -> Hand:
    """What a page sent, which may be anything.

    Raises
    ------
    ModelError
        If a parameter is missing or stands outside its ends.
    """
    hand = Hand({})
    entries: Mapping[str, object] = {}
    if isinstance(given, Mapping):
        entries = given
    for name in model.names:
        # By the model's names, never by those of the page: what it sends beside them is dropped.
        entry = entries.get(name)
        if not isinstance(entry, Mapping):
            raise ModelError(f"{model.name}: the parameter {name} has no value")
        value = _number(entry.get("value"), np.nan)
        ends = _number(entry.get("lower"), -np.inf), _number(entry.get("upper"), np.inf)
        if ends[0] > ends[1]:
            raise ModelError(
                f"{name}: the lower end {ends[0]:.4g} lies above the upper end {ends[1]:.4g};"
                " swap them"
            )
        # Written this way round, a value that is no number is refused too.
        if not ends[0] <= value <= ends[1]:
            raise ModelError(
                f"{name} = {value:.4g} is not within {ends[0]:.4g} to {ends[1]:.4g}; move one of"
                " them"
            )
        hand.values[name] = value
        # A parameter that stays needs no ends.
        if entry.get("fixed"):
            hand.fix[name] = value
        elif np.isfinite(ends).any():
            hand.bounds[name] = ends
    return hand


def theta_of(model: Model, units: Units, hand: Hand) -> Real:
    """The parameters (p,) in the model's own units.

    Raises
    ------
    ModelError
        If one is outside what the model allows.
    """
    own = []
    for parameter in model.parameters:
        factor, _ = units.of(parameter.unit)
        own.append(hand.values[parameter.name] / factor)
    # A hand may set wider ends than there is a model for.
    return np.array(list(map(allowed, model.parameters, own)))


def _number(value: object, otherwise: float) -> float:
    # True is an int to Python.
    if isinstance(value, int | float) and not isinstance(value, bool) and np.isfinite(value):
        return float(value)
    return otherwise
