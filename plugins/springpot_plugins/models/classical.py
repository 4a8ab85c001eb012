"""The classical models: springs and dashpots."""

from __future__ import annotations

from springpot.rheology import Model, dashpot, parallel, series, spring

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
