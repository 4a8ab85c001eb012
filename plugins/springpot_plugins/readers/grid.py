"""Bytes to text, and text as rows of cells, whatever separates them.

UTF-8, UTF-16, or the older code in which the file speaks of dynamic tests.
"""

from __future__ import annotations

import codecs
import csv
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from math import isnan
from pathlib import Path

from springpot.errors import DataError
from springpot.measurement import MOST_CELLS, MOST_COLUMNS, bytes_of

from .languages import CHANNELS, LANGUAGES

_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_OLDER = ("cp932", "gb18030", "big5", "cp949", "cp1251", "cp1250", "cp1254")
"""Codes of Japanese, Chinese, Korean, Russian, Polish and Turkish Windows.

Bytes alone cannot tell them apart.
"""
_WORDS = frozenset(
    word
    for names in (*LANGUAGES.values(), *CHANNELS.values())
    for word in names
    if not word.isascii() and len(word) > 1
)
"""What a table of dynamic tests says in languages that need one of those codes."""
HEAD = 1 << 15
"""Signs of a file by which its format is told: there stand the names of columns, if it has any."""
_CONTROL = bytes(set(range(32)) - set(b"\t\n\r\f")) + b"\x7f"


def encoding_of(head: bytes) -> str | None:
    """The encoding of a text that begins with `head`, or None if it is no text."""
    for mark, encoding in _MARKS:
        if head.startswith(mark):
            return encoding
    if b"\0" in head:
        return _wide(head)
    if head.translate(None, _CONTROL) != head:
        return None
    # The head may end within a character: an incremental decoder waits for the rest of it.
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return _older(head)
    return "utf-8"


def _older(head: bytes) -> str:
    """The code in which the text has most words of the field.

    Latin-1 where it has none in any other.
    """
    count = dict.fromkeys(("latin-1", *_OLDER), 0)
    head = head[:HEAD]
    for encoding in count:
        # The head may end within a character; what cannot be read at all has no words either.
        text = head.decode(encoding, errors="ignore").casefold()
        count[encoding] = sum(word in text for word in _WORDS)
    return max(count, key=lambda encoding: count[encoding])


def _wide(head: bytes) -> str | None:
    """UTF-16 without a mark: western text has a zero in every second byte."""
    # Not every second byte: a prime or an omega has no zero in it.
    even, odd = head[0::2], head[1::2]
    if len(odd) and odd.count(0) > 0.9 * len(odd) and not even.count(0):
        return "utf-16-le"
    if len(even) and even.count(0) > 0.9 * len(even) and not odd.count(0):
        return "utf-16-be"
    return None


def head_text(head: bytes) -> str:
    """As much of a file's beginning as is text; empty for what is none."""
    encoding = encoding_of(head)
    if encoding is None:
        return ""
    # The head may end within a character.
    return head.decode(encoding, errors="ignore")


def text_of(path: Path) -> str:
    """The whole text of a file.

    Raises
    ------
    DataError
        If it is empty, too large, no text, or cannot be read.
    """
    data = bytes_of(path)
    if not data.strip():
        raise DataError("the file is empty")
    encoding = encoding_of(data[: 1 << 16])
    # A beginning without accents is UTF-8 by any code: then the whole file tells.
    if encoding == "utf-8" and encoding_of(data) != "utf-8":
        encoding = encoding_of(data)
    if encoding is None:
        raise DataError("this is no text file; save the table as CSV in UTF-8")
    try:
        return data.decode(encoding)
    except UnicodeDecodeError as error:
        raise DataError(
            f"byte {error.start} is no {encoding} text; save the table as CSV in UTF-8"
        ) from None


