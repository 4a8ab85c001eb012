"""Tables as text: plain columns anywhere, ruled ones on a terminal."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from textwrap import wrap
from typing import Literal
from unicodedata import combining, east_asian_width

from springpot.terminal_safe import below, plain


@dataclass(frozen=True)
class TextTable:
    """A table of strings.

    Parameters
    ----------
    headers : sequence of str
        One for each column.
    rows : sequence of sequences of str
        As many cells each.
    right : str
        Headers of the columns that are set flush right, such as numbers.
    """

    headers: Sequence[str]
    rows: Sequence[Sequence[str]]
    right: frozenset[str] = frozenset()

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
        kept = [i for i, name in enumerate(self.headers) if name != header]
        headers = [self.headers[i] for i in kept]
        rows = [[row[i] for i in kept] for row in self.rows]
        return TextTable(headers, rows, self.right)

    def without(self, spare: Sequence[str], columns: int) -> TextTable:
        """The table without its first spare columns, as many as make it fit so many characters."""
        table = self
        for header in spare:
            if table.width <= columns:
                break
            table = table.lacking(header)
        return table

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


def fitted_to(part: str, columns: int) -> str:
    """Sentences broken at words to fit so many columns.

    A table has its own widths, and stays as it is.
    """
    if "\n---" in part:
        return part
    return wrapped(part, columns)


def paragraphs(parts: Iterable[str], columns: int) -> str:
    """The parts that say anything, fitted to so many columns, an empty line between them."""
    return "\n\n".join(fitted_to(part, columns) for part in parts if part)
