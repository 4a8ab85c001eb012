"""The classical models: springs and dashpots.

Among them families with any number of relaxation or retardation times.
"""

from __future__ import annotations

import numpy as np

from springpot.rheology import (
    Mapped,
    Model,
    Node,
    Real,
    columns,
    dashpot,
    parallel,
    relaxation_time,
    series,
    spring,
    stiffness,
)
from springpot.rheology.model import Family

TSCHOEGL = "Tschoegl (1989), 10.1007/978-3-642-73602-5"

MODELS = (
    Model("spring", spring(), "an elastic solid", TSCHOEGL, aliases=("hooke",)),
    Model("dashpot", dashpot(), "a Newtonian fluid", TSCHOEGL, aliases=("newton",)),
    Model(
        "kelvin",
        parallel(spring(), dashpot()),
        "spring beside dashpot: a solid that creeps to its limit",
        "eq. (20) with alpha = 1; " + TSCHOEGL,
        aliases=("kelvin-voigt", "kelvinvoigt", "voigt"),
    ),
    Model(
        "maxwell",
        series(spring(), dashpot()),
        "spring in series with dashpot: a fluid with one relaxation time",
        "eq. (21) with alpha = 1; " + TSCHOEGL,
    ),
    Model(
        "zener",
        parallel(spring("k1"), series(spring("k2"), dashpot())),
        "spring beside a Maxwell element: the standard linear solid",
        "eq. (7)-(9) with alpha = 1; " + TSCHOEGL,
        aliases=("sls", "standard-linear-solid", "sls-zener"),
    ),
    Model(
        "zener-kelvin",
        series(spring("k1"), parallel(spring("k2"), dashpot())),
        "spring in series with a Kelvin element: the standard linear solid in its other form",
        "eq. (3)-(6) with alpha = 1; " + TSCHOEGL,
        aliases=("sls-pt", "poynting-thomson"),
    ),
    Model(
        "jeffreys",
        parallel(dashpot("c1"), series(spring(), dashpot("c2"))),
        "dashpot beside a Maxwell element: a polymer in a Newtonian solvent",
        TSCHOEGL,
        aliases=("jeffreys-zener",),
    ),
    Model(
        "jeffreys-kelvin",
        series(dashpot("c1"), parallel(spring(), dashpot("c2"))),
        "dashpot in series with a Kelvin element: the Jeffreys fluid in its other form",
        TSCHOEGL,
        aliases=("jeffreys-pt",),
    ),
    Model(
        "burgers",
        series(spring("k1"), dashpot("c1"), parallel(spring("k2"), dashpot("c2"))),
        "Maxwell element in series with a Kelvin element: a fluid with elastic, retarded and"
        " viscous creep",
        TSCHOEGL,
        aliases=("burgersliquid",),
    ),
    Model(
        "zener-2",
        parallel(
            spring("k0"), series(spring("k1"), dashpot("c1")), series(spring("k2"), dashpot("c2"))
        ),
        "spring beside two Maxwell elements, in springs and dashpots (prony-2 holds relaxation"
        " times)",
        TSCHOEGL,
        aliases=("sls2",),
    ),
)


def _relaxation_mode(k: str, tau: str) -> Node:
    """K = k s tau / (1 + s tau): spring in series with the dashpot k tau."""
    network = series(spring(k), dashpot(f"{k} {tau}"))
    return Mapped(network, (stiffness(k), relaxation_time(tau)), _product, _product_jacobian)


def _retardation_mode(k: str, tau: str) -> Node:
    """K = k (1 + s tau): spring beside the dashpot k tau."""
    network = parallel(spring(k), dashpot(f"{k} {tau}"))
    return Mapped(network, (stiffness(k), relaxation_time(tau)), _product, _product_jacobian)


def _product(theta: Real) -> Real:
    """Spring k and dashpot k tau of (k, tau)."""
    # The literature gives moduli and times, not viscosities.
    return columns(theta[..., 0], theta[..., 0] * theta[..., 1])


def _product_jacobian(theta: Real) -> Real:
    """Derivative of (k, k tau) by (k, tau)."""
    jacobian = np.zeros((*theta.shape, 2), theta.dtype)
    jacobian[..., 0, 0] = 1.0
    # The second row is (tau, k).
    jacobian[..., 1, :] = theta[..., ::-1]
    return jacobian


def _prony(n: int) -> Model:
    branches = [_relaxation_mode(f"k{i}", f"tau{i}") for i in range(1, n + 1)]
    return Model(
        f"prony-{n}",
        parallel(spring("k0"), *branches),
        f"spring beside {n} Maxwell elements: a solid with {n} relaxation times",
        TSCHOEGL,
        aliases=(f"wiechert-{n}",),
    )


def _maxwell(n: int) -> Model:
    branches = [_relaxation_mode(f"k{i}", f"tau{i}") for i in range(1, n + 1)]
    return Model(
        f"maxwell-{n}",
        parallel(*branches),
        f"{n} Maxwell elements side by side: a fluid with {n} relaxation times",
        TSCHOEGL,
        aliases=(f"generalised-maxwell-{n}", f"generalized-maxwell-{n}"),
    )


def _kelvin(n: int) -> Model:
    links = [_retardation_mode(f"k{i}", f"tau{i}") for i in range(1, n + 1)]
    return Model(
        f"kelvin-{n}",
        series(spring("k0"), *links),
        f"spring in series with {n} Kelvin elements: a solid with {n} retardation times",
        TSCHOEGL,
        aliases=(f"kelvin-chain-{n}",),
    )


FAMILIES = (
    Family("prony-N", _prony, "spring beside N Maxwell elements", aliases=("wiechert-N",)),
    Family(
        "maxwell-N",
        _maxwell,
        "N Maxwell elements side by side, without a spring",
        aliases=("generalised-maxwell-N", "generalized-maxwell-N"),
    ),
    Family(
        "kelvin-N", _kelvin, "spring in series with N Kelvin elements", aliases=("kelvin-chain-N",)
    ),
)
