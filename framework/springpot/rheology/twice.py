"""Whether an effect that a model has already would be the same thing once more."""

from __future__ import annotations

import numpy as np

from .effect import Effect
from .elements import HALF_PI
from .nodes import GRADIENT, VALUE, Node, Response
from .parameters import Parameter
from .points import ROOM, Points, Real

ALONG = 1e-9
"""Sine of the angle between two slopes below which they are one direction."""
_GRID = np.meshgrid(np.log(np.geomspace(0.1, 10.0, 5)), [0.5, 2.0], [280.0, 300.0], indexing="ij")
_POINTS = Points(_GRID[0].ravel(), _GRID[1].ravel(), _GRID[2].ravel(), ROOM)


class _Sample(Node):
    """A material without parameters: K = 1 + s^0.4."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return ()

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        power = np.exp(0.4 * (at.log_omega + HALF_PI))
        nothing = np.zeros((0, len(power)), dtype=np.complex128)
        return Response(1.0 + power, nothing, 0.4 * power)


def same_twice(effect: Effect) -> bool:
    """Whether two effects of this kind in one model act as one of them with another size.

    Two masses are one larger mass; two relaxation modes, or two filters of different corner
    frequencies, are not one. Effects with a factor for each level and those of a test are; of the
    others only those with a single parameter are judged.
    """
    if effect.by_levels or effect.of_test:
        return True
    if len(effect.element.parameters) != 1:
        return False
    network: Node = _Sample()
    for prefix in ("first", "second"):
        network = effect.composition(network, effect.element.with_prefix(prefix))
    # Of two different sizes, as two equal ones would have the same slope whatever the effect.
    sizes = np.array([_inside(effect.element.parameters[0], share) for share in (0.3, 0.6)])
    with np.errstate(all="ignore"):
        slopes = network.respond(sizes, _POINTS, GRADIENT).by_theta
    first, second = np.concatenate([slopes.real, slopes.imag], axis=-1)
    length = np.linalg.norm(first) * np.linalg.norm(second)
    if not (np.isfinite(length) and length > 0):
        return False
    # Two of one kind are the same where both move K in one direction.
    left = second - first * (first @ second) / (first @ first)
    return bool(np.linalg.norm(left) < ALONG * np.linalg.norm(second))


def _inside(parameter: Parameter, share: float) -> float:
    """A value within the bounds."""
    low, high = parameter.lower, parameter.upper
    if np.isfinite(low) and np.isfinite(high):
        return low + share * (high - low)
    # From the end that there is, away from the other.
    if high == np.inf:
        return max(low, 0.0) + share
    return min(high, 0.0) - share
