"""The title of a column: its role, its name, and its unit in any of the ways in which units are written."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import lru_cache

from springpot.measurement import (
    AMPLITUDE_UNITS,
    ANGLE_UNITS,
    FORCE_UNITS,
    FREQUENCY_UNITS,
    LENGTH_UNITS,
    MODULUS_UNITS,
    PRESSURE_UNITS,
    STRAIN_UNITS,
    TEMPERATURE_UNITS,
    TIME_UNITS,
    TORQUE_UNITS,
    normal_unit,
)

from .curve_names import CurveName, curve_in_suffix, curve_in_title, logarithm
from .names import FREQUENCIES, role_of

VISCOSITY_UNITS = {"Pa s": 1.0, "mPa s": 1e-3, "kPa s": 1e3, "MPa s": 1e6, "P": 0.1, "cP": 1e-3}
COMPLIANCE_UNITS = {"1/Pa": 1.0, "1/kPa": 1e-3, "1/MPa": 1e-6, "1/GPa": 1e-9, "Pa^-1": 1.0, "MPa^-1": 1e-6}
DAMPING_UNITS = {
    f"{force}{space}s/{length}": newton / metre
    for force, newton in FORCE_UNITS.items()
    for length, metre in LENGTH_UNITS.items()
    for space in (" ", "")
}
WORK_UNITS = {"J": 1.0, "kJ": 1e3, "mJ": 1e-3} | {
    f"{one} {other}": newton * metre
    for force, newton in FORCE_UNITS.items()
    for length, metre in LENGTH_UNITS.items()
    for one, other in ((force, length), (length, force))
}
UNITS: dict[str, dict[str, float]] = {
    "omega": FREQUENCY_UNITS,
    "frequency": FREQUENCY_UNITS,
    "storage": MODULUS_UNITS,
    "loss": MODULUS_UNITS,
    "magnitude": MODULUS_UNITS,
    "storage_sd": MODULUS_UNITS,
    "loss_sd": MODULUS_UNITS,
    "viscosity": VISCOSITY_UNITS,
    "dynamic_viscosity": VISCOSITY_UNITS,
    "out_of_phase_viscosity": VISCOSITY_UNITS,
    "damping": DAMPING_UNITS,
    "force_amplitude": FORCE_UNITS | TORQUE_UNITS,
    "energy": WORK_UNITS,
    "storage_compliance": COMPLIANCE_UNITS,
    "loss_compliance": COMPLIANCE_UNITS,
    "phase": ANGLE_UNITS,
    "loss_factor": STRAIN_UNITS,
    "damping_ratio": STRAIN_UNITS,
    "temperature": TEMPERATURE_UNITS,
    "amplitude": AMPLITUDE_UNITS,
    "time": TIME_UNITS,
}
"""The units of each role that has any."""
USUAL = {
    "omega": "rad/s",
    "frequency": "Hz",
    "storage": "Pa",
    "loss": "Pa",
    "magnitude": "Pa",
    "viscosity": "Pa s",
    "dynamic_viscosity": "Pa s",
    "out_of_phase_viscosity": "Pa s",
    "damping": "N s/mm",
    "force_amplitude": "N",
    "energy": "N mm",
    "storage_compliance": "1/Pa",
    "loss_compliance": "1/Pa",
    "phase": "deg",
    "temperature": "degC",
    "amplitude": "%",
}
"""What to write in an example."""
KNOWN = frozenset(
    unit
    for table in (*UNITS.values(), FORCE_UNITS, LENGTH_UNITS, PRESSURE_UNITS, TORQUE_UNITS, TIME_UNITS)
    for unit in table
) | {"1/s", "1/K", "1/Pa", "1/MPa", "1/kPa", "1/rad", "A", "V"}
_LONGEST = 120
"""Signs of a title that is looked at."""
_BRACKETS = re.compile(r"^(.*?)\s*\[([^\[\]]*)\]\s*$")
_PARENTHESES = re.compile(r"^(.+?)\s*\(([^()]*(?:\([^()]*\)[^()]*)?)\)\s*$")


@dataclass(frozen=True)
class Heading:
    """What a title says.

    Parameters
    ----------
    title : str
        As written.
    name : str
        Without its unit.
    role : str or None
        What the column is; None for what is not known.
    unit : str or None
        The unit as written; None where there is none.
    joined : bool
        Whether the unit was joined by an underscore, as programs write it.
    log : str
        Base of the logarithm that the column holds, ``10`` or ``e``; ``?`` where the title does not say which,
        empty for plain numbers.
    curve : CurveName or None
        Which of several curves the column belongs to.
    """

    title: str
    name: str
    role: str | None
    unit: str | None
    joined: bool = False
    log: str = ""
    curve: CurveName | None = None


def is_unit(text: str) -> bool:
    """Whether a text is a unit that is known anywhere."""
    return normal_unit(text) in KNOWN


@lru_cache(maxsize=2048)
def heading(title: str, below: str | None = None) -> Heading:
    """Role, name and unit of a title; `below` is what a row of units says."""
    if len(title) > _LONGEST:
        return Heading(title[:_LONGEST], title[:_LONGEST], None, below)
    title = " ".join(title.split())
    if below is not None and below.strip():
        inner = below.strip()
        inner = inner[1:-1] if inner[:1] + inner[-1:] in ("[]", "()") else inner
        own = heading(title)
        name = own.name if own.log or own.curve else title
        role = role_of(title) or own.role
        return _by_unit(Heading(title, name, role, inner.strip(), log=own.log, curve=own.curve))
    return _by_unit(_marked(title) or _plain(title))


def _by_unit(found: Heading) -> Heading:
    """The heading whose unit tells what its name leaves open: a damping, or the dynamic stiffness ``C_dyn``."""
    unit = normal_unit(found.unit or "")
    if unit in DAMPING_UNITS:
        return replace(found, role="damping")
    if found.role == "damping" and unit in MODULUS_UNITS:
        return replace(found, role="magnitude")
    return found


def _marked(title: str) -> Heading | None:
    """The title of one of several curves, or of logarithms."""
    if role_of(title) is not None:
        return None
    if (marked := curve_in_title(title)) is not None:
        stem, curve = marked
        found = heading(stem) if stem != title else None
        clocks = FREQUENCIES if curve.role in FREQUENCIES else {curve.role}
        if found is not None and found.role in UNITS and found.role not in {*clocks, "time"}:
            return replace(found, title=title, curve=curve)
    if (taken := logarithm(title)) is not None:
        base, inner = taken
        found = _plain(inner)
        if found.role in UNITS and found.role not in ("time", "temperature"):
            return replace(found, title=title, log=base)
    return None


def _plain(title: str) -> Heading:
    """A title of name and unit."""
    if (match := _BRACKETS.match(title)) and match[1]:
        return Heading(title, match[1], _stem_role(match[1]), match[2].strip())
    if (role := role_of(title)) is not None:
        return Heading(title, title, role, "%" if title.startswith("%") else None)
    return _in_parentheses(title) or _after_sign(title) or _joined(title) or Heading(title, title, None, None)


def _stem_role(stem: str) -> str | None:
    """The role of a name that may still have a remark, as in ``Frequency (f) [Hz]``."""
    role = role_of(stem)
    if role is None and (match := _PARENTHESES.match(stem)):
        explained = role_of(match[2])
        role = role_of(match[1]) if explained in (None, role_of(match[1])) and not _restricts(match[2]) else None
    return role


def _restricts(remark: str) -> bool:
    """Whether a remark says that this is not the measured value."""
    return remark.lower() in ("cmd", "set", "target", "soll", "consigne", "step", "average", "sample", "command")


def _in_parentheses(title: str) -> Heading | None:
    match = _PARENTHESES.match(title)
    if match is None:
        return None
    stem = match[1].rstrip(" /")
    role, inner = role_of(stem) or _stem_role(stem), match[2].strip()
    if role is not None and role == role_of(inner) and not is_unit(inner):
        return Heading(title, stem, role, None)
    if role is not None and not _restricts(inner):
        return Heading(title, stem, role, inner)
    return Heading(title, stem, None, inner) if is_unit(inner) else None


def _after_sign(title: str) -> Heading | None:
    """``Storage modulus / Pa``, ``Frequenz in Hz``, ``Frequency, Hz`` and ``T °C``."""
    for place in [i for i in range(len(title) - 1, 0, -1) if title[i] in " /,"][:8]:
        stem, unit = title[:place].rstrip(" /,"), title[place + 1 :].strip()
        stem = re.sub(r"\s+(?:in|en)$", "", stem)
        role = role_of(stem) or _stem_role(stem)
        unit = unit[1:-1] if unit[:1] + unit[-1:] in ("()", "[]") else unit
        if role is not None and unit and is_unit(unit):
            return Heading(title, stem, role, unit)
    return None


def _joined(title: str) -> Heading | None:
    """``storage_N_per_mm``, ``omega_rad_s`` and ``Storage modulus_Pa``."""
    for match in reversed(list(re.finditer("_", title))[-8:]):
        stem, said = title[: match.start()], title[match.end() :]
        role = role_of(stem)
        if role is None or role not in UNITS:
            continue
        for unit in (said.replace("_per_", "/"), said.replace("_", "/"), said.replace("_", " "), _word(said)):
            known = normal_unit(unit)
            if known in UNITS[role] or known.lower() in {name.lower() for name in UNITS[role]}:
                return Heading(title, stem, role, unit, joined=True)
    return None


def _word(said: str) -> str:
    return {"pct": "%", "percent": "%", "c": "degC", "k": "K"}.get(said.lower(), said)


@lru_cache(maxsize=2048)
def plainly(found: Heading) -> Heading:
    """A title such as ``G'_A [Pa]`` as that of one of several curves; others as they are."""
    if found.role is None and (marked := curve_in_suffix(found.name)) is not None:
        name, curve = marked
        role = role_of(name)
        if role in UNITS and role not in ("time", "temperature", "amplitude"):
            return replace(found, role=role, name=name, curve=curve)
    return found
