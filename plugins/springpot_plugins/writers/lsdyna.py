"""LS-DYNA: *MAT_GENERAL_VISCOELASTIC (076), with terms G and beta = 1/tau, for the bulk too."""

from __future__ import annotations

import re

from springpot.errors import ModelError
from springpot.solvers import Handoff, Writer

WIDTH = 10
"""Of a field of a fixed card; numbers take one sign less, so that they stand apart."""
MOST = 18
"""Terms that the card holds (LS-DYNA keyword manual, volume II, *MAT_076).

The long-term modulus takes one.
"""


def field(number: float) -> str:
    """A number in nine signs, with as many digits as they hold."""
    for digits in range(8, 1, -1):
        # Leading zeros of the exponent take the room of digits.
        text = re.sub(r"e([-+])0*", r"e\1", f"{number:.{digits}g}").replace("e+", "e")
        if len(text) < WIDTH:
            return text.rjust(WIDTH)
    return f"{number:.1g}".rjust(WIDTH)


def to_lsdyna(handoff: Handoff) -> str:
    """A keyword card of shear and bulk modulus.

    Raises
    ------
    ModelError
        If there are more terms than the card holds.
    """
    solid = handoff.solid
    shear, bulk = solid.shear, solid.bulk
    if len(shear.times) + 1 > MOST:
        raise ModelError(
            f"ls-dyna takes {MOST - 1} terms beside the long-term modulus, not {len(shear.times)}: "
            "widen the tolerance, narrow the band or give --terms"
        )
    lines = ["*KEYWORD", *(f"$ {line}" for line in (*handoff.heading(), solid.says))]
    lines += [
        "$ the card takes shear and bulk moduli; the term without decay is the long-term",
        (
            "$ define the density RO by *PARAMETER: the card needs one, and no test of stiffness"
            " tells it"
        ),
        *_of_shift(handoff),
        "*MAT_GENERAL_VISCOELASTIC_TITLE",
        handoff.name,
        "$#     mid        ro      bulk       pcf        ef      tref         a         b",
        f"{handoff.number:>{WIDTH}}{'&RO':>{WIDTH}}{field(bulk.instantaneous)}",
        "$#    lcid        nt    bstart     tramp     lcidk       ntk   bstartk    trampk",
        "",
        "$#      gi     betai        ki    betaki",
    ]
    terms = [(shear.equilibrium, 0.0), *zip(shear.weights, 1.0 / shear.times, strict=True)]
    volume = [bulk.equilibrium, *bulk.weights]
    for i, (weight, rate) in enumerate(terms):
        line = field(weight) + field(rate)
        # A constant bulk modulus is that of the first card alone.
        if not solid.constant:
            line += field(volume[i]) + field(rate)
        lines.append(line)
    return "\n".join([*lines, "*END"]) + "\n"


def _of_shift(handoff: Handoff) -> list[str]:
    """That the law of temperature is left out, where there is one."""
    if handoff.shift is None:
        return []
    # Its sign differs from source to source, and a wrong one would be slow where it is fast.
    return ["$ TREF, A and B are left to you (unchecked here): the law is in the lines above"]


def _several(texts: list[str]) -> str:
    """One file of many materials."""
    bodies = [text.removeprefix("*KEYWORD\n").removesuffix("*END\n") for text in texts]
    return "".join(["*KEYWORD\n", *bodies, "*END\n"])


WRITER = Writer(
    "ls-dyna",
    to_lsdyna,
    "LS-DYNA: *MAT_GENERAL_VISCOELASTIC",
    ".k",
    solid=True,
    dashpot=False,
    aliases=("lsdyna",),
    several=_several,
)
