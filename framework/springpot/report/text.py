"""Tables: plain columns anywhere, ruled ones on a terminal, elements of a page."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import floor, inf, isfinite, log10
from textwrap import wrap
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol
from unicodedata import combining, east_asian_width

from springpot.errors import below, plain, plain_json
from springpot.identification.value import LOST, Value
from springpot.plain_data import jsonable
from springpot.writing import Html, at_place, exponent_of, joined, number, tag, wide_table

from ..numerics import NEGLIGIBLE

if TYPE_CHECKING:
    from springpot.measurement.measurement import Measurement


SILENT = frozenset({"", "-"})
"""Cells that say nothing."""


class Letters(NamedTuple):
    """Of words for which there is little room, before they are cut or broken."""

    left: int
    """Letters that are left of a name."""
    specimen: int
    """Characters of such a name before it is cut."""
    title: int
    """Characters of a title before it is cut."""
    panel: int
    """Letters of a model's name above a panel before it is cut."""
    label: int
    """Letters of a label in a table; a longer one is cut."""
    step: int
    """Letters of a name's line before it is broken."""
    formula: int
    """Signs of a formula that stand on one line above its picture."""


LETTERS = Letters(left=12, specimen=18, title=78, panel=44, label=24, step=14, formula=62)


@dataclass(frozen=True)
class TextTable:
    """A table of strings.

    Parameters
    ----------
    headers : sequence of str
        One for each column.
    rows : sequence of sequences of str
        As many cells each.
    right : set of str
        Headers of the columns that are set flush right, such as numbers.
    spare : sequence of str
        Headers of columns that a narrow window goes without, the first first.
    legend : dict of str to str
        What some columns mean, told below the table.
    brief : TextTable, optional
        What a window shows that is too narrow even without spare columns.
    cuts : bool
        Whether names in the first column are cut as a last resort.
    whole : bool
        Whether any window shows all columns that tell anything.
    """

    headers: Sequence[str]
    rows: Sequence[Sequence[str]]
    right: frozenset[str] = frozenset()
    spare: Sequence[str] = ()
    legend: Mapping[str, str] = field(default_factory=dict)
    brief: TextTable | None = None
    cuts: bool = False
    whole: bool = False

    def plain(self) -> str:
        """Columns two blanks apart, a header line and a rule under it."""
        widths = [max(map(width, column)) for column in zip(self.headers, *self.rows, strict=True)]
        rule = ["-" * w for w in widths]
        return "\n".join(self._line(cells, widths) for cells in (self.headers, rule, *self.rows))

    @property
    def width(self) -> int:
        """Columns that it takes on a terminal."""
        return max(map(width, self.plain().splitlines()))

    def lacking(self, header: str) -> TextTable:
        """The table without one column."""
        return self._with([i for i, name in enumerate(self.headers) if name != header])

    def telling(self) -> TextTable:
        """The table without columns that say nothing in any row; the first names the rows."""
        silent = {
            place for place in range(1, len(self.headers)) if SILENT.issuperset(self._cells(place))
        }
        return self._with([i for i in range(len(self.headers)) if i not in silent])

    def _cells(self, place: int) -> list[str]:
        return [row[place] for row in self.rows]

    def _with(self, places: Sequence[int]) -> TextTable:
        """Only these columns."""
        headers = [self.headers[i] for i in places]
        return replace(self, headers=headers, rows=[[row[i] for i in places] for row in self.rows])

    def fitted(self, columns: int) -> TextTable:
        """The table as it fits so many characters, as far as it can be made to."""
        table = self.telling()
        if self.whole:
            return table
        for header in self.spare:
            if table.width <= columns:
                return table
            table = table.lacking(header)
        if table.width > columns and self.brief is not None:
            return self.brief.fitted(columns)
        # The last resort: a table that is broken by the window cannot be read, a name that is cut
        # can.
        if table.width > columns and self.cuts:
            longest = max(len(row[0]) for row in table.rows)
            most = max(longest - table.width + columns, LETTERS.left)
            shortened = [[cut(row[0], most), *row[1:]] for row in table.rows]
            return replace(table, rows=shortened)
        return table

    def _legend(self) -> list[str]:
        return [f"{name}: {means}" for name, means in self.legend.items() if name in self.headers]

    def as_text(self, columns: int) -> str:
        """As it fits so many characters, what its columns mean below it."""
        table = self.fitted(columns)
        return "\n".join([table.plain(), *table._legend()])

    def as_html(self) -> Html:
        """With all columns that tell anything; a page can be scrolled."""
        table = self.telling()
        cells = wide_table(table.headers, table.rows, table.right)
        return joined([cells, *(tag("p", line, class_="quiet") for line in table._legend())])

    def _line(self, cells: Sequence[str], widths: Sequence[int]) -> str:
        padded = []
        for header, cell, wanted in zip(self.headers, cells, widths, strict=True):
            space = " " * (wanted - width(cell))
            if header in self.right:
                padded.append(space + cell)
            else:
                padded.append(cell + space)
        return "  ".join(padded).rstrip()

    def show(self) -> None:
        """Print it: ruled and fitted to the window on a terminal, plain otherwise."""
        # In a file or pipe rules and colours are noise, and a width of its own would break the
        # columns.
        if not sys.stdout.isatty():
            print(self.plain())
            return
        from rich import box
        from rich.console import Console
        from rich.table import Table as Ruled
        from rich.text import Text

        ruled = Ruled(box=box.SIMPLE_HEAD, pad_edge=False)
        for header in self.headers:
            # `Text`, since in a plain string rich would take [kPa] for markup.
            side: Literal["left", "right"] = "left"
            if header in self.right:
                side = "right"
            ruled.add_column(Text(plain(header)), justify=side)
        for row in self.rows:
            ruled.add_row(*(Text(plain(cell)) for cell in row))
        # Past the stream that writes commands out: rich commands the terminal itself, and cells are
        # plain already.
        Console(file=below(sys.stdout), highlight=False).print(ruled)


