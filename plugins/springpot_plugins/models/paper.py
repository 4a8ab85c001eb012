"""The models of the paper.

Springpot, fractional Kelvin and Maxwell, and the two four-parameter types.
"""

from __future__ import annotations

from springpot.rheology import (
    KELVIN_FORM,
    MAXWELL_FORM,
    TIME_FORM,
    Model,
    parallel,
    series,
    spring,
    springpot,
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
