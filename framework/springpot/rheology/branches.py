"""A network taken apart into branches side by side, readable anywhere in the complex s-plane.

Every network is analytic in ln s, so that a branch evaluates at a complex `log_omega`: s = i
exp(log_omega). With ``log_omega = ln r + i pi/2`` it is read at s = -r, on the upper edge of the
cut on which its relaxation lives.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .elements import FixedPower, KnownMass
from .nodes import (
    FULL,
    GRADIENT,
    VALUE,
    Chain,
    Composition,
    Mapped,
    Node,
    Parallel,
    Renamed,
    Response,
    Scaled,
    Series,
    Shift,
)
from .points import Points, Real

Anywhere: TypeAlias = NDArray[np.inexact[Any]]
"""Real or complex logarithms of a frequency."""


@dataclass(frozen=True)
class Branch:
    """One of the branches whose stiffnesses (or compliances) add up to the whole network's.

    Parameters
    ----------
    node : Node
        Its network.
    theta : ndarray, shape (b,)
        Its own parameters.
    chain : ndarray, shape (b, p)
        Their derivative by the parameters of the whole.
    conditions : Points
        Temperature and reference temperature; its frequencies are not used.
    compliance : bool
        Read 1/K as a function of p = 1/s, which has the form of a stiffness: then "log_omega" means
        that of p.
    """

    node: Node
    theta: Real
    chain: Real
    conditions: Points
    compliance: bool = False

    def respond(self, log_omega: Anywhere, depth: int = VALUE) -> Response:
        """The branch (n,), its derivative (p, n) by the whole's parameters and its slope (n,)."""
        where = log_omega
        if self.compliance:
            # s = 1/p, so that i exp(where) = 1 / (i exp(log_omega)).
            where = -log_omega - 1j * np.pi
        at = replace(self.conditions, log_omega=where)  # type: ignore[arg-type]
        response = self.node.respond(self.theta, at, depth)
        by_theta = response.by_theta
        if depth >= GRADIENT:
            by_theta = self.chain.T @ by_theta
        if not self.compliance:
            return Response(response.value, by_theta, response.by_log_omega)
        value = 1.0 / response.value
        if depth == VALUE:
            return Response(value)
        # d(1/K) = -dK / K^2, and ln p falls where ln s grows.
        square = value**2
        if depth < FULL:
            return Response(value, -square * by_theta)
        return Response(value, -square * by_theta, square * response.by_log_omega)

    @property
    def is_mass(self) -> bool:
        """Whether it is nothing but a mass."""
        element = _innermost(self.node)
        return isinstance(element, KnownMass) or (
            isinstance(element, FixedPower) and element.exponent == 2.0
        )

    @property
    def is_layer(self) -> bool:
        """Whether it is a fluid layer set in motion (Basset), between a dashpot and a mass."""
        element = _innermost(self.node)
        return isinstance(element, FixedPower) and 1.0 < element.exponent < 2.0

    def mass(self) -> tuple[float, Real]:
        """The constant of a mass and its derivative (p,), read at s = i."""
        # There s^2 = -1: minus the stiffness is the mass itself.
        response = self.respond(np.zeros(1), GRADIENT)
        return -float(response.value[0].real), -response.by_theta[:, 0].real


def _innermost(node: Node) -> Node:
    while isinstance(node, Renamed | Scaled | Shift | Chain):
        if isinstance(node, Composition):
            node = node.children[0]
        else:
            node = node.node
    return node


def branches(
    network: Node, theta: Real, conditions: Points, *, compliance: bool = False
) -> list[Branch]:
    """The branches of a network side by side, or, for the compliance, one after the other.

    Parameters
    ----------
    network : Node
        Of the whole model.
    theta : ndarray, shape (p,)
        Its parameters.
    conditions : Points
        Temperature and reference temperature.
    compliance : bool
        Take it apart in series instead, and let each branch give its compliance.
    """
    kind: type[Composition] = Parallel
    if compliance:
        kind = Series
    # Branch by branch: each may be a line, a mass or spread, and is then treated for what it is.
    parts = _split(network, theta, np.eye(len(theta)), kind)
    return [Branch(node, own, chain, conditions, compliance) for node, own, chain in parts]


def _split(
    node: Node, theta: Real, chain: Real, kind: type[Composition]
) -> Iterator[tuple[Node, Real, Real]]:
    if isinstance(node, Renamed):
        yield from _split(node.node, theta, chain, kind)
    elif isinstance(node, Scaled):
        for inner, own, link in _split(node.node, theta, chain, kind):
            yield Scaled(inner, node.factor), own, link
    elif isinstance(node, Mapped):
        yield from _split(node.node, node.forward(theta), node.jacobian(theta) @ chain, kind)
    elif isinstance(node, kind):
        for child, cut in zip(node.children, node.cuts, strict=True):
            yield from _split(child, theta[cut], chain[cut], kind)
    elif isinstance(node, Shift | Chain):
        # A shift, or a factor, of the whole is one of every branch.
        first, second = node.cuts
        for inner, own, link in _split(node.children[0], theta[first], chain[first], kind):
            together = np.concatenate([own, theta[second]]), np.concatenate([link, chain[second]])
            yield type(node)((inner, node.children[1])), *together
    else:
        yield node, theta, chain
