"""What a user says of a file's columns (``FILE?frequency=Hz,3=loss [Pa]``), and how to ask it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from springpot.errors import DataError
from springpot.measurement import (
    FREQUENCY_UNITS,
    LENGTH_UNITS,
    MODULUS_UNITS,
    Choice,
    OpenQuestion,
    Question,
    normal_unit,
)

from .blocks import ANGLE, FREQUENCY
from .channels import with_numbers_of
from .cleaning import IGNORE, STATUS
from .names import FREQUENCIES, fold, rank, role_of
from .proposals import OR_IN_TIME, proposal, stated_unit, usual_unit
from .table import OPPOSITE
from .title_words import logarithm
from .titles import (
    SWEEPS,
    UNITS,
    USUAL,
    Heading,
    Vocabulary,
    apart_from_sign,
    is_unit,
    require_word,
    title_again,
    to_type,
)

LOG, CURVES = "log", "curves"
WHOLE = frozenset((LOG, CURVES))
"""What is said of a whole table rather than of a column.

The base of its logarithms, by what its curves differ.
"""
_CONSTANT = re.compile(r"^([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*\[?\s*([^\[\]]*?)\s*\]?$")
_MEANING = re.compile(r"^([^\[\]]+?)\s*\[([^\[\]]*)\]$")


@dataclass(frozen=True)
class Chosen:
    """Columns after what the user said.

    Parameters
    ----------
    headings : tuple of Heading
        What the columns are.
    constants : dict of str to str
        Further columns of one value: ``frequency [Hz]`` and the number.
    keeps_flagged : bool
        Whether rows are kept that the instrument itself takes back.
    overruled : tuple of str
        What the file itself says otherwise.
    """

    headings: tuple[Heading, ...]
    constants: dict[str, str]
    keeps_flagged: bool = False
    overruled: tuple[str, ...] = ()


def with_choice(headings: Sequence[Heading], choice: Choice, words: Vocabulary = SWEEPS) -> Chosen:
    """The columns with the units and meanings that the user gives.

    Raises
    ------
    DataError
        If there is no such column, or what is said of it is neither a unit nor a meaning.
    """
    columns, constants = list(headings), {}
    named: set[int] = set()
    for name, meaning in choice.columns.items():
        if (name, meaning) == (STATUS, IGNORE):
            continue
        if name == LOG:
            columns = [_with_base(each, meaning) for each in columns]
        if name in WHOLE:
            continue
        role = _role(name, words)
        # 1/Pa is a unit, and no value of one per pascal.
        constant = None if is_unit(meaning) else _CONSTANT.match(meaning)
        # A column that is called by its number is one of the file's, whatever is said of it.
        if constant is not None and not name.isdigit():
            if role is not None:
                if not constant[2]:
                    _require_no_unit(role, name, constant[1])
                constants[f"{role} [{constant[2]}]"] = constant[1]
                continue
            # A plain number of a column that the file lacks, such as that of a batch.
            if constant[2] == "-" and not any(fold(name) == fold(each.name) for each in headings):
                constants[f"{name} [-]"] = constant[1]
                continue
        # By the file's own words: storage and loss can be exchanged in one line.
        place = _place(headings, name, meaning, words)
        columns[place] = as_said(columns[place], meaning, words)
        named.add(place)
    meant = {str(columns[place].role) for place in named} | {
        title.partition(" ")[0] for title in constants
    }
    # Of two columns that seem to be one thing, the one that was named is meant, and a constant goes
    # before any.
    spare = [
        place
        for place, each in enumerate(columns)
        if place not in named and _same(str(each.role), meant)
    ]
    differences = [_difference(headings, place, columns[place]) for place in sorted(named)]
    overruled = [note for note in differences if note]
    overruled += [
        f"'{headings[place].title}' is not used as {headings[place].role}, as you said"
        for place in spare
    ]
    for place in spare:
        # Without a name it is no further condition either.
        columns[place] = replace(columns[place], role=None, name="")
    return Chosen(tuple(columns), constants, choice.columns.get(STATUS) == IGNORE, tuple(overruled))


def _require_no_unit(role: str, name: str, value: str) -> None:
    if "-" in UNITS.get(role, "-"):
        return
    said = f"{name}={value}[{usual_unit(role, name)}]"
    raise DataError(f"'{name}={value}' has no unit: open 'FILE?{said}', or with another unit in it")


def _role(name: str, words: Vocabulary) -> str | None:
    """The role that a user names; springpot's own words before any title that looks like one."""
    if name in words.said:
        return name
    return words.role(name)


