"""Any table of a test in time.

CSV, RheoCompass, TRIOS, MTS, with names and units in many languages.

What was tested is read off the columns: ``time [s]`` with ``relaxation [kPa]``, ``compliance
[1/kPa]``, or displacement and force (strain and stress, angle and torque), of which the record is
then taken as it is, its real ramp included. What a file leaves open is said behind it:
``FILE?time=s,relaxation=Pa,temperature=160[degC],ramp=0.05[s],control=force``, and of a channel
that counts the other way ``FILE?force=-N``.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from springpot.errors import DataError
from springpot.measurement import (
    TEMPERATURE_UNITS,
    TIME_UNITS,
    Choice,
    TimeReader,
    TimeTest,
    known_unit,
    normal_unit,
    temperature_in_celsius,
)
from springpot.measurement.from_signals import stiffness_unit
from springpot.measurement.sign import sign_note
from springpot.measurement.timetest import CONTROLS
from springpot.rheology import Real

from ..readers.blocks import blocks_of
from ..readers.channels import UNITS
from ..readers.grid import Grid, grid_of, head_grid
from ..readers.moduli import letter_of
from ..readers.names import fold
from ..readers.text import head_text, text_of
from ..readers.titles import apart_from_sign, is_unit
from .lacking import EXAMPLES, lacking
from .sections import Section, Title, apart, sections_of, title_of

ANSWERS = ("relaxation", "compliance", "force")
"""Columns whose titles tell which modulus it is of."""
STEADY = 0.5
"""Kelvin by which a temperature may wander and still be one."""
MOST_TIED = 0.5
"""Share of rows that may repeat the printed time of the row before.

