"""Abaqus: a material with *VISCOELASTIC, TIME=PRONY, whose elastic constants are the instantaneous ones."""

from __future__ import annotations

from springpot.rheology import Handoff, Writer


def to_abaqus(handoff: Handoff) -> str:
    """Lines g_i, k_i, tau_i relative to the instantaneous modulus.

    The bulk modulus is taken to relax in proportion (k_i = g_i), so that Poisson's ratio stays constant: then the
    series may stand for a tensile modulus as well as for a shear modulus.
    """
    prony = handoff.prony
    lines = [f"** {line}" for line in handoff.heading()]
    lines += [
        "** moduli are instantaneous; the modulus is taken as Young's, with a constant Poisson's ratio (k_i = g_i)",
        f"*MATERIAL, NAME={handoff.name.upper()}",
        "*ELASTIC, MODULI=INSTANTANEOUS",
        f"{prony.instantaneous:.9g}, {handoff.poisson:.6g}",
        "*VISCOELASTIC, TIME=PRONY",
    ]
    for weight, time in zip(prony.weights, prony.times, strict=True):
        share = weight / prony.instantaneous
        lines.append(f"{share:.9g}, {share:.9g}, {time:.9g}")
    return "\n".join(lines) + "\n"


WRITER = Writer(
    "abaqus", to_abaqus, "Abaqus: *ELASTIC and *VISCOELASTIC, TIME=PRONY", ".inp", solid=True, dashpot=False
)
