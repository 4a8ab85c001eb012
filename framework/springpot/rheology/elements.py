"""The elements of linear viscoelasticity: powers of s = i omega.

A spring, a dashpot, a mass and a springpot are all K = c s^order; only the springpot's order is
free.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np

from .nodes import FULL, VALUE, Node, Response, repeated
from .parameters import (
    INERTANCE,
    SECOND,
    Dimension,
    Parameter,
    order,
    quasi_property,
    stiffness,
    viscosity,
)
from .points import HALF_PI, Complex, Points, Real, power_of_s

T = TypeVar("T", Real, Complex)


def table_of(column: Real, row: T) -> T:
    """Product (m, n) of a column (m, 1) and a row (n,).

    The longer of the two lies side by side in memory.

    numpy runs along what lies side by side; whatever is made from the table keeps its order.
    """
    tall = column.ndim == 2 and row.ndim == 1 and len(column) > len(row)
    order: Literal["F", "K"] = "K"
    if tall:
        order = "F"
    table: T = np.multiply(column, row, order=order)
    return table


def _phase(exponent: float) -> complex:
    """i^exponent, exact for whole exponents so that a mass has no loss and a dashpot no storage."""
    # exp(i pi) is -1 but for its last digit, which would give a mass a loss of 1e-16 of its force.
    if exponent == int(exponent):
        return complex(1j ** int(exponent))
    return complex(np.exp(HALF_PI * exponent))


@dataclass(frozen=True)
class KnownMass(Node):
    """K = -m omega^2 of a mass that was weighed: no parameter.

    Parameters
    ----------
    mass : float
        In units of stiffness times s^2.
    """

    mass: float

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """None."""
        return ()

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """K = m s^2."""
        value: Complex = np.asarray(-self.mass * np.exp(2.0 * at.log_omega), dtype=np.complex128)
        nothing = np.zeros((*theta.shape[:-1], 0, value.shape[-1]), dtype=np.complex128)
        if depth == VALUE:
            return Response(value)
        if depth == FULL:
            return Response(value, nothing, 2.0 * value)
        return Response(value, nothing)


@dataclass(frozen=True)
class FixedPower(Node):
    """K = c (i omega)^exponent with a fixed exponent.

    Parameters
    ----------
    parameter : Parameter
        The factor c.
    exponent : float
        0 for a spring, 1 for a dashpot, 2 for a mass, 3/2 for a Basset layer.
    kind : str
        Name of the element in drawings.
    """

    parameter: Parameter
    exponent: float
    kind: str = "power"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The factor."""
        return (self.parameter,)

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """K = c s^exponent, real for springs and masses."""
        # A spring is the same at all frequencies: no table of powers is made of ones.
        if self.exponent == 0 and depth == VALUE:
            return Response(repeated(theta.astype(complex), at.log_omega.shape))
        if self.exponent == 0:
            power: Complex = np.ones(at.log_omega.shape, dtype=complex)
        else:
            power = np.exp(self.exponent * at.log_omega) * _phase(self.exponent)
        if depth == VALUE:
            return Response(table_of(theta, power))
        value = theta * power
        # The derivative by a factor is the same for all thetas: a view, not a copy for each.
        by_theta = np.broadcast_to(power, value.shape)[..., None, :]
        if depth == FULL:
            return Response(value, by_theta, self.exponent * value)
        return Response(value, by_theta)


@dataclass(frozen=True)
class Springpot(Node):
    """Springpot (Scott-Blair element), K = c (i omega)^alpha; eq. (25) of the paper.

    Parameters
    ----------
    factor, exponent : Parameter
        Its constant c and its order alpha in [0, 1].
    """

    factor: Parameter
    exponent: Parameter
    kind: str = "springpot"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The constant and the order."""
        return (self.factor, self.exponent)

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """K = c s^alpha; dK/dalpha = K ln s."""
        # Cut and not indexed, so that it keeps an axis along which the frequencies are laid.
        alpha = theta[..., 1:]
        if depth == VALUE:
            value: Complex = np.exp(table_of(alpha, at.log_omega)).astype(complex)
            # The constant joins the phase, one number for all frequencies, and not the long table.
            value *= theta[..., :1] * np.exp(HALF_PI * alpha)
            return Response(value)
        # By itself, without the constant: it is the derivative by it.
        power = power_of_s(alpha, at.log_omega)
        value = theta[..., :1] * power
        by_theta = np.empty((*value.shape[:-1], 2, value.shape[-1]), dtype=complex)
        by_theta[..., 0, :] = power
        # ln s = ln omega + i pi / 2.
        by_theta[..., 1, :] = value * (at.log_omega + HALF_PI)
        if depth == FULL:
            return Response(value, by_theta, alpha * value)
        return Response(value, by_theta)


def spring(name: str = "k") -> FixedPower:
    """A spring of stiffness `name`.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, spring
    >>> spring().respond(np.array([3.0]), Points.at([1.0, 10.0])).value
    array([3.+0.j, 3.+0.j])
    """
    return FixedPower(stiffness(name), 0.0, "spring")


def dashpot(name: str = "c") -> FixedPower:
    """A dashpot of viscosity `name`.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, dashpot
    >>> dashpot().respond(np.array([3.0]), Points.at([1.0, 10.0])).value.imag.round(6)
    array([ 3., 30.])
    """
    return FixedPower(viscosity(name), 1.0, "dashpot")


def mass(name: str = "m") -> FixedPower:
    """A moving mass (or inerter): K = -m omega^2.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, mass
    >>> mass().respond(np.array([0.5]), Points.at([1.0, 10.0])).value.real.round(6)
    array([ -0.5, -50. ])
    """
    return FixedPower(Parameter(name, "m", INERTANCE), 2.0, "mass")


def springpot(factor: str = "c", exponent: str = "alpha") -> Springpot:
    """A springpot with constant `factor` and order `exponent`.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, springpot
    >>> np.abs(springpot().respond(np.array([3.0, 0.5]), Points.at([1.0, 100.0])).value).round(6)
    array([ 3., 30.])
    """
    return Springpot(quasi_property(factor, exponent), order(exponent))


RADIAN = Dimension(label="rad")


def basset(c: str = "c") -> FixedPower:
    """Oscillating boundary layer in a fluid (Basset), K = c s^(3/2).

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Points, basset
    >>> basset().respond(np.array([1.0]), Points.at([4.0])).value.round(3)
    array([-5.657+5.657j])
    """
    return FixedPower(Parameter(c, "c", Dimension(stiffness=1, time=1.5)), 1.5, "basset")


def delay_time(name: str = "tau") -> Parameter:
    """A time that may be negative: the other channel may be the late one."""
    return Parameter(name, "τ", SECOND, lower=-np.inf, scale="linear", typical=0.1)