def width(text: str) -> int:
    """Columns that `text` takes on a terminal."""
    return sum(_columns_of(letter) for letter in text)


def _columns_of(letter: str) -> int:
    """Columns of one letter.

    An accent stands on the letter before it, an ideograph is as wide as two.
    """
    if combining(letter):
        return 0
    if east_asian_width(letter) in "WF":
        return 2
    return 1


def cut(text: str, most: int) -> str:
    """At most so many letters of a name."""
    if len(text) <= most:
        return text
    return f"{text[: most - 1]}…"


def indented(text: str) -> str:
    """Every line of `text` behind two blanks."""
    return "\n".join(f"  {line}".rstrip() for line in text.splitlines())


def wrapped(text: str, columns: int, by: str = "  ") -> str:
    """Each line of `text` broken at words to fit so many columns, what follows set behind `by`."""
    lines = []
    for line in text.splitlines():
        if width(line) <= columns:
            lines.append(line)
            continue
        # What follows stands below what it belongs to.
        start = line[: len(line) - len(line.lstrip())]
        # Neither within words nor at hyphens: names such as fractional-maxwell are to be copied
        # whole.
        # A number and its per cent stay on one line.
        lines += wrap(
            line.replace(" %", "\N{NO-BREAK SPACE}%"),
            columns,
            subsequent_indent=start + by,
            break_long_words=False,
            break_on_hyphens=False,
        )
    return "\n".join(lines).replace("\N{NO-BREAK SPACE}%", " %")


APART = 5.0
"""Ratio of the ends of an interval from which each has its own digits.

Rounded alike, the lower one would vanish.
"""

MOST_DIGITS = 8
"""Significant digits of a number known to the last bit, as from noise-free artificial data."""


def percent(fraction: float | None, digits: int = 3) -> str:
    """A fraction as per cent, such as ``0.31 %``."""
    if fraction is None or not isfinite(fraction):
        return "-"
    return f"{number(100 * fraction, digits)} %"


def with_interval(value: float, low: float | None, high: float | None) -> tuple[str, str]:
    """A value and its interval, rounded alike to what the interval's width justifies.

    The half-width keeps two digits where they start with 10 to 35 and one above: the rule of the
    Particle Data Group's Review of Particle Physics (introduction, section 5.3).

    Returns
    -------
    tuple of str
        Such as ``("400.1", "[399.2, 401.0]")``; the interval is empty where there is none.
    """
    if low is None or high is None or low != low or high != high:
        return number(value), ""
    width = 0.5 * abs(high - low)
    # Neither an open end nor an interval of no width tells how many digits are known.
    if not isfinite(width) or width == 0:
        return number(value), f"[{number(low)}, {number(high)}]"
    # A value of nothing has no size to count digits from: its interval has.
    sized = value
    if abs(value) < NEGLIGIBLE * width:
        value, sized = 0.0, width
    size = exponent_of(sized)
    place = max(_place(width), size - MOST_DIGITS + 1)
    wide = low > 0.0 and high > APART * low
    # The interval says little more than the size of the value.
    if place > size or wide:
        return number(value, 2), f"[{number(low, 2)}, {number(high, 2)}]"
    return at_place(value, place), f"[{at_place(low, place)}, {at_place(high, place)}]"


def halved(value: float, low: float, high: float) -> tuple[str, str]:
    """A value and half the width of its interval, with the digits that `with_interval` keeps."""
    width = 0.5 * (high - low)
    if width <= 0.0:
        return number(value), "0"
    place = max(_place(width), exponent_of(value if value else width) - MOST_DIGITS + 1)
    size = at_place(value, place)
    # With the decimals that the value has, however small it is.
    if "e" not in size and place <= 0:
        return size, f"{width:.{-place}f}"
    return size, at_place(width, place)


