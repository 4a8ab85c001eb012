"""The title of a column.

Its role, its name, and its unit in any of the ways in which units are written.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

from springpot.errors import DataError
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

from .names import FREQUENCIES, MODULI, ROLES, role_of
from .table import DECIBEL, INVERSE, OPPOSITE, PER_PERIOD, decibel_of
from .title_words import (
    LONGEST,
    CurveName,
    curve_in_suffix,
    curve_in_title,
    logarithm,
    without_swing,
)


def _inverses(unit: str) -> tuple[str, ...]:
    """How one over a unit of pressure is written: ``1/Pa``, ``Pa^-1``, ``mm^2/N``."""
    over, slash, under = unit.partition("/")
    if slash:
        return (f"{under}/{over}",)
    return f"1/{unit}", f"{unit}^-1"


VISCOSITY_UNITS = {"Pa s": 1.0, "mPa s": 1e-3, "kPa s": 1e3, "MPa s": 1e6, "P": 0.1, "cP": 1e-3}
RECEPTANCE_UNITS = {
    f"{length}/{force}": metre / newton
    for length, metre in LENGTH_UNITS.items()
    for force, newton in FORCE_UNITS.items()
}
"""Displacement over force, as modal tests measure it."""
COMPLIANCE_UNITS = RECEPTANCE_UNITS | {
    inverse: 1.0 / pascal for unit, pascal in PRESSURE_UNITS.items() for inverse in _inverses(unit)
}
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
    "relaxation": MODULUS_UNITS,
    "flow": dict.fromkeys(_inverses("s"), STRAIN_UNITS["-"]),
    "compliance": COMPLIANCE_UNITS,
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
    "relaxation": "Pa",
    "compliance": "1/Pa",
    "displacement": "mm",
    "force": "N",
    "time": "s",
    "phase": "deg",
    "temperature": "degC",
    "amplitude": "%",
}
"""What to write in an example."""
VALUES = MODULI | {
    "phase",
    "loss_factor",
    "damping_ratio",
    "out_of_phase_viscosity",
    "loss_compliance",
    "storage_sd",
    "loss_sd",
}
"""What differs from curve to curve of sweeps."""
KNOWN = frozenset(
    unit
    for table in (
        *UNITS.values(),
        FORCE_UNITS,
        LENGTH_UNITS,
        PRESSURE_UNITS,
        TORQUE_UNITS,
        TIME_UNITS,
    )
    for unit in table
) | {"1/s", "1/K", "1/Pa", "1/MPa", "1/kPa", "1/rad", "A", "V"}
_MADE_A_NAME = re.compile(r"(.*[A-Za-z*])(?:_|\.\.+)([A-Za-z]\w*(?:\.\w+)*)[_.]+\Z")
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
    written : str
        What was done to the numbers before they were written: ``10`` or ``e`` is the base of their
        logarithm, ``?`` one that the title does not say, `DECIBEL`, `INVERSE` or `OPPOSITE`; empty
        for plain numbers.
    curve : CurveName or None
        Which of several curves the column belongs to.
    """

    title: str
    name: str
    role: str | None
    unit: str | None
    joined: bool = False
    written: str = ""
    curve: CurveName | None = None


def title_again(headings: Sequence[Heading], name: str) -> str:
    """The one title of that name that stands above several columns; empty where there is none."""
    titles = [each.title for each in headings if name in (each.title, each.name)]
    return titles[0] if len(titles) > 1 and len(set(titles)) == 1 else ""


def to_type(headings: Sequence[Heading], place: int) -> str:
    """What to type for a column: its title where that means it in each curve, else its number."""
    title = title_again(headings, headings[place - 1].title)
    return title if title and not set(title) & set(",=?'") else str(place)


def is_unit(text: str) -> bool:
    """Whether a text is a unit that is known anywhere."""
    return normal_unit(text) in KNOWN


