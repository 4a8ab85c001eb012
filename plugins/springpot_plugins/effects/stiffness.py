"""Effects in parallel: their stiffness adds to that of the model."""

from __future__ import annotations

from springpot.measurement import Measurement, TimeTest
from springpot.rheology import (
    STIFFNESS,
    AppliesTo,
    Effect,
    InstrumentConstant,
    Layer,
    Parameter,
    basset,
    dashpot,
    mass,
    parallel,
    relaxation_time,
    spring,
    springpot,
    stiffness,
)


def _moves_as_known(test: Measurement | TimeTest) -> bool:
    """Whether there is a motion that a fluid could follow: a step of displacement has none."""
    return isinstance(test, Measurement) or test.kind != "relaxation"


EFFECTS = (
    Effect(
        "parallel-spring",
        parallel,
        spring("k"),
        "a spring beside the model carries a share of the force that is the same at all"
        " frequencies",
        citation="Ferry, Viscoelastic Properties of Polymers, 1980",
        aliases=("equilibrium-spring", "bearing-spring", "gas-spring"),
        equation="K + k",
    ),
    Effect(
        "parallel-dashpot",
        parallel,
        dashpot("c"),
        "viscous drag beside the model adds a loss that grows as omega and moves with the"
        " material's temperature",
        citation="Ferry, Viscoelastic Properties of Polymers, 1980",
        aliases=("solvent-dashpot", "bearing-drag"),
        equation="K + c * s",
        constant=InstrumentConstant(
            "friction as viscosity", "c", "a bearing friction that is a viscosity of {stated}"
        ),
    ),
    Effect(
        "parallel-springpot",
        parallel,
        springpot("c", "alpha"),
        "a further broad relaxation beside the model: storage and loss grow as the same power of"
        " omega",
        citation="Schiessel et al. 1995, doi:10.1088/0305-4470/28/23/012",
        equation="K + c * s^alpha",
    ),
    Effect.from_formula(
        "relaxation-mode",
        "parallel: k * s * tau / (1 + s * tau)",
        "one more relaxation time: a step in storage and a bump in loss at omega = 1/tau",
        (stiffness(), relaxation_time()),
        "maxwell",
        citation="Ferry, Viscoelastic Properties of Polymers, 1980",
        aliases=("maxwell-branch",),
    ),
    Effect.from_formula(
        "diffusion",
        "parallel: k * (1 - tanh(sqrt(s * tau)) / sqrt(s * tau))",
        "fluid that seeps through the specimen stiffens it above omega = 1/tau: a step that levels"
        " off as omega^-1/2",
        (stiffness(), relaxation_time()),
        "diffusion",
        citation="Biot 1941, doi:10.1063/1.1712886",
        aliases=("poroelastic",),
        prior=0.3,
    ),
    Effect.from_formula(
        "hysteretic-loss",
        "parallel: i * h",
        "a loss that depends neither on frequency nor on amplitude",
        (Parameter("h", "h", STIFFNESS),),
        "hysteretic",
        citation="Crandall 1970, J. Sound Vib. 11, 3",
        aliases=("structural-damping",),
    ),
    Effect(
        "inertia",
        parallel,
        mass("m"),
        "a moving mass takes force in phase with acceleration: storage falls as omega squared, loss"
        " is untouched",
        Layer.MOVING_PARTS,
        "Krieger 1990, J. Rheol. 34, 471",
        ("fixture-mass", "inerter", "instrument-inertia"),
        equation="K - m * omega^2",
        constant=InstrumentConstant(
            "inertia as modulus",
            "m",
            "a moment of inertia that takes {stated} omega^2 from the modulus",
        ),
    ),
    Effect(
        "basset",
        parallel,
        basset("c"),
        "fluid set in motion around a moving surface adds a force at 135 degrees that grows as"
        " omega^(3/2)",
        Layer.MOVING_PARTS,
        "Basset 1888, A Treatise on Hydrodynamics; Landau and Lifshitz, Fluid Mechanics,"
        " section 24",
        ("stokes-layer",),
        prior=0.3,
        equation="K + c * s^(3 / 2)",
        applies_to=AppliesTo(suits=_moves_as_known),
    ),
)
