"""Blocks to a measurement.

Which parts and columns are meant, what is left out, and the note that says so.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypeAlias

from springpot.errors import DataError
from springpot.measurement import (
    COHERENCE,
    FILE_UNITS,
    PRESSURE_UNITS,
    Choice,
    Measurement,
    OpenQuestion,
    Part,
    Reader,
    normal_unit,
)
from springpot.rheology import Real

from .blocks import Block, lacking
from .choices import (
    CURVES,
    Chosen,
    ask_base,
    ask_meaning,
    doubt,
    with_choice,
)
from .cleaning import (
    STATUS,
    bare_name,
    cleaned,
    flags_in,
    is_blank,
    raw_phase_note,
    rows_of,
    with_unit_of_cells,
)
from .columns import measurement_of, sign_note
from .derived import COMPLIANCES, RATIOS, VISCOSITIES, with_moduli, with_units
from .grid import is_number
from .joining import joined, require_one_kind
from .names import FREQUENCIES
from .proposals import condition_name, offers
from .table import Column, as_measured, value_of
from .title_words import says_whole_swing, without_peak
from .titles import UNITS, Heading, heading, is_dynamic

KEPT = (
    *("time", "gap", "normal_force", "torque", "displacement", "raw_phase", "stress"),
    COHERENCE,
)
"""Further columns of instruments that are kept as conditions."""
_PAIRS = (
    ("storage", "loss"),
    *(
        (size, angle)
        for size in ("magnitude", "storage", "viscosity", "loss")
        for angle in ("phase", "loss_factor", "damping_ratio")
    ),
    ("storage", "damping"),
    ("magnitude", "damping"),
    VISCOSITIES,
    COMPLIANCES,
    ("storage", "energy"),
    ("magnitude", "energy"),
    ("force_amplitude", "phase"),
    ("force_amplitude", "loss_factor"),
)
"""What gives a complex modulus, best first."""
_REPEATED = set(FREQUENCIES).union(*_PAIRS)
"""Columns that say once more what the chosen ones say."""
COLUMNS_AGREE = 0.01
"""Share by which two columns of one frequency may differ, as what was set and what was measured do.

