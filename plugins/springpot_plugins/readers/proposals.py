"""What to type for columns that nobody knows.

Commands that open the file as they stand, and say what they assume.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence

from springpot.measurement import (
    FILE_UNITS,
    FORCE_UNITS,
    LENGTH_UNITS,
    TEMPERATURE_UNITS,
    Choice,
    Measurement,
    near_units,
    normal_unit,
    temperature_in_celsius,
)
from springpot.rheology import KELVIN, Real

from .names import FREQUENCIES, fold
from .title_words import without_peak, without_swing
from .titles import UNITS, USUAL, Heading, to_type

COLUMN_OF_AMPLITUDE, COLUMN_OF_TEMPERATURE = (
    "note column of amplitude",
    "note column of temperature",
)
"""Keys of the notes in a measurement's provenance."""
OR_IN_TIME = (
    "; of a test in time 'FILE?FIRST=time[s],SECOND=relaxation[Pa]', or compliance[1/Pa], or"
    " both displacement[mm] and force[N], or strain[-] and stress[Pa]"
)
"""What else columns may be whose names say nothing."""
_SPECIAL = re.compile(r"[^\w ]")
"""What a name in a hint may not hold."""
_MOST = 2
"""Columns that a note offers for one condition: a longer list is no help."""
_IGNORED = ("", "ignore", "none")
"""Names of columns of which the user said that they are nothing."""
_WHOLE = frozenset({"storage", "magnitude"})
_ANGLES = frozenset({"phase", "loss_factor", "damping_ratio", "damping"})
_STRAINS = frozenset({"%", "m/m", "mm/mm", "strain"})
"""Units of a strain that are written out; a mere number may be anything."""
_BEHIND = re.compile(r".(?:\s*[,/]\s*|\s+in\s+)\(?([^\s,()]+)\)?\Z")
_STIFF = re.compile(
    r"\A(?-i:[Kkc])(?:dyn|[a-z]?(?![a-z]))|stiff|steif|raideur|rigid|spring|feder", re.IGNORECASE
)
"""Names of a stiffness; a modulus is nearly always in Pa."""
_MOVED = re.compile(r"disp|weg|deflect|stroke|deplac|déplac|desplaz|spost|verschieb", re.IGNORECASE)
"""Names of an amplitude that is a length, and no strain."""
_MODULUS = re.compile(
    rf"{_STIFF.pattern}|\A(?-i:[GEM])[a-z]?(?![a-z])|modul|storage|loss|speicher|verlust",
    re.IGNORECASE,
)
_OF_SIGNALS = re.compile(r"(?:[mu]?V|mA|counts?|cts|digits?|bits?|LSB|-)(?:/|\Z)", re.IGNORECASE)
"""A unit of signals that nobody calibrated: volts, counts, or one over the other."""
_LOOKS_LIKE = {
    "frequency": re.compile(r"\A(?:f|w|ω)(?![a-z])|freq|omega|puls|hertz", re.IGNORECASE),
    "storage": _MODULUS,
    "loss": _MODULUS,
    "phase": re.compile(r"phas|angle|winkel", re.IGNORECASE),
}
_TYPED = re.compile(r"[^\W\d_][\w .%°/-]*\Z")
"""Names that may stand in ``FILE?NAME=...`` within quotes; others go by their number."""
_OTHER_LENGTHS = (
    *(
        "gap",
        "spalt",
        "thick",
        "dicke",
        "height",
        "höhe",
        "width",
        "breite",
        "length",
        "länge",
        "diam",
        "radius",
    ),
    *(
        "durchmesser",
        "stärke",
        "humid",
        "feucht",
        "moisture",
        "content",
        "gehalt",
        "conc",
        "konz",
        "fraction",
    ),
    *(
        "anteil",
        "füllgrad",
        "filler",
        "damp",
        "dämpf",
        "error",
        "fehler",
        "devia",
        "abweich",
        "uncert",
        "unsicher",
        "mean",
        "mittel",
    ),
    *(
        "static",
        "stati",
        "preload",
        "prestrain",
        "vorlast",
        "vorverform",
        "offset",
        "minim",
        "maxim",
        "position",
    ),
    *(
        "harmonic",
        "distortion",
        "noise",
        "quality",
        "gauge",
        "loss",
        "factor",
        "faktor",
        "roughness",
        "power",
    ),
)
"""What a length or a percentage that is no amplitude is called, whole or in part."""
_OTHER_TEMPERATURES = (
    *(
        "rise",
        "differ",
        "delta",
        "gradient",
        "rate",
        "devia",
        "abweich",
        "uncert",
        "error",
        "fehler",
        "toleran",
    ),
    *("glass", "refer", "anstieg", "erhöhung", "elevation", "std"),
)
_OTHER_WORDS = frozenset(
    (
        "rh",
        "err",
        "sd",
        "std",
        "min",
        "max",
        "avg",
        "rms",
        "pre",
        "ref",
        "tg",
        "d",
        "δt",
        "dt",
        "thd",
    )
)
"""The same as whole words: of a root mean square the amplitude is another multiple."""


