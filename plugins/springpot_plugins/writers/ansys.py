"""ANSYS Mechanical APDL: MP and TB,PRONY, whose elastic constants are those of fast loading."""

from __future__ import annotations

from springpot.solvers import Handoff, Writer

PER_LINE = 3
"""Constants of a TBDATA line, kept at three for readers of older releases (it takes six)."""


def to_ansys(handoff: Handoff) -> str:
    """Relative moduli and times in turn, for shear, and for volume if the bulk modulus relaxes."""
    solid = handoff.solid
    lines = [f"! {line}" for line in (*handoff.heading(), solid.says)]
    lines += [
        "! moduli are instantaneous",
        f"MP,EX,1,{solid.young:.9g}",
        f"MP,PRXY,1,{solid.poisson:.9g}",
    ]
    for kind, series in (("SHEAR", solid.shear), ("BULK", solid.bulk)):
        pairs = zip(series.weights / series.instantaneous, series.times, strict=True)
        constants = [number for pair in pairs for number in pair]
        if constants:
            lines.append(f"TB,PRONY,1,1,{len(series.times)},{kind}")
        for start in range(0, len(constants), PER_LINE):
            part = ",".join(f"{number:.9g}" for number in constants[start : start + PER_LINE])
            lines.append(f"TBDATA,{start + 1},{part}")
    return "\n".join(lines) + "\n"


WRITER = Writer(
    "ansys", to_ansys, "ANSYS Mechanical APDL: TB,PRONY", ".mac", solid=True, dashpot=False
)
