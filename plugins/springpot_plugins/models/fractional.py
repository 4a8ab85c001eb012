"""The fractional family that RHEOS.jl and pyRheo share, and the models of bituminous materials.

Springpots where the classical models have dashpots. Aliases are the names those tools use, in lower
case. ``fractional-maxwell-gel`` and ``-liquid`` are no aliases: pyRheo and RheoJAX give the two
names to each other's networks. And any linear passive material: the model of all networks of
springs, dashpots and springpots. Of Huet, Huet-Sayegh, 1S2P1D and 2S2P1D the literature calls the
orders alpha and beta k and h, and the factor nu of the dashpot beta.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from springpot.rheology import (
    Continuum,
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

REVIEW = "Bonfanti, Kaplan, Charras & Kabla (2020), 10.1039/D0SM00354A"
SCHIESSEL = "Schiessel, Metzler, Blumen & Nonnenmacher (1995), 10.1088/0305-4470/28/23/012"


def _pot(number: int, exponent: str) -> Node:
    return springpot(f"c{number}", exponent)


MODELS = (
    Model(
        "fractional-maxwell-dashpot",
        series(dashpot("c1"), _pot(2, "alpha")),
        "dashpot in series with springpot (pyRheo calls it liquid, RheoJAX gel)",
        REVIEW,
        aliases=("fractd-maxwell",),
    ),
    Model(
        "fractional-maxwell-general",
        series(_pot(1, "alpha"), _pot(2, "beta")),
        "two springpots in series; swapping them changes nothing",
        SCHIESSEL,
        aliases=("fract-maxwell", "fractional-maxwell4"),
    ),
    Model(
        "fractional-kelvin-dashpot",
        parallel(dashpot("c1"), _pot(2, "alpha")),
        "dashpot beside springpot",
        REVIEW,
        aliases=("fractd-kelvinvoigt", "fractional-kelvin-voigt-d"),
    ),
    Model(
        "fractional-kelvin-general",
        parallel(_pot(1, "alpha"), _pot(2, "beta")),
        "two springpots side by side; swapping them changes nothing",
        SCHIESSEL,
        aliases=("fract-kelvinvoigt", "fractional-kelvin-voigt4"),
    ),
    Model(
        "fractional-solid",
        parallel(spring("k"), series(dashpot("c1"), _pot(2, "alpha"))),
        "spring beside a dashpot in series with a springpot: a solid that flows a little first",
        REVIEW,
        aliases=("fractsolid", "fractional-zener-liquid-s"),
    ),
    Model(
        "fractional-jeffreys",
        parallel(dashpot("c1"), series(dashpot("c2"), _pot(3, "alpha"))),
        "dashpot beside a dashpot in series with a springpot",
        REVIEW,
        aliases=("fractjeffreys-zener", "fractional-zener-liquid-d"),
    ),
    Model(
        "fractional-jeffreys-kelvin",
        series(dashpot("c1"), parallel(dashpot("c2"), _pot(3, "alpha"))),
        "dashpot in series with a dashpot beside a springpot",
        REVIEW,
        aliases=("fractjeffreys-pt",),
    ),
    Model(
        "fractional-zener5",
        parallel(spring("k"), series(_pot(1, "alpha"), _pot(2, "beta"))),
        "spring beside two springpots in series: Pritz's five-parameter solid",
        "Pritz (2003), 10.1016/S0022-460X(02)01530-4",
        aliases=("pritz", "fractional-zener-s"),
    ),
    Model(
        "fractional-zener-general",
        parallel(_pot(1, "alpha"), series(_pot(2, "beta"), _pot(3, "gamma"))),
        "springpot beside two springpots in series: six parameters",
        SCHIESSEL,
        aliases=("fract-zener", "fractional-zener6"),
    ),
    Model(
        "fractional-poynting-thomson-general",
        series(_pot(1, "alpha"), parallel(_pot(2, "beta"), _pot(3, "gamma"))),
        "springpot in series with two springpots side by side: six parameters",
        SCHIESSEL,
        aliases=("fract-pt", "fractional-poynting-thomson6"),
    ),
    Model(
        "fractional-burgers",
        series(spring("k1"), _pot(1, "alpha"), parallel(spring("k2"), _pot(2, "beta"))),
        "fractional Maxwell element in series with a fractional Kelvin element",
        REVIEW,
    ),
)


PASSIVE = (
    Model(
        "material",
        Continuum(),
        "any linear passive material: a spectrum of relaxation times, the least error that any"
        " model reaches",
        "Ferry, Viscoelastic Properties of Polymers (1980), ch. 3",
        aliases=("any-material", "free-spectrum"),
    ),
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

ASPHALT = (
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