def proposal(headings: Sequence[Heading]) -> str:
    """``if 'K1' is storage [N/mm] and ..., open 'FILE?2=storage[N/mm],...'``.

    A command that works as it stands.

    A column is proposed only by its unit or a name that looks like one of a modulus; of columns
    that could be anything a command says ``NAME``, so that it gives no numbers before the user has
    chosen.

    Parameters
    ----------
    headings : sequence of Heading
        The columns of a table that lacks a frequency or a modulus.
    """
    unknown = {
        place: each for place, each in enumerate(headings, 1) if each.title and each.role is None
    }
    needed = _needed({str(each.role) for each in headings})
    given = next((stated_unit(each) for each in headings if each.role in ("storage", "loss")), "")
    assumed, said, has_example = [], [], False
    for number, each in enumerate(headings, 1):
        # A known column without its unit would only be asked for next.
        if needed and each.role in FREQUENCIES and not stated_unit(each):
            unit, has_example = usual_unit(str(each.role), each.title), True
            assumed.append(f"'{each.title}' is {each.role} [{unit}]")
            said.append(f"{to_type(headings, number)}={each.role}[{unit}]")
    for role in needed:
        place = _likeliest(role, unknown)
        if place is None and role == "loss":
            # An angle beside a modulus gives its loss as well.
            role, place = "phase", _likeliest("phase", unknown)
        if place is None:
            return _with_names(needed, unknown)
        each = unknown.pop(place)
        unit = stated_unit(each)
        if unit not in UNITS[role]:
            unit, has_example = _example(role, each.title, given), True
        if role == "storage":
            given = unit
        assumed.append(f"'{each.title}' is {role} [{unit}]")
        said.append(f"{to_type(headings, place)}={role}[{unit}]")
    if not said:
        return ""
    other_unit = ""
    if has_example:
        other_unit = ", or with another unit in the brackets"
    return f"if {' and '.join(assumed)}, open 'FILE?{','.join(said)}'{other_unit}"


def _with_names(needed: Sequence[str], unknown: Mapping[int, Heading]) -> str:
    """The proposal where nothing tells which column is which."""
    if not unknown:
        return ""
    if len(needed) == 3 and (loop := _of_loop(unknown)):
        return loop
    pair = list(dict.fromkeys(each.title for each in unknown.values()))
    if len(pair) == 2 < len(unknown) and not any(map(_SPECIAL.search, pair)):
        # Curves side by side, whose columns have the same two names: tests in time.
        first, second = pair
        return "say what they are" + OR_IN_TIME.replace("FIRST", first).replace("SECOND", second)
    spec = ",".join(f"NAME={role}[{USUAL[role]}]" for role in needed)
    says = f"say which, with their names or numbers and units, such as 'FILE?{spec}'"
    if {"frequency", "storage", "loss"} <= {*needed}:
        says += OR_IN_TIME.replace("FIRST", "NAME").replace("SECOND", "NAME")
    return says


def _of_loop(unknown: Mapping[int, Heading]) -> str:
    """The proposal where one column is a length and one a force, with no clock beside them."""
    said = []
    for role, units in (("displacement", LENGTH_UNITS), ("force", FORCE_UNITS)):
        alike = [place for place, each in unknown.items() if stated_unit(each) in units]
        if len(alike) != 1:
            return ""
        said.append(f"{alike[0]}={role}[{stated_unit(unknown[alike[0]])}]")
    return (
        "of a loop say how many samples there are a second, such as"
        f" 'FILE?{','.join(said)},rate=100[Hz]'"
    )


def _needed(roles: set[str]) -> list[str]:
    """What a table with these columns lacks to be a dynamic test."""
    needed = []
    if not roles & FREQUENCIES:
        needed.append("frequency")
    if not roles & _WHOLE:
        needed.append("storage")
    if not roles & {"loss", *_ANGLES}:
        needed.append("loss")
    return needed


def _likeliest(role: str, unknown: Mapping[int, Heading]) -> int | None:
    """The first column with a unit of this role, else the first without one that is named alike."""
    looks = _LOOKS_LIKE[role]
    fits = [place for place, each in unknown.items() if stated_unit(each) in UNITS[role]]
    alike = [
        place
        for place, each in unknown.items()
        if not stated_unit(each) and looks.search(each.title)
    ]
    return next(iter([*fits, *alike]), None)


def _example(role: str, title: str, given: str) -> str:
    # Storage and loss have one unit in nearly all tables.
    if role in ("storage", "loss") and given in UNITS[role]:
        return given
    return usual_unit(role, title)


def unit_proposal(roles: Sequence[str], title: str, written: str) -> str:
    """What to type for a unit that nobody knows, in which columns of these roles are."""
    first = roles[0]
    near = [unit for unit in near_units(written, UNITS[first]) if unit != FILE_UNITS]
    of_signals = FILE_UNITS in UNITS[first] and _OF_SIGNALS.match(written)
    if not near or near[0].lower() != normal_unit(written).lower():
        near = list(dict.fromkeys([usual_unit(first, title), *near]))
    cases = {unit: f"it is {unit}" for unit in near[:_MOST]}
    if of_signals:
        cases[FILE_UNITS] = "the channels are not calibrated"
    said = []
    for unit, case in cases.items():
        # A force and a displacement may both be in volts: of these a newton is one of the two.
        options = ",".join(f"{role}={unit}" for role in roles if unit in UNITS[role])
        said.append(f"if {case}, open 'FILE?{options}'")
    return "; ".join(said)


