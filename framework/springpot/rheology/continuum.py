"""Any linear passive material.

A spring, a dashpot and as many Maxwell elements as the data can tell apart.

Springs, dashpots and springpots, in whatever network, have K(s) = K_e + c s + integral H(r) s / (s
+ r) dln r with H >= 0 (Bernstein's theorem; Ferry, Viscoelastic Properties of Polymers, 1980, ch.
3). With lines of weight g at given rates r in place of H the stiffness is linear in K_e, c and g,
all of which are positive or zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from springpot.errors import ModelError

from .nodes import FULL, VALUE, Node, Response
from .parameters import Parameter, stiffness, viscosity
from .points import Complex, Points, Real

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
        unit = EQUILIBRIUM.unit
        # Details: of forty weights none means anything by itself.
        lines = [
            Parameter(f"g{j}", f"g_{j}", unit, detail=True) for j in range(1, len(self.rates) + 1)
        ]
        return (EQUILIBRIUM, VISCOSITY, *lines)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """K_e, c and the weight of each line."""
        return self._parameters

    @cached_property
    def _log_rates(self) -> Real:
        logs: Real = np.log(np.array(self.rates, dtype=np.float64))
        return logs

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
    >>> from springpot.rheology.continuum import Relaxation
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
    >>> from springpot.rheology.continuum import Compliance
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