def _same(role: str, meant: set[str]) -> bool:
    """Whether a role is among those, where all frequencies are one."""
    return role in meant or (role in FREQUENCIES and bool(meant & FREQUENCIES))


def _difference(headings: Sequence[Heading], place: int, after: Heading) -> str:
    """What the file says of a column that the user reads otherwise; empty where it is silent."""
    before = headings[place]
    if before.role is None and after.role is not None and title_again(headings, before.title):
        return (
            f"'{before.title}' stands above several columns, of which number {place + 1} is taken"
        )
    if before.role is not None and after.role != before.role:
        return (
            f"'{before.title}' is {after.role or 'ignored'} as you said; its name says"
            f" {before.role}"
        )
    if (
        before.unit is not None
        and after.unit is not None
        and normal_unit(before.unit) != normal_unit(after.unit)
    ):
        return f"'{before.title}' is in {after.unit} as you said; the file says {before.unit}"
    return ""


def _with_base(heading_: Heading, base: str) -> Heading:
    """A column of logarithms whose base the user says."""
    if base not in ("10", "e"):
        raise DataError(f"the base of logarithms is 10 or e, not '{base:.20}'; write 'FILE?log=10'")
    if heading_.written != "?":
        # Plain numbers, or a title that says the base itself.
        return heading_
    return replace(heading_, written=base)


def _place(headings: Sequence[Heading], name: str, meaning: str, words: Vocabulary) -> int:
    """Where the column is that is called by number, title, name or role."""
    if name.isdigit() and len(name) < 6 and 1 <= int(name) <= len(headings):
        return int(name) - 1
    role = _role(name, words)
    # A number may belong to a symbol, such as G2 for a loss; else it is that of a sensor.
    symbol = role_of(name) is not None
    # The exact word first: titles that differ in case alone, such as g' and G', are told apart by
    # it.
    tests: tuple[Callable[[Heading], bool], ...] = (
        lambda h: h.title == name or h.name == name or words.heading(h.title).name == name,
        lambda h: fold(h.title) == fold(name) or fold(h.name) == fold(name),
        lambda h: (
            role is not None and h.role == role and (symbol or with_numbers_of(name, h.title))
        ),
    )
    for test in tests:
        places = [i for i, heading in enumerate(headings) if test(heading)]
        if len(places) > 1 and test is tests[-1] and not any(headings[i].unit for i in places):
            # Nothing is taken of them without the hint.
            shown = " or ".join(f"{i + 1}, '{headings[i].title}'" for i in places[:4])
            instead = f"write {places[0] + 1}={meaning:.40} or another number in its place"
            raise DataError(f"'{name:.40}' may be column {shown}; {instead}")
        if places:
            # Of several the one that would be taken without the hint: that says more of it, and
            # never another.
            return min(places, key=lambda i: doubt(headings[i], words))
    shown = ", ".join(heading.title or str(i) for i, heading in enumerate(headings[:12], 1))
    raise DataError(f"no column '{name:.40}' (there are: {shown}, or numbers 1 to {len(headings)})")