def usual_unit(role: str, title: str) -> str:
    """The unit to write in an example for a column of that title."""
    if role in ("storage", "loss", "magnitude") and _STIFF.search(title):
        return "N/mm"
    if role == "amplitude" and _MOVED.search(title):
        return "mm"
    return USUAL.get(role, next(iter(UNITS.get(role, {"UNIT": 1.0}))))


def stated_unit(heading: Heading) -> str:
    """The unit of a title, also behind a comma or a stroke; empty where there is none."""
    if heading.unit is not None:
        return normal_unit(heading.unit)
    match = _BEHIND.search(heading.title)
    if match is None:
        return ""
    return normal_unit(match[1])


def offers(measurement: Measurement, headings: Sequence[Heading], choice: Choice) -> dict[str, str]:
    """Notes that ask whether an unknown column is the amplitude or the temperature that lacks.

    Parameters
    ----------
    measurement : Measurement
        The data, in which such a column is a further condition.
    headings : sequence of Heading
        The columns of the file.
    choice : Choice
        What the user said already, which is to be said again.
    """
    notes = {}
    if "amplitude" not in measurement.conditions:
        notes[COLUMN_OF_AMPLITUDE] = _offer(
            measurement, headings, choice, "amplitude", "the amplitude", _may_be_amplitude
        )
    if "temperature" not in measurement.conditions:
        notes[COLUMN_OF_TEMPERATURE] = _offer(
            measurement,
            headings,
            choice,
            "temperature",
            "the temperature of the specimen",
            _may_be_temperature,
        )
    return {key: note for key, note in notes.items() if note}


def _offer(
    measurement: Measurement,
    headings: Sequence[Heading],
    choice: Choice,
    role: str,
    what: str,
    may_be: Callable[[Heading, Real], str],
) -> str:
    offered: list[str] = []
    for place, each in enumerate(headings, 1):
        values = measurement.conditions.get(condition_name(each))
        if each.role is not None or each.name in _IGNORED or values is None:
            continue
        unit = may_be(each, values)
        if unit and len(offered) < _MOST:
            meaning = f"{_called(place, headings)}={role}[{unit}]"
            offered.append(
                f"if '{each.title}' is {what}{_from_where(each, unit)}, open"
                f" '{_again(choice, meaning)}'"
            )
    return "; ".join(offered)


def _from_where(heading: Heading, unit: str) -> str:
    """What a length is taken for that does not say from where it counts."""
    if unit in LENGTH_UNITS and without_swing(heading.title) == heading.title:
        return ", counted from the middle"
    return ""


def condition_name(heading: Heading) -> str:
    """The name of a further condition that a column becomes."""
    return re.sub(r"[\s-]+", "_", heading.name.strip().lower())


def _may_be_amplitude(heading: Heading, values: Real) -> str:
    """The unit if a column may hold an amplitude, otherwise nothing."""
    written = heading.unit or ""
    unit = normal_unit(without_peak(written))
    if not heading.unit:
        unit = stated_unit(heading)
    is_length = unit in LENGTH_UNITS or unit == "%" or written in _STRAINS
    if not is_length or _says(heading.title, _OTHER_LENGTHS) or not (values > 0).all():
        return ""
    if without_peak(written) != written:
        # From where it counts stands in the unit, and is read there again.
        return written
    return unit


def _may_be_temperature(heading: Heading, values: Real) -> str:
    unit = stated_unit(heading)
    if unit not in TEMPERATURE_UNITS or _says(heading.title, _OTHER_TEMPERATURES):
        return ""
    if not (temperature_in_celsius(values, unit) >= -KELVIN).all():
        return ""
    return unit


def _says(title: str, parts: Sequence[str]) -> bool:
    """Whether one of the words of a title is another quantity's, or holds one."""
    words = re.findall(r"[^\W\d_]+", title.casefold())
    return any(word in _OTHER_WORDS or any(part in word for part in parts) for word in words)


def _called(place: int, headings: Sequence[Heading]) -> str:
    """What to type for a column: its name where it can be typed and is its own, else its number."""
    name = headings[place - 1].name
    alike = [
        each for each in headings if fold(each.name) == fold(name) or fold(each.title) == fold(name)
    ]
    if _TYPED.match(name) and len(alike) == 1:
        return name
    return str(place)


def _again(choice: Choice, meaning: str) -> str:
    """``FILE#2?frequency=Hz,Foo=amplitude[mm]``: what was said before, and this."""
    part = ""
    if choice.part:
        part = f"#{choice.part}"
    said = [f"{name}={each}" for name, each in choice.columns.items()]
    return f"FILE{part}?{','.join([*said, meaning])}"
