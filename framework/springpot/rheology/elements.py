"""The elements of linear viscoelasticity, powers of s = i omega, and any linear passive material.

A spring, a dashpot, a mass and a springpot are all K = c s^order; only the springpot's order is
free. They, in whatever network, have K(s) = K_e + c s + integral H(r) s / (s + r) dln r with H >= 0
(Bernstein's theorem; Ferry, Viscoelastic Properties of Polymers, 1980, ch. 3). With lines of weight
g at given rates r in place of H the stiffness is linear in K_e, c and g, all of which are positive
or zero: a spring, a dashpot and as many Maxwell elements as the data can tell apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property
from typing import ClassVar, Literal, TypeVar

import numpy as np

from springpot.errors import ModelError

from .nodes import (
    FULL,
    VALUE,
    Chain,
    Node,
    Parallel,
    Renamed,
    Response,
    Scaled,
    Series,
    Shift,
    SpecimenWave,
    repeated,
)
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
    return np.multiply(column, row, order=order)


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

    def parts(self, theta: Real, at: Points) -> tuple[Real, Real]:
        """Both; of a spring its column, and nothing."""
        if self.exponent == 0:
            return theta, np.zeros((1, 1))
        return super().parts(theta, at)


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

    def parts(self, theta: Real, at: Points) -> tuple[Real, Real]:
        """Both, each a product of real tables."""
        alpha = theta[..., 1:]
        table = table_of(alpha, at.log_omega)
        np.exp(table, out=table)
        phase = theta[..., :1] * np.exp(HALF_PI * alpha)
        return table * phase.real, np.multiply(table, phase.imag, out=table)


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


MANY = 4000
"""Frequencies from which K of one material is interpolated."""
SPACING = 0.02
"""Distance in ln omega of the nodes.

The cubic's error, SPACING^4 / 384 of the fourth derivative, is below 1e-9.
"""
LONG_AGO = 6.0
"""Logarithm of the times of a line after which it has faded to nothing, exp(-400)."""
EQUILIBRIUM = Parameter("K_e", "K_e", stiffness().unit)
VISCOSITY = viscosity("c")


@cache
def _line(j: int) -> Parameter:
    """The weight of line j: searches ask for thousands of spectra, whose weights are the same."""
    # A detail: of forty weights none means anything by itself.
    return Parameter(f"g{j}", f"g_{j}", EQUILIBRIUM.unit, detail=True)


@dataclass(frozen=True)
class Continuum(Node):
    """K = K_e + c s + sum of g_j s / (s + r_j) over the lines of a spectrum.

    Parameters
    ----------
    rates : tuple of float
        The rates r_j in rad/s, ascending. Without any the node stands for a material that has not
        been fitted yet: the fit chooses them.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology import Continuum, Points
    >>> material = Continuum((1.0, 10.0))
    >>> material.respond(np.array([1.0, 0.0, 2.0, 3.0]), Points.at([1e6])).value.real.round(6)
    array([6.])
    """

    rates: tuple[float, ...] = ()
    kind: str = "material"
    columns: ClassVar[tuple[str, ...]] = ("omega", "storage", "loss")
    flow: ClassVar[float] = 1.0
    """Power of the frequency that the dashpot's share goes with."""

    def __post_init__(self) -> None:
        if not min(self.rates, default=1.0) > 0.0:
            raise ModelError("rates of a spectrum are above zero")

    @cached_property
    def _parameters(self) -> tuple[Parameter, ...]:
        return (EQUILIBRIUM, VISCOSITY, *map(_line, range(1, len(self.rates) + 1)))

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """K_e, c and the weight of each line."""
        return self._parameters

    @cached_property
    def _log_rates(self) -> Real:
        return np.log(np.array(self.rates, dtype=np.float64))

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """K, linear in all parameters."""
        # Between the nodes K of a passive material is smooth; a complex frequency may meet a pole.
        if (
            depth == VALUE
            and at.log_omega.size > MANY
            and not np.iscomplexobj(at.log_omega)
            and _one(theta)
        ):
            return Response(self._interpolated(theta.reshape(-1, theta.shape[-1])[0], at.log_omega))
        basis, slopes = self.basis(at.log_omega, depth == FULL)
        value = np.matmul(theta[..., None, :], basis)[..., 0, :]
        if depth == VALUE:
            return Response(value)
        by_theta = np.broadcast_to(basis, (*value.shape[:-1], *basis.shape[-2:]))
        if depth < FULL:
            return Response(value, by_theta)
        return Response(value, by_theta, np.matmul(theta[..., None, :], slopes)[..., 0, :])

    def _interpolated(self, theta: Real, log_omega: Real) -> Complex:
        """K of one material at very many frequencies, as for a shift tried at many settings."""
        # A third of a second that `springpot --help` is spared.
        from scipy.interpolate import CubicHermiteSpline

        low = float(np.min(log_omega))
        # A time sweep has but one frequency, and a curve two nodes.
        high = max(float(np.max(log_omega)), low + SPACING)
        x = np.linspace(low, high, 2 + int((high - low) / SPACING))
        basis, slopes = self.basis(x, True)
        return np.asarray(
            CubicHermiteSpline(x, theta @ basis, theta @ slopes)(log_omega), dtype=np.complex128
        )

    def basis(self, log_omega: Real, with_slopes: bool) -> tuple[Complex, Complex]:
        """dK/dtheta (..., 2 + m, n), and its derivative by ln omega."""
        shape = (*log_omega.shape[:-1], 2 + len(self.rates), log_omega.shape[-1])
        basis = np.empty(shape, dtype=np.complex128)
        basis[..., 0, :] = 1.0
        basis[..., 1, :] = 1j * np.exp(log_omega)
        # s / (s + r) in terms of r / omega, which stays finite where the two lie far apart.
        ratio = np.exp(self._log_rates[:, None] - log_omega[..., None, :])
        if np.iscomplexobj(ratio):
            basis[..., 2:, :] = 1.0 / (1.0 - 1j * ratio)
        else:  # the same in real numbers, which cost a third
            room = 1.0 / (1.0 + ratio * ratio)
            basis.real[..., 2:, :] = room
            basis.imag[..., 2:, :] = ratio * room
        if not with_slopes:
            return basis, basis
        slopes = np.zeros_like(basis)
        slopes[..., 1, :] = basis[..., 1, :]
        slopes[..., 2:, :] = basis[..., 2:, :] * (1.0 - basis[..., 2:, :])
        return basis, slopes

    def moved(self, lines: Complex) -> tuple[Complex, Complex]:
        """First and second derivative (m, n) by ln omega of lines of these values (m, n)."""
        slopes = lines * (1.0 - lines)
        return slopes, slopes * (1.0 - 2.0 * lines)