NUMBER = re.compile(r"\s*[-+−]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eEdD][-+]?\d+)?\s*\Z")
APOSTROPHES = re.compile(r"\s*[-+−]?\d{1,3}(?:['’]\d{3})+(?:[.,]\d*)?\s*\Z")
"""Thousands as in Switzerland: 1'234.5."""
THOUSANDS = re.compile(r"\s*[-+]?\d{1,3}(?:,\d{3})+\.\d*\s*$")
POINTS = re.compile(r"\s*[-+]?\d{1,3}(?:\.\d{3})+,\d*\s*$")
BLANKS = re.compile(r"\s*[-+]?\d{1,3}(?:[^\S\t]\d{3})+(?:[.,]\d*)?\s*$")
"""Other thousands: 1,234.5; 1.234,5; 1 234,5."""
_SIZE = r"(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?"
COMPLEX = re.compile(
    rf"\s*\(?\s*([-+−]?\s*{_SIZE})\s*([-+−])\s*(?:({_SIZE})\s*\*?\s*[ijIJ]|[ijIJ]\s*\*?\s*({_SIZE}))\s*\)?\s*\Z"
)
"""A complex number as programs write it: ``(1+2j)``, ``1.2 + 0.3i``, ``1,2-i0,3``, ``1 + 2*I``."""
DEVIATING = re.compile(rf"\s*\(?\s*([-+−]?{_SIZE})\s*(?:±|\+/-|\+-)\s*({_SIZE})\s*\)?\s*\Z")
"""A value with its deviation: ``12.3 ± 0.4``."""
_STYLES = (APOSTROPHES, THOUSANDS, POINTS, BLANKS, COMPLEX, DEVIATING)
MISSING = frozenset(
    (
        *(
            "",
            "-",
            "--",
            "---",
            "----",
            "-----",
            "------",
            "*",
            "***",
            "****",
            "*****",
            "******",
            "—",
            "–",
            "?",
        ),
        *(
            "n/a",
            "N/A",
            "NA",
            "nan",
            "NaN",
            "NAN",
            "-nan",
            "null",
            "None",
            "none",
            "#N/A",
            "#NV",
            "#DIV/0!",
        ),
        *("n.a.", "N.A.", "n. a.", "n.d.", "n.v.", "k.A.", "k. A.", "N/D", "n/d"),
        *("#NAME?", "#NUM!", "#NULL!", "#WERT!", "#ZAHL!", "#BEZUG!"),
        *("#VALUE!", "#REF!", "inf", "-inf", "Inf", "-Inf", "1.#QNAN", "-1.#IND"),
        *(
            "OL",
            "OVL",
            "OVLD",
            "OVERLOAD",
            "Overload",
            "Over",
            "over",
            "ERR",
            "Error",
            "#ERR",
            "invalid",
        ),
    )
)
"""What stands where nothing was measured."""
SEPARATORS = (";", "\t", ",", "|", " ")
COMMENT = ("#", "%", "//", "!")
LONGEST_CELL = 500
"""Signs of a cell of a spreadsheet that are kept.

No name of a column is longer, and patterns are sought in it.
"""
SEARCHED = 500
"""Lines that may stand above the names of a table, or above its numbers."""
_SAMPLED = 300
"""Lines of the whole file by which the separator is told."""
_OPEN = re.compile(r'(?:^|[;,\t|]) *"[^"]*$')
"""A last cell whose quote is not closed."""
_MOST_JOINED = 3
"""Lines that a quoted cell may go on in.

A quote that never closes must not swallow the rest of the file.
"""
_LONG = 20_000
"""Signs beyond which a line is no row of a table: to take it apart in every way would take long."""
_BY_BLANKS = 0.8
"""Weight of blanks as separators."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Rows of cells with their line numbers; cells are stripped only where they are used.

    Parameters
    ----------
    rows : list of list of str
        The cells.
    lines : list of int
        Line numbers in the file.
    separator : str
        What stands between the cells; a space for any white space.
    """

    rows: list[list[str]]
    lines: Sequence[int]
    separator: str = ","


def is_number(cell: str) -> bool:
    """Whether a cell is a number, with point or comma."""
    return NUMBER.match(cell) is not None


def holds_number(cell: str) -> bool:
    """Whether a cell is a number in any style.

    With thousands parted, complex, or with its deviation.
    """
    if NUMBER.match(cell):
        return True
    return any(style.match(cell) for style in _STYLES)


