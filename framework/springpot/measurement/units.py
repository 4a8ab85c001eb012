"""Units of dynamic tests.

A small table with exact factors to SI, and the units of a model's parameters.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import lru_cache
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.rheology.parameters import Dimension, Exponent
from springpot.rheology.points import KELVIN
from springpot.writing import LISTED

MODULI = {"shear": "G", "young": "E", "bulk": "K"}
"""What users call the moduli, and their letters."""
MODULUS_WORDS = {"": "modulus", "G": "shear modulus", "E": "Young's modulus", "K": "bulk modulus"}
"""How a modulus is called whose letter is known."""

T = TypeVar("T", float, NDArray[np.float64])

FORCE_UNITS = {
    "N": 1.0,
    "kN": 1e3,
    "mN": 1e-3,
    "MN": 1e6,
    "uN": 1e-6,
    "lbf": 4.4482216152605,
    "kip": 4448.2216152605,
    "kgf": 9.80665,
    "dyn": 1e-5,
    "daN": 10.0,
} | {"nN": 1e-9, "pN": 1e-12}
LENGTH_UNITS = {
    "m": 1.0,
    "mm": 1e-3,
    "cm": 1e-2,
    "um": 1e-6,
    "nm": 1e-9,
    "in": 0.0254,
    "ft": 0.3048,
}
TORQUE_UNITS = {
    "N m": 1.0,
    "kN m": 1e3,
    "mN m": 1e-3,
    "uN m": 1e-6,
    "N mm": 1e-3,
    "lbf in": 0.1129848290276167,
}
ANGLE_UNITS = {
    "rad": 1.0,
    "mrad": 1e-3,
    "urad": 1e-6,
    "deg": 0.017453292519943295,
    "gon": 0.015707963267948967,
}


def _quotients(over: dict[str, float], under: dict[str, float]) -> dict[str, float]:
    """Each unit of one table over each of another, with its factor to SI."""
    factors = {}
    for upper, factor in over.items():
        for lower, divisor in under.items():
            factors[f"{upper}/{lower}"] = factor / divisor
    return factors


STIFFNESS_UNITS = _quotients(FORCE_UNITS, LENGTH_UNITS)
TORSION_UNITS = _quotients(TORQUE_UNITS, ANGLE_UNITS)
PRESSURE_UNITS = {
    "Pa": 1.0,
    "hPa": 1e2,
    "kPa": 1e3,
    "MPa": 1e6,
    "GPa": 1e9,
    "mPa": 1e-3,
    "bar": 1e5,
    "psi": 6894.757293168361,
    "ksi": 6894757.293168361,
    "N/mm^2": 1e6,
    "N/m^2": 1.0,
    "dyn/cm^2": 0.1,
    "kgf/cm^2": 98066.5,
}
STRAIN_UNITS = {"-": 1.0, "%": 0.01}
FREQUENCY_UNITS = {
    "Hz": 6.283185307179586,
    "rad/s": 1.0,
    "kHz": 6283.185307179586,
    "mHz": 0.006283185307179586,
    "1/min": 0.10471975511965977,
}
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}
TEMPERATURE_UNITS = {"degC": 1.0, "K": 1.0, "degF": 5.0 / 9.0}
_USUAL = {"N/m": 1.0, "N/mm": 1e3, "kN/m": 1e3, "kN/mm": 1e6, "lbf/in": STIFFNESS_UNITS["lbf/in"]}
FILE_UNITS = "file units"
"""Of moduli, stiffnesses, stresses or forces whose unit nobody tells: numbers as a file has them.

