"""Abaqus and Nastran, which take a table of K by the frequency, straight between its lines.

Abaqus: one material for time (a Prony series), one for steady-state dynamics (the model itself).
FREQUENCY and TIME exclude one another in a material of Abaqus, so that there are two. Elastic
constants are E and nu, and what relaxes is the shear modulus (g) and the bulk modulus (k). The
table of frequencies is of the model itself; where its shear modulus is a spring beside a springpot,
it is the power law that Abaqus has built in (User's Guide 22.7.2): G' = G_inf (1 - w Im g*), G'' =
G_inf w Re g*, and g* = g1* f^-a in FORMULA, f in cycles a unit of time.

Nastran: a damper as PBUSH and PBUSHT, tables of stiffness and loss factor by the frequency. For
direct frequency response (MSC and Siemens Nastran). K is K' and GE is K''/K', both against f in
cycles a unit of time, straight between their points.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from springpot.rheology import Complex, Real
from springpot.solvers import Handoff, Writer

FEWEST = 8
"""Lines of a table at least, so that one of a narrow band is no straight line either."""


def frequencies(handoff: Handoff, per_decade: int) -> Real:
    """Angular frequencies (n,) over the whole of the band, equal steps of their logarithm."""
    low, high = np.log10(handoff.prony.band)
    steps = int(np.ceil(per_decade * (high - low)))
    return np.logspace(low, high, max(FEWEST, steps + 1))


ABAQUS_PER_DECADE = 20
"""Frequencies a decade of the table: straight lines between them are within 0.05 % of a power law.
"""
STRAIGHT = 1e-9
"""Scatter of a slope that is one: what is left of the digits of K after two differences."""
NEXT_TO_NOTHING = 1e-5
"""Share of the least storage modulus that a springpot alone gets as the spring that Abaqus needs.

