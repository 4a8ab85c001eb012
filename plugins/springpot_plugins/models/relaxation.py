"""Relaxation functions that are no network of springpots.

Havriliak-Negami, Cole-Davidson and the power law.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import digamma, gamma

from springpot.rheology import (
    FULL,
    VALUE,
    Complex,
    Model,
    Node,
    Parameter,
    Points,
    Real,
    Response,
    limits_form,
    order,
    parallel,
    power_of_s,
    relaxation_time,
    spring,
    stiffness,
)
from springpot.rheology.points import HALF_PI

from .fractional import REVIEW

_STEP = 0.3
_LOG_RATE = np.arange(-60.0, 4.0, _STEP)
_RATE = np.exp(_LOG_RATE)
"""Nodes of the trapezoidal rule in ln x, whose error is exp(-pi^2 / step), the rounding error."""
_TURN = np.pi / 4
"""Angle by which the path of x avoids a pole on the positive axis.

As far from it as from where exp(-x) grows.
"""
_TURNED_STEP = 0.15
_TURNED_LOG_RATE = np.arange(-60.0, 4.2, _TURNED_STEP) + 1j * _TURN
_TURNED_RATE = np.exp(_TURNED_LOG_RATE)
"""Its nodes: the error is exp(-2 pi turn / step), 5e-15, and the last exp(-x) is 1e-18."""


@dataclass(frozen=True)
class HavriliakNegami(Node):
    """K = k1 [1 - (1 + (s tau)^alpha)^-gamma], complete Bernstein function for orders in [0, 1]."""

    kind: str = "havriliak-negami"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Strength, time and the two orders."""
        return stiffness("k1", "k₁"), relaxation_time(), order(), order("gamma", "γ")

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """Through logarithms, so that nothing cancels where (s tau)^alpha is small."""
        k, tau, alpha, gam = (theta[..., i, None] for i in range(4))
        if np.iscomplexobj(at.log_omega):
            # At alpha = 1 (Davidson and Cole 1951) the spectrum begins at 1/tau by an infinite
            # edge, which no rule for smooth functions sums: just below it K is 1e-4 off at most.
            alpha = np.where(gam < 1.0, np.minimum(alpha, 1.0 - 1e-4), alpha)
        log_time = at.log_omega + np.log(tau)
        z = power_of_s(alpha, log_time)
        log_sum = np.log1p(z)
        shape: Complex = -np.expm1(-gam * log_sum)
        value = k * shape
        if depth == VALUE:
            return Response(value)
        faded = k * np.exp(-gam * log_sum)
        by_log_z = gam * faded * z / (1.0 + z)
        parts = [shape, alpha * by_log_z / tau, by_log_z * (log_time + HALF_PI), faded * log_sum]
        by_theta = np.stack(np.broadcast_arrays(*parts), axis=-2)
        if depth < FULL:
            # Nobody asks for the slope then; the value fills its place.
            return Response(value, by_theta, value)
        return Response(value, by_theta, alpha * by_log_z)


