"""LS-DYNA: *MAT_GENERAL_VISCOELASTIC (076), whose terms are G, beta = 1/tau and the same for the bulk modulus."""

from __future__ import annotations

import re

from springpot.errors import ModelError
from springpot.solvers import Handoff, Writer

WIDTH = 10
"""Of a field of a fixed card; numbers take one sign less, so that they stand apart."""
MOST = 18
"""Terms that the card holds (LS-DYNA keyword manual, volume II, *MAT_076); the long-term modulus takes one."""


def field(number: float) -> str:
    """A number in nine signs, with as many digits as they hold."""
    for digits in range(8, 1, -1):
        # Leading zeros of the exponent take the room of digits.
        text = re.sub(r"e([-+])0*", r"e\1", f"{number:.{digits}g}").replace("e+", "e")
        if len(text) < WIDTH:
            return text.rjust(WIDTH)
    return f"{number:.1g}".rjust(WIDTH)


def to_lsdyna(handoff: Handoff) -> str:
    """A keyword card; the modulus is taken as Young's, with a constant Poisson's ratio.

    Raises
    ------
    ModelError
        If there are more terms than the card holds.
    """
    prony = handoff.prony
    if len(prony.times) + 1 > MOST:
        raise ModelError(
            f"ls-dyna takes {MOST - 1} terms beside the long-term modulus, not {len(prony.times)}: "
            "widen the tolerance, narrow the band or give --terms"
        )
    poisson = float(handoff.poisson or 0.0)
    # The card takes shear and bulk moduli: G = E / (2 (1 + nu)), K = E / (3 (1 - 2 nu)).
    shear, bulk = 0.5 / (1.0 + poisson), 1.0 / (3.0 * (1.0 - 2.0 * poisson))
    lines = ["*KEYWORD", *(f"$ {line}" for line in handoff.heading())]
    lines += [
        "$ the modulus is taken as Young's, with a constant Poisson's ratio; the term without decay is the long-term",
        "$ define the density RO by *PARAMETER: the card needs one, and no test of stiffness tells it",
        "*MAT_GENERAL_VISCOELASTIC_TITLE",
        handoff.name,
        "$#     mid        ro      bulk       pcf        ef      tref         a         b",
        f"{1:>{WIDTH}}{'&RO':>{WIDTH}}{field(prony.instantaneous * bulk)}",
        "$#    lcid        nt    bstart     tramp     lcidk       ntk   bstartk    trampk",
        "",
        "$#      gi     betai        ki    betaki",
    ]
    terms = [(prony.equilibrium, 0.0), *zip(prony.weights, 1.0 / prony.times, strict=True)]
    for weight, rate in terms:
        lines.append(field(weight * shear) + field(rate) + field(weight * bulk) + field(rate))
    return "\n".join([*lines, "*END"]) + "\n"


WRITER = Writer(
    "ls-dyna",
    to_lsdyna,
    "LS-DYNA: *MAT_GENERAL_VISCOELASTIC",
    ".k",
    solid=True,
    dashpot=False,
    aliases=("lsdyna",),
)
