"""ANSYS Mechanical APDL: MP and TB,PRONY, whose elastic constants are those of fast loading."""

from __future__ import annotations

from springpot.solvers import Handoff, Writer

PER_LINE = 3
"""Constants of a TBDATA line, kept at three for readers of older releases (it takes six)."""


def to_ansys(handoff: Handoff) -> str:
    """Relative moduli and times in turn, for shear, and for volume if the bulk modulus relaxes."""
    solid, number = handoff.solid, handoff.number
    lines = [f"! {line}" for line in (*handoff.heading(), solid.says)]
    lines += [
        "! moduli are instantaneous",
        f"MP,EX,{number},{solid.young:.9g}",
        f"MP,PRXY,{number},{solid.poisson:.9g}",
    ]
    for kind, series in (("SHEAR", solid.shear), ("BULK", solid.bulk)):
        pairs = zip(series.weights / series.instantaneous, series.times, strict=True)
        constants = [number for pair in pairs for number in pair]
        if constants:
            lines.append(f"TB,PRONY,{number},1,{len(series.times)},{kind}")
        for start in range(0, len(constants), PER_LINE):
            part = ",".join(f"{each:.9g}" for each in constants[start : start + PER_LINE])
            lines.append(f"TBDATA,{start + 1},{part}")
    if handoff.shift is not None:
        # Its sign differs from manual to manual, and a wrong one would be slow where it is fast.
        lines.append(
            f"! TB,SHIFT,{number} is left to you (unchecked here): the law is in the lines above"
        )
    return "\n".join(lines) + "\n"


WRITER = Writer(
    "ansys",
    to_ansys,
    "ANSYS Mechanical APDL: TB,PRONY",
    ".mac",
    solid=True,
    dashpot=False,
    several="".join,
)