@dataclass(frozen=True)
class Relaxation(Continuum):
    """What the same material shows at the time t = 1 / omega after a step: its relaxation function.

    G = K_e + sum of g_j exp(-r_j t), real; the dashpot has pushed at the step itself and no more.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology.elements import Relaxation
    >>> from springpot.rheology import Points
    >>> relaxing = Relaxation((1.0,))
    >>> relaxing.respond(np.array([1.0, 0.0, 2.0]), Points.at([1.0])).value.real.round(3)
    array([1.736])
    """

    columns: ClassVar[tuple[str, ...]] = ("time", "relaxation")

    def basis(self, log_omega: Real, with_slopes: bool) -> tuple[Complex, Complex]:
        """As of `Continuum`."""
        shape = (*log_omega.shape[:-1], 2 + len(self.rates), log_omega.shape[-1])
        basis, slopes = np.zeros(shape, dtype=np.complex128), np.zeros(shape, dtype=np.complex128)
        basis[..., 0, :] = 1.0
        ratio = self._ratio(log_omega)
        basis[..., 2:, :] = np.exp(-ratio)
        slopes[..., 2:, :] = ratio * basis[..., 2:, :]
        return basis, slopes

    def moved(self, lines: Complex) -> tuple[Complex, Complex]:
        """As of `Continuum`."""
        ratio = -np.log(np.maximum(lines.real, np.exp(-np.exp(LONG_AGO))))
        slopes = (ratio * lines).astype(np.complex128)
        return slopes, (ratio - 1.0) * slopes

    def _ratio(self, log_omega: Real) -> Real:
        """Times (m, n) in those of each line; what has long faded need not be told apart."""
        return np.exp(np.minimum(self._log_rates[:, None] - log_omega[..., None, :], LONG_AGO))


@dataclass(frozen=True)
class Compliance(Relaxation):
    """What a material shows at the time t = 1 / omega after a step of the force: its compliance.

    J = J_g + t / eta + sum of L_j (1 - exp(-r_j t)), real, all shares positive or zero (Ferry,
    Viscoelastic Properties of Polymers, 1980, ch. 3). The shares stand in the places of K_e, c and
    the weights, and are compliances.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot.rheology.elements import Compliance
    >>> from springpot.rheology import Points
    >>> creeping = Compliance((1.0,))
    >>> creeping.respond(np.array([1.0, 0.5, 2.0]), Points.at([1.0])).value.real.round(3)
    array([2.764])
    """

    columns: ClassVar[tuple[str, ...]] = ("time", "compliance")
    flow: ClassVar[float] = -1.0

    def basis(self, log_omega: Real, with_slopes: bool) -> tuple[Complex, Complex]:
        """As of `Continuum`."""
        basis, slopes = super().basis(log_omega, with_slopes)
        basis[..., 1, :] = np.exp(-log_omega)
        slopes[..., 1, :] = -basis[..., 1, :]
        # Of short times the difference of one and nearly one would be rounding.
        basis[..., 2:, :] = -np.expm1(-self._ratio(log_omega))
        slopes[..., 2:, :] = -slopes[..., 2:, :]
        return basis, slopes

    def moved(self, lines: Complex) -> tuple[Complex, Complex]:
        """As of `Continuum`."""
        slopes, bends = super().moved(1.0 - lines)
        return -slopes, -bends


def _one(theta: Real) -> bool:
    """Whether all rows of theta (..., p) are the same material."""
    return bool(np.all(theta == theta[(0,) * (theta.ndim - 1)]))


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
