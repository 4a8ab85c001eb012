"""A model with parameters set, fixed or bounded by hand: its curve, and the best fit that respects the hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.errors import ModelError
from springpot.measurement import Measurement
from springpot.rheology import Model, Real

LEAST = 1e-300
"""Logarithms of a parameter begin here."""
MOST_STEPS = 400
"""Evaluations of a fit by hand: from a curve that a slider has brought near, ten are enough."""


@dataclass(frozen=True)
class Hand:
    """What a user set for one parameter, in the model's own units.

    Parameters
    ----------
    value : float
        Where the fit begins, or stays if `fixed`.
    fixed : bool
        Whether it stays.
    lower, upper : float
        Ends, which the model's own ends may narrow.
    """

    value: float
    fixed: bool = False
    lower: float = -np.inf
    upper: float = np.inf


def hands_of(model: Model, measurement: Measurement, given: Mapping[str, Any]) -> list[Hand]:
    """What a page sent, in printed units, as hands in the model's own.

    Raises
    ------
    ModelError
        If a parameter is missing, no finite number or outside its ends.
    """
    hands = []
    for parameter in model.parameters:
        said = given.get(parameter.name)
        if not isinstance(said, Mapping):
            raise ModelError(f"{model.name}: the parameter {parameter.name} has no value")
        factor, unit = measurement.units.of(parameter.unit)
        value = _number(said.get("value"), np.nan) / factor
        lower = max(_number(said.get("lower"), -np.inf) / factor, parameter.lower)
        upper = min(_number(said.get("upper"), np.inf) / factor, parameter.upper)
        if not lower <= value <= upper:
            ends = f"{lower * factor:.4g} to {upper * factor:.4g} {unit}".strip()
            raise ModelError(f"{parameter.name} = {value * factor:.4g} is not within {ends}; move one of them")
        hands.append(Hand(value, bool(said.get("fixed")), lower, upper))
    return hands


def _number(value: object, otherwise: float) -> float:
    if isinstance(value, int | float) and not isinstance(value, bool) and np.isfinite(value):
        return float(value)
    return otherwise


def fitted(model: Model, measurement: Measurement, hands: list[Hand], sd: Real) -> Real:
    """The parameters of least weighted squares that respect the hands.

    Parameters
    ----------
    model : Model
        With p parameters.
    measurement : Measurement
        With n points.
    hands : list of Hand
        One for each parameter.
    sd : ndarray, shape (2, n)
        Standard deviations of storage and loss by which differences are weighted.

    Returns
    -------
    ndarray, shape (p,)
        By scipy's trust-region reflective algorithm with exact derivatives, in ln of what is positive.
    """
    from scipy.optimize import least_squares

    theta = np.array([hand.value for hand in hands])
    free = np.array([i for i, hand in enumerate(hands) if not hand.fixed], dtype=int)
    if not len(free):
        return theta
    logs = np.array([model.parameters[i].scale == "log" and theta[i] > 0.0 for i in free])
    weights = 1.0 / sd.ravel()

    def whole(x: Real) -> Real:
        moved = theta.copy()
        moved[free] = np.where(logs, np.exp(np.where(logs, x, 0.0)), x)
        return moved

    def left(x: Real) -> Real:
        return _stacked(model.stiffness(whole(x), measurement.points) - measurement.stiffness) * weights

    def slopes(x: Real) -> Real:
        moved = whole(x)
        by_theta = model.jacobian(moved, measurement.points)[:, free] * np.where(logs, moved[free], 1.0)
        return np.asarray(_stacked(by_theta.T).T * weights[:, None], dtype=float)

    low, high = (_ends([getattr(hands[i], side) for i in free], logs) for side in ("lower", "upper"))
    start = np.where(logs, np.log(np.maximum(theta[free], LEAST)), theta[free])
    inside = np.clip(start, np.nextafter(low, np.inf), np.nextafter(high, -np.inf))
    found = least_squares(left, inside, slopes, bounds=(low, high), x_scale="jac", max_nfev=MOST_STEPS)
    return whole(found.x)


def _stacked(values: NDArray[np.complex128]) -> Real:
    """Real parts, then imaginary parts, along the last axis."""
    return np.concatenate([values.real, values.imag], axis=-1)


def _ends(values: list[float], logs: NDArray[np.bool_]) -> Real:
    ends = np.array(values, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(logs, np.log(np.maximum(ends, 0.0)), ends)
