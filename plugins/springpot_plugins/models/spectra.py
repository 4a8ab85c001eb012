"""Families with any number of relaxation or retardation times."""

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

from .classical import TSCHOEGL


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