def doubt(heading_: Heading, words: Vocabulary = SWEEPS) -> tuple[bool, int]:
    """How unsure it is that a column is the one meant.

    Least for a known name with a unit of its quantity.
    """
    units = words.units.get(str(heading_.role))
    # A sensor in volts stands beside the calibrated one.
    foreign = (
        bool(units)
        and heading_.unit is not None
        and normal_unit(heading_.unit) not in (units or ())
    )
    return foreign, rank(heading_.name)


def as_said(heading_: Heading, meaning: str, words: Vocabulary) -> Heading:
    """A column of which a user says unit or meaning.

    Raises
    ------
    DataError
        If it is neither.
    """
    base, taken = "", logarithm(meaning)
    if taken and taken[0] != "?":
        base, meaning = taken
    match = _MEANING.match(meaning)
    name, unit = meaning, heading_.unit
    if match:
        name, (sign, unit) = match[1].strip(), apart_from_sign(match[2])
        if sign < 0.0:
            base = OPPOSITE
    elif is_unit(meaning) and meaning not in words.said:
        return replace(heading_, unit=meaning, written=base or heading_.written)
    elif is_unit(apart_from_sign(meaning)[1]) and not heading_.written:
        return replace(heading_, unit=apart_from_sign(meaning)[1], written=OPPOSITE)
    require_word(meaning)
    role = _role(name, words)
    if role is None and name not in ("ignore", "none"):
        roles = (
            "omega, frequency, storage, loss, magnitude, phase, loss_factor, amplitude, repeat,"
            " temperature"
        )
        if words is not SWEEPS:
            roles = ", ".join(words.units)
        raise DataError(f"'{meaning:.40}' is neither a unit nor one of {roles}, ignore")
    if role is None:
        # Without a name it is no further condition either.
        name = ""
    return Heading(heading_.title, name, role, unit, written=base or heading_.written)


def ask_units(headings: Iterable[Heading]) -> OpenQuestion:
    """The question for the units that are missing."""
    missing = [heading for heading in headings if heading.role]
    message = f"{_without_unit(missing)}; {_units_if(missing)}"
    units = _usual_units(missing)
    return OpenQuestion(message, [_unit_of(heading, units) for heading in missing])


def in_hertz(heading_: Heading) -> str:
    """The note that a frequency is taken in Hz, and how to say that it is an angular one."""
    return (
        f"{_without_unit([heading_])}: Hz is taken; if it is rad/s, open 'FILE?frequency=rad/s',"
        " or write omega [rad/s] in it"
    )


def in_units_of_file(headings: Sequence[Heading]) -> str:
    """The note that moduli are taken in the file's own units, and how to say others."""
    return f"{_without_unit(headings)}: all is told in the file's units; {_units_if(headings)}"


def _without_unit(missing: Sequence[Heading]) -> str:
    names = ", ".join(f"'{heading.title}'" for heading in missing)
    return f"{names} {'have' if len(missing) > 1 else 'has'} no unit"


def _usual_units(missing: Sequence[Heading]) -> dict[str, str]:
    """The usual unit of each role; storage and loss have one, whichever of their titles tells."""
    units = {str(heading.role): usual_unit(str(heading.role), heading.title) for heading in missing}
    alike = [role for role in ("storage", "loss", "magnitude") if role in units]
    told = [units[role] for role in alike if units[role] != USUAL[role]]
    if told:
        units |= dict.fromkeys(alike, told[0])
    return units


def _units_if(missing: Sequence[Heading]) -> str:
    """How the usual units of some columns are said."""
    units = _usual_units(missing)
    given = ",".join(f"{role}={unit}" for role, unit in units.items())
    they_are = "they are" if len(missing) > 1 else "it is"
    write = f"{missing[0].title} [{units[str(missing[0].role)]}]"
    if any(heading.role == "frequency" for heading in missing):
        # Hz and rad/s differ by 2 pi, and a bare "frequency" may be either: both are offered.
        write = "frequency [Hz] or omega [rad/s]"
    usual = " and ".join(dict.fromkeys(units.values()))
    return f"if {they_are} {usual}, open 'FILE?{given}', or write {write} in it"


