"""HTML that cannot be broken by data: plain text is escaped wherever it enters a page."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape


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
    body = []
    for row in rows:
        cells = [tag("td", cell, **kind) for cell, kind in zip(row, named, strict=True)]
        body.append(tag("tr", *cells))
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
