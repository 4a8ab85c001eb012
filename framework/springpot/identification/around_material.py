"""What stands around a material in a network: what it makes of frequencies and of weights."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from springpot.rheology.elements import Continuum
from springpot.rheology.model import Model
from springpot.rheology.nodes import (
    Chain,
    Node,
    Parallel,
    Renamed,
    Response,
    Scaled,
    Series,
    Shift,
    SpecimenWave,
)
from springpot.rheology.parameters import Parameter
from springpot.rheology.points import Complex, Points, Real


@dataclass(frozen=True)
class Probe(Node):
    """Stands in a material's place and keeps the reduced frequencies that reach it."""

    seen: list[tuple[float, float]]

    def respond(self, theta: Real, at: Points, depth: int = 0) -> Response:
        """K = 1, whatever is asked."""
        self.seen.append((float(np.min(at.log_omega.real)), float(np.max(at.log_omega.real))))
        one = np.ones(at.log_omega.shape, dtype=np.complex128)
        empty = np.zeros((*theta.shape[:-1], 0, at.log_omega.shape[-1]), dtype=np.complex128)
        return Response(one, empty, np.zeros_like(one))

    @property
    def parameters(self) -> tuple[()]:
        """None."""
        return ()


@dataclass(frozen=True, eq=False)
class Tabulated(Node):
    """Stands in a material's place where it is asked at the measured frequencies, whatever theta.

    Its lines are worked out once: dK/dtheta (2 + m, n).
    """

    basis: Complex
    material: Continuum

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """K_e, c and the weight of each line."""
        return self.material.parameters

    def respond(self, theta: Real, at: Points, depth: int = 0) -> Response:
        """K, linear in all parameters."""
        value = theta @ self.basis
        by_theta = np.broadcast_to(self.basis, (*value.shape[:-1], *self.basis.shape))
        return Response(value, by_theta)


def linear_in_material(network: Node) -> bool:
    """Whether K is linear in the weights of the spectrum.

    Only sums, factors and shifts stand around it.
    """
    if isinstance(network, Continuum):
        return True
    if isinstance(network, Renamed | Scaled):
        return linear_in_material(network.node)
    if isinstance(network, Parallel):
        return any(linear_in_material(child) for child in network.children)
    if isinstance(network, Chain | Shift):
        return linear_in_material(network.children[0])
    return False


def asked_as_measured(network: Node) -> bool:
    """Whether nothing around the material moves the frequencies at which it is asked."""
    if isinstance(network, Continuum):
        return True
    if isinstance(network, Renamed | Scaled):
        return asked_as_measured(network.node)
    if isinstance(network, Parallel | Series | Chain | SpecimenWave):
        return any(asked_as_measured(child) for child in network.children)
    return False


def reduced_range(fitted: Model, theta: Real, points: Points) -> tuple[float, float]:
    """Least and largest logarithm of the reduced frequencies that reach a fitted material."""
    probe = Probe([])
    own = theta[len(fitted.material.parameters) :]
    with np.errstate(all="ignore"):
        replace(fitted, material=probe).network.respond(own, points)
    return min(seen[0] for seen in probe.seen), max(seen[1] for seen in probe.seen)
