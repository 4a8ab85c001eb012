"""What the lines above a table say.

Conditions, such as ``T = 25 °C`` or ``# Frequency [Hz]: 1``; and facts of instrument, geometry and
sample, under fixed keys, with what they mean for a measured modulus.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from springpot.measurement import PRESSURE_UNITS, TORQUE_UNITS, normal_unit

from .blocks import Block
from .names import FREQUENCIES, fold, role_of
from .title_words import curve_in_cell
from .titles import UNITS

_STATED = re.compile(
    r"(?:^|[,;|#%]\s*)([^\W\d][^\[\]=:,;|]{0,40}?)\s*(?:[\[(]([^\[\]()]{1,12})[\])])?\s*[=:]\s*"
    r"([-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?)\s*([^\s,;|\d][^\s,;|]{0,12})?\s*(?=$|[,;|])"
)
_ROLES = frozenset({"temperature", "amplitude", *FREQUENCIES})
_NEAR = 12
"""Lines above a table that are looked at."""
_LONGEST = 1000
"""Signs of such a line."""


def with_conditions_above(blocks: Iterable[Block]) -> list[Block]:
    """The blocks, each with the conditions that lines above it state and no column of it has."""
    return [
        replace(block, constants={**conditions_above(block), **block.constants}) for block in blocks
    ]


def conditions_above(block: Block) -> dict[str, str]:
    """Conditions by title: ``temperature [degC]`` and the number; only those with a known unit."""
    taken = set(block.roles)
    if taken & FREQUENCIES:
        # A column of omega says the frequency as well.
        taken |= FREQUENCIES
    stated: dict[str, str] = {}
    # Downwards, so that the line nearest to the table counts.
    for row in block.above[-_NEAR:]:
        conditions = _conditions_in([cell for cell in row if cell])
        for role in {role for role, _, _ in conditions} - taken:
            values = {(unit, number) for each, unit, number in conditions if each == role}
            # Two temperatures in one line are those of two curves.
            if len(values) == 1:
                unit, number = values.pop()
                stated[f"{role} [{unit}]"] = number
    return stated


def _conditions_in(cells: Sequence[str]) -> list[tuple[str, str, str]]:
    """Role, unit and number of each condition in a line."""
    conditions = []
    if len(cells) == 1 and (curve := curve_in_cell(cells[0].strip("#%/ "))).title:
        return [(curve.role, normal_unit(curve.title.partition(" ")[2]), curve.value)]
    text = ""
    if len(cells) == 2 and not re.search("[:=]", cells[0]):
        # A line of two cells is a key and its value, also without a colon.
        cells = [f"{cells[0]}:", cells[1]]
    for cell in cells:
        # "Temperature:" and "25 °C" stand in two cells.
        separator = ", "
        if cell.endswith((":", "=")):
            separator = " "
        text += cell + separator
    for name, bracket, number, behind in _STATED.findall(text[:_LONGEST].removesuffix(", ")):
        role, unit = role_of(name), normal_unit(bracket or behind)
        if role in _ROLES and (bracket or behind) and unit in UNITS[str(role)]:
            conditions.append((str(role), unit, number.replace(",", ".")))
    return conditions


KEYS: dict[str, tuple[str, ...]] = {
    "sample": ("samplename", "sample", "echantillon", "probe", "probenname", "muestra", "campione"),
    "project": ("project", "projet", "projekt", "proyecto", "progetto"),
    "test": ("test", "essai", "versuch", "prueba", "prova", "testname", "procedurename"),
    "result": ("result", "resultat", "ergebnis", "resultado", "risultato"),
    "date": ("rundate", "date", "datum", "datetime", "datum/zeit", "fecha", "data", "starttime"),
    "instrument.type": (
        "instrumenttype",
        "instrument",
        "gerat",
        "messgerat",
        "appareil",
        "device",
        "instrumento",
    ),
    "instrument.serial": ("instrumentserialnumber", "serialnumber"),
    "instrument.inertia": ("instrumentinertia", "motorinertia", "systeminertia", "deviceinertia"),
    "instrument.friction": ("bearingfriction", "instrumentfriction", "motorfriction", "friction"),
    "instrument.compliance": (
        "instrumentcompliance",
        "axialcompliance",
        "torsionalcompliance",
        "systemcompliance",
    ),
    "software": ("triosversion", "softwareversion", "software", "rheocompassversion"),
    "geometry.type": ("geometrytype", "measuringsystemtype"),
    "geometry.name": (
        *("geometryname", "measuringsystem", "messsystem", "systemedemesure", "sistemademedicion"),
        *("sistemadimisura", "measuringgeometry", "geometry", "messgeometrie"),
    ),
    "geometry.diameter": ("diameter", "durchmesser", "diametre", "diametro", "platediameter"),
    "geometry.angle": ("angle", "coneangle", "kegelwinkel"),
    "geometry.gap": ("gap", "messspalt", "entrefer", "measuringgap", "spalt"),
    "geometry.length": ("length", "boblength", "gaugelength", "samplelength"),
    "geometry.width": ("width", "samplewidth"),
    "geometry.thickness": ("thickness", "samplethickness"),
    "geometry.inertia": ("geometryinertia", "measuringsysteminertia", "inertia"),
    "geometry.compliance": ("compliance", "geometrycompliance", "measuringsystemcompliance"),
    "geometry.upper_compliance": ("uppercompliance",),
    "geometry.lower_compliance": ("lowercompliance",),
    "geometry.mass": ("uppergeometrymass", "geometrymass"),
    "geometry.stress_constant": ("stressconstant", "css"),
    "geometry.strain_constant": ("strainconstant",),
    "geometry.stress_constant_linear": ("stressconstant(linear)",),
    "geometry.strain_constant_linear": ("strainconstant(linear)",),
    "inertia_correction": ("inertiacorrection", "flowinertiacorrection"),
    "fluid_density": ("fluiddensity", "density"),
}
_KEY_OF = {fold(name): key for key, names in KEYS.items() for name in names}
_SENTENCE = 60
"""Signs from which what stands before a value is a sentence, and no key."""
_QUANTITY = re.compile(r"^\s*([-+]?\d+(?:[.,]\d+)?(?:[eE][-+]?\d+)?)\s*[\[(]?(.*?)[\])]?\s*$")
_PREFIXES = {"": 1.0, "m": 1e-3, "u": 1e-6, "n": 1e-9, "k": 1e3}
INERTIA_UNITS = {f"{p}N m {s}": f for p, f in _PREFIXES.items() for s in ("s^2", "s2")}
FRICTION_UNITS = {f"{p}N m{s}": f for p, f in _PREFIXES.items() for s in (" s", " s/rad", "/rad/s")}
COMPLIANCE_UNITS = {f"{p}rad/N m": f for p, f in _PREFIXES.items()}
PER_ANGLE_UNITS = {"1/rad": 1.0, "rad^-1": 1.0, "rad-1": 1.0, "-": 1.0}
# A gram-force centimetre, by the standard gravity of 9.80665 m/s^2.
_TORQUES = TORQUE_UNITS | {"g cm": 9.80665e-5}
PER_TORQUE_UNITS = {
    f"{p}/{t}": a / b for p, a in PRESSURE_UNITS.items() for t, b in _TORQUES.items()
}


def facts_of(pairs: Iterable[tuple[str, str]]) -> dict[str, str]:
    """The pairs that are known, under their fixed keys; the first of each.

    Parameters
    ----------
    pairs : iterable of tuple of str
        Key and value as the file writes them.
    """
    facts: dict[str, str] = {}
    for key, value in pairs:
        if len(key) >= _SENTENCE:
            continue
        known = _KEY_OF.get(fold(key))
        value = " ".join(value.split())[:200]
        # The first of each: the header of the file stands above those of its steps.
        if known is not None and not _is_unset(value):
            facts.setdefault(known, value)
    return {**facts, **as_modulus(facts)}


def _is_unset(value: str) -> bool:
    """Whether a field was left as the program had it.

    Empty, a dash, or nothing of a unit such as ``0 mm``.
    """
    parsed = quantity(value)
    return value in ("", "-", "Anonymous") or bool(parsed and parsed[0] == 0 and parsed[1])


def pairs_in(rows: Iterable[list[str]]) -> list[tuple[str, str]]:
    """Lines of a key and a value, as cells."""
    pairs = []
    for row in rows:
        filled = [cell for cell in row if cell]
        if len(filled) > 1 and not filled[0].startswith("["):
            pairs.append((filled[0].rstrip(": "), " ".join(filled[1:4])))
        elif len(filled) == 1 and ":" in filled[0]:
            key, _, value = filled[0].partition(":")
            pairs.append((key.strip("#% "), value.strip()))
    return pairs


def quantity(text: str) -> tuple[float, str] | None:
    """Number and unit of a value such as ``20.72 µN.m.s²``; None for words."""
    match = _QUANTITY.match(text)
    if match is None:
        return None
    return float(match[1].replace(",", ".")), match[2].strip()


def as_modulus(facts: dict[str, str]) -> dict[str, str]:
    """Inertia, friction and compliance of a rotational rheometer as they act on a shear modulus.

    With stress = F_s torque and strain = F_g angle, a moment of inertia I takes I omega^2 F_s / F_g
    from the modulus, a friction b adds a viscosity b F_s / F_g, a compliance C is a spring F_s /
    (F_g C) in series.
    """
    stress = _in_si(facts.get("geometry.stress_constant"), PER_TORQUE_UNITS)
    strain = _in_si(facts.get("geometry.strain_constant"), PER_ANGLE_UNITS)
    if not stress or not strain:
        # Without the constants of the geometry a torque tells nothing of a modulus.
        return {}
    factor, moduli = stress / strain, {}
    inertia = sum(
        _in_si(facts.get(f"{part}.inertia"), INERTIA_UNITS) for part in ("instrument", "geometry")
    )
    friction = _in_si(facts.get("instrument.friction"), FRICTION_UNITS)
    compliance = sum(
        _in_si(facts.get(key), COMPLIANCE_UNITS)
        for key in ("geometry.compliance", "geometry.upper_compliance", "geometry.lower_compliance")
    )
    if inertia:
        moduli["inertia as modulus"] = f"{inertia * factor:.6g} Pa s^2"
    if friction:
        moduli["friction as viscosity"] = f"{friction * factor:.6g} Pa s"
    if compliance:
        moduli["compliance as modulus"] = f"{factor / compliance:.6g} Pa"
    return moduli


def _in_si(text: str | None, units: Mapping[str, float]) -> float:
    """A quantity in SI; zero where it is missing or its unit is another."""
    parsed = quantity(text or "")
    if parsed is None:
        return 0.0
    # The bracket around a unit may have taken the closing one within it along.
    unit = normal_unit(parsed[1].replace("(", "").replace(")", ""))
    return parsed[0] * units.get(unit, 0.0)
