"""Any table of a test in time.

CSV, workbooks, RheoCompass, TRIOS, MTS, with names and units in many languages.

What was tested is read off the columns: ``time [s]`` with ``relaxation [kPa]``, ``compliance
[1/kPa]``, or displacement and force (strain and stress, angle and torque), of which the record is
then taken as it is, its real ramp included. What a file leaves open is said behind it:
``FILE?time=s,relaxation=Pa,temperature=160[degC],ramp=0.05[s],control=force``, and of a channel
that counts the other way ``FILE?force=-N``.

The binary files of laboratories and RepTate's .laos hold records of displacement and force. The
readers that give a stiffness for each record know these formats; here the record itself is what was
measured.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.measurement import (
    FILE_UNITS,
    PRESSURE_UNITS,
    STRAIN_UNITS,
    TEMPERATURE_UNITS,
    TIME_UNITS,
    Choice,
    OpenQuestion,
    Reader,
    Signals,
    TimeReader,
    TimeTest,
    known_unit,
    normal_unit,
    temperature_in_celsius,
)
from springpot.measurement.from_signals import stiffness_unit
from springpot.measurement.mixed_up import history_note, sign_note
from springpot.measurement.timetest import CONTROLS
from springpot.rheology import Real
from springpot.rheology.points import HELD

from .blocks import Block
from .channels import STRAINS, STRESSES, channel_of, example_unit
from .choices import ask_base, with_choice
from .cleaning import cleaned, is_blank
from .derived import in_celsius
from .dynamic import columns_of, picked, spare_note, with_distinct_names
from .grid import HEAD, grid_of, head_text, is_number, text_of
from .reptate import LAOS, first_line
from .signals_binary import MATLAB, TDMS
from .signals_csv import sample_rate
from .table import OPPOSITE, Column, value_of
from .tables_in_time import (
    EXAMPLES,
    STRETCH,
    as_strain,
    holds_sweep,
    in_seconds,
    lacking,
    recognises_table,
    tables_of,
    without_ties,
)
from .title_words import letter_of
from .titles import COMPLIANCE_UNITS

ANSWERS = ("relaxation", "compliance", "force")
"""Columns whose titles tell which modulus it is of."""
OF_FILE = {
    **dict.fromkeys(("relaxation", "compliance", "force"), FILE_UNITS),
    "displacement": "-",
}
"""Units of columns that tell none; a displacement is what the force is over."""
WITHOUT_UNIT = ({"relaxation"}, {"compliance"}, {"displacement", "force"})
"""What needs none: all that is measured together, as of one alone the other's unit says nothing."""
_CONSTANT = re.compile(r"^([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*\[([^\]]*)\]$")


class Given(TypedDict):
    """What is said of a test beside its numbers."""

    temperature: float | Real | None
    name: str
    provenance: Mapping[str, str]


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


def _read_table(path: Path, choice: Choice) -> list[TimeTest]:
    """The tests in a file, or the chosen one.

    Raises
    ------
    DataError
        One line that says what is missing and how to say it.
    """
    manner, columns = manner_of(choice, path)
    choice = replace(choice, columns=columns)
    blocks = with_distinct_names(tables_of(path, choice))
    # The rate has become a column of times.
    _, choice = sample_rate(choice, "", ())
    if not blocks:
        return []
    chosen = blocks
    if choice.part:
        chosen = picked(blocks, choice.part)
    tests = []
    for number, block in enumerate(blocks, 1):
        if block not in chosen:
            continue
        name = path.stem
        if len(blocks) > 1:
            name = f"{path.stem}#{number}"
        try:
            tests.append(_test(block, choice, manner, name, path))
        except DataError as error:
            if _is_sweep_below(path):
                # A rest may be so long that the sweep below it was not seen when the file was
                # recognised.
                return []
            raise _about(error, name, path) from None
    return tests


def _is_sweep_below(path: Path) -> bool:
    try:
        return holds_sweep(grid_of(text_of(path)))
    except DataError:
        return False


def _about(error: DataError, name: str, path: Path) -> DataError:
    """An error without the test's name, which is made from the file's, and which comes before."""
    if isinstance(error, OpenQuestion):
        return error
    return DataError(str(error).removeprefix(f"{name}: "))


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


