"""Parameters that a user knows: some are held at a value, others are kept within narrower bounds.

What is held leaves theta, so that degrees of freedom, uncertainty and every test of a residual
count only what the data decide.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from springpot.errors import ModelError

from .nodes import Mapped, Node, Response
from .parameters import Parameter
from .points import Complex, Points, Real

Bounds = tuple[float, float]


@dataclass(frozen=True)
class Inserted:
    """The map from the parameters that are left to all of them.

    Parameters
    ----------
    values : tuple of (float or None)
        For each parameter of the inner node the value it is held at, or None where it is free.
    """

    values: tuple[float | None, ...]

    @property
    def free(self) -> NDArray[np.intp]:
        """Positions of the free parameters."""
        return np.array([i for i, value in enumerate(self.values) if value is None], dtype=np.intp)

    def __call__(self, theta: Real) -> Real:
        """All parameters (..., p) of the free ones (..., q)."""
        # Of theta's own kind: a complex step of a derivative must pass through.
        full: Real = np.empty((*theta.shape[:-1], len(self.values)), dtype=theta.dtype)
        # Those that are free are no numbers here, until theta takes their places.
        full[...] = np.array(self.values, dtype=float)
        full[..., self.free] = theta
        return full

    def jacobian(self, theta: Real) -> Real:
        """Its derivative (..., p, q): ones where a free parameter stands."""
        slopes: Real = np.eye(len(self.values))[:, self.free]
        return np.broadcast_to(slopes, (*theta.shape[:-1], *slopes.shape))


@dataclass(frozen=True)
class Held(Mapped):
    """A node some of whose parameters are held or bounded; see `hold`."""

    forward: Inserted

    @property
    def released(self) -> Node:
        """The inner node with all its parameters free."""
        return self.node.released

    @property
    def held(self) -> dict[str, float]:
        """Parameters that are held, by name."""
        return {**self.node.held, **self.here}

    @property
    def here(self) -> dict[str, float]:
        """Those that are held by this node, and by none within it."""
        pairs = zip(self.node.parameters, self.forward.values, strict=True)
        return {parameter.name: value for parameter, value in pairs if value is not None}

    @property
    def absent_at(self) -> float | None:
        """As the inner node says."""
        return self.node.absent_at

    def bound_to(self, at: Points) -> Node:
        """The inner node bound, and held as before."""
        bound = self.node.bound_to(at)
        if bound is self.node:
            return self
        bounds = {each.name: (each.lower, each.upper) for each in self.parameters}
        return hold(bound, self.here, bounds)

    def third_harmonic(self, theta: Real, at: Points) -> Complex | None:
        """That of the inner node, where it knows one."""
        predict = getattr(self.node, "third_harmonic", None)
        if predict is None:
            return None
        harmonic: Complex | None = predict(self.forward(theta), at)
        return harmonic


@dataclass(frozen=True, eq=False)
class Fixed(Node):
    """A node at given parameters.

    It has none of its own, and is evaluated once for all settings beside it.

    Parameters
    ----------
    node : Node
        What is fixed.
    theta : ndarray, shape (p,)
        Its parameters.
    """

    node: Node
    theta: Real

    @property
    def parameters(self) -> tuple[()]:
        """None are left."""
        return ()

    @property
    def needs(self) -> frozenset[str]:
        """What the inner node needs."""
        return self.node.needs

    def within(self, theta: Real) -> tuple[Real, Node]:
        """The inner node and its parameters."""
        return self.theta, self.node

    def respond(self, theta: Real, at: Points, depth: int = 0) -> Response:
        """The inner node's response, without leading axes where the points have none."""
        # Once for all thetas beside it: that is why it is fixed.
        response = self.node.respond(self.theta, at, depth)
        empty = np.zeros(
            (*response.value.shape[:-1], 0, response.value.shape[-1]), dtype=np.complex128
        )
        return response._replace(by_theta=empty)


def hold(node: Node, values: Mapping[str, float], bounds: Mapping[str, Bounds]) -> Node:
    """The node with parameters held at `values` and others within `bounds`.

    Itself where neither names its own.

    Parameters
    ----------
    node : Node
        Its parameters.
    values, bounds : mapping of str
        By name, in the unit of theta.

    Raises
    ------
    ModelError
        If a value or bound is none that the parameter can take.
    """
    # Most nodes of a model are not named: they stay what they are, without a wrapping that costs
    # time.
    names = {parameter.name for parameter in node.parameters}
    if not names & (set(values) | set(bounds)):
        return node
    # What is held already stays held, in one wrapping for all.
    inner, known = node, dict[str, float]()
    if isinstance(node, Held):
        inner, known = node.node, node.here
    known |= {name: allowed(p, values[name]) for p in node.parameters if (name := p.name) in values}
    free = [_bounded(p, bounds.get(p.name), known) for p in node.parameters if p.name not in known]
    inserted = Inserted(tuple(known.get(parameter.name) for parameter in inner.parameters))
    return Held(inner, tuple(free), inserted, inserted.jacobian)


def allowed(parameter: Parameter, value: float) -> float:
    """A value that a parameter can take.

    Raises
    ------
    ModelError
        If it is none.
    """
    if not (isfinite(value) and parameter.lower <= value <= parameter.upper):
        ends = f"{parameter.lower:g}", f"{parameter.upper:g}"
        room = f"[{ends[0]}, {ends[1]}{']' if isfinite(parameter.upper) else ')'}"
        raise ModelError(f"{parameter.name} cannot be {value:g}: it lies in {room}")
    return float(value)


def _bounded(parameter: Parameter, bounds: Bounds | None, known: Mapping[str, float]) -> Parameter:
    """The parameter in its narrower bounds; an order that is held becomes a number in the unit."""
    # A unit such as kN s^alpha/m is told with the number from here on: there is no alpha left to be
    # looked up.
    time = parameter.unit.time
    if isinstance(time, str) and time in known:
        parameter = replace(parameter, unit=replace(parameter.unit, time=known[time]))
    if bounds is None:
        return parameter
    # Bounds of a user never reach beyond those of physics.
    low, high = max(bounds[0], parameter.lower), min(bounds[1], parameter.upper)
    if not low < high:
        ends = f"{parameter.lower:g}", f"{parameter.upper:g}"
        room = f"[{ends[0]}, {ends[1]}{']' if isfinite(parameter.upper) else ')'}"
        raise ModelError(
            f"{parameter.name} has no room between {bounds[0]:g} and {bounds[1]:g}:"
            f" it lies in {room}"
        )
    return replace(parameter, lower=low, upper=high)
