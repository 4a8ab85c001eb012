"""The models of bituminous binders and mixtures: Huet, Huet-Sayegh, 1S2P1D, 2S2P1D.

In their literature the orders alpha and beta are called k and h, and the factor nu of the dashpot
beta.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from springpot.rheology import (
    Mapped,
    Model,
    Node,
    Parameter,
    Real,
    columns,
    dashpot,
    limits_form,
    order,
    parallel,
    relaxation_time,
    rows,
    series,
    spring,
    springpot,
    stiffness,
)

OLARD = "Olard & Di Benedetto (2003), 10.1080/14680629.2003.9689946"
HUET = "Huet (1963), thesis, Paris"
SAYEGH = "Sayegh (1967), 2nd Int. Conf. Structural Design of Asphalt Pavements; " + OLARD


def _branch_elements(theta: Real, with_dashpot: bool) -> Real:
    k, delta, tau, alpha, beta = np.moveaxis(theta[..., :5], -1, 0)
    parts = [k, k * tau**alpha / delta, alpha, k * tau**beta, beta]
    if with_dashpot:
        parts.append(theta[..., 5] * k * tau)
    return columns(*parts)


def _branch_jacobian(theta: Real, with_dashpot: bool) -> Real:
    k, delta, tau, alpha, beta = np.moveaxis(theta[..., :5], -1, 0)
    nu = np.zeros_like(k)
    if with_dashpot:
        nu = theta[..., 5]
    one, log_tau = np.ones_like(k), np.log(tau)
    c1, c2 = k * tau**alpha / delta, k * tau**beta
    full = rows(
        columns(one, 0.0, 0.0, 0.0, 0.0, 0.0),
        columns(c1 / k, -c1 / delta, alpha * c1 / tau, c1 * log_tau, 0.0, 0.0),
        columns(0.0, 0.0, 0.0, one, 0.0, 0.0),
        columns(c2 / k, 0.0, beta * c2 / tau, 0.0, c2 * log_tau, 0.0),
        columns(0.0, 0.0, 0.0, 0.0, one, 0.0),
        columns(nu * tau, 0.0, nu * k, 0.0, 0.0, k * tau),
    )
    if with_dashpot:
        return full
    # The dashpot is the last element, and its factor the last parameter.
    return full[..., :5, :5]


def _branch(with_dashpot: bool) -> Node:
    """K = k1 / (1 + delta (s tau)^-alpha + (s tau)^-beta [+ (s nu tau)^-1])."""
    forward = partial(_branch_elements, with_dashpot=with_dashpot)
    jacobian = partial(_branch_jacobian, with_dashpot=with_dashpot)
    pots = [springpot("k1 tau^alpha/delta", "alpha"), springpot("k1 tau^beta", "beta")]
    own = (
        stiffness("k1", "k₁"),
        Parameter("delta", "δ"),
        relaxation_time(),
        order("alpha", "α"),
        order("beta", "β"),
    )
    if not with_dashpot:
        return Mapped(series(spring("k1"), *pots), own, forward, jacobian)
    network = series(spring("k1"), *pots, dashpot("nu k1 tau"))
    return Mapped(network, (*own, Parameter("nu", "ν")), forward, jacobian)


_huet_sayegh = parallel(spring("k0"), _branch(with_dashpot=False))
_2s2p1d = parallel(spring("k0"), _branch(with_dashpot=True))

MODELS = (
    Model(
        "huet",
        _branch(with_dashpot=False),
        "spring in series with two springpots of different order",
        HUET,
    ),
    Model(
        "huet-sayegh",
        _huet_sayegh,
        "spring beside a Huet element: kinf = k0 + k1",
        SAYEGH,
        search=limits_form(_huet_sayegh.parameters),
    ),
    Model(
        "1s2p1d",
        _branch(with_dashpot=True),
        "Huet element in series with a dashpot: a bituminous binder",
        OLARD,
    ),
    Model(
        "2s2p1d",
        _2s2p1d,
        "spring beside a spring, two springpots and a dashpot in series: a bituminous mixture, kinf"
        " = k0 + k1",
        OLARD,
        search=limits_form(_2s2p1d.parameters),
    ),
)
