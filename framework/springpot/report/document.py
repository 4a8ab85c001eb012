"""The document of an answer: made once, rendered as text or as HTML.

Terminal, notebook and report show the same parts, each in its own way.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

from springpot.markup import Html, joined, tag

from .text import indented, wrapped


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