Below what any test shows.
"""


class PowerLaw(NamedTuple):
    """K = spring + size (i w)^order."""

    spring: float
    size: float
    order: float


def to_abaqus(handoff: Handoff) -> str:
    """Both materials; k follows g where the bulk modulus relaxes, and is zero where it does not."""
    lines = [f"** {line}" for line in (*handoff.heading(), handoff.solid.says)]
    return "\n".join(lines + _in_time(handoff) + _at_frequencies(handoff)) + "\n"


def _in_time(handoff: Handoff) -> list[str]:
    solid = handoff.solid
    lines = []
    if handoff.shift is not None and handoff.shift.kind == "arrhenius":
        lines.append("*PHYSICAL CONSTANTS, ABSOLUTE ZERO=-273.15, UNIVERSAL GAS=8.31446262")
    lines += [
        "** for analyses in time; moduli are instantaneous",
        f"*MATERIAL, NAME={_name(handoff)}",
        "*ELASTIC, MODULI=INSTANTANEOUS",
        f"{solid.young:.9g}, {solid.poisson:.9g}",
        "*VISCOELASTIC, TIME=PRONY",
    ]
    for share, time in zip(
        solid.shear.weights / solid.shear.instantaneous, solid.shear.times, strict=True
    ):
        lines.append(f"{share:.9g}, {_of_bulk(handoff, f'{share:.9g}', '0.')}, {time:.9g}")
    if handoff.shift is not None:
        numbers = (handoff.shift.reference, *handoff.shift.constants)
        lines += [
            "** temperatures in degC",
            f"*TRS, DEFINITION={handoff.shift.kind.upper()}",
            ", ".join(f"{number:.9g}" for number in numbers),
        ]
    return lines


def _name(handoff: Handoff) -> str:
    """Of the material; a further one in the file has its number."""
    number = "" if handoff.number == 1 else f"_{handoff.number}"
    return f"{handoff.name.upper()}{number}"


def _of_bulk(handoff: Handoff, as_shear: str, nothing: str) -> str:
    """The numbers of the bulk modulus: those of the shear modulus, or none where it is constant."""
    if handoff.solid.constant:
        return nothing
    return as_shear


def _at_frequencies(handoff: Handoff) -> list[str]:
    solid = handoff.solid
    omega = frequencies(handoff, ABAQUS_PER_DECADE)
    shear, spring = solid.shear_of(handoff.stiffness(omega)), solid.shear.equilibrium
    # Only of the model itself: a series is no power law.
    law = None
    if handoff.exact is not None:
        law = power_law_of(omega, shear)
    if law is not None:
        spring = law.spring
    poisson = solid.poisson_beside(spring)
    lines = [
        "** for direct steady-state dynamics; moduli are long-term",
        f"*MATERIAL, NAME={_name(handoff)}_FREQUENCY",
        "*ELASTIC, MODULI=LONG TERM",
        f"{2.0 * (1.0 + poisson) * spring:.9g}, {poisson:.9g}",
    ]
    if law is not None:
        turned = (
            law.size
            * (2.0 * np.pi) ** (law.order - 1.0)
            / law.spring
            * np.exp(0.5j * np.pi * (1.0 - law.order))
        )
        g = f"{turned.real:.9g}, {-turned.imag:.9g}, {1.0 - law.order:.9g}"
        return [
            *lines,
            "*VISCOELASTIC, FREQUENCY=FORMULA",
            f"{g}, {_of_bulk(handoff, g, '0., 0., 0.')}",
        ]
    relative = shear / spring
    lines.append("*VISCOELASTIC, FREQUENCY=TABULAR")
    for f, real, imaginary in zip(omega / (2.0 * np.pi), relative.real, relative.imag, strict=True):
        # The real part of g* is what the loss is over the spring, the imaginary part what the
        # storage lacks of it.
        g = f"{imaginary:.9g}, {1.0 - real:.9g}"
        lines.append(f"{g}, {_of_bulk(handoff, g, '0., 0.')}, {f:.9g}")
    return lines


def power_law_of(omega: Real, k: Complex) -> PowerLaw | None:
    """The spring and the springpot that a model consists of, told from its K (n,).

    None where there is more to it.
    """
    # A spring alone, or one that an effect turns active: there is no logarithm of its loss.
    if np.any(k.imag <= 0.0):
        return None
    slopes = np.diff(np.log(k.imag)) / np.diff(np.log(omega))
    order = float(slopes.mean())
    if not 0.0 < order < 1.0 or np.ptp(slopes) > STRAIGHT:
        return None
    # (i w)^order has the loss sin(order pi / 2) and the storage cos(order pi / 2): what is left of
    # it is the spring.
    size = float(k.imag[0] / omega[0] ** order / np.sin(0.5 * np.pi * order))
    spring = k.real - size * omega**order * np.cos(0.5 * np.pi * order)
    if np.ptp(spring) > STRAIGHT * k.real.max():
        return None
    least = NEXT_TO_NOTHING * float(k.real.min())
    return PowerLaw(max(float(spring.mean()), least), size, order)


ABAQUS = Writer(
    "abaqus",
    to_abaqus,
    "Abaqus: *VISCOELASTIC in time (PRONY) and at frequencies (a table, or the power law of a"
    " springpot)",
    ".inp",
    solid=True,
    dashpot=False,
    several="".join,
)


class Card(NamedTuple):
    """Of a material of Nastran: its numbers, and the fields of its tables."""

    property: int
    stiffness_table: int
    loss_table: int
    per_material: int
    """Numbers of the property and of both tables."""
    per_decade: int
    """Points a decade: straight lines between them are within 0.02 % of a power law."""
    pairs: int
    """Pairs of numbers on a line of TABLED1."""
    width: int
    """Signs of a field."""


CARD = Card(
    property=100,
    stiffness_table=101,
    loss_table=102,
    per_material=3,
    per_decade=32,
    pairs=4,
    width=8,
)


def field(number: float) -> str:
    """A real number in eight signs, with the point that Nastran asks for."""
    for digits in range(7, 0, -1):
        text = f"{number:.{digits}g}"
        if "e" in text:
            # 1.5e-05 as 1.5-5: the sign tells where the exponent begins, and saves two signs.
            mantissa, exponent = text.split("e")
            text = f"{_with_point(mantissa)}{int(exponent):+d}"
        text = _with_point(text)
        if text.startswith("0.") and len(text) > CARD.width:
            text = text.removeprefix("0")
        if len(text) <= CARD.width:
            return text
    return f"{number:.1e}"


def _with_point(text: str) -> str:
    """A number that Nastran does not take for a whole one."""
    if "." in text:
        return text
    return text + "."


def _table(number: int, x: list[float], y: list[float]) -> list[str]:
    lines = [f"TABLED1,{number}"]
    pairs = [f"{field(a)},{field(b)}" for a, b in zip(x, y, strict=True)] + ["ENDT"]
    lines += ["," + ",".join(pairs[i : i + CARD.pairs]) for i in range(0, len(pairs), CARD.pairs)]
    return lines


def to_nastran(handoff: Handoff) -> str:
    """Property and tables, for a bush along the first axis of its element."""
    omega = frequencies(handoff, CARD.per_decade)
    stiffness = handoff.stiffness(omega)
    frequency = (omega / (2.0 * np.pi)).tolist()
    own, stiff, loss = (
        tag + CARD.per_material * (handoff.number - 1)
        for tag in (CARD.property, CARD.stiffness_table, CARD.loss_table)
    )
    lines = [f"$ {line}" for line in handoff.heading()]
    lines += [
        "$ K is the storage stiffness, GE the loss factor K''/K', against f in Hz",
        f"PBUSH,{own},K,{field(float(stiffness.real[0]))}",
        f"PBUSHT,{own},K,{stiff}",
        f",,GE,{loss}",
        *_table(stiff, frequency, stiffness.real.tolist()),
        *_table(loss, frequency, (stiffness.imag / stiffness.real).tolist()),
    ]
    return "\n".join(lines) + "\n"


NASTRAN = Writer(
    "nastran",
    to_nastran,
    "Nastran: PBUSH and PBUSHT with tables of stiffness and loss factor",
    ".bdf",
    damper=True,
    several="".join,
)
