"""COMSOL: parameters to load from a file, of the fractional model itself and of its branches.

Its solid mechanics has springpots since version 6.2, so that a fractional model needs no series
there; the branches serve the generalised Maxwell model of all versions, which takes shear moduli.
The parameters of the model are those of the modulus that was measured. Rows of a parameter file are
name, expression and description.
"""

from __future__ import annotations

import re

from springpot.solvers import Handoff, Writer

_VALUE = re.compile(r"^(\S+)\s*(.*)$")


def to_comsol(handoff: Handoff) -> str:
    """The table, comments in front."""
    prony, unit = handoff.prony, _unit(handoff.unit)
    lines = [f"% {line}" for line in handoff.heading()]
    numbers = {name: _VALUE.match(value) for name, value in handoff.parameters.items()}
    for name, match in numbers.items():
        assert match is not None
        unit_text = match[2]
        for other, theirs in numbers.items():
            assert theirs is not None
            # The power of time of a springpot is the value of its order.
            unit_text = re.sub(rf"\^{re.escape(other)}(?![\w.])", f"^{theirs[1]}", unit_text)
        lines.append(
            f'{_name(name)} {match[1]}{_unit(unit_text)} "{name} of {handoff.model}, as measured"'
        )
    lines.append(f'G_inf {prony.equilibrium:.9g}{unit} "long-term stiffness or modulus"')
    if prony.viscosity:
        lines.append(
            f'eta {prony.viscosity:.9g}{_unit(f"{handoff.unit} s".strip())} "dashpot beside the'
            ' branches"'
        )
    for i, (weight, time) in enumerate(zip(prony.weights, prony.times, strict=True), 1):
        lines.append(f'G_{i} {weight:.9g}{unit} "branch {i}"')
        lines.append(f'tau_{i} {time:.9g}[s] "relaxation time of branch {i}"')
    return "\n".join(lines) + "\n"


def _name(text: str) -> str:
    """A name that may be a variable."""
    return re.sub(r"\W", "_", text)


def _unit(text: str) -> str:
    """``kN s^0.5/m`` as ``[kN*s^0.5/m]``; nothing for a pure number."""
    bare = text.strip()
    if bare in ("", "-"):
        return ""
    return f"[{bare.replace(' ', '*')}]"


WRITER = Writer(
    "comsol",
    to_comsol,
    "COMSOL: a parameter file of the fractional model and its branches",
    ".txt",
    modulus="G",
)