def _unit_of(heading_: Heading, units: Mapping[str, str]) -> Question:
    role = str(heading_.role)
    return Question.of_unit(role, units[role], UNITS.get(role, ()))


def ask_base(headings: Iterable[Heading]) -> OpenQuestion:
    """The question for the base of logarithms, and for the units that are missing as well."""
    logarithms = list(headings)
    unsure = ", ".join(f"'{heading.title}'" for heading in logarithms if heading.written == "?")
    # An omega is in rad/s by its name, so that no unit is asked for.
    bare = [
        heading
        for heading in logarithms
        if heading.unit is None and heading.role in {*USUAL} - {"omega"}
    ]
    given = ",".join(
        ["log=10", *(f"{heading.role}={USUAL[str(heading.role)]}" for heading in bare)]
    )
    units = ""
    if bare:
        usual = dict.fromkeys(USUAL[str(heading.role)] for heading in bare)
        units = f" and units {', '.join(usual)}"
    message = (
        f"{unsure}: logarithms to base 10 or e? For base 10{units} open 'FILE?{given}', or write"
        " log10 or ln in it"
    )
    base = Question(LOG, "base", {"10": f"{LOG}=10", "e": f"{LOG}=e"})
    of_each = _usual_units(bare)
    return OpenQuestion(message, [base, *(_unit_of(heading, of_each) for heading in bare)])


MEANINGS = (
    *("omega[rad/s]", "frequency[Hz]"),
    *("storage[Pa]", "loss[Pa]", "storage[kPa]", "loss[kPa]", "storage[MPa]", "loss[MPa]"),
    *("storage[kN/m]", "loss[kN/m]", "storage[N/mm]", "loss[N/mm]"),
    *("temperature[degC]", "amplitude[mm]", "amplitude[%]", "repeat", "ignore"),
)
"""What a column may be whose name says nothing, in the units that instruments write most."""
FIRST_COLUMNS = ("omega[rad/s]", "storage[Pa]", "loss[Pa]")
"""The order in which most programs write them; weights may follow."""


def ask_meaning(
    says: str, block_lacks: str, headings: Sequence[Heading], untitled: Sequence[int] = ()
) -> DataError:
    """The error of a table that lacks something, with how to say it where that would mend it.

    A hint must not lead to wrong numbers without a word when it is typed as it stands: it says what
    it assumes. Columns that are `untitled` and hold numbers are known by their number, from 1.
    """
    if block_lacks == f"missing {FREQUENCY}":
        return _ask_frequency(says, headings, untitled)
    moduli = [each for each in headings if each.role is None and stated_unit(each) in MODULUS_UNITS]
    if block_lacks == "missing storage [unit] or magnitude [unit]" and moduli:
        return _ask_which_modulus(says, moduli, headings)
    # A length that nobody names may be the amplitude, but also a gap: it is asked for, not taken.
    moved = next(
        (
            i
            for i, h in enumerate(headings, 1)
            if not h.role and normal_unit(h.unit or "") in LENGTH_UNITS
        ),
        0,
    )
    if block_lacks.endswith("of the displacement") and moved:
        title, unit = called(headings, moved), normal_unit(headings[moved - 1].unit or "")
        spec = f"{to_type(headings, moved)}=amplitude[{unit}]"
        says = f"{says}; if {title} is it, counted from the middle, open 'FILE?{spec}'"
        return OpenQuestion(says, [Question("amplitude", "column", {title: spec})])
    unknown = {key: title for key, title in unknown_in(headings).items() if title}
    if not unknown and block_lacks.endswith(ANGLE):
        return DataError(f"{says}; {_how_to_add(block_lacks)}")
    if not block_lacks.startswith("missing") or not unknown:
        return DataError(says)
    if hint := proposal(headings):
        says = f"{says}; {hint}"
    return OpenQuestion(says, ask_each(unknown))