def lines_of(text: str) -> list[str]:
    """The lines of a text, with any kind of ending."""
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def separator_in(lines: Sequence[str]) -> str:
    """The sign that makes the most numbers of the lines, and the fewest cells that are none."""
    # A sample of the whole file beside its beginning, which may be a long report.
    step = max(1, len(lines) // _SAMPLED)
    sample = [
        line
        for line in (*lines[:50], *lines[50::step])
        if any(sign.isdigit() for sign in line[:200])
    ]
    gains = {
        sign: sum(_gain(line, sign) for line in sample if len(line) < _LONG) for sign in SEPARATORS
    }
    # White space also splits words within cells, which may look like a number gained.
    gains[" "] = int(_BY_BLANKS * gains[" "])
    if not any(gains.values()):
        # As many words as numbers in each row: then the sign that gives all lines the same number
        # of cells.
        return max(SEPARATORS, key=lambda sign: _evenness(sample, sign))
    return max(SEPARATORS, key=gains.__getitem__)


def _evenness(lines: Sequence[str], separator: str) -> int:
    """How many lines have the most usual number of cells, of at least three."""
    widths = Counter(len(split_line(line, separator)) for line in lines if len(line) < _LONG)
    return max((count for width, count in widths.items() if width > 2), default=0)


# Each reader that is asked whether it knows a file looks at the same lines, and then who reads it.
@lru_cache(maxsize=8192)
def _gain(line: str, separator: str) -> int:
    cells = split_line(line, separator)
    if len(cells) < 2:
        return 0
    numbers = sum(map(holds_number, cells))
    if numbers < 2:
        # A key and its value are parted by many signs.
        return 0
    filled = sum(1 for cell in cells if cell.strip())
    return max(0, 2 * numbers - filled)


def cells_of(line: str, separator: str, number: int) -> list[str]:
    """The cells of a line.

    Raises
    ------
    DataError
        If quotes do not close.
    """
    try:
        return split_line(line, separator)
    except csv.Error as error:
        raise DataError(f"line {number}: {error}") from None


def split_line(line: str, separator: str) -> list[str]:
    """The cells of a line; quotes that do not close are an error of csv."""
    if separator == " ":
        return line.split()
    if (
        '"' not in line
        or line.count('"') % 2
        or not re.search(rf'(?:^|{re.escape(separator)}) *"', line)
    ):
        # A lone quote is a prime, as in G".
        return line.split(separator)
    return next(csv.reader([line], delimiter=separator, skipinitialspace=True), [""])


def closed(lines: Iterable[tuple[int, str]]) -> list[tuple[int, str]]:
    """The lines, where a quoted cell that goes on in the next lines is one line of words."""
    whole: list[tuple[int, str]] = []
    joining = 0
    for number, line in lines:
        if joining:
            first, begun = whole[-1]
            whole[-1] = (first, f"{begun} {line}")
            joining -= 1
            if whole[-1][1].count('"') % 2 == 0:
                joining = 0
        else:
            whole.append((number, line))
            # An even number of quotes is closed; a lone one behind other signs is a prime, as in
            # G".
            if line.count('"') % 2 and _OPEN.search(line):
                joining = _MOST_JOINED
    return whole


def grid_of(text: str) -> Grid:
    """All lines that hold anything, as rows of cells.

    Raises
    ------
    DataError
        If there is nothing.
    """
    lines = lines_of(text)
    if lines and re.fullmatch(r"\ufeff?sep=.", lines[0].strip()):
        # A word of Excel to itself; emptied, not removed, so that errors name the right lines.
        lines[0] = ""
    filled = closed((i, line) for i, line in enumerate(lines, 1) if line and not line.isspace())
    if not filled:
        raise DataError("the file holds no table")
    separator = separator_in([line for _, line in filled])
    rows = [cells_of(line, separator, i) for i, line in filled]
    require_columns(max(map(len, rows)))
    return Grid(rows, [i for i, _ in filled], separator)


def head_grid(text: str, most: int = 400) -> Grid:
    """The first lines of a file as rows, for its recognition; never an error."""
    numbered = (
        (i, line) for i, line in enumerate(lines_of(text[:HEAD])) if line and not line.isspace()
    )
    filled = [line for _, line in closed(islice(numbered, most))]
    if len(filled) > 1 and len(text) >= HEAD:
        # The last line may be cut off.
        filled = filled[:-1]
    if not filled:
        return Grid([], range(1, 1))
    separator = separator_in(filled)
    rows = [split_line(line, separator) for line in filled]
    return Grid(rows, range(1, len(rows) + 1), separator)


def require_columns(count: int) -> None:
    """Refuse a table that is wider than any that somebody measured.

    Raises
    ------
    DataError
        With what to do.
    """
    if count > MOST_COLUMNS:
        raise DataError(
            f"{count} columns, of which {MOST_COLUMNS} are read; save those that matter alone"
        )


def shortest(value: float) -> str:
    """The shortest decimals that read back as the same bits.

    Nothing for nan, which stands for a gap.
    """
    if isnan(value):
        return ""
    return repr(value)


@dataclass
class Unpacked:
    """How many cells of a workbook have been unpacked, of all its sheets together."""

    cells: int = 0

    def counted(self, rows: Iterable[list[str]]) -> Iterator[list[str]]:
        """The rows of a sheet, as long as there are not too many.

        Raises
        ------
        DataError
            If there are; while they come, for how many there are is known when all have been
            unpacked.
        """
        for cells in rows:
            self.cells += len(cells)
            if self.cells > MOST_CELLS:
                raise DataError(
                    f"a workbook of more than {MOST_CELLS} cells; save the table that matters"
                    " as CSV"
                )
            yield cells


def grid_of_sheet(rows: Iterable[list[str]]) -> Grid:
    """The rows of a sheet as a grid, without those that hold nothing."""
    kept: list[list[str]] = []
    lines: list[int] = []
    for number, cells in enumerate(rows, 1):
        # A sheet is as wide as its widest table: what is blank behind a row is none of it.
        while cells and not cells[-1]:
            cells.pop()
        if cells:
            kept.append(cells)
            lines.append(number)
    return Grid(kept, lines, "\t")
