"""What is left of columns that a file gives.

Rows in which something was measured, numbers in one style. Cells that hold two numbers, a complex
modulus or a value with its deviation, become two columns. Of what an instrument says against its
values (flags of a status column, tan delta at a limit, raw phase near 180 deg), rows with a limit
instead of a loss tangent are left out: a storage modulus that follows from the limit was not
measured. All else is told and left to the user.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.measurement import MODULUS_UNITS, normal_unit
from springpot.rheology import Real

from .grid import APOSTROPHES, BLANKS, COMPLEX, DEVIATING, MISSING, POINTS, THOUSANDS, is_number
from .names import MODULI
from .table import Column
from .titles import COMPLIANCE_UNITS, Heading, heading, is_unit

_SAMPLED = 20
"""Cells of a column by which it is told: a column of numbers alone must cost nothing."""
_CONJUGATE = {
    "viscosity": ("dynamic_viscosity", "out_of_phase_viscosity"),
    "complex_compliance": ("storage_compliance", "loss_compliance"),
}
"""Parts of what is written x' - i x'', since it goes against the modulus.

Eta* = G* / (i omega), J* = 1 / G*.
"""


def with_pairs_apart(
    headings: Sequence[Heading], rows: Sequence[list[str]]
) -> tuple[tuple[Heading, ...], Sequence[list[str]]]:
    """Headings and rows, where columns of two numbers in a cell have become two columns.

    Parameters
    ----------
    headings : sequence of Heading
        What the columns are.
    rows : sequence of list of str
        The cells, as many in each row as there are headings.
    """
    parts = {place: _parts(title, rows, place) for place, title in enumerate(headings)}
    if not any(parts.values()):
        return tuple(headings), rows
    made: list[Heading] = []
    for place, title in enumerate(headings):
        made += parts[place] or [title]
    return tuple(made), [_row_apart(row, parts) for row in rows]


def _parts(heading: Heading, rows: Sequence[Sequence[str]], place: int) -> list[Heading]:
    """The two headings of a column of pairs; none for a column that stays as it is."""
    filled = (row[place] for row in rows if row[place].strip() not in MISSING)
    sample = [cell for cell in islice(filled, _SAMPLED) if not is_number(cell)]
    # By most of them: a slip in one cell is told with its line, not by a column that nobody knows.
    if 2 * sum(1 for cell in sample if COMPLEX.match(cell)) > len(sample):
        return _complex_parts(heading)
    if 2 * sum(1 for cell in sample if DEVIATING.match(cell)) > len(sample):
        return _with_deviation(heading)
    return []


def _complex_parts(heading: Heading) -> list[Heading]:
    roles = _CONJUGATE.get(str(heading.role))
    unit = normal_unit(heading.unit or "")
    if heading.role is None and unit in COMPLIANCE_UNITS:
        roles = _CONJUGATE["complex_compliance"]
    # A name such as "stiffness" leaves open which part is meant: a complex number is both.
    elif heading.role in MODULI - {*_CONJUGATE} or (
        heading.role is None and (not heading.unit or unit in MODULUS_UNITS)
    ):
        roles = ("storage", "loss")
    if roles is None:
        return []
    names = [f"{heading.title} (real part)", f"{heading.title} (imaginary part)"]
    return [
        replace(heading, title=name, name=role, role=role)
        for name, role in zip(names, roles, strict=True)
    ]


def _with_deviation(heading: Heading) -> list[Heading]:
    deviation = replace(heading, title=f"{heading.title} (deviation)", name="", role=None)
    # Of other quantities the deviation is left out: only that of the moduli weighs anything.
    if heading.role in ("storage", "loss"):
        deviation = replace(deviation, name=f"{heading.role}_sd", role=f"{heading.role}_sd")
    return [heading, deviation]


def _row_apart(row: Sequence[str], parts: dict[int, list[Heading]]) -> list[str]:
    cells: list[str] = []
    for place, cell in enumerate(row):
        if parts[place]:
            cells += _two_numbers(cell, parts[place][1])
        else:
            cells.append(cell)
    return cells


def _two_numbers(cell: str, second: Heading) -> tuple[str, str]:
    """Both numbers of a cell; what is no pair is a gap in both, and told as such."""
    if match := DEVIATING.match(cell):
        return match[1], match[2]
    match = COMPLEX.match(cell)
    if match is None:
        return cell, cell
    sign = match[2]
    if second.role in ("out_of_phase_viscosity", "loss_compliance"):
        sign = {"-": "+", "−": "+", "+": "-"}[sign]
    return re.sub(r"\s", "", match[1]), sign.replace("+", "") + (match[3] or match[4])


STATUS = "status"
IGNORE = "ignore"
"""What a user says (``?status=ignore``) to keep rows that the instrument takes back."""
CLIPPED = "taD"
"""RheoCompass: the loss factor is beyond its limit."""
TANGENT_LIMIT = 20000.0
"""The limit that RheoCompass writes as the loss factor; storage is the loss over it."""
ROUNDING = 1e-3
"""Values are printed with five digits, so that the ratio of two is known to a thousandth."""
WAYS = frozenset(
    {"trustrain", "trustress", "dso", "dsc", "dy_auto", "dy_man", "ok", "good", "valid", "-", "0"}
)
"""Words of a status column that tell how was measured, not that something is wrong."""
RAW_PHASE = 150.0
"""Degrees. Without inertia the raw phase lies within 0 and 90.