def told_range(data: Measurement) -> str:
    """The frequencies of data as the file tells them, such as ``1.00 to 48.0 Hz``."""
    first, last = float(min(data.frequency)), float(max(data.frequency))
    low, high = number(data.units.on_clock(first), 3), number(data.units.on_clock(last), 3)
    clock = data.units.clock
    if low == high:
        return f"at {low} {clock}"
    return f"{low} to {high} {clock}"


def seconds(value: float) -> str:
    """A duration in the unit that fits."""
    for limit, factor, unit in ((1e-3, 1e6, "us"), (1.0, 1e3, "ms"), (120.0, 1.0, "s")):
        if value < limit:
            return f"{number(value * factor, 3)} {unit}"
    return f"{value / 60:.1f} min"


def _place(width: float) -> int:
    """The decimal place, as a power of ten, to which a quantity with this half-width is known."""
    exponent = floor(log10(width))
    leading = round(width / 10.0 ** (exponent - 2))
    # Two digits up to 354; up to 949 one; beyond, the width rounds to 1000 and keeps two again.
    if 355 <= leading < 950:
        return exponent
    return exponent - 1


NUMBERS = re.compile(r"\[\n\s*((?:-?\d[\d.eE+-]*|null|,\s+)+)\n\s*\]")
"""A list of numbers on lines of their own; within a string there is no line end."""


def to_json(value: Any, indent: int | None = 2) -> str:
    """Strict JSON text of `value`; ``indent=None`` gives one line, for JSON lines.

    Lists of numbers stand in one line each, so that people still see the rest.
    """
    text = json.dumps(jsonable(value), indent=indent, ensure_ascii=False, allow_nan=False)
    in_lines = NUMBERS.sub(lambda numbers: f"[{' '.join(numbers[1].split())}]", text)
    # Names in it come from strangers, and JSON is printed on terminals too.
    return plain_json(in_lines)


class Passage(Protocol):
    """A piece of a document; one of which nothing is left in text is not shown."""

    def as_text(self, columns: int) -> str:
        """For a window of so many columns."""

    def as_html(self) -> Html:
        """For a page."""


@dataclass(frozen=True)
class Prose:
    """Lines of text, of which each is a paragraph on a page.

    Parameters
    ----------
    *lines : str
        Empty ones are left out.
    """

    lines: tuple[str, ...]

    def __init__(self, *lines: str) -> None:
        object.__setattr__(self, "lines", tuple(filter(None, lines)))

    def as_text(self, columns: int) -> str:
        """Broken at words."""
        return wrapped("\n".join(self.lines), columns)

    def as_html(self) -> Html:
        """Paragraphs."""
        return joined(tag("p", line) for line in self.lines)


@dataclass(frozen=True)
class Listing:
    """Sentences of one kind, a line each.

    Parameters
    ----------
    items : sequence of str
        May be none.
    heading : str
        A line above them.
    mark : str
        Stands before each in text.
    hang : str
        Stands before what is broken off a line.
    """

    items: Sequence[str]
    heading: str = ""
    mark: str = ""
    hang: str = "  "

    def as_text(self, columns: int) -> str:
        """Broken at words, below the heading."""
        lines = [self.heading, *(f"{self.mark}{item}" for item in self.items)]
        return wrapped("\n".join(filter(None, lines)), columns, self.hang)

    def as_html(self) -> Html:
        """A list, the heading above it."""
        parts = [tag("p", self.heading)] if self.heading else []
        if self.items:
            # A page has bullets of its own.
            word = self.mark.strip(" -")
            parts.append(tag("ul", *(tag("li", f"{word} {item}".strip()) for item in self.items)))
        return joined(parts)


@dataclass(frozen=True)
class Preformatted:
    """A picture made of letters."""

    text: str

    def as_text(self, columns: int) -> str:
        """As it is, set in."""
        return indented(self.text)

    def as_html(self) -> Html:
        """As it is."""
        return tag("pre", self.text)


def as_text(document: Iterable[Passage], columns: int) -> str:
    """The parts that say anything for a window of so many columns, an empty line between them."""
    return "\n\n".join(filter(None, (part.as_text(columns) for part in document)))


def as_html(document: Iterable[Passage]) -> Html:
    """The parts as elements of a page."""
    return tag("div", *(part.as_html() for part in document))


OPEN = "not determined"


def shown(value: Value) -> tuple[str, str]:
    """A value and its interval as they are printed.

    Where the data leave an end open, the other end.
    """
    if value.fixed:
        return number(value.value), "fixed"
    # A value that is one thousandth of what it may be is not known to be anything.
    if value.low == 0.0 and LOST * value.value < value.high < inf:
        return "0", f"[0, {number(value.high, 2)}]"
    # Zero and what is below it have no decades to count, but an interval without an end says
    # nothing of them either.
    ends = isfinite(value.low) and isfinite(value.high)
    if value.determined or (value.value <= 0.0 and ends):
        return with_interval(value.value, value.low, value.high)
    # One end is known, and may be all that a user needs.
    if value.low > 0.0 and value.high == inf:
        return "-", f"{OPEN}, above {number(value.low, 2)}"
    return "-", OPEN
