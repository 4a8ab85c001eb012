"""Nastran: a damper as PBUSH and PBUSHT, tables of stiffness and loss factor by the frequency.

For direct frequency response (MSC and Siemens Nastran). K is K' and GE is K''/K', both against f in
cycles a unit of time, straight between their points.
"""

from __future__ import annotations

import numpy as np

from springpot.solvers import Handoff, Writer

from .frequencies import frequencies

PROPERTY, STIFFNESS_TABLE, LOSS_TABLE = 100, 101, 102
PER_MATERIAL = 3
"""Numbers of the property and of both tables."""
PER_DECADE = 32
"""Points a decade: straight lines between them are within 0.02 % of a power law."""
PAIRS = 4
"""Pairs of numbers on a line of TABLED1."""
WIDTH = 8
"""Signs of a field."""


def field(number: float) -> str:
    """A real number in eight signs, with the point that Nastran asks for."""
    for digits in range(7, 0, -1):
        text = f"{number:.{digits}g}"
        if "e" in text:
            # 1.5e-05 as 1.5-5: the sign tells where the exponent begins, and saves two signs.
            mantissa, exponent = text.split("e")
            text = f"{_with_point(mantissa)}{int(exponent):+d}"
        text = _with_point(text)
        if text.startswith("0.") and len(text) > WIDTH:
            text = text.removeprefix("0")
        if len(text) <= WIDTH:
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
    lines += ["," + ",".join(pairs[i : i + PAIRS]) for i in range(0, len(pairs), PAIRS)]
    return lines


def to_nastran(handoff: Handoff) -> str:
    """Property and tables, for a bush along the first axis of its element."""
    omega = frequencies(handoff, PER_DECADE)
    stiffness = handoff.stiffness(omega)
    frequency = (omega / (2.0 * np.pi)).tolist()
    own, stiff, loss = (
        tag + PER_MATERIAL * (handoff.number - 1) for tag in (PROPERTY, STIFFNESS_TABLE, LOSS_TABLE)
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


WRITER = Writer(
    "nastran",
    to_nastran,
    "Nastran: PBUSH and PBUSHT with tables of stiffness and loss factor",
    ".bdf",
    damper=True,
    several="".join,
)
