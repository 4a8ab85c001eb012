"""RepTate (.tts, .osc): ``Mw=23.4;T=-35;chem=PI;``, then omega, G' and G'' in rad/s and Pa."""

from __future__ import annotations

import re
from pathlib import Path

from springpot.errors import DataError
from springpot.measurement import Choice, Measurement, Reader

from .blocks import Block, is_data
from .dynamic import measurement_from
from .grid import COMMENT, cells_of, is_number, lines_of, separator_in
from .headings import headings_of
from .text import head_text, text_of
from .titles import Heading, heading

# At least one semicolon: a lone "T = 20" heads the tables of many instruments. The last one is
# often forgotten.
HEADER = re.compile(
    r"(?=[^;\n]*;)(?:[A-Za-z_]\w{0,20}\s{0,9}=[^;=\n]{0,60}(?:;\s{0,9}|\Z)){1,40}\Z"
)
_FORMAT = (
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


def recognises(head: bytes) -> float:
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
        *_FORMAT,
        *(Heading(str(i), f"column_{i}", None, None) for i in range(4, width + 1)),
    ]
    for i, own in enumerate(_own_headings(above, width)):
        if i >= len(_FORMAT):
            headings[i] = own
        elif own.unit is not None:
            # The format fixes what the first three are; a unit that is written goes before that of
            # the format.
            headings[i] = Heading(own.title, own.name, _FORMAT[i].role, own.unit)
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


def read(path: Path, choice: Choice) -> Measurement:
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


READER = Reader(
    "reptate", "RepTate .tts and .osc: omega, G' and G'' of one sweep", recognises, read
)