@dataclass(frozen=True)
class PowerLawRelaxation(Node):
    """The modulus whose relaxation is k1 (1 + t/tau)^-alpha.

    With z = s tau, K = k1 [1 - alpha I(z)], I = 1/Gamma(1+alpha) times the integral of x^alpha e^-x
    / (z + x) over the relaxation rates x > 0; it is evaluated by the trapezoidal rule in ln x. At a
    complex `log_omega`, where z comes near the negative axis, the path of x turns away from it.
    """

    kind: str = "power-law-relaxation"

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Strength, time and exponent."""
        return stiffness("k1", "k₁"), relaxation_time(), order()

    def respond(self, theta: Real, at: Points, depth: int = VALUE) -> Response:
        """The sum over rates, and its derivatives under the sum."""
        k, tau, alpha = (theta[..., i, None] for i in range(3))
        log_time = at.log_omega + np.log(tau)
        if np.iscomplexobj(at.log_omega):
            mean, spread, square = _turned(log_time + 0j, alpha, depth > VALUE)
        else:
            mean, spread, square = _straight(log_time, alpha, depth > VALUE)
        shape = 1.0 - alpha * mean
        value: Complex = k * shape
        if depth == VALUE:
            return Response(value)
        by_log_z = k * alpha * np.exp(log_time + HALF_PI) * square
        by_theta = np.stack(
            np.broadcast_arrays(shape, by_log_z / tau, -k * (mean + alpha * spread)), axis=-2
        )
        if depth < FULL:
            return Response(value, by_theta, value)
        return Response(value, by_theta, by_log_z)


def _straight(log_time: Real, alpha: Real, slopes: bool) -> tuple[Complex, Complex, Complex]:
    """I(z), its derivative by alpha and minus that by z, at z = i y.

    1/(z + x) = (x - i y)/(x^2 + y^2).
    """
    y = np.exp(log_time)
    pole = 1.0 / (_RATE**2 + (y * y)[..., None])
    weight = _STEP * np.exp((alpha + 1.0) * _LOG_RATE - _RATE) / gamma(alpha + 1.0)

    def over_rates(weight: Real) -> Complex:
        sums = np.matmul(pole, np.stack([weight * _RATE, weight], axis=-1))
        mean: Complex = sums[..., 0] - 1j * y * sums[..., 1]
        return mean

    mean = over_rates(weight)
    if not slopes:
        return mean, mean, mean
    spread = over_rates(weight * (_LOG_RATE - digamma(alpha + 1.0)))
    sums = np.matmul(pole * pole, np.stack([weight * _RATE**2, weight * _RATE, weight], axis=-1))
    return mean, spread, sums[..., 0] - 2j * y * sums[..., 1] - y * y * sums[..., 2]


def _turned(
    log_time: NDArray[np.complexfloating[Any, Any]], alpha: Real, slopes: bool
) -> tuple[Complex, Complex, Complex]:
    """The same at any z: x runs along a ray on the other side of -z."""
    # One path serves both halves of the plane, for I of a conjugate z is the conjugate of I.
    below = log_time.imag + HALF_PI.imag < 0.0
    z = np.exp(log_time + HALF_PI)
    pole = 1.0 / (np.where(below, z.conj(), z)[..., None] + _TURNED_RATE)
    weight = (
        np.exp((alpha + 1.0) * _TURNED_LOG_RATE - _TURNED_RATE) * _TURNED_STEP / gamma(alpha + 1.0)
    )

    def over_rates(pole: Complex, weight: Complex) -> Complex:
        mean = np.matmul(pole, weight[..., None])[..., 0]
        upright: Complex = np.where(below, mean.conj(), mean)
        return upright

    mean = over_rates(pole, weight)
    if not slopes:
        return mean, mean, mean
    spread = over_rates(pole, weight * (_TURNED_LOG_RATE - digamma(alpha + 1.0)))
    return mean, spread, over_rates(pole * pole, weight)


_havriliak_negami = parallel(spring("k0"), HavriliakNegami())
_power_law = parallel(spring("k0"), PowerLawRelaxation())

MODELS = (
    Model(
        "havriliak-negami",
        _havriliak_negami,
        "asymmetric relaxation, kinf - k1 / (1 + (s tau)^alpha)^gamma, kinf = k0 + k1; gamma = 1 is"
        " oldroyd-b",
        "Havriliak & Negami (1967), 10.1016/0032-3861(67)90021-3",
        search=limits_form(_havriliak_negami.parameters),
    ),
    Model(
        "power-law-plateau",
        _power_law,
        "relaxation k0 + k1 (1 + t/tau)^-alpha: a power law between two plateaus",
        REVIEW,
        aliases=("powerlawplateau",),
        search=limits_form(_power_law.parameters),
    ),
)
