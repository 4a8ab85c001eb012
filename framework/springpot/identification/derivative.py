"""A model's derivative is checked along one direction when the model is first used.

The contract tests of `springpot.testing` look at every parameter; but who uses a plugin's model
need not have run them, and a fit by a wrong derivative ends in a wrong place without a word.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from springpot.errors import ModelError
from springpot.owners import owned
from springpot.rheology.model import Model
from springpot.rheology.nodes import GRADIENT, Node
from springpot.rheology.points import Complex, Points, Real

STEPS = (1e-3, 1e-4, 1e-5)
"""Of the central difference, relative to each parameter.

Its error falls with the square of the step and rises, by
rounding, with its inverse; the best of three is about 1e-8."""
WRONG = 1e-5
"""Deviation from the difference at its best step, relative to the sum of all shares, that no
rounding explains: 2e-10 was the largest among the 76 installed models and effects.
"""
ELSEWHERE = (3.0, 0.2, 7.0)
"""Factors by which parameters are moved before a deviation is believed."""
_checked: set[object] = set()


def require_derivative(model: Model, theta: Real, points: Points) -> None:
    """Compare dK/dtheta of a model with differences, once for each network.

    Parameters
    ----------
    model : Model
        What is about to be fitted.
    theta : ndarray, shape (p,)
        Where; anywhere in the interior.
    points : Points
        The measured points.

    Raises
    ------
    ModelError
        If the derivative is wrong, with the parameter where it is most so; if the model gives
        another stiffness with it than without; or no number at a point, whatever its parameters.
    """
    # Once is enough: a derivative does not change, and a fit must not pay for it each time.
    if model.network in _checked:
        return
    places = [theta, *(_elsewhere(model, theta, factor) for factor in ELSEWHERE)]
    _require_numbers(model, places, points)
    with np.errstate(all="ignore"):
        apart = _least_apart(model, places, points)
    if apart > WRONG:
        raise ModelError(
            f"the stiffness of {model.name} is another by {100 * apart:.2g} % where its derivative"
            " is asked for too: nothing is fitted with it; the plugin's author finds the rest with"
            " springpot.testing"
        )
    _checked.add(model.network)
    with np.errstate(all="ignore"):
        # At the kink of a slider, say, no difference is right; a wrong derivative is wrong
        # everywhere.
        for place in places:
            direction = _direction(model, place)
            if not _deviation(model, place, points, direction) > WRONG:
                return
        deviations = [_deviation(model, places[-1], points, alone) for alone in np.diag(direction)]
    _checked.discard(model.network)
    worst = int(np.argmax(np.nan_to_num(deviations)))
    raise ModelError(
        f"the derivative of {model.name} by {model.names[worst]} is wrong by"
        f" {100 * deviations[worst]:.2g} %: nothing is fitted with it; the plugin's author finds"
        " the rest with springpot.testing"
    )


def _require_numbers(model: Model, places: Sequence[Real], points: Points) -> None:
    """Tell of a model that gives no number, and of the effect that is why, before a fit."""
    never = _never(model.network, places, points)
    if not np.any(never):
        return
    what = owned("model", model.base)
    for effect in model.effects:
        own = [i for i, name in enumerate(model.names) if name.startswith(f"{effect.name}.")]
        alone = [place[own] for place in places]
        if len(own) == len(effect.element.parameters) and np.any(
            _never(effect.element, alone, points)
        ):
            what = owned("effect", effect.name)
    where = f"at {np.sum(never)} of {len(never)} points, whatever its parameters"
    raise ModelError(f"the {what} gives no number (nan) {where}: nothing is fitted with it")


def _never(node: Node, places: Sequence[Real], points: Points) -> NDArray[np.bool_]:
    """Points (n,) at which it gives no number at any of the places.

    Infinity is one, of a place that is absurd.
    """
    with np.errstate(all="ignore"):
        values = [node.respond(place, points).value for place in places]
    never: NDArray[np.bool_] = np.all(np.isnan(values), axis=0)
    return never


def _least_apart(model: Model, places: Sequence[Real], points: Points) -> float:
    """How far the stiffnesses with and without derivatives differ.

    At the first place where they do not agree, or where they differ least.
    """
    least = np.inf
    # Where a balance of two nonlinear parts has no single solution rounding decides: a wrong way
    # errs everywhere.
    for place in places:
        least = min(least, _apart(model, place, points))
        if least <= WRONG:
            break
    return least


def _apart(model: Model, theta: Real, points: Points) -> float:
    """Largest relative difference of K with and without derivatives, where both are finite."""
    # Two ways of one model, the quick one of them written apart: a search goes by one and a descent
    # by the other.
    alone, beside = (
        model.network.respond(theta, points).value,
        model.network.respond(theta, points, GRADIENT).value,
    )
    apart = np.abs(beside - alone) / np.abs(alone)
    return float(np.max(apart[np.isfinite(apart)], initial=0.0))


def _elsewhere(model: Model, theta: Real, factor: float) -> Real:
    """Other parameters inside the bounds, neighbours in theta moved in opposite directions."""
    moved = theta * factor ** ((-1.0) ** np.arange(len(theta)))
    lower, upper = (
        np.array([getattr(p, end) for p in model.parameters]) for end in ("lower", "upper")
    )
    inside = (moved > lower) & (moved < upper)
    return np.where(inside, moved, theta)


def _direction(model: Model, theta: Real) -> Real:
    """A step of every parameter, none of them alike and all inside their bounds."""
    share = 1.0 + 0.3 * np.sin(1.0 + np.arange(len(theta)))
    size = np.where(theta == 0.0, 0.01, np.abs(theta))
    upper = np.array([p.upper for p in model.parameters])
    # From the upper half downwards, as no step may leave the bounds.
    direction: Real = share * size * np.where(np.isfinite(upper) & (theta > 0.5 * upper), -1.0, 1.0)
    return direction


def _deviation(model: Model, theta: Real, points: Points, direction: Real) -> float:
    """Median over the points of the smallest deviation at any step.

    No number where nothing is finite.
    """
    response = model.network.respond(theta, points, GRADIENT)
    # Along one direction in which no two parameters are alike: no error of one can cancel
    # another's.
    shares = response.by_theta * direction[:, None]
    size = np.sum(np.abs(shares), axis=0)
    off = np.abs(_differences(model, theta, points, direction) - shares.sum(axis=0)) / size
    least = np.min(off, axis=0)
    least = least[np.isfinite(least)]
    if not least.size:
        return float("nan")
    # Single points may lie at a kink, or show nothing but rounding.
    return float(np.median(least))


def _differences(model: Model, theta: Real, points: Points, direction: Real) -> Complex:
    """Central differences (steps, n) along a direction.

    One call for all, as each costs about as much.
    """
    steps = np.array(STEPS)[:, None]
    ends = np.concatenate([theta + steps * direction, theta - steps * direction])
    ahead, behind = np.split(model.network.respond(ends, points).value, 2)
    differences: Complex = (ahead - behind) / (2.0 * steps)
    return differences