Much more than
rows of one column, which come from one instrument."""
_MEANT = {*UNITS, "repeat"} - {"time", "relaxation", "compliance"}
SWINGING = ("amplitude", "force_amplitude")
"""What may be counted either way."""


def measurement_from(
    blocks: Sequence[Block],
    choice: Choice,
    path: Path,
    provenance: Mapping[str, str],
    further: bool = False,
) -> Measurement:
    """The measurement in the chosen blocks, by default in all that are dynamic tests.

    Parameters
    ----------
    blocks : sequence of Block
        The tables of the file.
    choice : Choice
        What the user says.
    provenance : mapping of str to str
        What the file says of instrument and sample.
    further : bool
        Whether all further columns are kept, rather than those in `KEPT`.

    Raises
    ------
    DataError
        One line that says what was recognised and what is missing.
    """
    blocks = with_distinct_names(blocks)
    chosen = chosen_blocks(blocks, choice)
    parts, refused = _opened(chosen, choice, provenance, further)
    chosen = [block for block in chosen if block.name not in refused]
    name = path.stem
    if choice.part:
        name = f"{path.stem}#{choice.part}"
    left_out = {f"note {block}": f"left out: {reason}" for block, reason in refused.items()}
    if len(parts) == 1:
        origin = dict(parts[0].provenance)
        if chosen[0].name and len(blocks) > 1:
            origin["part"] = chosen[0].name
        if len(blocks) == 1:
            # Of columns side by side the numbers and names would be those of the whole file.
            origin |= offers(parts[0], with_choice(chosen[0].headings, choice).headings, choice)
        return replace(parts[0], name=name, provenance={**origin, **left_out})
    first = next(i for i, block in enumerate(blocks, 1) if block is chosen[0])
    note = (
        f"{len(parts)} of {len(blocks)} parts together; choose one by '#', such as"
        f" {path.name}#{first}"
    )
    if CURVES not in choice.columns and all(is_number(block.name) for block in chosen):
        # Numbers without a unit may count samples as well as state temperatures: only the user
        # knows.
        shown = ", ".join(block.name for block in chosen[:3])
        note += (
            f"; say what {shown} ... are by '{path.name}?curves=temperature[degC]' or"
            " '?curves=repeat'"
        )
    opened = {block.name for block in chosen}
    require_one_kind(
        parts, {block.name: i for i, block in enumerate(blocks, 1) if block.name in opened}
    )
    together = joined(parts, [block.name for block in chosen], name, note)
    return replace(together, provenance={**together.provenance, **left_out})


def _opened(
    blocks: Sequence[Block], choice: Choice, provenance: Mapping[str, str], further: bool
) -> tuple[list[Measurement], dict[str, str]]:
    """The measurements in the blocks, and by name the reason of each that cannot be used.

    Raises
    ------
    DataError
        If none can be used: the reason of the first.
    """
    parts: dict[str, Measurement] = {}
    refused: dict[str, DataError] = {}
    for block in blocks:
        try:
            parts[block.name] = _measurement(block, choice, provenance, further)
        except DataError as error:
            # One part that cannot be used must not keep the others from opening.
            refused[block.name] = error
    if not parts:
        raise next(iter(refused.values()))
    left_out = {name: str(error) for name, error in refused.items()}
    bare = {name for name, part in parts.items() if part.units.stiffness == FILE_UNITS}
    if len(bare) < len(parts):
        # Beside others whose units are known.
        left_out |= {name: parts.pop(name).provenance["note units"] for name in bare}
    return list(parts.values()), left_out


def parts_from(blocks: Sequence[Block]) -> tuple[Part, ...]:
    """The blocks as they are listed for a user; none where there is but one."""
    if len(blocks) < 2:
        return ()
    return tuple(map(_part, with_distinct_names(blocks)))


Parsed: TypeAlias = Callable[[Path], tuple[list[Block], dict[str, str]]]
"""Gives the tables of a file, and what it says of instrument and sample under fixed keys."""


def reader_of_blocks(
    name: str, summary: str, recognises: Callable[[bytes], float], parsed: Parsed, written_by: str
) -> Reader:
    """The reader of a format that is told by how its tables are found, and read as any other then.

    Parameters
    ----------
    name, summary, recognises
        As of `springpot.measurement.Reader`.
    parsed : callable
        See `Parsed`.
    written_by : str
        The program, noted in the provenance.
    """
    # No functions within this one: those could not be handed to another process.
    return Reader(
        name,
        summary,
        recognises,
        partial(_read_blocks, parsed, written_by),
        parts=partial(_parts_of_blocks, parsed),
    )


def _read_blocks(parsed: Parsed, written_by: str, path: Path, choice: Choice) -> Measurement:
    """The dynamic tests in a file."""
    blocks, facts = parsed(path)
    return measurement_from(blocks, choice, path, {"format": written_by, **facts})


def _parts_of_blocks(parsed: Parsed, path: Path) -> tuple[Part, ...]:
    """The tables of a file as they are listed."""
    return parts_from(parsed(path)[0])


def _part(block: Block) -> Part:
    """A block as it is listed: whether it can be opened, and if not, why."""
    size = len(block.rows)
    if not block.is_dynamic:
        return Part(block.name, size, False, block.lacks())
    try:
        _measurement(block, Choice(), {}, further=True)
    except OpenQuestion as question:
        return Part(block.name, size, False, str(question), asks=True)
    except DataError as error:
        return Part(block.name, size, False, str(error))
    return Part(block.name, size)


def with_distinct_names(blocks: Sequence[Block]) -> list[Block]:
    """The blocks, each with a name of its own where there are several."""
    if len(blocks) < 2:
        return list(blocks)
    names = [block.name or f"table {i}" for i, block in enumerate(blocks, 1)]
    count, seen = Counter(names), Counter[str]()
    made = []
    for block, name in zip(blocks, names, strict=True):
        seen[name] += 1
        if count[name] > 1:
            # Parts are chosen, refused and labelled by name.
            name = f"{name} ({seen[name]})"
        made.append(replace(block, name=name))
    return made


def chosen_blocks(blocks: Sequence[Block], choice: Choice) -> list[Block]:
    """The blocks that a user means.

    Raises
    ------
    DataError
        If there is no such block, or none that is a dynamic test.
    """
    if not blocks:
        raise DataError(
            "there is no table of numbers, such as below frequency [Hz], storage [Pa], loss [Pa]"
        )
    meant = list(blocks)
    if choice.part:
        meant = picked(blocks, choice.part)
    usable = [block for block in meant if is_dynamic(_roles_chosen(block, choice))]
    # Parts that a user names are all meant; without a choice, those that are no dynamic test are
    # passed over.
    if usable and (len(usable) == len(meant) or not choice.part):
        return usable
    if len(meant) == 1:
        raise _not_dynamic(meant[0])
    reasons = list(dict.fromkeys(block.lacks() for block in meant))
    names = ", ".join(dict.fromkeys(block.name or "unnamed" for block in meant))
    says = (
        f"none of its {len(meant)} parts is a dynamic test ({names:.120}):"
        f" {'; '.join(reasons):.200}"
    )
    common_reason = ""
    if len(reasons) == 1:
        # Only what all of them lack can be mended by one option.
        common_reason = reasons[0]
    raise ask_meaning(says, common_reason, ())


def _not_dynamic(block: Block) -> DataError:
    """The error of the only table that is meant."""
    where = ""
    if block.name:
        where = f"part '{block.name}' is no dynamic test: "
    return ask_meaning(f"{where}{block.holds()}", block.lacks(), block.headings, block.untitled)


def _roles_chosen(block: Block, choice: Choice) -> set[str]:
    if not choice.columns:
        return block.roles
    try:
        chosen = with_choice(block.headings, choice)
    except DataError:
        # Options are for the parts that have such columns.
        return block.roles
    roles = {each.role for each in chosen.headings if each.role}
    return roles | {str(heading(title).role) for title in chosen.constants}


def picked(blocks: Sequence[Block], part: str) -> list[Block]:
    """The blocks that a user names, by number or a part of their names.

    Raises
    ------
    DataError
        If there is none.
    """
    if match := re.fullmatch(r"(\d{1,6})(?:-(\d{1,6}))?", part):
        first, last = int(match[1]), int(match[2] or match[1])
        if not 1 <= first <= last <= len(blocks):
            raise DataError(f"there is no part {part}; it has {len(blocks)} (inspect lists them)")
        return list(blocks[first - 1 : last])
    named = [block for block in blocks if part.casefold() in block.name.casefold()]
    if not named:
        names = (
            ", ".join(dict.fromkeys(block.name for block in blocks if block.name))
            or "none has a name"
        )
        raise DataError(f"no part is called '{part:.40}' ({names:.120})")
    return named


def _measurement(
    block: Block, choice: Choice, provenance: Mapping[str, str], further: bool
) -> Measurement:
    chosen = with_choice(block.headings, choice)
    if any(each.written == "?" and each.role in _MEANT for each in chosen.headings):
        raise ask_base([each for each in chosen.headings if each.written and each.role in _MEANT])
    columns = columns_of(block, chosen)
    _require_one_clock(columns)
    roles = _roles(columns)
    chosen_roles = dict(roles)
    roles, unstated = with_units(roles)
    used = {column.title for column in roles.values()}
    others = [
        c
        for c in columns
        if c.title not in used and c.name not in _REPEATED and _is_kept(c, further)
    ]
    # Gaps before sums: what is not there in a row gives no modulus there.
    roles, others, notes = cleaned(roles, others)
    notes |= unstated
    own = dict(roles)
    roles = with_moduli(roles)
    flags = flags_in(_named(others, STATUS), *_moduli(roles), chosen.keeps_flagged)
    roles = {role: rows_of(column, flags.keep) for role, column in roles.items()}
    others = [rows_of(column, flags.keep) for column in others if column.name != STATUS]
    measured = measurement_of(roles, others, block.name or "part", dict(provenance))
    notes |= sign_note(measured, own) | spare_note(chosen_roles, columns, block.words.values)
    notes |= flags.notes | raw_phase_note(_named(others, "raw_phase"), measured.frequency)
    for each in chosen.headings:
        if each.role in SWINGING and counts_whole_swing(each):
            notes["note amplitude"] = (
                f"'{each.title}' counts from trough to crest; half of it is the amplitude"
            )
    if chosen.overruled:
        notes["note columns"] = "; ".join(chosen.overruled)
    return replace(measured, provenance={**measured.provenance, **notes})


def _require_one_clock(columns: Sequence[Column]) -> None:
    """Refuse a table whose storage and loss have frequencies of their own, as digitised curves."""
    clocks = [(place, each) for place, each in enumerate(columns, 1) if each.name in FREQUENCIES]
    for place, other in clocks[1:]:
        first = clocks[0][1]
        if other.title != first.title:
            # A frequency that was set, beside the measured one.
            _require_factor(first, other, columns)
            continue
        for one, two in zip(first.cells, other.cells, strict=True):
            if is_number(one) and is_number(two) and not _is_near(one, two):
                raise DataError(
                    f"'{first.title}' stands twice, with {one.strip()} and {two.strip()} in one"
                    " row: storage and loss need the same frequencies; bring them there, or leave"
                    f" out the second by 'FILE?{place}=ignore'"
                )


def _require_factor(first: Column, other: Column, columns: Sequence[Column]) -> None:
    """Refuse one row of numbers in both Hz and rad/s, of which one unit is wrong."""
    pairs = [
        (one, two)
        for one, two in zip(first.cells, other.cells, strict=True)
        if is_number(one) and is_number(two)
    ]
    if first.unit == other.unit or not pairs or not all(_is_near(one, two) for one, two in pairs):
        return
    kept = {each.title: f"'FILE?{columns.index(each) + 1}=ignore'" for each in (first, other)}
    raise DataError(
        f"'{first.title}' and '{other.title}' hold the same numbers, so that one unit is wrong by"
        f" 2 pi: leave out that one, by {kept[first.title]} or {kept[other.title]}"
    )


def _is_near(one: str, two: str) -> bool:
    """Whether two cells are one frequency, to 1 %."""
    first, second = value_of(one), value_of(two)
    return abs(first - second) <= COLUMNS_AGREE * abs(first)


def spare_note(
    used: Mapping[str, Column], columns: Sequence[Column], values: Collection[str]
) -> dict[str, str]:
    """What else is there of a measured quantity of which one column is taken.

    In the same unit it is another sensor's, and a modulus beside a stiffness the same of the
    material; in another unit of one kind it is the chosen column once more.
    """
    told = []
    for role, column in used.items():
        alike = (
            each
            for each in columns
            if each.name == role
            and (each.unit == column.unit or _is_pressure(each) != _is_pressure(column))
        )
        others = [
            f"'{each.title}'" for each in alike if each.cells != column.cells and not is_blank(each)
        ]
        if others and role in values:
            told.append(f"{role} is '{column.title}', not {' or '.join(others[:3])}")
    if not told:
        return {}
    return {"note spare columns": "; ".join(told)}


def _is_pressure(column: Column) -> bool:
    return column.unit in PRESSURE_UNITS


def _named(columns: Sequence[Column], name: str) -> Column | None:
    return next((column for column in columns if column.name == name), None)


def _moduli(roles: Mapping[str, Column]) -> tuple[Real | None, Real | None]:
    """Storage and loss as they stand in the file, where they have one unit."""
    if not roles.keys() >= {"storage", "loss"} or roles["storage"].unit != roles["loss"].unit:
        return None, None
    return roles["storage"].numbers(), roles["loss"].numbers()


def columns_of(block: Block, chosen: Chosen) -> list[Column]:
    """The columns of a table, and those of one value that user or file state, in plain numbers."""
    # What the user says goes before what the file says.
    constants = {**block.constants, **chosen.constants}
    return [
        *_columns(block, chosen.headings),
        *(_constant(title, value, block) for title, value in constants.items()),
    ]


def _columns(block: Block, headings: Sequence[Heading]) -> list[Column]:
    cells: list[Sequence[str]] = list(zip(*block.rows, strict=True))
    made: list[Column] = []
    complete = _has_all_units(headings)
    for heading_, column in zip(headings, cells, strict=False):
        name = heading_.role or condition_name(heading_)
        unit = _normal(heading_.unit)
        if heading_.role == "omega" and unit in (None, "1/s", "/s", "s^-1", "s-1"):
            # An angular frequency is in rad/s also where the radian is not written.
            unit = "rad/s"
        if (
            unit is None
            and heading_.role == "amplitude"
            and complete
            and "strain" in heading_.name.lower()
        ):
            # Where every other name carries its unit, a strain without one is a plain number.
            unit = "-"
        if heading_.role in SWINGING:
            unit = unit_of_amplitude(unit)
            if counts_whole_swing(heading_):
                column = halved(column)
        title = heading_.title or name
        whole = with_unit_of_cells(
            Column(title, name, unit, column, block.lines, decimal_comma=True)
        )
        made.append(as_measured(whole, heading_.written))
    return made


def _normal(unit: str | None) -> str | None:
    """The usual spelling; a unit that lacks still does, and is asked for."""
    if unit is None:
        return None
    return normal_unit(unit)


def _has_all_units(headings: Sequence[Heading]) -> bool:
    known = [h for h in headings if h.role in UNITS and h.role not in ("amplitude", *RATIOS)]
    return len(known) > 2 and all(heading.unit is not None for heading in known)


def _constant(title: str, value: str, block: Block) -> Column:
    named = heading(title)
    return Column(
        title, named.role or named.name, _normal(named.unit), [value] * len(block.rows), block.lines
    )


def _roles(columns: Sequence[Column]) -> dict[str, Column]:
    """The column of each role: of several, the one whose name is surest."""
    roles: dict[str, Column] = {}
    for column in columns:
        if column.name not in _MEANT or is_blank(column):
            continue
        before = roles.get(column.name)
        if before is None or _doubt(column) < _doubt(before):
            roles[column.name] = column
    if "omega" in roles and "frequency" in roles:
        # They say the same; an omega in another unit than rad/s is the doubtful one.
        spare = "omega"
        if roles["omega"].unit == "rad/s":
            spare = "frequency"
        del roles[spare]
    pair = next((pair for pair in _PAIRS if roles.keys() >= set(pair)), ())
    if pair:
        # The others say the modulus once more, with other rounding, and must not contradict the
        # chosen ones.
        others = set().union(*_PAIRS) - set(pair)
        roles = {role: column for role, column in roles.items() if role not in others}
    if not is_dynamic(set(roles)):
        there = ", ".join(f"'{column.title}'" for column in roles.values()) or "no known column"
        raise DataError(f"found {there}; {lacking({str(role) for role in roles})}")
    return roles


def _doubt(column: Column) -> tuple[bool, int]:
    return doubt(Heading(column.title, bare_name(column), column.name, column.unit))


def _is_kept(column: Column, further: bool) -> bool:
    return (
        bool(column.name) and (further or column.name in (*KEPT, STATUS)) and not is_blank(column)
    )


def counts_whole_swing(heading: Heading) -> bool:
    """Whether the title or the unit of an amplitude says that it counts from trough to crest."""
    return says_whole_swing(heading.title) or says_whole_swing(heading.unit or "")


def unit_of_amplitude(unit: str | None) -> str | None:
    """The unit without what says from where it counts: ``mm`` of ``mm pk-pk``."""
    if unit is None:
        return None
    # A unit that is nothing else, such as "pp", is told as it stands.
    return without_peak(unit) or unit


def halved(cells: Sequence[str]) -> list[str]:
    """Half of each number."""
    return list(map(_half, cells))


def _half(cell: str) -> str:
    if not is_number(cell):
        # A gap or a slip is told later, as it stands in the file.
        return cell
    return repr(value_of(cell) / 2)