def _test(block: Block, choice: Choice, manner: Manner, name: str, path: Path) -> TimeTest:
    chosen = with_choice(block.headings, choice, block.words)
    if unsure := [each for each in chosen.headings if each.written == "?" and each.role]:
        raise ask_base(unsure)
    # What nothing of a record is called is a condition of all of it.
    said = {title.removesuffix(" [-]"): value for title, value in chosen.constants.items()}
    marks = {name: float(value) for name, value in said.items() if block.words.role(name) is None}
    origin = {"file": path.name}
    if chosen.overruled:
        origin["note columns"] = "; ".join(chosen.overruled)
    if block.name:
        origin["part"] = block.name
    columns = [as_strain(each) for each in columns_of(block, chosen) if not is_blank(each)]
    warm = [each for each in columns if each.name == "temperature"][:1]
    used, unstated = _used(columns, block, manner)
    if any(each.role == STRETCH for each in chosen.headings):
        origin["note stretch"] = "a stretch is one more than the strain, which is taken"
    roles, others, notes = cleaned(dict(used), warm)
    origin |= notes | unstated | spare_note(used, columns, block.words.values)
    clock = _clock(roles.pop("time"))
    kept = without_ties(clock, origin)
    temperature: float | Real | None = manner.temperature
    if temperature is None and others:
        told, taken = in_celsius(others[0])
        origin |= taken
        temperature = _temperature(told, kept, origin)
    common: Given = {"temperature": temperature, "name": name, "provenance": origin}
    values = {role: column.numbers()[kept] for role, column in roles.items()}
    test = _made(clock[kept], values, roles, manner, common)
    test = replace(test, provenance={**test.provenance, **history_note(test)})
    if "force" in roles:
        turned = any(each.written == OPPOSITE for each in chosen.headings if each.role == "force")
        # The other way than it counts now.
        hint = f"force={'-' * (not turned)}{roles['force'].unit}"
        test = replace(test, provenance={**test.provenance, **sign_note(test, hint)})
    titles = [column.title for role, column in roles.items() if role in ANSWERS]
    letter = letter_of(titles, test.units.is_modulus)
    if unstated and "force" in roles and channel_of(titles[0])[2].casefold() not in STRESSES:
        # Without units a name tells whether it is a force, over a displacement, or a stress.
        letter = "K"
    return replace(test, letter=letter, marks=marks)


def _used(
    columns: Sequence[Column], block: Block, manner: Manner
) -> tuple[dict[str, Column], dict[str, str]]:
    """The columns by role that a test is made of, and a note where units are those of the file.

    The record before a modulus that was computed from it: it has the real ramp.
    """
    found = {role: [each for each in columns if each.name == role] for role in EXAMPLES}
    timed: dict[str, Column] = {}
    noted: dict[str, str] = {}
    if found["time"]:
        timed["time"], noted = _with_unit(in_seconds(found["time"][0]))
    found, notes = _in_units(found)
    notes = {**noted, **notes}
    if timed and (pair := _pair(found["displacement"], found["force"])) is not None:
        return {**timed, "displacement": pair[0], "force": pair[1]}, notes
    for role in ("relaxation", "compliance"):
        if timed and found[role]:
            return {**timed, role: found[role][0]}, notes
    alone = [*found["displacement"], *found["force"]]
    if timed and manner.planned and len(alone) == 1:
        return {**timed, "planned": alone[0]}, notes
    raise lacking(block, columns)


def _made(
    clock: Real, values: dict[str, Real], used: dict[str, Column], manner: Manner, common: Given
) -> TimeTest:
    """The test that these columns are."""
    units = {role: str(column.unit) for role, column in used.items()}
    if "planned" in used:
        return TimeTest.planned(
            clock,
            values["planned"],
            units["planned"],
            temperature=common["temperature"],
            name=common["name"],
        )
    if "relaxation" in used:
        rise = manner.ramp or 0.0
        return TimeTest.of_relaxation(
            clock, values["relaxation"], units["relaxation"], rise=rise, **common
        )
    if "compliance" in used:
        rise, unit = manner.ramp or 0.0, _inverse(units["compliance"])
        return TimeTest.of_compliance(clock, values["compliance"], unit, rise=rise, **common)
    return TimeTest.of_history(
        clock,
        values["displacement"],
        values["force"],
        units["displacement"],
        units["force"],
        control=manner.control,
        rise=manner.ramp,
        **common,
    )


def _clock(column: Column) -> Real:
    unit = known_unit(str(column.unit), TIME_UNITS, "time")
    return column.numbers() * TIME_UNITS[unit]


def _with_unit(clock: Column) -> tuple[Column, dict[str, str]]:
    """Times in their unit, or in seconds and a note that these are taken."""
    if clock.unit is not None:
        return clock, {}
    says = f"there is no unit, and seconds are taken; write {clock.title} [s]"
    note = f"'{clock.title}': {says}, or if it is another one say 'FILE?time=min'"
    return replace(clock, unit="s"), {"note clock": note}


def _in_units(
    found: dict[str, list[Column]],
) -> tuple[dict[str, list[Column]], dict[str, str]]:
    """The columns with their units, and a note where these are not written in the file.

    Raises
    ------
    DataError
        If units are missing that must be known: all that are missing are asked for at once.
    """
    wanted = []
    if _pair(found["displacement"], found["force"]) is None:
        # A displacement or a force by itself is of no use beside a modulus.
        moduli = [*found["relaxation"][:1], *found["compliance"][:1]]
        record = [*found["displacement"], *found["force"]]
        wanted = moduli or record
        if found["displacement"] and found["force"]:
            wanted = record
    bare = [each for each in wanted if each.unit is None]
    if not bare:
        return found, {}
    names = ", ".join(f"'{each.title}'" for each in bare)
    if wanted and _are_strains_beside_stresses(bare, found["force"]):
        strains = [replace(each, unit="-") for each in bare]
        says = "there is no unit, as a strain has none; if it is %, say 'FILE?displacement=%'"
        return {**found, "displacement": strains}, {"note units": f"{names}: {says}"}
    units = [example_unit(each.title, EXAMPLES[each.name]) for each in bare]
    spec = ",".join(f"{each.name}={unit}" for each, unit in zip(bare, units, strict=True))
    mend = f"write {bare[0].title} [{units[0]}], or say it by 'FILE?{spec}'"
    roles = {each.name for each in bare}
    together = next((set(each) for each in WITHOUT_UNIT if roles <= each), None)
    if together is None:
        raise DataError(f"column {names}: there is no unit; {mend}")
    taken = {role: [replace(each, unit=OF_FILE[role]) for each in found[role]] for role in together}
    note = f"{names}: there is no unit, and all is told in the file's units; {mend}"
    return {**found, **taken}, {"note units": note}


