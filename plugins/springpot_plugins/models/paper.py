"""The models of the paper.

Springpot, fractional Kelvin and Maxwell, and the two four-parameter types; and the fluid forms
whose published parameters are not those of the elements. Their thermodynamic conditions tie two
parameters together (alpha <= beta, kinf > k0). The model's own parameters therefore hold a ratio or
a difference, so that their bounds alone keep every result lawful; the published ones are the search
form.
"""

from __future__ import annotations

import numpy as np

from springpot.rheology import (
    KELVIN_FORM,
    MAXWELL_FORM,
    TIME_FORM,
    Dimension,
    Mapped,
    Model,
    Node,
    Parameter,
    Real,
    SearchForm,
    columns,
    limits_form,
    order,
    parallel,
    quasi_property,
    relaxation_time,
    rows,
    series,
    spring,
    springpot,
    stiffness,
)

MODELS = (
    Model(
        "springpot",
        springpot(),
        "a single springpot: loss factor independent of frequency",
        "eq. (1), (25), (26)",
        aliases=("scott-blair",),
    ),
    Model(
        "fractional-kelvin",
        parallel(spring("k"), springpot()),
        "spring beside springpot: a solid",
        "eq. (20), (22), (33)",
        aliases=("fracts-kelvinvoigt", "fractional-kelvin-voigt", "fractional-kelvin-voigt-s"),
        search=TIME_FORM,
    ),
    Model(
        "fractional-maxwell",
        series(spring("k"), springpot()),
        "spring in series with springpot: a fluid damper (pyRheo calls it gel, RheoJAX liquid)",
        "eq. (21), (23), (24), (29), (30)",
        aliases=("fracts-maxwell",),
        search=TIME_FORM,
    ),
    Model(
        "fractional-kelvin4",
        series(spring("k1"), parallel(spring("k2"), springpot())),
        "spring in series with a fractional Kelvin element: the Kelvin type, or standard model of"
        " fluids",
        "eq. (3)-(6), (34)",
        aliases=("fractional-standard", "fractsls-pt", "fractional-poynting-thomson"),
        search=KELVIN_FORM,
    ),
    Model(
        "fractional-zener",
        parallel(spring("k1"), series(spring("k2"), springpot())),
        "spring beside a fractional Maxwell element: the Maxwell type with four parameters",
        "eq. (7)-(9), (35)",
        aliases=(
            "fractional-maxwell-type4",
            "fractional-sls",
            "fractsls-zener",
            "fractional-zener-solid-s",
        ),
        search=MAXWELL_FORM,
    ),
)


LARGEST_LOG = 600.0
"""exp(600) is 1e260, still a number; exp(710) is none."""


def _ab_forward(theta: Real) -> Real:
    k, tau, ratio, beta = np.moveaxis(theta, -1, 0)
    gap = beta * (1.0 - ratio)
    return columns(k * tau**beta, beta, k * tau**gap, gap)


def _ab_jacobian(theta: Real) -> Real:
    k, tau, ratio, beta = np.moveaxis(theta, -1, 0)
    rest = 1.0 - ratio
    gap, log_tau = beta * rest, np.log(tau)
    c1, c2 = k * tau**beta, k * tau**gap
    return rows(
        columns(tau**beta, beta * c1 / tau, 0.0, c1 * log_tau),
        columns(0.0, 0.0, 0.0, np.ones_like(k)),
        columns(tau**gap, gap * c2 / tau, -beta * c2 * log_tau, rest * c2 * log_tau),
        columns(0.0, 0.0, -beta, rest),
    )


def _unequal_orders() -> Node:
    """K = k (s tau)^beta / (1 + (s tau)^alpha), alpha = ratio beta: two springpots in series."""
    network = series(springpot("k tau^beta", "beta"), springpot("k tau^(beta-alpha)", "beta-alpha"))
    own = (stiffness(), relaxation_time(), order("ratio", "α/β"), order("beta", "β"))
    return Mapped(network, own, _ab_forward, _ab_jacobian)


def _ab_form_to_elements(x: Real) -> Real:
    k, tau, alpha, beta = np.moveaxis(x, -1, 0)
    return columns(k, tau, alpha / beta, beta)


def _ab_form_jacobian(x: Real) -> Real:
    one = np.ones_like(x[..., 0])
    alpha, beta = x[..., 2], x[..., 3]
    return rows(
        columns(one, 0.0, 0.0, 0.0),
        columns(0.0, one, 0.0, 0.0),
        columns(0.0, 0.0, 1.0 / beta, -alpha / beta**2),
        columns(0.0, 0.0, 0.0, one),
    )


def _ab_form_from_elements(theta: Real) -> Real:
    k, tau, ratio, beta = np.moveaxis(theta, -1, 0)
    return columns(k, tau, ratio * beta, beta)


def _unequal_orders_form() -> SearchForm:
    """(k, tau, alpha, beta) of eq. (27), alpha <= beta."""
    searched = (stiffness(), relaxation_time(), order(), order("beta", "β"))
    return SearchForm(
        searched,
        _ab_form_to_elements,
        _ab_form_jacobian,
        _ab_form_from_elements,
        ordered=(2, 3),
        # Equal orders are lawful: one that is violated is mended to the other.
        margin=1.0,
    )


