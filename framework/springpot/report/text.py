"""Tables: plain columns anywhere, ruled ones on a terminal, elements of a page."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from textwrap import wrap
from typing import Literal
from unicodedata import combining, east_asian_width

from springpot.markup import Html, joined, tag
from springpot.markup import table as html_table
from springpot.terminal_safe import below, plain

SILENT = frozenset({"", "-"})
"""Cells that say nothing."""
LEAST = 12
"""Letters that are left of a name."""


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
            most = max(longest - table.width + columns, LEAST)
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
        cells = tag("div", html_table(table.headers, table.rows, table.right), class_="scroll")
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


def indented(text: str, by: str = "  ") -> str:
    """Every line of `text` behind `by`."""
    return "\n".join((by + line).rstrip() for line in text.splitlines())


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
        lines += wrap(
            line,
            columns,
            subsequent_indent=start + by,
            break_long_words=False,
            break_on_hyphens=False,
        )
    return "\n".join(lines)