def _how_to_add(block_lacks: str) -> str:
    """What to do where only the size of a modulus was exported, and perhaps no frequency."""
    if FREQUENCY not in block_lacks:
        return "export the phase angle as well, as a column phase [deg]"
    return (
        "export the phase angle and the frequency as well, as columns phase [deg] and frequency"
        " [Hz]; a frequency that is the same in all rows may be said instead, by"
        " 'FILE?frequency=1[Hz]'"
    )


_SWEPT = frozenset(
    {"amplitude", "temperature", "time", "stress", "torque", "displacement", "repeat"}
)
"""What is swept at one frequency."""


def _ask_frequency(says: str, headings: Sequence[Heading], untitled: Sequence[int]) -> OpenQuestion:
    """The question for the frequency: which column holds it, or that it is the same in all rows."""
    clock = next(
        (i for i, h in enumerate(headings, 1) if normal_unit(h.unit or "") in FREQUENCY_UNITS), None
    )
    if clock is not None:
        unit = normal_unit(headings[clock - 1].unit or "")
        spec = f"{to_type(headings, clock)}=frequency[{unit}]"
        title = called(headings, clock)
        says = f"{says}; if {title} is it, open 'FILE?{spec}'"
        return OpenQuestion(says, [Question("frequency", "column", {title: spec})])
    same = Question("frequency", "constant", {"1 Hz": "frequency=1[Hz]"})
    unknown = {key: title for key, title in unknown_in(headings).items() if title}
    unknown |= {str(number): called(headings, number) for number in untitled}
    # A constant is the nearest answer only where something else is swept: a column that nobody
    # knows may be the frequency, and a constant in its place would be wrong without a word.
    if not unknown or any(each.role in _SWEPT for each in headings):
        return OpenQuestion(
            f"{says}; if it is 1 Hz in all rows, open 'FILE?frequency=1[Hz]'", [same]
        )
    place, title = next(iter(unknown.items()))
    hint = f"if {title} is it, in Hz, open 'FILE?{place}=frequency[Hz]'"
    hint += ", if it is 1 Hz in all rows, 'FILE?frequency=1[Hz]'"
    columns = {title: f"{place}=frequency[Hz]" for place, title in unknown.items()}
    return OpenQuestion(f"{says}; {hint}", [Question("frequency", "column", columns)])


def ask_clock(title: Heading, place: int) -> OpenQuestion:
    """The question whether a column of relaxation times is the clock of a test."""
    spec = f"{place}=time[{stated_unit(title) or 's'}]"
    says = (
        f"'{title.title}' and what belongs to each are the terms of a Prony series: a model, no"
        f" measurement; if it is the clock of a test, open 'FILE?{spec}'"
    )
    return OpenQuestion(says, [Question(title.title, "column", {"time": spec})])


def _ask_which_modulus(
    says: str, moduli: Sequence[Heading], headings: Sequence[Heading]
) -> OpenQuestion:
    """The question whether a modulus beside a loss angle is the magnitude or the part in phase.

    With a second one it may be the first of both parts, unless curves stand side by side.
    """

    def spec(each: Heading, role: str) -> str:
        return f"{to_type(headings, headings.index(each) + 1)}={role}[{stated_unit(each)}]"

    first, unit = moduli[0], stated_unit(moduli[0])
    whole, part, beside = spec(first, "magnitude"), spec(first, "storage"), ""
    names = [each.title for each in headings]
    if len(moduli) > 1 and len({*names}) == len(names):
        part += f",{spec(moduli[1], 'loss')}"
        beside = f" and {moduli[1].title} that out of phase"
    hint = (
        f"; if {first.title} is the whole one, open 'FILE?{whole}', if it is the part in"
        f" phase{beside}, 'FILE?{part}'"
    )
    asked = {f"magnitude[{unit}]": whole, f"storage[{unit}]": part}
    return OpenQuestion(f"{says}{hint}", [Question(first.title, "meaning", asked)])