def _makris_forward(theta: Real) -> Real:
    c0, tau, ratio, q = np.moveaxis(theta, -1, 0)
    return columns(c0, q, c0 * tau ** (-ratio * q), q * (1.0 - ratio))


def _makris_jacobian(theta: Real) -> Real:
    c0, tau, ratio, q = np.moveaxis(theta, -1, 0)
    r, log_tau = ratio * q, np.log(tau)
    c = c0 * tau**-r
    one = np.ones_like(c0)
    return rows(
        columns(one, 0.0, 0.0, 0.0),
        columns(0.0, 0.0, 0.0, one),
        columns(tau**-r, -r * c / tau, -q * c * log_tau, -ratio * c * log_tau),
        columns(0.0, 0.0, -q, 1.0 - ratio),
    )


def _makris() -> Node:
    """K = c0 s^q / (1 + (s tau)^r), r = ratio q, tau^r = lambda: two springpots in series."""
    network = series(springpot("c0", "q"), springpot("c0/lambda", "q-r"))
    own = (
        quasi_property("c0", "q", "c₀"),
        relaxation_time(),
        order("ratio", "r/q"),
        order("q", "q"),
    )
    return Mapped(network, own, _makris_forward, _makris_jacobian)


def _makris_form_log_time(lam: Real, r: Real) -> Real:
    # As r goes to 0 the time leaves the range of floating point long before K changes.
    return np.clip(np.log(lam) / r, -LARGEST_LOG, LARGEST_LOG)


def _makris_form_to_elements(x: Real) -> Real:
    lam, c0, r, q = np.moveaxis(x, -1, 0)
    return columns(c0, np.exp(_makris_form_log_time(lam, r)), r / q, q)


def _makris_form_jacobian(x: Real) -> Real:
    lam, _, r, q = np.moveaxis(x, -1, 0)
    # A time that is held at its limit does not move with lambda and r.
    tau = np.exp(_makris_form_log_time(lam, r)) * (np.abs(np.log(lam)) < LARGEST_LOG * r)
    one = np.ones_like(lam)
    return rows(
        columns(0.0, one, 0.0, 0.0),
        columns(tau / (r * lam), 0.0, -tau * np.log(lam) / r**2, 0.0),
        columns(0.0, 0.0, 1.0 / q, -r / q**2),
        columns(0.0, 0.0, 0.0, one),
    )


def _makris_form_from_elements(theta: Real) -> Real:
    c0, tau, ratio, q = np.moveaxis(theta, -1, 0)
    r = ratio * q
    return columns(tau**r, c0, r, q)


def _makris_form() -> SearchForm:
    """(lambda, c0, r, q) of eq. (54), r <= q, lambda = tau^r."""
    searched = (
        Parameter("lambda", "λ", Dimension(time="r")),
        quasi_property("c0", "q", "c₀"),
        order("r", "r"),
        order("q", "q"),
    )
    return SearchForm(
        searched,
        _makris_form_to_elements,
        _makris_form_jacobian,
        _makris_form_from_elements,
        ordered=(2, 3),
        margin=1.0,
    )


def _relaxing_springpot(k: str, tau: str) -> Node:
    """K = k (s tau)^alpha / (1 + (s tau)^alpha): spring k in series with springpot k tau^alpha."""
    network = series(spring(k), springpot(f"{k} {tau}^alpha"))
    own = (stiffness(k), relaxation_time(tau), order())
    # The parameters are those in which the three-parameter models are searched, and so are their
    # maps.
    return Mapped(network, own, TIME_FORM.to_elements, TIME_FORM.jacobian)


# A spring beside a relaxing springpot: kinf = k0 + k1 is above k0 whatever the parameters are.
_oldroyd = parallel(spring("k0"), _relaxing_springpot("k1", "tau"))

FLUIDS = (
    Model(
        "fractional-maxwell-ab",
        _unequal_orders(),
        "fractional Maxwell fluid with two orders: k (s tau)^beta / (1 + (s tau)^alpha), alpha ="
        " ratio beta <= beta",
        "eq. (27)",
        search=_unequal_orders_form(),
    ),
    Model(
        "oldroyd-b",
        _oldroyd,
        "fractional Oldroyd-B fluid of the paper: (k0 + kinf (s tau)^alpha) / (1 + (s tau)^alpha),"
        " kinf = k0 + k1",
        "eq. (28), (31), (32)",
        aliases=("fractional-oldroyd-b",),
        search=limits_form(_oldroyd.parameters),
    ),
    Model(
        "makris",
        _makris(),
        "fractional Maxwell model of viscous dampers: c0 s^q / (1 + lambda s^r), lambda = tau^r, r"
        " = ratio q <= q",
        "eq. (54); Makris & Constantinou (1991), 10.1061/(ASCE)0733-9445(1991)117:9(2708)",
        aliases=("makris-constantinou",),
        search=_makris_form(),
    ),
)