More is no rounding, but another table.
"""
ENOUGH = 20
"""Rows of a table from which such repeats are taken for rounding."""
_CONSTANT = re.compile(r"^([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*\[([^\]]*)\]$")
_MEANING = re.compile(r"^([^\[\]]+?)\s*\[([^\[\]]*)\]$")


@dataclass(frozen=True)
class Manner:
    """What a user says of a test as a whole.

    Parameters
    ----------
    control : str, optional
        Which channel was imposed.
    ramp : float, optional
        Seconds that a step took; None where nobody says so.
    temperature : float, optional
        In degC.
    planned : bool
        Whether the answer may be missing, since it is to be predicted (``answer=none``).
    """

    control: str | None = None
    ramp: float | None = None
    temperature: float | None = None
    planned: bool = False


def recognises(head: bytes) -> float:
    """High for a table that names a time and what was measured, unless it names frequencies too."""
    text = head_text(head)
    sections = sections_of(text)
    # A sweep may list time, force and displacement of each of its points.
    if any("dynamic" in section.roles for section in sections):
        return 0.0
    if not any(map(_is_test, sections)) or _holds_sweep(head_grid(text)):
        return 0.0
    return 0.9


def _holds_sweep(grid: Grid) -> bool:
    """Whether any table is a sweep.

    Of a job with a pre-shear or a rest, the sweep is what is meant.
    """
    try:
        return any(block.is_dynamic for block in blocks_of(grid, stacked=True)[0])
    except DataError:
        return False


def _is_test(section: Section) -> bool:
    return bool(section.roles & {"relaxation", "compliance", "displacement", "force"})


def read(path: Path, choice: Choice) -> list[TimeTest]:
    """The tests in a file, or the chosen one.

    Raises
    ------
    DataError
        One line that says what is missing and how to say it.
    """
    manner, columns = manner_of(choice, path)
    text = text_of(path)
    found = [section for section in sections_of(text) if _is_test(section)]
    sections = [part for section in found for part in _by_temperature(section)]
    tests = []
    for number, section in enumerate(sections, 1):
        if choice.part and not _is_meant(choice.part, number, section.name):
            continue
        name = path.stem
        if len(sections) > 1:
            name = f"{path.stem}#{number}"
        try:
            told = _told(section, columns, path)
            test = _test(told, manner, name, path, _overruled(section, told))
            titles = [title.text for title in told.titles if title.role in ANSWERS]
            tests.append(replace(test, letter=letter_of(titles, test.units.is_modulus)))
        except DataError as error:
            if _holds_sweep(grid_of(text)):
                # A rest may be so long that the sweep below it was not seen when the file was
                # recognised.
                return []
            raise DataError(_with_path(str(error), path, name)) from None
    if not tests:
        raise DataError(f"{path}: there is no part '{choice.part:.40}'; it has {len(sections)}")
    return tests


def _with_path(message: str, path: Path, name: str) -> str:
    """A message that names the file, in place of the test's name, which is made from the file's."""
    if str(path) in message:
        return message
    return f"{path}: {message.removeprefix(f'{name}: ')}"


def _is_meant(part: str, number: int, name: str) -> bool:
    if match := re.fullmatch(r"(\d{1,6})(?:-(\d{1,6}))?", part):
        return int(match[1]) <= number <= int(match[2] or match[1])
    return part.casefold() in name.casefold()


def manner_of(choice: Choice, path: Path) -> tuple[Manner, dict[str, str]]:
    """What is said of the whole test, and the rest, which is of columns."""
    columns = dict(choice.columns)
    control = columns.pop("control", None)
    planned = columns.pop("answer", "") == "none"
    if control is not None and control not in CONTROLS:
        raise DataError(f"{path}: control is displacement or force, not '{control:.20}'")
    ramp = _constant(columns, "ramp", TIME_UNITS, "0.05[s]", path)
    warm = _constant(columns, "temperature", TEMPERATURE_UNITS, "25[degC]", path)
    manner = Manner(control, planned=planned)
    if ramp is not None:
        manner = replace(manner, ramp=ramp[0] * TIME_UNITS[ramp[1]])
    if warm is not None:
        manner = replace(manner, temperature=temperature_in_celsius(*warm))
    return manner, columns


def _constant(
    columns: dict[str, str], name: str, units: dict[str, float], example: str, path: Path
) -> tuple[float, str] | None:
    match = _CONSTANT.match(columns.get(name, ""))
    if match is None and name == "ramp" and name in columns:
        raise DataError(f"{path}: '{columns[name]:.20}' is no ramp: write 'FILE?ramp={example}'")
    if match is None:
        # A temperature may be said of a column too: "temperature=K".
        return None
    del columns[name]
    return float(match[1]), known_unit(normal_unit(match[2]), units, name)


def _told(section: Section, columns: dict[str, str], path: Path) -> Section:
    """The section with the units and meanings that a user gives."""
    titles = list(section.titles)
    # Before any hint is heeded: none changes which column another means.
    places = [_place(section, key, meaning, path) for key, meaning in columns.items()]
    for place, meaning in zip(places, columns.values(), strict=True):
        titles[place] = _with_meaning(titles[place], meaning, path)
    meant = {titles[place].role for place in places}
    for i, title in enumerate(titles):
        if title.role in meant and i not in places:
            # Of two columns that seem to be one thing, the one that was named is meant.
            titles[i] = replace(title, role="")
    return replace(section, titles=tuple(titles))


def _with_meaning(title: Title, meaning: str, path: Path) -> Title:
    """A column with the unit or meaning that a user gives."""
    sign, unit = apart_from_sign(meaning)
    if _MEANING.match(meaning) is None and is_unit(unit):
        return replace(title, unit=normal_unit(unit), sign=sign)
    made = title_of(meaning)
    if not made.role:
        raise DataError(
            f"{path}: '{meaning:.40}' is neither a unit nor one of {', '.join(EXAMPLES)}"
        )
    sign, unit = apart_from_sign(made.unit or title.unit)
    return Title(title.text, made.role, normal_unit(unit), sign)


def _place(section: Section, key: str, meaning: str, path: Path) -> int:
    """Where the column is that a user calls by number, title or role.

    Of several it is the one that would be taken without the hint, which says more of it and never
    another.
    """
    titles = section.titles
    if key.isdigit() and 1 <= int(key) <= len(titles):
        return int(key) - 1
    # A title as it stands, then without its unit, before any that means the same.
    tests: tuple[Callable[[Title], bool], ...] = (
        lambda title: title.text.casefold() == key.casefold(),
        lambda title: fold(apart(title.text)[0]) == fold(key),
        lambda title: title.role == title_of(key).role != "",
    )
    passing = ([i for i, title in enumerate(titles) if test(title)] for test in tests)
    named = next((places for places in passing if places), [])
    role = ""
    if named:
        role = titles[named[0]].role
    taken = _taken(section, role)
    if taken in named:
        return taken
    # A sensor in volts beside the calibrated one is not meant by its quantity.
    able = [i for i in named if not titles[i].unit or titles[i].unit in UNITS.get(role, ())]
    named = able or named
    if not named:
        shown = ", ".join(title.text for title in titles[:12])
        raise DataError(f"{path}: no column '{key:.40}' (there are: {shown})")
    if len(named) > 1:
        shown = " or ".join(f"{i + 1}, '{titles[i].text}'" for i in named[:4])
        instead = f"write {named[0] + 1}={meaning:.40} or another number in its place"
        raise DataError(f"{path}: '{key:.40}' may be column {shown}; {instead}")
    return named[0]


def _taken(section: Section, role: str) -> int | None:
    """The column that is taken for this where a user says nothing."""
    if role not in ("displacement", "force"):
        return _first(section, role)
    pair = _pair(section)
    if pair is None:
        return None
    return pair[role == "force"]


def _overruled(section: Section, told: Section) -> str:
    """What the file says otherwise than the user."""
    notes = []
    for before, after in zip(section.titles, told.titles, strict=True):
        if before.unit and after.role and after.unit != before.unit:
            notes.append(
                f"'{before.text}' is in {after.unit} as you said; the file says {before.unit}"
            )
    return "; ".join(notes)


def _test(section: Section, manner: Manner, name: str, path: Path, overruled: str) -> TimeTest:
    origin = {"file": path.name}
    if overruled:
        origin["note columns"] = overruled
    if section.name:
        origin["part"] = section.name
    _require_units(section, path)
    section = _without_ties(section, origin)
    temperature: float | Real | None = manner.temperature
    if temperature is None and (place := _first(section, "temperature")) is not None:
        temperature = _temperature(section, place, origin)
    common = {"temperature": temperature, "name": name, "provenance": origin}
    clock = _clock(section)
    pair = _pair(section)
    # The record before a modulus that was computed from it: it has the real ramp.
    if pair is not None:
        moved, pulled = (section.titles[place] for place in pair)
        test = TimeTest.of_history(
            clock,
            section.column(pair[0]),
            section.column(pair[1]),
            moved.unit,
            pulled.unit,
            control=manner.control,
            rise=manner.ramp,
            **common,  # type: ignore[arg-type]
        )
        # The other way than it counts now.
        opposite = "-" * (pulled.sign > 0.0)
        return replace(
            test, provenance={**origin, **sign_note(test, f"force={opposite}{pulled.unit}")}
        )
    if (place := _first(section, "relaxation")) is not None:
        unit, values = section.titles[place].unit, section.column(place)
        return TimeTest.of_relaxation(clock, values, unit, rise=manner.ramp or 0.0, **common)  # type: ignore[arg-type]
    if (place := _first(section, "compliance")) is not None:
        unit, values = _inverse(section.titles[place].unit, path), section.column(place)
        return TimeTest.of_compliance(clock, values, unit, rise=manner.ramp or 0.0, **common)  # type: ignore[arg-type]
    if manner.planned and (alone := _alone(section)) is not None:
        unit = section.titles[alone].unit
        return TimeTest.planned(
            clock, section.column(alone), unit, temperature=temperature, name=name
        )
    raise lacking(section, path)


def _alone(section: Section) -> int | None:
    """The column of what is imposed, where there is nothing else."""
    imposed = [
        i for i, title in enumerate(section.titles) if title.role in ("displacement", "force")
    ]
    if len(imposed) == 1:
        return imposed[0]
    return None


def _first(section: Section, role: str) -> int | None:
    return next((i for i, title in enumerate(section.titles) if title.role == role), None)


def _clock(section: Section) -> Real:
    place = _first(section, "time")
    assert place is not None
    unit = known_unit(section.titles[place].unit, TIME_UNITS, "time")
    return section.column(place) * TIME_UNITS[unit]


def _without_ties(section: Section, origin: dict[str, str]) -> Section:
    """The table without rows whose time is that of the row before, as printed digits make it."""
    place = _first(section, "time")
    assert place is not None
    clock = section.column(place)
    tied = np.concatenate([[False], np.diff(clock) == 0.0])
    if not tied.any() or len(clock) < ENOUGH or tied.mean() > MOST_TIED:
        return section
    # Times of a record have to rise.
    origin["note time"] = (
        f"{int(tied.sum())} of {len(clock)} rows have the time of the row before and are left out"
    )
    kept = np.flatnonzero(~tied).tolist()
    return replace(
        section, lines=[section.lines[i] for i in kept], numbers=[section.numbers[i] for i in kept]
    )


def _by_temperature(section: Section) -> list[Section]:
    """The tests of a table that has several below one another, each at its own temperature.

    The time begins anew at each, and may fall within all of them.
    """
    clock, warm = _first(section, "time"), _first(section, "temperature")
    if clock is None or warm is None:
        return [section]
    steps = np.sign(np.diff(section.column(clock)))
    if not len(steps):
        return [section]
    onwards = float(np.median(steps))
    starts = np.flatnonzero(steps == -onwards) + 1
    runs = np.split(np.arange(len(steps) + 1), starts)
    temperatures = [section.column(warm)[run] for run in runs]
    moved = [abs(np.mean(b) - np.mean(a)) for a, b in pairwise(temperatures)]
    # A record whose clock slipped is none of these: the temperature went on as it was.
    if not moved or min(map(len, runs)) < 2 or min(moved) < max(map(np.ptp, temperatures)):
        return [section]
    parts = []
    for run in runs:
        rows = run[:: int(onwards) or 1].tolist()
        lines, numbers = section.lines, section.numbers
        parts.append(
            replace(section, lines=[lines[i] for i in rows], numbers=[numbers[i] for i in rows])
        )
    return parts


def _require_units(section: Section, path: Path) -> None:
    """Ask for all units that are missing at once."""
    wanted = {"time"}
    if _pair(section) is None:
        # Displacement and force are of no use beside a modulus, unless their units make one.
        wanted |= section.roles & {"relaxation", "compliance"} or set(EXAMPLES)
    places = [
        i for i, title in enumerate(section.titles) if title.role in wanted and not title.unit
    ]
    if not places:
        return
    bare = [section.titles[i] for i in places]
    names = ", ".join(f"'{title.text}'" for title in bare)
    spec = ",".join(f"{_called(section, i)}={EXAMPLES[section.titles[i].role]}" for i in places)
    raise DataError(
        f"{path}, column {names}: there is no unit; write {bare[0].text}"
        f" [{EXAMPLES[bare[0].role]}], or say it by 'FILE?{spec}'"
    )


def _called(section: Section, place: int) -> str:
    """The word by which a hint means this column: its number where others have its role."""
    role = section.titles[place].role
    if sum(title.role == role for title in section.titles) == 1:
        return role
    return str(place + 1)


def _pair(section: Section) -> tuple[int, int] | None:
    """The columns of displacement and force that make a stiffness or modulus.

    Strain and stress before others.
    """
    moved = [i for i, title in enumerate(section.titles) if title.role == "displacement"]
    pulled = [i for i, title in enumerate(section.titles) if title.role == "force"]
    pairs = []
    for i in moved:
        for j in pulled:
            try:
                stiffness_unit(section.titles[i].unit, section.titles[j].unit)
            except DataError:
                continue
            pairs.append((section.titles[i].unit not in ("-", "%"), i, j))
    if not pairs:
        return None
    return min(pairs)[1:]


def _inverse(unit: str, path: Path) -> str:
    """The stiffness that a compliance in this unit is one over.

    ``1/Pa`` and ``mm/N`` give ``Pa`` and ``N/mm``.
    """
    text = unit.removesuffix("^-1")
    if text != unit:
        return text.strip()
    over, slash, under = unit.partition("/")
    if not slash:
        raise DataError(f"{path}: [{unit}] is no unit of a compliance: write 1/Pa or mm/N")
    if over == "1":
        return under
    return f"{under}/{over}"


def _temperature(section: Section, place: int, origin: dict[str, str]) -> float | Real | None:
    """One temperature in degC, or that of each row where it moved."""
    column = section.column(place)
    known = np.isfinite(column)
    if not known.any() or section.titles[place].unit not in TEMPERATURE_UNITS:
        return None
    warm = temperature_in_celsius(column, section.titles[place].unit)
    moved = float(np.ptp(warm[known]))
    if moved <= STEADY:
        return float(np.mean(warm[known]))
    # Reduced time is followed from row to row, and cannot be where the temperature lacks.
    if not known.all():
        origin["note temperature"] = (
            f"it moves by {moved:.2g} K, and lacks in {int((~known).sum())} rows: its mean is used"
        )
        return float(np.mean(warm[known]))
    return np.asarray(warm, dtype=float)


READER = TimeReader(
    "time-table",
    "relaxation, compliance, or displacement and force against time: CSV, RheoCompass, TRIOS, MTS",
    recognises,
    read,
)