Nothing is converted to it or from it.
"""
MODULUS_UNITS = _USUAL | PRESSURE_UNITS | STIFFNESS_UNITS | TORSION_UNITS | {FILE_UNITS: 1.0}
AMPLITUDE_UNITS = LENGTH_UNITS | STRAIN_UNITS | ANGLE_UNITS

_SPELT = {
    "degC": "°c,degc,c,celsius,deg c,℃,grad c,grad celsius,gradc,grd c",
    "degF": "°f,f",
    "K": "kelvin",
    "Hz": "hertz,cps,cycles/s",
    "1/min": "cpm,rpm,u/min,upm,r/min,rev/min,min^-1",
    "rad/s": "rads/s,rad s^-1",
    # German test benches write Grad for a degree; the hundredth of a right angle is a gon there.
    "deg": "grad,grd,altgrad,winkelgrad,degs,°,degree,degrees",
    "gon": "neugrad,gradian,gradians",
    "-": ",1,strain,m/m,mm/mm,in/in,frac,fraction",
    "%": "percent",
    "s": "sec,seconds",
    "ms": "milliseconds",
    "min": "minutes",
    "in": "inch,inches",
    "mm": "millimeter,millimeters,millimetre,millimetres",
    "m": "meter,meters,metre,metres",
    "N": "newton,newtons",
    "kN": "kilonewton,kilonewtons",
    "lbf": "lb,pound,pounds",
    "kip": "kips",
    "Pa": "pascal,pascals",
    "ksi": "kpsi",
}
_SPELLINGS = {other: usual for usual, others in _SPELT.items() for other in others.split(",")}
_SIGNS = str.maketrans(
    {
        "µ": "u",
        "μ": "u",
        "²": "^2",
        "³": "^3",
        "⁶": "^6",
        "⁹": "^9",
        "·": " ",
        "⋅": " ",
        "*": " ",
        "−": "-",
        "⁻": "^-",
        "¹": "1",
    }
)
_POWER_BEFORE = re.compile(r"(?:[x×]\s*)?(?:10\^\s*(-?\d)|1[eE]([-+]?\d))\s*(?=[A-Za-z])(.+)\Z")
_POWER_BEHIND = re.compile(r"([A-Za-z].*?)\s*[x×]\s*10\^\s*(-?\d)\Z")
_PREFIXES = {3: "k", 6: "M", 9: "G", -3: "m", -6: "u"}
_WITHOUT_BLANK = {"Nm": "N m", "mNm": "mN m", "uNm": "uN m", "kNm": "kN m", "Nmm": "N mm"}


_IN_RUSSIAN = (
    "Гц Hz,кГц kHz,рад rad,град deg,Па Pa,кПа kPa,МПа MPa,ГПа GPa,м m,мм mm,см cm,мкм um,"
    "Н N,кН kN,МН MN,с s,сек s,мс ms,мин min,С C,К K,кгс kgf,Дж J,кДж kJ"
)
_RUSSIAN = dict(pair.split() for pair in _IN_RUSSIAN.split(","))
_CYRILLIC = re.compile(r"[а-яА-Я]+")
_LONGEST = 60
"""Signs of a unit that are looked at."""


@lru_cache(maxsize=4096)
def normal_unit(text: str) -> str:
    """The usual spelling of a unit as people and programs write it.

    Those that are unknown are tidied only.

    Examples
    --------
    >>> [normal_unit(text) for text in ("°C", "N.m", "rad·s-1", "[mPa.s]", "10³ Pa", "1/(kN/m)")]
    ['degC', 'N m', 'rad/s', 'mPa s', 'kPa', 'm/kN']
    """
    # An abbreviation may end in a dot, as people write "deg." and "sec.".
    unit = text.strip().strip("[]").strip()[:_LONGEST].removesuffix(".")
    if _CYRILLIC.search(unit):
        unit = _CYRILLIC.sub(lambda word: _RUSSIAN.get(word[0], word[0]), unit)
    # Dots and hyphens between letters stand for a product: N.m, Pa-s.
    unit = re.sub(r"(?<=[A-Za-zµμ])[.\-](?=[A-Za-z])", " ", unit)
    # People write the inverse of a unit in many ways: s-1, s^-1, s⁻¹.
    unit = re.sub(r"(?<=[a-z])\s*(?:\^|⁻|-)\s*(?:-|⁻)?[1¹]$", "^-1", unit)
    unit = re.sub(r"\bsec(?:onds?)?\b", "s", unit)
    # A pascal second is often written in one word.
    unit = re.sub(r"^([mkM]?Pa)s$", r"\1 s", unit)
    unit = " ".join(unit.translate(_SIGNS).split())
    # Before the spellings are looked up, which know no powers of ten.
    unit = _with_prefix(unit)
    if (spelt := _SPELLINGS.get(unit.lower())) is not None:
        return spelt
    unit = re.sub(r"(?<=/)(m|cm|mm|in)2$", r"\1^2", re.sub(r"\bdynes?\b", "dyn", unit))
    over, slash, under = (part.strip() for part in unit.partition("/"))
    # A product with an inverse is a quotient: rad s^-1.
    if not slash and over.endswith("^-1") and " " in over:
        over, _, under = over[:-3].rpartition(" ")
        slash = "/"
    if not slash:
        return _WITHOUT_BLANK.get(over, over)
    over, under = _part(over), _part(under)
    # One over a quotient is the quotient turned over, as our own tables write a compliance. Without
    # brackets it is meant so too: over a force times a length nothing is measured.
    if over == "1" and "/" in under:
        under, _, over = under.partition("/")
    return f"{over}/{under}"


def _with_prefix(unit: str) -> str:
    """``10^6 Pa``, ``1e6 Pa`` or ``Pa x10^6`` as ``MPa``; other units as they are."""
    if match := _POWER_BEFORE.match(unit):
        power, base = int(match[1] or match[2]), match[3]
    elif match := _POWER_BEHIND.match(unit):
        power, base = int(match[2]), match[1]
    else:
        return unit
    if power not in _PREFIXES:
        return unit
    # A unit with a prefix of its own gives a name that no table has, and is told as it stands.
    return f"{_PREFIXES[power]}{base}"


def _part(text: str) -> str:
    """One side of a fraction; the one of 1/s stays."""
    if text[:1] + text[-1:] == "()":
        text = text[1:-1].strip()
    # By itself nothing, or a 1, is the unit of a share: over or under a stroke it is not.
    if text in ("", "1"):
        return text
    return normal_unit(text)


def known_unit(text: str, table: dict[str, float], what: str) -> str:
    """`text` as the table spells it.

    Raises
    ------
    DataError
        If the unit is unknown, with the nearest known ones.

    Examples
    --------
    >>> from springpot.measurement import known_unit
    >>> known_unit("kilonewton", {"N": 1.0, "kN": 1e3}, "a force")
    'kN'
    """
    unit = normal_unit(text)
    if unit in table:
        return unit
    # A unit is never guessed but for its case: a wrong one would change K a thousandfold without a
    # word.
    near = near_units(unit, table)
    # Case may be sloppy, but it must not turn mega into milli.
    if (
        len(near) == 1
        and near[0].lower() == unit.lower()
        and (near[0][0] == unit[0] or unit[0] not in "mM")
    ):
        return near[0]
    hint = ""
    if near:
        proposals = " or ".join(f"[{known}]" for known in near)
        hint = f"did you mean {proposals}? "
    shown = ", ".join(list(table)[:LISTED])
    if len(table) > LISTED:
        shown += ", ..."
    raise DataError(f"unknown unit [{text}] for {what}: {hint}known are {shown}")


def near_units(text: str, table: dict[str, float]) -> list[str]:
    """The units of a table that an unknown one may stand for.

    Those that differ in case alone, else the most alike.

    Examples
    --------
    >>> near_units("mpa", {"Pa": 1.0, "MPa": 1e6, "mPa": 1e-3})
    ['MPa', 'mPa']
    """
    unit = normal_unit(text)
    folded = [known for known in table if known.lower() == unit.lower()]
    return folded or get_close_matches(unit, table, n=2, cutoff=0.5)


@dataclass(frozen=True)
class Units:
    """The units a measurement came in, in which its results are printed.

    Parameters
    ----------
    stiffness : str
        Unit of storage and loss, such as ``kN/m`` or ``Pa``.
    amplitude : str
        Unit of the amplitude, such as ``mm`` or ``-``.
    clock : {"Hz", "rad/s"}
        In which frequencies are told; every array is in rad/s, or in Hz where its name is
        frequency.
    letter : {"", "G", "E", "K"}
        What was measured: a shear modulus (G), Young's modulus (E), or of a modulus the bulk one
        and of a stiffness the stiffness itself (K); empty where nobody says. Solids need it, see
        `springpot.solvers.solid_of`.

    Raises
    ------
    DataError
        If a unit is unknown, with the nearest known ones.

    Examples
    --------
    >>> from springpot import Units
    >>> Units("N/mm^2", "%")
    Units(stiffness='N/mm^2', amplitude='%')
    >>> told = Units("Pa", clock="rad/s", letter="G")
    >>> told.storage, told.magnitude, told.at(10.0)
    ("G'", '|G*|', '62.8 rad/s')
    """

    stiffness: str = "Pa"
    amplitude: str = "-"
    # No units: numbers of data that differ in these alone need no factor between them.
    clock: str = field(default="Hz", compare=False, repr=False)
    letter: str = field(default="", compare=False, repr=False)

    def __post_init__(self) -> None:
        if self.clock not in ("Hz", "rad/s"):
            raise DataError(f"frequencies are told in Hz or rad/s, not in '{self.clock}'")
        if self.letter not in ("", "G", "E", "K"):
            raise DataError(f"the letter of a modulus is G, E or K, not '{self.letter}'")
        for name, table in (("stiffness", MODULUS_UNITS), ("amplitude", AMPLITUDE_UNITS)):
            given = getattr(self, name)
            if given not in table:
                # Kept as the table spells it, so that equal units compare as equal.
                object.__setattr__(self, name, known_unit(str(given), table, f"the {name}"))

    @property
    def is_modulus(self) -> bool:
        """Whether stress over strain was measured, rather than force over displacement.

        In units of the file what its names say: ``K'`` is a stiffness.
        """
        if self.stiffness == FILE_UNITS:
            return self.letter != "K"
        return self.stiffness in PRESSURE_UNITS

    @property
    def modulus(self) -> str:
        """Letter of the modulus that was measured; empty for a stiffness, or where nobody says."""
        if self.is_modulus:
            return self.letter
        return ""

    @property
    def storage(self) -> str:
        """What the part in phase is called.

        ``G'`` where the file says so, else storage modulus or stiffness.
        """
        if self.letter:
            return f"{self.letter}'"
        return f"storage {self._noun}"

    @property
    def loss(self) -> str:
        """What the part out of phase is called."""
        if self.letter:
            return f"{self.letter}''"
        return f"loss {self._noun}"

    @property
    def parts(self) -> tuple[str, str]:
        """Storage and loss as the heads of a table: ``G'`` and ``G''`` where the file says so."""
        if self.letter:
            return self.storage, self.loss
        return "storage", "loss"

    @property
    def magnitude(self) -> str:
        """What the whole is called: ``|G*|``, ``|E*|`` or, for a stiffness, ``|K|``."""
        if self.modulus:
            return f"|{self.letter}*|"
        if self.is_modulus:
            return "|G*|"
        return "|K|"

    @property
    def _noun(self) -> str:
        return "modulus" if self.is_modulus else "stiffness"

    @property
    def clock_head(self) -> str:
        """The head of a column of frequencies, as they are told."""
        return {"Hz": "frequency [Hz]", "rad/s": "omega [rad/s]"}[self.clock]

    def of_condition(self, name: str) -> str:
        """Unit of a column of what was set, a hyphen where none is known of it."""
        return {"temperature": "degC", "amplitude": self.amplitude}.get(name, "-")

    def on_clock(self, hertz: T) -> T:
        """Frequencies in Hz, in the unit in which they are told."""
        if self.clock == "rad/s":
            return hertz * FREQUENCY_UNITS["Hz"]
        return hertz

    def at(self, hertz: float, digits: int = 3) -> str:
        """A frequency in Hz as it is told: ``10 Hz`` or ``62.8 rad/s``."""
        return f"{self.on_clock(hertz):.{digits}g} {self.clock}"

    def of(self, dimension: Dimension) -> tuple[float, str]:
        """Factor and label with which a parameter of this dimension is printed.

        Parameters
        ----------
        dimension : Dimension
            Powers of stiffness, time and amplitude.

        Returns
        -------
        factor : float
            Multiplies the value in the measurement's own units.
        label : str
            The unit, such as ``kg`` or ``kN s^alpha/m``.
        """
        if dimension.label:
            return 1.0, dimension.label
        if dimension.beyond:
            return self._with_others(dimension)
        # Units that mechanics has a name for go first: kg rather than kN s^2/m.
        mechanical = self._mechanical(dimension)
        if mechanical:
            return mechanical
        return 1.0, self._plain(dimension)

    def _with_others(self, dimension: Dimension) -> tuple[float, str]:
        """``N/m K^-1``: further units behind the usual ones, each with its power."""
        own = {"stiffness": f"({self.stiffness})", "time": "s", "amplitude": self.amplitude}
        factor, label = self.of(replace(dimension, beyond=()))
        words = [] if label == "-" else [label]
        for base, power in dimension.beyond:
            unit = own.get(base, base)
            # A strain has no unit to be raised to a power.
            if unit != "-":
                words.append(_power(unit, _exponent(power)))
        return factor, " ".join(words) or "-"

    def factor_to(self, other: Units, own: str, others: str) -> float:
        """By which a stiffness in these units is more in others.

        Parameters
        ----------
        other : Units
            In which it is wanted.
        own, others : str
            What comes in the two, for the message.

        Raises
        ------
        DataError
            If one is of a stiffness and the other of a modulus, between which stands the geometry
            of a specimen, or nobody tells the unit of one of them.
        """
        here, there = self.stiffness, other.stiffness
        if here == there:
            return 1.0
        told = f"{own} is in {here} and {others} in {there}"
        if FILE_UNITS in (here, there):
            raise DataError(f"{told}: say its unit by the command in the note on it")
        if self.is_modulus != other.is_modulus:
            raise DataError(f"{told}: a stiffness is no modulus; convert one of them by --geometry")
        return MODULUS_UNITS[here] / MODULUS_UNITS[there]

    def _mechanical(self, dimension: Dimension) -> tuple[float, str] | None:
        # Of numbers that may be anything nothing is so many kilograms.
        if self.stiffness == FILE_UNITS:
            return None
        powers = (dimension.stiffness, dimension.time, dimension.amplitude)
        stiff = MODULUS_UNITS[self.stiffness]
        # A stiffness times s^2 is a mass, which nobody reads in kN s^2/m.
        if powers == (1, 2, 0):
            if self.is_modulus:
                return stiff, "kg/m"
            # What turns has a moment of inertia, no mass.
            if self.stiffness in TORSION_UNITS:
                return stiff, "kg m^2/rad^2"
            return stiff, "kg"
        if (dimension.stiffness, dimension.amplitude) == (1, 1):
            force = self._force()
            if force:
                return force[0], _with_time(force[1], dimension.time)
        # A stiffness times amplitude squared over a time is a power: its inverse is so much for
        # each watt.
        if powers == (-1, 1, -2) and (self.is_modulus or self.amplitude != "-"):
            reach = AMPLITUDE_UNITS[self.amplitude]
            per_watt = 1.0 / (stiff * reach * reach)
            return per_watt, "m^3/W" if self.is_modulus else "1/W"
        return None

    def _force(self) -> tuple[float, str] | None:
        """What stiffness times amplitude is.

        A force, a torque, or where strain was measured a stress.
        """
        if self.is_modulus and self.amplitude in STRAIN_UNITS:
            return STRAIN_UNITS[self.amplitude], self.stiffness
        # As the file has it: a force of uN in N is nothing that anybody reads.
        if self.stiffness in STIFFNESS_UNITS and self.stiffness.endswith(f"/{self.amplitude}"):
            return 1.0, self.stiffness.partition("/")[0]
        if self.stiffness in STIFFNESS_UNITS and self.amplitude in LENGTH_UNITS:
            return STIFFNESS_UNITS[self.stiffness] * LENGTH_UNITS[self.amplitude], "N"
        if self.stiffness in TORSION_UNITS and self.amplitude in ANGLE_UNITS:
            return TORSION_UNITS[self.stiffness] * ANGLE_UNITS[self.amplitude], "N m"
        return None

    def _plain(self, dimension: Dimension) -> str:
        length = ""
        # A strain has no unit to be raised to a power.
        if self.amplitude != "-":
            length = _power(self.amplitude, dimension.amplitude)
        if abs(dimension.stiffness) not in (0, 1):
            own = _with_time(_power(f"({self.stiffness})", dimension.stiffness), dimension.time)
            return f"{own} {length}".rstrip()
        if dimension.stiffness == 1:
            return self._of_stiffness(dimension, length)
        if dimension.stiffness == -1:
            return f"{_inverse(self.stiffness)} {length}".rstrip()
        if dimension.amplitude and dimension.time:
            # A speed or a rate of strain, not an angular frequency times something.
            return _with_time(length or "1", dimension.time)
        if dimension.time:
            return {1: "s", -1: "rad/s", 2: "s^2"}.get(dimension.time, f"s^{dimension.time}")  # type: ignore[call-overload, no-any-return]
        return length or "-"

    def _of_stiffness(self, dimension: Dimension, length: str) -> str:
        over, _, under = self.stiffness.partition("/")
        if under != self.amplitude:
            return f"{_with_time(self.stiffness, dimension.time)} {length}".rstrip()
        # N/mm times a power of mm is N over another power of mm, which is what a person would
        # write.
        below = _power(under, 1 - dimension.amplitude)
        if below:
            over = f"{over}/{below}"
        return _with_time(over, dimension.time)