LOOP = (
    "of which the first goes back and forth, as a displacement does; of a loop say how many samples"
    " there are a second, such as 'FILE?1=displacement[mm],2=force[N],rate=100[Hz]', or strain[-]"
    " and stress[Pa]"
)
"""What columns are that no clock and no frequency leads."""

CLOCK = "of which the first begins at 0, as a time does"
"""What columns are that a clock leads."""


def ask_columns(
    count: int, leading: str = "", separator: str = ",", first: int = 1
) -> OpenQuestion:
    """The question for columns that have no names.

    The first of them may be LOOP or CLOCK; another one, `first`, may be what was set.
    """
    order = [first, *(i for i in range(1, count + 1) if i != first)]
    usual = FIRST_COLUMNS
    places = zip(order, FIRST_COLUMNS, strict=False)
    spec = f"'FILE?{','.join(f'{i}={each}' for i, each in places)}'"
    message = f"{count} columns of numbers without names"
    if first != 1:
        message += f", of which number {first} goes in even steps, as what is set does"
    if leading == LOOP and first == 1:
        message += f", {LOOP}"
        if count > 2:
            message += f"; of a sweep open {spec}"
    elif leading == CLOCK:
        usual = ("time[s]", "displacement[mm]", "force[N]")
        message += f", {CLOCK}"
        if count > 2:
            message += (
                "; say what the others are, such as 'FILE?1=time[s],2=displacement[mm],3=force[N]',"
                " or strain[-] and stress[Pa]"
            )
        message += OR_IN_TIME
    elif count > 2:
        message += f"; say what they are, such as {spec}"
        if count > 3:
            message += "; further columns, such as weights, are left out"
        message += OR_IN_TIME
    else:
        # Storage and loss often stand one below the other, as a program for graphs writes them.
        between = {"\t": "<TAB>", ",": ", "}.get(separator, separator)
        message += (
            ", where frequency, storage and loss are needed; of tables one below the other write a"
            f' line of titles above each, such as "frequency [Hz]{between}G\' [Pa]"{OR_IN_TIME}'
        )
    message = message.replace("FIRST", str(order[0])).replace("SECOND", str(order[1]))
    return OpenQuestion(message, ask_each({str(i): f"column {i}" for i in order}, usual))


def called(headings: Sequence[Heading], number: int) -> str:
    """How a column is called, by its number from 1 where it has no title."""
    return headings[number - 1].title or f"column {number} (without a title)"


def all_called(headings: Sequence[Heading], untitled: Sequence[int]) -> list[str]:
    """How columns are called, less those that neither have a title nor hold numbers."""
    numbers = [i for i, each in enumerate(headings, 1) if each.title or i in untitled]
    return [called(headings, number) for number in numbers]


def unknown_in(headings: Sequence[Heading]) -> dict[str, str]:
    """The titles of the columns that nobody knows, by what is typed for them."""
    return {to_type(headings, i): h.title for i, h in enumerate(headings, 1) if h.role is None}


def ask_each(columns: Mapping[str, str], usual: Sequence[str] = ()) -> list[Question]:
    """What each of these columns is, by what is typed for it.

    Without a usual meaning it is left out unless somebody says.
    """
    questions = []
    # Left out unless somebody says what it is: a guess would become data.
    first_answers = [*usual, *["ignore"] * len(columns)]
    for (typed, name), first in zip(columns.items(), first_answers, strict=False):
        questions.append(
            Question(name, "meaning", {each: f"{typed}={each}" for each in [first, *MEANINGS]})
        )
    return questions


def numbered(count: int) -> tuple[Heading, ...]:
    """Headings of columns without names."""
    return tuple(Heading(str(i), str(i), None, None) for i in range(1, count + 1))