At 150 the moment of inertia takes 0.87 of the torque
(the cosine) beyond what the sample's elasticity balances, and storage is a small difference of
large numbers.
"""


@dataclass(frozen=True)
class Flags:
    """What was found.

    Parameters
    ----------
    keep : ndarray of bool, shape (n,)
        Rows whose values were measured.
    notes : dict of str to str
        What to tell, by the key of the note.
    """

    keep: NDArray[np.bool_]
    notes: dict[str, str]


def flags_in(
    status: Column | None, storage: Real | None, loss: Real | None, ignored: bool
) -> Flags:
    """What a status column and the values themselves say.

    Parameters
    ----------
    status : Column or None
        The status column.
    storage, loss : ndarray, shape (n,), or None
        The moduli, where the file has both.
    ignored : bool
        Whether the user keeps the rows all the same.

    Raises
    ------
    DataError
        If no row is left.
    """
    words = []
    if status is not None:
        words = [_words(cell) for cell in status.cells]
    count = len(words)
    if storage is not None:
        count = len(storage)
    clipped = np.array([CLIPPED in each for each in words] or [False] * count, dtype=bool)
    zero = np.zeros_like(clipped)
    if storage is not None and loss is not None:
        zero = _zero_in_place_of(storage, loss)
        clipped |= _at_limit(storage, loss) | zero
    notes = _flag_note(words)
    # Flags of other kinds are told and change nothing: what they mean differs from instrument to
    # instrument.
    if not clipped.any():
        return Flags(~clipped, notes)
    why = "tan delta at its limit"
    if zero.any():
        why = "0 beside large ones"
        if (clipped & ~zero).any():
            why += ", or tan delta at its limit"
    what = f"{int(clipped.sum())} of {count} rows have a storage that was not measured ({why})"
    if ignored:
        return Flags(
            np.ones(count, dtype=bool), {**notes, "note clipped": f"{what}; kept as you said"}
        )
    # Nothing would be left: the user decides, rather than an empty table.
    if clipped.all():
        raise DataError(f"{what}; open 'FILE?{STATUS}={IGNORE}' to see them all the same")
    notes["note clipped"] = f"{what} and were left out; '?{STATUS}={IGNORE}' keeps them"
    return Flags(~clipped, notes)


def _words(cell: str) -> set[str]:
    return {word.strip("™® ") for word in re.split(r"[,;|]", cell)} - {""}


def _flag_note(words: Sequence[set[str]]) -> dict[str, str]:
    """How often each flag stands there that may mean a fault."""
    count = Counter[str]()
    for each in words:
        # Sorted, since a set has another order in each process and ties are told in the order of
        # counting.
        count.update(word for word in sorted(each) if word.casefold() not in WAYS)
    if not count:
        return {}
    shown = ", ".join(f"{word} ({number})" for word, number in count.most_common(6))
    return {
        "note status": (
            f"of {len(words)} rows the instrument flags {shown}; its manual says what that means"
        )
    }


def _at_limit(storage: Real, loss: Real) -> NDArray[np.bool_]:
    """Rows whose loss is the limit times their storage; one such row alone may be chance."""
    with np.errstate(all="ignore"):
        rows = np.abs(loss / storage / TANGENT_LIMIT - 1.0) < ROUNDING
    return np.asarray(rows & (rows.sum() > 1))


def _zero_in_place_of(storage: Real, loss: Real) -> NDArray[np.bool_]:
    """Rows of a storage of 0 beside large ones: written for what was negative or not measured.

    Beside the small values of a column it is rounded, and nothing but zeros is a liquid's.
    """
    zero = (storage == 0.0) & (loss != 0.0)
    measured = np.flatnonzero(~zero)
    if not zero.any() or not len(measured):
        return np.zeros_like(zero)
    size = np.abs(storage[measured])
    nearest = np.argmin(np.abs(np.arange(len(storage))[:, None] - measured), axis=1)
    return np.asarray(zero & (size[nearest] > np.median(size)))


def raw_phase_note(raw: Column | None, frequency: Real) -> dict[str, str]:
    """A note where the raw phase comes near 180 deg; `frequency` (n,) in Hz."""
    if raw is None or not raw.is_numeric():
        return {}
    values = raw.numbers(gaps=True)
    # Instruments write degrees unless they say otherwise.
    if raw.unit == "rad":
        values = np.degrees(values)
    rows = values > RAW_PHASE
    if not rows.any():
        return {}
    where = f"{int(rows.sum())} of {len(values)} rows, from {frequency[rows].min():.3g} Hz on"
    return {
        "note raw phase": (
            f"beyond {RAW_PHASE:g} deg in {where}: the instrument's inertia outweighs the sample"
            " there"
        )
    }


_WITH_UNIT = re.compile(r"\s*[-+−]?\d[\d.,]*(?:[eE][-+]?\d+)?\s*((?:[^\W\d]|[°%]).*)\Z")
_PARTED = re.compile(r"\s*[-+−]?[1-9]\d{0,2}(?:,\d{3}|\.\d{3})\s*\Z")
"""A number with three digits behind its only mark, which may part thousands: 1,234 or 1.234."""
_FILLED = re.compile(r"[-−]9{3,}(?:[.,](?:0*|9+|250*))?\Z")
"""What programs write where nothing was measured: -999, -9999.0, -999.25."""
_WHOLE = ("temperature", "amplitude", "storage_sd", "loss_sd")


def cleaned(
    roles: dict[str, Column], others: list[Column]
) -> tuple[dict[str, Column], list[Column], dict[str, str]]:
    """Rows in which something was measured, the columns complete there, and what was left out."""
    roles, notes = _with_one_decimal_sign(roles)
    keep = np.ones(len(next(iter(roles.values())).cells), dtype=bool)
    for role, column in roles.items():
        if role not in (*_WHOLE, "repeat"):
            column = roles[role] = _without_thousands(column)
            _one_style(column)
            keep &= _present(column)
    if not keep.any():
        raise DataError(f"no row has a number for {', '.join(c.title for c in roles.values())}")
    if not keep.all():
        notes["note rows"] = (
            f"{int((~keep).sum())} of {len(keep)} rows without a measured value were left out"
        )
    roles = {role: rows_of(column, keep) for role, column in roles.items()}
    for role in [role for role in (*_WHOLE, "repeat") if role in roles]:
        # A point was measured without its temperature too, so that the column goes and the row
        # stays.
        if not _present(roles[role]).all():
            notes[f"note {role}"] = f"column '{roles[role].title}' has gaps and was left out"
            del roles[role]
    if ("storage_sd" in roles) != ("loss_sd" in roles):
        # One of the two weighs nothing: an objective needs both.
        roles.pop("storage_sd", roles.pop("loss_sd", None))
    return roles, _named_apart([rows_of(column, keep) for column in others], roles), notes


def with_unit_of_cells(column: Column) -> Column:
    """A column whose cells carry one unit, ``23 °C``, as plain numbers in that unit.

    Others as they are.
    """
    first = next((cell for cell in column.cells if cell.strip() not in MISSING), "")
    behind = unit_behind(first)
    if not behind:
        return column
    cells = [cell.strip() for cell in column.cells]
    if column.unit not in (None, normal_unit(behind)) or not all(
        cell.endswith(behind) or cell in MISSING for cell in cells
    ):
        return column
    return replace(
        column,
        unit=normal_unit(behind),
        cells=[cell.removesuffix(behind).rstrip() for cell in cells],
    )


def unit_behind(cell: str) -> str:
    """The unit behind a number, as in ``23 °C``; empty where there is none."""
    match = _WITH_UNIT.match(cell)
    return match[1].strip() if match is not None and is_unit(match[1]) else ""


def _present(column: Column) -> NDArray[np.bool_]:
    cells = [cell.strip() for cell in column.cells]
    known = np.array([cell not in MISSING for cell in cells], dtype=bool)
    filled = np.array([_FILLED.match(cell) is not None for cell in cells], dtype=bool)
    # Of values that are never negative, -999 is none.
    if filled.any() and not any(cell[:1] in "-−" for cell in np.array(cells)[known & ~filled]):
        known &= ~filled
    return known


def _without_thousands(column: Column) -> Column:
    """Numbers such as 1,234.5, where all commas plainly part thousands, without them; 1.234,5.

    1 234,5; 1'234.5.
    """
    quoted = [cell for cell in column.cells if "'" in cell or "’" in cell]
    if quoted and all(map(APOSTROPHES.match, quoted)):
        column = replace(
            column, cells=[cell.replace("'", "").replace("’", "") for cell in column.cells]
        )
    parted = [cell for cell in column.cells if len(cell.split()) > 1]
    if parted and all(map(BLANKS.match, parted)):
        column = replace(column, cells=["".join(cell.split()) for cell in column.cells])
    for sign, pattern in ((",", THOUSANDS), (".", POINTS)):
        marked = [cell for cell in column.cells if sign in cell]
        # 1,234 alone may be a decimal comma: only a cell with both signs tells which is which.
        if (
            marked
            and any({",", "."} <= set(cell) for cell in marked)
            and all(map(pattern.match, marked))
        ):
            return replace(column, cells=[cell.replace(sign, "") for cell in column.cells])
    return column


def _with_one_decimal_sign(roles: dict[str, Column]) -> tuple[dict[str, Column], dict[str, str]]:
    """The columns without the sign that parts thousands, where others show the decimal sign.

    ``1,500`` beside ``900.2``. Where nothing shows it, a comma is the decimal sign, with a note.
    """
    as_written = {role: column for role, column in roles.items() if column.decimal_comma}
    shown = {
        sign
        for sign in ",."
        for column in as_written.values()
        if any(
            sign in cell and is_number(cell) and not _PARTED.match(cell) for cell in column.cells
        )
    }
    notes = {}
    made = dict(roles)
    for role, column in as_written.items():
        signs = {sign for cell in column.cells for sign in ",." if sign in cell} - shown
        marked = [cell for cell in column.cells if signs & {*cell}]
        if len(signs) != 1 or not all(map(_PARTED.match, marked)):
            continue
        [sign] = signs
        value, read_as = marked[0].strip(), "."
        if shown:
            read_as = ""
            made[role] = replace(column, cells=[cell.replace(sign, "") for cell in column.cells])
        if shown or sign == ",":
            notes["note thousands"] = (
                f"column '{column.title}': '{value}' is read as {value.replace(sign, read_as)}"
            )
    return made, notes


def _one_style(column: Column) -> None:
    """Numbers with commas and numbers with points in one column can be read in two ways."""
    numbers = [cell for cell in column.cells if any(map(str.isdigit, cell))]
    commas = next((cell for cell in numbers if "," in cell), None)
    points = next((cell for cell in numbers if "." in cell), None)
    if commas is not None and points is not None:
        raise column.error(
            f"'{commas.strip():.20}' and '{points.strip():.20}' have comma and point; write one"
            " decimal sign"
        )


def rows_of(column: Column, keep: NDArray[np.bool_]) -> Column:
    """The rows of a column that are kept, gaps as empty cells."""
    if keep.all():
        cells: Sequence[str] = column.cells
        lines = column.lines
    else:
        places = np.flatnonzero(keep).tolist()
        cells = [column.cells[i] for i in places]
        lines = [column.lines[i] for i in places]
    if any(cell in MISSING for cell in cells):
        cells = list(map(_without_sign_of_gap, cells))
    return replace(column, cells=cells, lines=lines)


def _without_sign_of_gap(cell: str) -> str:
    if cell.strip() in MISSING:
        return ""
    return cell


def _named_apart(columns: list[Column], taken: Collection[str]) -> list[Column]:
    """Further columns, each with a name of its own.

    Of two that mean alike, the second keeps the file's words.
    """
    made: dict[str, Column] = {}
    for column in columns:
        words = re.sub(r"[\W_]+", "_", bare_name(column).lower()).strip("_")
        stem = column.name
        # A second temperature must not take the place of the one that was chosen.
        if (column.name in made or column.name in taken) and words:
            stem = words
        name, number = stem, 2
        while name in made or name in taken:
            name, number = f"{stem}_{number}", number + 1
        made[name] = replace(column, name=name)
    return list(made.values())


def is_blank(column: Column) -> bool:
    """Whether a column holds nothing."""
    return all(cell.strip() in MISSING for cell in column.cells)


def bare_name(column: Column) -> str:
    """The name of a column without its unit."""
    return heading(column.title).name
