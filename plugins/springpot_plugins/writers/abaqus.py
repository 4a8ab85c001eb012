"""Abaqus: one material for time (a Prony series), one for steady-state dynamics (the model itself).

FREQUENCY and TIME exclude one another in a material of Abaqus, so that there are two. That of frequencies is a table
of the model's own K, or where K is a spring beside a springpot, the power law that Abaqus has built in (User's Guide
22.7.2): G' = G_inf (1 - w Im g*), G'' = G_inf w Re g*, and g* = g1* f^-a in FORMULA, f in cycles a unit of time.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from springpot.rheology import Real
from springpot.solvers import Handoff, Writer

from .frequencies import frequencies

PER_DECADE = 20
"""Frequencies a decade of the table: straight lines between them are within 0.05 % of a power law."""
STRAIGHT = 1e-9
"""Scatter of a slope that is one: what is left of the digits of K after two differences."""
NEXT_TO_NOTHING = 1e-5
"""Share of the least storage modulus that is given to a springpot alone as the spring that Abaqus needs: below what
any test shows."""


class PowerLaw(NamedTuple):
    """K = spring + size (i w)^order."""

    spring: float
    size: float
    order: float


def to_abaqus(handoff: Handoff) -> str:
    """Both materials.

    The bulk modulus is taken to relax in proportion (k_i = g_i), so that Poisson's ratio stays constant: then the
    series may stand for a tensile modulus as well as for a shear modulus.
    """
    lines = [f"** {line}" for line in handoff.heading()]
    lines.append("** the modulus is taken as Young's, with a constant Poisson's ratio (k_i = g_i)")
    return "\n".join(lines + _in_time(handoff) + _at_frequencies(handoff)) + "\n"


def _in_time(handoff: Handoff) -> list[str]:
    prony = handoff.prony
    lines = [
        "** for analyses in time; moduli are instantaneous",
        f"*MATERIAL, NAME={handoff.name.upper()}",
        "*ELASTIC, MODULI=INSTANTANEOUS",
        f"{prony.instantaneous:.9g}, {handoff.poisson:.6g}",
        "*VISCOELASTIC, TIME=PRONY",
    ]
    for weight, time in zip(prony.weights, prony.times, strict=True):
        share = weight / prony.instantaneous
        lines.append(f"{share:.9g}, {share:.9g}, {time:.9g}")
    return lines


def _at_frequencies(handoff: Handoff) -> list[str]:
    omega = frequencies(handoff, PER_DECADE)
    law = power_law_of(omega, handoff)
    spring = handoff.prony.equilibrium
    if law is not None:
        spring = law.spring
    lines = [
        "** for direct steady-state dynamics; moduli are long-term",
        f"*MATERIAL, NAME={handoff.name.upper()}_FREQUENCY",
        "*ELASTIC, MODULI=LONG TERM",
        f"{spring:.9g}, {handoff.poisson:.6g}",
    ]
    if law is not None:
        turned = law.size * (2.0 * np.pi) ** (law.order - 1.0) / law.spring * np.exp(0.5j * np.pi * (1.0 - law.order))
        g = f"{turned.real:.9g}, {-turned.imag:.9g}, {1.0 - law.order:.9g}"
        return [*lines, "*VISCOELASTIC, FREQUENCY=FORMULA", f"{g}, {g}"]
    relative = handoff.stiffness(omega) / spring
    lines.append("*VISCOELASTIC, FREQUENCY=TABULAR")
    for f, real, imaginary in zip(omega / (2.0 * np.pi), relative.real, relative.imag, strict=True):
        # The real part of g* is what the loss is over the spring, the imaginary part what the storage lacks of it.
        g = f"{imaginary:.9g}, {1.0 - real:.9g}"
        lines.append(f"{g}, {g}, {f:.9g}")
    return lines


def power_law_of(omega: Real, handoff: Handoff) -> PowerLaw | None:
    """The spring and the springpot that a model consists of, told from its K; None where there is more to it."""
    if handoff.exact is None:
        return None
    k = handoff.stiffness(omega)
    # A spring alone, or one that an effect turns active: there is no logarithm of its loss.
    if np.any(k.imag <= 0.0):
        return None
    slopes = np.diff(np.log(k.imag)) / np.diff(np.log(omega))
    order = float(slopes.mean())
    if not 0.0 < order < 1.0 or np.ptp(slopes) > STRAIGHT:
        return None
    # (i w)^order has the loss sin(order pi / 2) and the storage cos(order pi / 2): what is left of it is the spring.
    size = float(k.imag[0] / omega[0] ** order / np.sin(0.5 * np.pi * order))
    spring = k.real - size * omega**order * np.cos(0.5 * np.pi * order)
    if np.ptp(spring) > STRAIGHT * k.real.max():
        return None
    least = NEXT_TO_NOTHING * float(k.real.min())
    return PowerLaw(max(float(spring.mean()), least), size, order)


WRITER = Writer(
    "abaqus",
    to_abaqus,
    "Abaqus: *VISCOELASTIC in time (PRONY) and at frequencies (a table, or the power law of a springpot)",
    ".inp",
    solid=True,
    dashpot=False,
)
