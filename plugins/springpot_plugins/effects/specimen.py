"""Effects of the specimen: of its temperature, and of its own mass.

Those of temperature need a column of temperatures.
"""

from __future__ import annotations

from springpot.rheology import (
    Effect,
    Layer,
    activation_energy,
    arrhenius,
    chain,
    fixed_side_wave,
    free_factors,
    free_vertical_factors,
    mass,
    moving_side_wave,
    parallel,
    shift,
    springpot,
    steady_dashpot,
    stiffness,
    temperature_power,
    viscosity,
    wlf,
)

FERRY = "Ferry, Viscoelastic Properties of Polymers, 1980"

_OF_TEMPERATURE = (
    Effect(
        "arrhenius-shift",
        shift,
        arrhenius("Ea"),
        "the material relaxes faster when hot: all times follow one activation energy",
        Layer.TEMPERATURE,
        FERRY,
        ("arrhenius",),
        equation="K(omega * exp(Ea / R * (1 / T - 1 / Tr)))",
    ),
    Effect(
        "wlf-shift",
        shift,
        wlf("C1", "C2"),
        "the material relaxes faster when hot: all times follow the free volume above the glass"
        " transition",
        Layer.TEMPERATURE,
        "Williams, Landel and Ferry 1955, doi:10.1021/ja01619a008",
        ("wlf", "vft", "vogel-fulcher-tammann"),
        equation="K(omega * 10^(-C1 * (T - Tr) / (C2 + T - Tr)))",
    ),
    Effect(
        "vertical-shift",
        chain,
        temperature_power("n"),
        "all moduli change with a power of the absolute temperature, the same at all frequencies",
        Layer.TEMPERATURE,
        FERRY,
        equation="K * (T / Tr)^n",
    ),
    Effect.from_formula(
        "entropic-spring",
        "parallel: k * T / Tr",
        "a rubber network beside the model, stiffer in proportion to the absolute temperature",
        (stiffness(),),
        "entropic spring",
        citation="Treloar, The Physics of Rubber Elasticity, 1975",
        prior=0.3,
    ),
    Effect.from_formula(
        "arrhenius-dashpot",
        "parallel: c * s * exp(Ea / R * (1 / T - 1 / Tr))",
        "a viscous branch with an activation energy of its own: sweeps at different temperatures do"
        " not superpose",
        (viscosity(), activation_energy(typical=20.0)),
        "dashpot",
        layer=Layer.SPECIMEN,
        citation="van Gurp and Palmen 1998, Rheol. Bull. 67, 5",
        aliases=("second-activation",),
        prior=0.3,
    ),
    Effect.from_formula(
        "arrhenius-springpot",
        "parallel: c * s^alpha * exp(alpha * Ea / R * (1 / T - 1 / Tr))",
        "a branch of many relaxation times with an activation energy of its own: sweeps at"
        " different temperatures do not superpose",
        (*springpot().parameters, activation_energy(typical=20.0)),
        "springpot",
        layer=Layer.SPECIMEN,
        citation="van Gurp and Palmen 1998, Rheol. Bull. 67, 5",
        prior=0.3,
    ),
    Effect(
        "rig-drag",
        parallel,
        steady_dashpot("c"),
        "viscous drag of the rig, which the specimen's temperature does not change",
        Layer.DEVICE,
        FERRY,
        prior=0.3,
        equation="K + c * s",
    ),
    Effect(
        "free-shift",
        shift,
        free_factors(),
        "all times change by one factor for each temperature (or level of another column), without"
        " a law",
        Layer.TEMPERATURE,
        FERRY,
        ("shift-factors",),
        # A factor, which changes nothing where it is one.
        absent_at=1.0,
        equation="K(omega * a)",
    ),
    Effect(
        "free-vertical-shift",
        chain,
        free_vertical_factors(),
        "all moduli change by one factor for each temperature (or level of another column), without"
        " a law",
        Layer.TEMPERATURE,
        FERRY,
        ("vertical-factors",),
        absent_at=1.0,
        equation="K * b",
    ),
)


SCHRAG = "Schrag 1977, Trans. Soc. Rheol. 21, 399"
HEAVIEST = 100.0
"""Density times thickness squared, in kg/m, that no specimen of a modulus exceeds.

0.2 m of a filled solid of
2500 kg/m^3. A plate 1 mm thick has 0.001, a block of rubber of 20 mm has 0.5."""

_OF_MASS = (
    Effect(
        "specimen-inertia",
        moving_side_wave,
        mass("m"),
        "a shear wave in the specimen, force taken where it is moved: storage falls as omega"
        " squared, then ripples",
        Layer.SPECIMEN,
        SCHRAG,
        equation="K * z / tan(z), z = omega * sqrt(m / K)",
        prior=0.8,
        largest_of_modulus=HEAVIEST,
    ),
    Effect(
        "specimen-inertia-fixed",
        fixed_side_wave,
        mass("m"),
        "a shear wave in the specimen, force taken at its fixed end: storage grows with omega"
        " squared, then ripples",
        Layer.SPECIMEN,
        SCHRAG,
        prior=0.3,
        equation="K * z / sin(z), z = omega * sqrt(m / K)",
        largest_of_modulus=HEAVIEST,
    ),
)

EFFECTS = (*_OF_TEMPERATURE, *_OF_MASS)