def _inverse(unit: str) -> str:
    # Without brackets 1/kN/m could be read as a length per force or as its inverse.
    if "/" in unit or " " in unit:
        return f"1/({unit})"
    return f"1/{unit}"


def _exponent(power: Exponent) -> float | str:
    """``1-n``: a power as a person writes it; the part that a parameter belongs to is left out."""
    if len(power) == 1 and not power[0][0]:
        return power[0][1]
    if len(power) == 1 and power[0][1] == 1:
        return power[0][0].rpartition(".")[2]
    words = ""
    for name, share in sorted(power):
        word = f"{share:+g}"
        if name:
            word = word.replace("+1", "+").replace("-1", "-") if abs(share) == 1 else f"{word}*"
            word += name.rpartition(".")[2]
        words += word
    return f"({words.removeprefix('+')})"


def _power(unit: str, power: float | str) -> str:
    if power == 0:
        return ""
    if power == 1:
        return unit
    return f"{unit}^{power}"


def _with_time(unit: str, time: float | str) -> str:
    """``kN/m`` with ``alpha`` gives ``kN s^alpha/m``, as the paper prints it."""
    if time == 0:
        return unit
    power = time
    if isinstance(power, str):
        # The paper prints the order alone, without the part that it belongs to.
        power = power.rpartition(".")[2]
    if power == -1 and "/" not in unit:
        return f"{unit}/s"
    seconds = "s"
    if power != 1:
        seconds = f"s^{power}"
    over, slash, under = unit.partition("/")
    return f"{over} {seconds}{slash}{under}"


def temperature_in_celsius(value: T, unit: str) -> T:
    """Convert temperatures in ``degC``, ``K`` or ``degF`` to degrees Celsius.

    Those in Celsius stay the same bits.

    Examples
    --------
    >>> from springpot.measurement import temperature_in_celsius
    >>> temperature_in_celsius(212.0, "degF")
    100.0
    """
    if unit == "K":
        return value - KELVIN
    if unit == "degF":
        return (value - 32.0) * TEMPERATURE_UNITS["degF"]
    return value


def one_modulus(all_units: Iterable[tuple[str, Units]]) -> str:
    """The letter of the modulus that tests of these names and units have in common.

    Empty where none of them says.

    Raises
    ------
    DataError
        If they are different moduli: between them stands Poisson's ratio.
    """
    known = [(name, units.modulus) for name, units in all_units if units.modulus]
    for name, letter in known:
        first, first_letter = known[0]
        if letter != first_letter:
            raise DataError(
                f"{first} is a {MODULUS_WORDS[first_letter]} and {name} a {MODULUS_WORDS[letter]}: "
                "convert one of them by Poisson's ratio"
            )
    return next((letter for _, letter in known), "")
