"""ANSYS Mechanical APDL: MP and TB,PRONY, whose elastic constants are those of fast loading."""

from __future__ import annotations

from springpot.solvers import Handoff, Writer

PER_LINE = 3
"""Constants that one TBDATA line may hold, kept at three for readers of older releases (it takes six)."""


def to_ansys(handoff: Handoff) -> str:
    """Relative moduli and times in turn, for shear and in the same way for volume."""
    prony = handoff.prony
    lines = [f"! {line}" for line in handoff.heading()]
    lines += [
        "! moduli are instantaneous; the modulus is taken as Young's, with a constant Poisson's ratio",
        f"MP,EX,1,{prony.instantaneous:.9g}",
        f"MP,PRXY,1,{handoff.poisson:.6g}",
    ]
    pairs = zip(prony.weights / prony.instantaneous, prony.times, strict=True)
    constants = [number for pair in pairs for number in pair]
    # The same series for both is what keeps Poisson's ratio constant.
    for kind in ("SHEAR", "BULK"):
        lines.append(f"TB,PRONY,1,1,{len(prony.times)},{kind}")
        for start in range(0, len(constants), PER_LINE):
            part = ",".join(f"{number:.9g}" for number in constants[start : start + PER_LINE])
            lines.append(f"TBDATA,{start + 1},{part}")
    return "\n".join(lines) + "\n"


WRITER = Writer("ansys", to_ansys, "ANSYS Mechanical APDL: TB,PRONY", ".mac", solid=True, dashpot=False)
