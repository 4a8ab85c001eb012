"""How numbers, names, commands, HTML and CSV are written, so that no data can break them.

Numbers have as many digits as are known, and no more. Text is escaped wherever it enters a page,
commands can be copied into a shell. A spreadsheet takes a cell such as ``=HYPERLINK(...)`` for a
formula and runs it; an apostrophe before it makes it text, as the Open Worldwide Application
Security Project advises ("CSV Injection").
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from html import escape
from io import StringIO
from math import floor, isfinite, log10
from shlex import quote

from .numerics import SMALLEST

DIGITS = 4
"""Significant digits of a number whose uncertainty is not known."""

NAMED = 3
"""Of a list in a sentence, how many are named; the rest is counted."""
LISTED = 8
"""Rows of a table, or names where one of many is wanted; the rest is counted."""
FEW = 6
"""Rows or colours that are taken in at a glance, where not everything is asked for."""
SHOWN = 5
"""Of what comes the most telling first, how many are shown."""
NARROWEST, USUAL, WIDEST = 60, 120, 140
"""Columns between which text is laid out: below, tables cannot be read; above, sentences cannot.

The usual number where no window says it.
"""
PLAIN = 4
"""Decimals of what rounds to zero.

``0.00`` beside ``0.12`` says how nearly it is known, a row of them nothing.
"""


def near_names(typed: str, known: Iterable[str]) -> list[str]:
    """The known names that may have been meant.

    Those whose words begin with the typed ones, in the order of `known`, then the most alike.

    Examples
    --------
    >>> near_names("frac-maxwell", ["kelvin", "fractional-maxwell", "maxwell"])
    ['fractional-maxwell', 'maxwell']
    >>> near_names("bananas", ["backlash"])
    []
    """
    names = list(known)
    parts = typed.lower().split("-")
    begun = [name for name in names if all(_begins(part, name) for part in parts)]
    return list(dict.fromkeys([*begun, *get_close_matches(typed, names, NAMED)]))[:NAMED]


def _begins(part: str, name: str) -> bool:
    """Whether a word of a name begins so."""
    return bool(part) and any(word.startswith(part) for word in re.split(r"[-/]", name.lower()))


def number(value: float | None, digits: int = DIGITS) -> str:
    """`value` with `digits` significant digits; a hyphen where there is none."""
    # Only nan differs from itself.
    if value is None or value != value:
        return "-"
    if not isfinite(value):
        if value > 0:
            return "inf"
        return "-inf"
    # Nothing has no first digit to count from.
    if value == 0:
        return "0"
    return at_place(value, exponent_of(value, digits) - digits + 1)


def exponent_of(value: float, digits: int = DIGITS) -> int:
    """Power of ten of the first digit, after rounding to `digits`: 9.9999 is printed as 10.00."""
    if abs(value) < SMALLEST:
        return 0
    exponent = floor(log10(abs(value)))
    return exponent + (round(abs(value) / 10.0**exponent, digits - 1) >= 10)


def at_place(value: float, place: int) -> str:
    """`value` rounded at 10**place; scientific where plain digits would be long."""
    if not isfinite(value):
        return number(value)
    # Nothing from below is nothing: without the sum, -0.001 would be printed as -0.00.
    rounded = round(value, -place) + 0.0
    # Nothing has no decimals, and what rounds to it would have as many as the place is small.
    if value == 0.0 or (rounded == 0.0 and -place > PLAIN):
        return "0"
    exponent = exponent_of(rounded)
    # Plain as long as people read it at a glance, and as every digit that is written is known.
    if rounded and (exponent >= 6 or exponent < -3) and exponent >= place:
        return f"{rounded:.{exponent - place}e}"
    return f"{rounded:.{max(0, -place)}f}"


def listed(names: Sequence[object], most: int | None = None) -> str:
    """Names in a row; of more than `most` it says how many more there are.

    Examples
    --------
    >>> from .writing import listed
    >>> listed(["k", "c", "alpha"], 2)
    'k, c and 1 more'
    """
    shown = ", ".join(map(str, names[:most]))
    if most is not None and len(names) > most:
        shown += f" and {len(names) - most} more"
    return shown


def counted(count: int, noun: str) -> str:
    """A number with its noun, such as ``1 point`` or ``3 points``.

    Examples
    --------
    >>> from .writing import counted
    >>> counted(1, "point"), counted(3, "point")
    ('1 point', '3 points')
    """
    if count == 1:
        return f"1 {noun}"
    return f"{count} {noun}s"


def suggested(verb: str, *words: object) -> str:
    """A command of springpot as a shell takes it.

    Parameters
    ----------
    verb : str
        What stands behind ``springpot``, such as ``list models``.
    *words : object
        Data, options and their values. Those in capitals, such as ``STUDY.py``, the reader
        replaces.

    Examples
    --------
    >>> from springpot.writing import suggested
    >>> print(suggested("diagnose", "my gel.csv", "--model", "kelvin + inertia"))
    springpot diagnose 'my gel.csv' --model 'kelvin + inertia'
    """
    return " ".join(["springpot", verb, *map(in_shell, words)])


def in_shell(word: object) -> str:
    """A word as a shell takes it."""
    return quote(str(word))


def with_model(model: str | None) -> list[str]:
    """The words that name a model, if there is one."""
    if model is None:
        return []
    return ["--model", model]


def accepting(effects: Iterable[str]) -> list[str]:
    """The words that accept effects one after the other."""
    return [word for effect in effects for word in ("--accept", effect)]


class Html(str):
    """Text that already is HTML."""

    __slots__ = ()


VOID = frozenset({"br", "img", "meta"})
"""Elements without an end."""


def html(part: str | int | float) -> Html:
    """`part` as HTML: text is escaped, `Html` stays as it is."""
    # What was escaped once would be shown with its escapes if it were escaped again.
    if isinstance(part, Html):
        return part
    return Html(escape(str(part)))


def joined(parts: Iterable[str]) -> Html:
    """Parts one after the other."""
    return Html("".join(html(part) for part in parts))


def tag(name: str, /, *children: str, **attributes: str) -> Html:
    """An element with its children.

    Parameters
    ----------
    name : str
        Such as ``p``.
    *children : str
        Text, which is escaped, or `Html`.
    **attributes : str
        Values are escaped; an underscore at the end of a name is dropped (``class_``), others
        become hyphens.
    """
    given = ""
    for key, value in attributes.items():
        attribute = key.rstrip("_").replace("_", "-")
        # `escape` turns quotation marks too: no value can end its attribute and begin another.
        given += f' {attribute}="{escape(value)}"'
    end = f"</{name}>"
    if name in VOID:
        end = ""
    return Html(f"<{name}{given}>{joined(children)}{end}")


def table(
    headers: Iterable[str], rows: Iterable[Iterable[str]], numbers: Iterable[str] = ()
) -> Html:
    """A table; cells are text, which is escaped, or `Html`.

    Parameters
    ----------
    headers : iterable of str
        One for each column.
    rows : iterable of iterables of str
        As many cells each.
    numbers : iterable of str
        Headers of the columns that are set flush right.
    """
    headers, numbers = list(headers), set(numbers)
    kinds: list[dict[str, str]] = []
    for header in headers:
        kind = {}
        if header in numbers:
            kind = {"class_": "number"}
        kinds.append(kind)
    head = tag(
        "tr", *(tag("th", header, **kind) for header, kind in zip(headers, kinds, strict=True))
    )
    # Each cell repeats its header, for screens too narrow for columns.
    named = [{**kind, "data_label": header} for header, kind in zip(headers, kinds, strict=True)]
    # Written once for a column: tables may have many thousand rows.
    ends = [tag("td", **kind).partition("</") for kind in named]
    body = []
    for row in rows:
        cells = zip(row, ends, strict=True)
        body.append(tag("tr", Html("".join(f"{a}{html(cell)}{b}{c}" for cell, (a, b, c) in cells))))
    return tag("table", tag("thead", head), tag("tbody", *body))


def wide(says: str, inside: Html, kind: str = "") -> Html:
    """What is scrolled where a screen is too narrow for it, by the keys too.

    Parameters
    ----------
    says : str
        What it is, for a screen reader.
    inside : Html
        Its content.
    kind : str
        A class of its own for the style sheet.
    """
    classes = f"scroll {kind}".strip()
    return tag("div", inside, class_=classes, tabindex="0", role="group", aria_label=says)


def wide_table(
    headers: Iterable[str], rows: Iterable[Iterable[str]], numbers: Iterable[str] = ()
) -> Html:
    """A `table` that is scrolled where a screen is too narrow for it."""
    headers = list(headers)
    return wide(f"table of {', '.join(headers)}", table(headers, rows, numbers))


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
    >>> from springpot.writing import guarded, unguarded
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
