"""Cells of a CSV file that a spreadsheet would take for a formula, and run.

A program that opens ``=HYPERLINK(...)`` runs it. An apostrophe before it makes it text to a
spreadsheet; that is what the Open Worldwide Application Security Project advises ("CSV Injection").
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable
from io import StringIO

_SIGNS = r"[=+\-@\t\r＝＋－＠]"
_FORMULA = re.compile(rf"['\"]*{_SIGNS}")
"""Quotes may stand before it: in a line that is parted by others they are taken away."""
_GUARDED = re.compile(rf"'['\"]*{_SIGNS}")
_ALONE = frozenset("=+-@")
"""What is no formula as long as it is the whole cell, such as a dash for nothing."""
_PARTED = re.compile(r"[^,;\t]+")


def csv_text(rows: Iterable[Iterable[object]]) -> str:
    r"""Rows as the text of a CSV file, in which no cell of words is a formula.

    Examples
    --------
    >>> csv_text([["name", "value"], ["=1+1", -2.5]])
    "name,value\n'=1+1,-2.5\n"
    """
    stream = StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    for row in rows:
        writer.writerow([guarded(cell) if isinstance(cell, str) else cell for cell in row])
    return stream.getvalue()


def guarded(cell: str) -> str:
    """`cell` as a spreadsheet shows it rather than runs it; numbers stay as they are.

    Examples
    --------
    >>> guarded("=1+1"), guarded("-1.5e3"), guarded("a")
    ("'=1+1", '-1.5e3', 'a')
    """
    if cell in _ALONE:
        return cell
    return _guarded(cell)


def unguarded(cell: str) -> str:
    """What `guarded` was given.

    Examples
    --------
    >>> from .csv_safe import guarded, unguarded
    >>> unguarded(guarded("=1+1"))
    '=1+1'
    """
    if _GUARDED.match(cell):
        return cell[1:]
    return cell


def guarded_line(line: str) -> str:
    """A line of words, which a spreadsheet will part at commas, semicolons and tabs.

    Examples
    --------
    >>> from springpot.measurement import guarded_line
    >>> guarded_line("sample 4,=1+1,-2.5")
    "sample 4,'=1+1,-2.5"
    """
    # A quote that opens here may close anywhere, so that a sign is not alone for sure.
    return _PARTED.sub(lambda piece: _guarded(piece[0]), line)


def unguarded_line(line: str) -> str:
    """What `guarded_line` was given.

    Examples
    --------
    >>> from springpot.measurement import guarded_line, unguarded_line
    >>> unguarded_line(guarded_line("sample 4,=1+1,-2.5"))
    'sample 4,=1+1,-2.5'
    """
    return _PARTED.sub(lambda piece: unguarded(piece[0]), line)


def _guarded(cell: str) -> str:
    # A spreadsheet runs what begins like a formula; a number below zero begins so too, and is none.
    if _FORMULA.match(cell) and not _is_number(cell):
        return f"'{cell}"
    return cell


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
