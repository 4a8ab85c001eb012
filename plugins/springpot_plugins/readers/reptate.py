"""RepTate: a line of keys, ``Mw=23.4;T=-35;chem=PI;``, above columns that the format defines.

``.tts`` and ``.osc`` hold omega, G' and G'' in rad/s and Pa; ``.laos``, whose first line has omega
and gamma, time, strain and stress. ``.gt`` holds t and G(t); ``.shear`` has the key ``gdot`` and
holds t and the growth of the viscosity, which times the rate is the stress of a startup, and
perhaps further columns; ``.creep`` has the key ``stress`` and holds t and the strain. All in s, Pa
and Pa s.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from springpot.errors import DataError
from springpot.measurement import (
    Choice,
    Loading,
    Measurement,
    Reader,
    Signals,
    TimeReader,
    TimeTest,
)
from springpot.rheology import Real

from .blocks import Block, is_data
from .channels import channel_of, found_in, places_of, reader_of_signals, signals_from
from .dynamic import measurement_from
from .grid import COMMENT, MISSING, cells_of, head_text, is_number, lines_of, separator_in, text_of
from .headings import headings_of
from .tables_in_time import without_ties
from .titles import Heading, heading, is_unit

# At least one semicolon: a lone "T = 20" heads the tables of many instruments. The last one is
# often forgotten.
HEADER = re.compile(
    r"(?=[^;\n]*;)(?:[A-Za-z_]\w{0,20}\s{0,9}=[^;=\n]{0,60}(?:;\s{0,9}|\Z)){1,40}\Z"
)
_SWEEP = (
    Heading("w", "omega", "omega", "rad/s"),
    Heading("G'", "storage", "storage", "Pa"),
    Heading("G''", "loss", "loss", "Pa"),
)
"""What the first three columns are by the definition of the format."""


CLOCKS = frozenset({"omega", "freq", "frequency"})
"""A frequency in the first line is that of a time signal."""


def first_line(text: str) -> dict[str, str]:
    """The keys and values of the first line; none for other files."""
    line = lines_of(text.lstrip("\ufeff")[:4000])[0].strip()
    if not HEADER.match(line):
        return {}
    pairs = (piece.partition("=") for piece in line.split(";") if "=" in piece)
    return {key.strip(): value.strip() for key, _, value in pairs}


def _is_sweep(head: bytes) -> float:
    """High for a first line of keys without the amplitude and frequency of a time signal."""
    header = first_line(head_text(head[:8000]))
    if not header or header.keys() & CLOCKS:
        return 0.0
    return 0.95


def table_of(text: str) -> tuple[list[list[str]], list[int], list[list[str]]]:
    """Rows, their line numbers, and the lines between the first line and the numbers.

    Raises
    ------
    DataError
        If there are no numbers, or rows of fewer than three cells.
    """
    lines = [(i, line) for i, line in enumerate(lines_of(text), 1) if i > 1 and line.strip()]
    separator = separator_in([line for _, line in lines])
    split = [(i, _numbers_apart(cells_of(line.strip(), separator, i))) for i, line in lines]
    start = next((k for k, (_, cells) in enumerate(split) if _is_row(cells)), None)
    if start is None:
        raise DataError("a RepTate file without three columns of numbers")
    numbers = [(i, cells) for i, cells in split[start:] if not cells[0].startswith(COMMENT)]
    for i, cells in numbers:
        if len(cells) < 3:
            raise DataError(f"line {i}: {len(cells)} cells where at least 3 are needed")
    return (
        [cells for _, cells in numbers],
        [i for i, _ in numbers],
        [cells for _, cells in split[:start]],
    )


def _numbers_apart(cells: list[str]) -> list[str]:
    """The cells, where blanks may part some numbers of a row and tabs the others."""
    if not any(" " in cell for cell in cells):
        return cells
    apart: list[str] = []
    for cell in cells:
        words = cell.split()
        apart += words if words and all(map(is_number, words)) else [cell]
    return apart


def _is_row(cells: list[str]) -> bool:
    return is_data(cells) and len(cells) > 2 and not cells[0].startswith(COMMENT)


def _block(text: str, header: dict[str, str]) -> Block:
    rows, lines, above = table_of(text)
    width = min(len(row) for row in rows)
    rows = [row[:width] for row in rows]
    headings = [
        *_SWEEP,
        *(Heading(str(i), f"column_{i}", None, None) for i in range(4, width + 1)),
    ]
    for i, own in enumerate(_own_headings(above, width)):
        if i >= len(_SWEEP):
            headings[i] = own
        elif own.unit is not None:
            # The format fixes what the first three are; a unit that is written goes before that of
            # the format.
            headings[i] = Heading(own.title, own.name, _SWEEP[i].role, own.unit)
    constants = {}
    has_temperatures = any(each.role == "temperature" and each.unit for each in headings)
    # One T for all rows says less than a column of temperatures.
    if _is_number(header.get("T", "")) and not has_temperatures:
        constants["temperature [degC]"] = header["T"]
    return Block("", tuple(headings), rows, lines, constants=constants)


def _own_headings(above: list[list[str]], width: int) -> tuple[Heading, ...]:
    """The names between the first line and the numbers, which the format does not ask for."""
    for i, cells in enumerate(above):
        if len(cells) >= 3 and heading(cells[1]).role == "storage":
            return headings_of(cells, above[i + 1 :], width)[:width]
    return ()


def _is_number(text: str) -> bool:
    try:
        return abs(float(text)) < 1e6
    except ValueError:
        return False


def _read_sweep(path: Path, choice: Choice) -> Measurement:
    """The sweep in a file.

    Raises
    ------
    DataError
        If it holds no such table.
    """
    text = text_of(path)
    header = first_line(text)
    block = _block(text, header)
    origin = {"format": "RepTate", **{f"reptate.{key}": value for key, value in header.items()}}
    return measurement_from([block], choice, path, origin)


SWEEP = Reader(
    "reptate", "RepTate .tts and .osc: omega, G' and G'' of one sweep", _is_sweep, _read_sweep
)


_LAOS = ("time [s]", "strain [-]", "stress [Pa]")
"""What the columns are by the definition of the format."""


def _is_laos(head: bytes) -> float:
    """High for a first line with a frequency."""
    header = first_line(head_text(head[:8000]))
    if not header.keys() & CLOCKS:
        return 0.0
    return 0.96


def _laos_signals(path: Path, choice: Choice) -> Signals:
    """The signals in a file.

    Raises
    ------
    DataError
        If there are no three columns of numbers.
    """
    rows, lines, above = table_of(text_of(path))
    named = [[cells[0].lstrip("#% "), *cells[1:]] for cells in above]
    titles = next((cells for cells in named if len(found_in(cells)) == 3), list(_LAOS))
    units = next((cells for cells in named if sum(map(is_unit, cells)) >= 3), [])
    if not units:
        titles = list(map(_with_unit, titles))
    places = places_of(titles, units, choice)
    width = max(places.columns) + 1
    values = []
    for row, line in zip(rows, lines, strict=True):
        padded = [*row, *[""] * width]
        try:
            values.append([_number(padded[i].strip()) for i in places.columns])
        except ValueError:
            raise DataError(f"line {line}: no number in its first {width} columns") from None
    return signals_from(list(np.array(values, dtype=float).T), places, path, "RepTate LAOS")


def _number(cell: str) -> float:
    if cell in MISSING:
        return np.nan
    return float(cell.replace(",", "."))


def _with_unit(title: str) -> str:
    """A name without a unit has that of the format."""
    channel, unit, _ = channel_of(title)
    if unit:
        return title
    return next((known for known in _LAOS if channel_of(known)[0] == channel), title)


LAOS = reader_of_signals(
    "reptate-laos",
    "RepTate .laos: strain and stress against time",
    _is_laos,
    _laos_signals,
)


STEPS = {"gt", "g(t)"}
"""Names that may stand above the second column of a relaxation."""


def _is_test(head: bytes) -> float:
    """High for a first line of keys above two columns of numbers, or with the rate of a startup."""
    text = head_text(head)
    keys = first_line(text)
    if not keys or keys.keys() & CLOCKS:
        return 0.0
    widths = {len(line.split()) for line in lines_of(text)[1:40] if _is_row_of_test(line)}
    # A sweep of RepTate has the same first line above three columns, but nothing that is sheared at
    # one rate; what stands behind the first two columns of a startup is the rheometer's.
    return 0.96 * (widths == {2} or ("gdot" in keys and bool(widths) and min(widths) >= 2))


def _read_test(path: Path, choice: Choice) -> list[TimeTest]:
    """The test in a file.

    Raises
    ------
    DataError
        If a row is none, or the rate or stress is no number.
    """
    if choice.columns or choice.part:
        raise DataError(
            f"{path}: RepTate's columns have their meaning by the format; leave out what follows"
            " the name"
        )
    text = text_of(path)
    keys, rows = first_line(text), _rows_of_test(text, path)
    temperature = None
    if "T" in keys:
        temperature = _value(keys, "T", path)
    origin = {"format": "RepTate", **{f"reptate.{key}": value for key, value in keys.items()}}
    rows = rows[without_ties(rows[:, 0], origin)]
    t, y = rows[:, 0], rows[:, 1]
    given = {"temperature": temperature, "name": path.stem, "provenance": origin}
    if "gdot" in keys:
        rate = _value(keys, "gdot", path)
        ramp = Loading(np.array([0.0, t[-1]]), np.array([0.0, rate * t[-1]]))
        # The file holds the growth of the viscosity, which times the rate is the stress.
        return [TimeTest(t, y * rate, ramp, letter="G", **given)]  # type: ignore[arg-type]
    if "stress" in keys:
        if keys.get("rec", "0") not in ("0", ""):
            origin["note recovery"] = (
                "the strain that came back once the stress was taken away, read as the creep"
                " without its flow: the recoverable compliance"
            )
        step = Loading.step(_value(keys, "stress", path))
        return [TimeTest(t, y, step, "force", letter="G", **given)]  # type: ignore[arg-type]
    return [replace(TimeTest.of_relaxation(t, y, "Pa", **given), letter="G")]  # type: ignore[arg-type]


def _is_row_of_test(line: str) -> bool:
    cells = line.split()
    return len(cells) > 1 and all(map(is_number, cells))


def _rows_of_test(text: str, path: Path) -> Real:
    lines = [line for line in lines_of(text)[1:] if _is_row_of_test(line)]
    rows = np.array([[float(cell) for cell in line.split()[:2]] for line in lines])
    if len(rows) < 2:
        raise DataError(f"{path}: a RepTate file without two columns of numbers")
    # A step at t = 0 has no value there that a finite sum could have.
    return rows[rows[:, 0] > 0.0]


def _value(keys: dict[str, str], key: str, path: Path) -> float:
    try:
        return float(keys[key])
    except ValueError:
        raise DataError(f"{path}: {key}={keys[key]:.20} in the first line is no number") from None


TEST = TimeReader(
    "time-reptate",
    "RepTate .gt, .shear and .creep: relaxation, startup, creep",
    _is_test,
    _read_test,
)