@dataclass(frozen=True, eq=False)
class Vocabulary:
    """What titles mean in one kind of table: sweeps, or tests in time.

    Whatever is known of layouts holds for both.

    Parameters
    ----------
    role : callable
        From a name to the role that it stands for, or None.
    plain : callable
        From a title of name and unit to its heading.
    by_unit : callable
        From a heading to the one that its unit makes of it.
    units : mapping of str to dict of str to float
        The units of each role that has any.
    said : collection of str
        Roles that a user may say of a column.
    clocks, values : frozenset of str
        Roles along which a curve runs, and those that differ from curve to curve.
    complete : callable
        Whether columns of these roles are a whole table.
    """

    role: Callable[[str], str | None]
    plain: Callable[[str], Heading]
    by_unit: Callable[[Heading], Heading]
    units: Mapping[str, dict[str, float]]
    said: Collection[str]
    clocks: frozenset[str]
    values: frozenset[str]
    complete: Callable[[set[str]], bool]

    @lru_cache(maxsize=4096)  # noqa: B019  (there are two of them, and they stay)
    def heading(self, title: str, below: str | None = None) -> Heading:
        """Role, name and unit of a title; `below` is what a row of units says."""
        if len(title) > LONGEST:
            return Heading(title[:LONGEST], title[:LONGEST], None, below)
        title = " ".join(title.split())
        own = self.by_unit(self._marked(title) or self.plain(title))
        if below is None or not below.strip():
            return own
        name = title
        if own.written or own.curve:
            name = own.name
        # The row of units stands for the whole column, so that its unit goes before one within the
        # title.
        unit = unbracketed(below.strip()).strip()
        role = self.role(title) or own.role
        return self.by_unit(Heading(title, name, role, unit, written=own.written, curve=own.curve))

    @lru_cache(maxsize=4096)  # noqa: B019
    def plainly(self, named: Heading) -> Heading:
        """A title such as ``G'_A [Pa]`` as that of one of several curves; others as they are."""
        if named.role is None and (marked := curve_in_suffix(named.name)) is not None:
            name, curve = marked
            role = self.by_unit(replace(named, name=name, role=self.role(name))).role
            # Time, temperature and amplitude are shared by the curves, or several sensors'.
            if role in self.units and role not in ("time", "temperature", "amplitude"):
                return replace(named, role=role, name=name, curve=curve)
        return named

    def _marked(self, title: str) -> Heading | None:
        """The title of one of several curves, or of logarithms."""
        if self.role(title) is not None:
            # A name that is known as a whole, such as log10 a_T, is not taken apart.
            return None
        if (marked := curve_in_title(title)) is not None:
            stem, curve = marked
            if stem != title and self._is_along_curve(self.heading(stem).role, curve):
                return replace(self.heading(stem), title=title, curve=curve)
        if (taken := logarithm(title)) is not None:
            base, inner = taken
            plain = self.plain(inner)
            if plain.role in self.clocks or plain.role in {*self.units} - {"time", "temperature"}:
                return replace(plain, title=title, written=base)
        return None

    def _is_along_curve(self, role: str | None, curve: CurveName) -> bool:
        """Whether a column of this role may belong to one of several curves, not say which."""
        if role not in self.units or role in (curve.role, "time"):
            return False
        return role not in FREQUENCIES or curve.role not in FREQUENCIES


def heading(title: str, below: str | None = None) -> Heading:
    """Role, name and unit of a title in a table of sweeps; see `Vocabulary.heading`."""
    return SWEEPS.heading(title, below)


def unbracketed(unit: str) -> str:
    """A unit without the brackets around it."""
    if unit[:1] + unit[-1:] in ("[]", "()"):
        return unit[1:-1]
    return unit


def _by_unit(named: Heading) -> Heading:
    """The heading whose unit tells what its name leaves open.

    A damping, the dynamic stiffness ``C_dyn``, a level.
    """
    unit = normal_unit(named.unit or "")
    if named.role == "period":
        # Without a unit of time it may count periods.
        frequency = PER_PERIOD.get(unit)
        if frequency is None:
            return replace(named, role=None)
        return replace(named, role="frequency", unit=frequency, written=INVERSE)
    if named.role == "receptance_imaginary":
        # X / F = J' - i J'': its imaginary part is the negative of the loss compliance.
        return replace(named, role="loss_compliance", written=OPPOSITE)
    if (reference := decibel_of(named.unit or "")) and named.role in UNITS:
        return replace(named, unit=reference, written=DECIBEL)
    if unit in DAMPING_UNITS:
        return replace(named, role="damping")
    if named.role == "damping" and unit in MODULUS_UNITS:
        return replace(named, role="magnitude")
    return named


def plain_title(title: str) -> Heading:
    """A title of name and unit."""
    if (match := _BRACKETS.match(title)) and match[1]:
        return Heading(title, match[1], _stem_role(match[1]), match[2].strip())
    if (role := role_of(title)) is not None:
        # "% strain"
        unit = None
        if title.startswith("%"):
            unit = "%"
        return Heading(title, title, role, unit)
    return (
        _in_parentheses(title)
        or _after_sign(title)
        or _joined(title)
        or _made_a_name(title)
        or _behind_unit(title)
        or Heading(title, title, None, None)
    )


def _stem_role(stem: str) -> str | None:
    """The role of a name that may still have a remark, as in ``Frequency (f) [Hz]``."""
    role, match = role_of(stem), _PARENTHESES.match(stem)
    if role is not None or match is None:
        return role
    # "Temperature (sample)", "dyn. stiffness (K')": the remark may be what makes the name known.
    whole = role_of(f"{match[1]} {match[2]}")
    if whole is not None:
        return whole
    own, explained = role_of(match[1]), role_of(match[2])
    # Where both are known and differ, the title does not tell which is meant.
    if explained not in (None, own) or _restricts(match[2]):
        return None
    return own