def _are_strains_beside_stresses(bare: Sequence[Column], pulled: Sequence[Column]) -> bool:
    """Whether all that lacks a unit is called a strain, and its other is a stress."""
    called = {channel_of(each.title)[2].casefold() for each in bare}
    units = {normal_unit(each.unit or "") for each in pulled}
    return called <= set(STRAINS) and bool(units & set(PRESSURE_UNITS))


def _pair(moved: Sequence[Column], pulled: Sequence[Column]) -> tuple[Column, Column] | None:
    """The columns of displacement and force that make a stiffness or modulus.

    Strain and stress before others.
    """
    pairs = []
    for each, other in product(moved, pulled):
        try:
            stiffness_unit(str(each.unit), str(other.unit))
        except DataError:
            continue
        pairs.append((each, other))
    return min(pairs, key=lambda pair: pair[0].unit not in STRAIN_UNITS, default=None)


def _inverse(unit: str) -> str:
    """The stiffness that a compliance in this unit is one over: ``Pa`` of ``1/Pa``."""
    if unit == FILE_UNITS:
        return unit
    known = known_unit(unit, COMPLIANCE_UNITS, "a compliance")
    over, _, under = known.partition("/")
    if not under:
        return over.removesuffix("^-1")
    if over == "1":
        return under
    return f"{under}/{over}"


def _temperature(
    column: Column, kept: NDArray[np.bool_], origin: dict[str, str]
) -> float | Real | None:
    """One temperature in degC, or that of each row where it moved."""
    if column.unit not in TEMPERATURE_UNITS:
        return None
    warm = temperature_in_celsius(column.numbers(gaps=True), column.unit)[kept]
    known = np.isfinite(warm)
    if not known.any():
        return None
    moved = float(np.ptp(warm[known]))
    if moved <= HELD["temperature"]:
        return float(np.mean(warm[known]))
    # Reduced time is followed from row to row, and cannot be where the temperature lacks.
    if not known.all():
        origin["note temperature"] = (
            f"it moves by {moved:.2g} K, and lacks in {int((~known).sum())} rows: its mean is used"
        )
        return float(np.mean(warm[known]))
    return np.asarray(warm, dtype=float)


TABLE = TimeReader(
    "time-table",
    "relaxation, compliance, or displacement and force against time: CSV, RheoCompass, TRIOS, MTS",
    recognises_table,
    _read_table,
)


_FORMATS = (LAOS, MATLAB, TDMS)


def _is_record(head: bytes) -> float:
    """High for what one of these formats is sure of."""
    return max(reader.recognises(head) for reader in _FORMATS)


def _read_record(path: Path, choice: Choice) -> list[TimeTest]:
    """The record in a file; none where it holds something else, such as a sweep."""
    with path.open("rb") as stream:
        head = stream.read(HEAD)
    reader = max(_FORMATS, key=lambda each: each.recognises(head))
    manner, columns = manner_of(choice, path)
    try:
        signals = _signals(reader, path, replace(choice, columns=columns))
    except DataError:
        # What lacks is asked for by the reader that finds a stiffness, which knows sweeps in such
        # files as well.
        return []
    known = (
        np.isfinite(signals.time) & np.isfinite(signals.displacement) & np.isfinite(signals.force)
    )
    temperature = manner.temperature
    if (
        temperature is None
        and (warm := first_line(head_text(head)).get("T")) is not None
        and is_number(warm)
    ):
        temperature = value_of(warm)
    test = TimeTest.of_history(
        signals.time[known],
        signals.displacement[known],
        signals.force[known],
        signals.displacement_unit,
        signals.force_unit,
        control=manner.control,
        rise=manner.ramp,
        temperature=temperature,
        name=path.stem,
        provenance={"file": path.name, **signals.provenance},
    )
    return [
        replace(
            test, provenance={**test.provenance, **sign_note(test, f"force=-{signals.force_unit}")}
        )
    ]


def _signals(reader: Reader, path: Path, choice: Choice) -> Signals:
    load = reader.signals
    assert load is not None, "all of these formats hold signals"
    return load(path, choice)


RECORD = TimeReader(
    "time-records",
    "displacement and force against time in MATLAB .mat, TDMS and RepTate .laos",
    _is_record,
    _read_record,
)
