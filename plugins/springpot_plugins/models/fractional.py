"""The fractional family that RHEOS.jl and pyRheo share.

Springpots where the classical models have dashpots.

Aliases are the names those tools use, in lower case. ``fractional-maxwell-gel`` and ``-liquid`` are
no aliases: pyRheo and RheoJAX give the two names to each other's networks.

And any linear passive material: the model of all networks of springs, dashpots and springpots.
"""

from __future__ import annotations

from springpot.rheology import Continuum, Model, Node, dashpot, parallel, series, spring, springpot

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