def _restricts(remark: str) -> bool:
    """Whether a remark says that this is not the measured value."""
    return remark.lower() in (
        "cmd",
        "set",
        "target",
        "soll",
        "consigne",
        "step",
        "average",
        "sample",
        "command",
    )


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
    if is_unit(inner):
        return Heading(title, stem, None, inner)
    return None


def _after_sign(title: str) -> Heading | None:
    """``Storage modulus / Pa``, ``Frequenz in Hz``, ``Frequency, Hz``, ``K / dB re 1 N/m``."""
    # From the right: the shortest rest that is a unit leaves the longest name.
    for place in [i for i in range(len(title) - 1, 0, -1) if title[i] in " /,"][:8]:
        stem, unit = title[:place].rstrip(" /,"), unbracketed(title[place + 1 :].strip())
        stem = re.sub(r"\s+(?:in|en)$", "", stem)
        role = role_of(stem) or _stem_role(stem)
        if role is not None and unit and (is_unit(unit) or decibel_of(unit)):
            return Heading(title, stem, role, unit)
    return None


def _joined(title: str) -> Heading | None:
    """``storage_N_per_mm``, ``omega_rad_s`` and ``Storage modulus_Pa``."""
    for match in reversed(list(re.finditer("_", title))[-8:]):
        stem, rest = title[: match.start()], title[match.end() :]
        role = role_of(stem)
        if role is None or role not in UNITS:
            continue
        for unit in (
            rest.replace("_per_", "/"),
            rest.replace("_", "/"),
            rest.replace("_", " "),
            _sign_of(rest),
        ):
            known = normal_unit(unit)
            # Programs often write names in lower case alone: storage_mpa.
            if known in UNITS[role] or known.lower() in {name.lower() for name in UNITS[role]}:
                return Heading(title, stem, role, unit, joined=True)
    return None


def _made_a_name(title: str) -> Heading | None:
    """``Frequency_Hz_`` and ``Storage.modulus..Pa.``.

    Titles that MATLAB and R made names of, by replacing signs.
    """
    match = _MADE_A_NAME.match(title)
    if match is None:
        return None
    named = _joined(f"{match[1]}_{match[2]}".replace(".", "_"))
    if named is None:
        return None
    return replace(named, title=title)


def _behind_unit(title: str) -> Heading | None:
    """``Amplitude (mm) p-p``: from where it counts stands behind the unit."""
    bare = without_swing(title)
    if bare in ("", title):
        return None
    named = plain_title(bare)
    if named.role not in ("amplitude", "force_amplitude"):
        return None
    return replace(named, title=title)


def _sign_of(word: str) -> str:
    """The sign of a unit that a name in a program cannot hold."""
    return {"pct": "%", "percent": "%", "c": "degC", "k": "K"}.get(word.lower(), word)


def apart_from_sign(unit: str) -> tuple[float, str]:
    """Sign and unit of ``-kN``."""
    # A sign alone is the unit of a strain.
    if unit.startswith("-") and len(unit) > 1:
        return -1.0, unit[1:]
    return 1.0, unit


def require_word(meaning: str) -> None:
    """Refuse what is neither a word nor a word with its unit, and would lose a part unseen.

    Raises
    ------
    DataError
        If a sign stands before the word, or the word is the title of a column with its own unit.
    """
    word = meaning.partition("[")[0].strip()
    signed = word[:1] in ("-", "+") and word[1:2].isalpha() and not is_unit(word[1:])
    if signed or ("(" in word and not is_unit(word)):
        raise DataError(
            f"'{meaning:.40}': a meaning is one word with its unit, such as force[N], of a channel"
            " that counts the other way force[-N]; the column stands before the ="
        )


def is_dynamic(roles: set[str]) -> bool:
    """Whether columns of these roles give a complex modulus against frequency."""
    modulus = {"storage", "loss"} <= roles or (
        bool(roles & {"storage", "loss", "magnitude", "viscosity"})
        and bool(roles & {"phase", "loss_factor", "damping_ratio"})
    )
    modulus |= "damping" in roles and bool(roles & {"storage", "magnitude"})
    modulus |= {"force_amplitude", "amplitude"} <= roles and bool(roles & {"phase", "loss_factor"})
    modulus |= {"energy", "amplitude"} <= roles and bool(roles & {"storage", "magnitude"})
    modulus |= {"dynamic_viscosity", "out_of_phase_viscosity"} <= roles
    modulus |= {"storage_compliance", "loss_compliance"} <= roles
    return modulus and bool(roles & FREQUENCIES)


SWEEPS = Vocabulary(role_of, plain_title, _by_unit, UNITS, ROLES, FREQUENCIES, VALUES, is_dynamic)
"""Tables of a frequency and a complex modulus."""
