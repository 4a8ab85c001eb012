"""Names and units above a table, one for each of its columns."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from springpot.measurement import normal_unit

from .grid import COMMENT
from .titles import UNITS, Heading, heading, is_unit

_MOST_JOINED = 200
"""Words above a table that are tried in pairs; each joining looks at all of them again."""


def headings_of(names: Sequence[str], between: Iterable[Sequence[str]], width: int) -> tuple[Heading, ...]:
    """Titles with the units from the row below them, at least `width` of them."""
    titles = [unquoted(cell.strip()) for cell in uncommented(names)]
    if len(titles) > width:
        titles = _rejoined(titles, names, width)
    units: list[str | None] = [None] * max(len(titles), width)
    titles += [""] * (len(units) - len(titles))
    for row in between:
        if (found := units_in(row)) and len(found) <= len(units):
            units = _beside_titles(found, titles)
        elif len(row) == len(titles):
            titles = _in_two_rows(titles, [unquoted(cell.strip()) for cell in uncommented(row)])
    return tuple(heading(title, unit) for title, unit in zip(titles, units, strict=True))


def _beside_titles(units: Sequence[str], titles: Sequence[str]) -> list[str | None]:
    """The units under their titles: a column without one, such as a counter, leaves no gap between blanks."""
    spare = [None] * (len(titles) - len(units))
    from_left, from_right = [*units, *spare], [*spare, *units]
    fits = [
        sum(_fits(title, unit) for title, unit in zip(titles, each, strict=True)) for each in (from_left, from_right)
    ]
    return from_right if fits[1] > fits[0] else from_left


def _fits(title: str, unit: str | None) -> bool:
    """Whether this is a unit of what the title names."""
    known = UNITS.get(heading(title).role or "")
    return bool(unit) and known is not None and normal_unit(str(unit)) in known


def _in_two_rows(titles: list[str], below: Sequence[str]) -> list[str]:
    """Names that go on in the next row, ``Storage`` and ``modulus``, where more is known of the whole."""
    whole = [f"{title} {more}".strip() for title, more in zip(titles, below, strict=False)]
    known = [sum(1 for title in each if heading(title).role) for each in (titles, whole)]
    return whole if len(whole) == len(titles) and known[1] > known[0] else titles


def unquoted(cell: str) -> str:
    """Without quotes around it; the one of G" stays."""
    return cell[1:-1] if len(cell) > 1 and cell[0] == cell[-1] == '"' else cell


def _rejoined(titles: list[str], names: Sequence[str], width: int) -> list[str]:
    """Names with spaces in a file that is separated by them: joined where only the whole is known."""
    while width < len(titles) < min(4 * width + 8, _MOST_JOINED):
        pairs = [i for i in range(len(titles) - 1) if heading(" ".join(titles[i : i + 2])).role]
        pairs = [i for i in pairs if not (heading(titles[i]).role and heading(titles[i + 1]).role)]
        if not pairs:
            filled = [cell for cell in titles if cell]
            # Where the names that hold anything are as many as the numbers, the empty ones were wider gaps.
            return filled if len(filled) == width else titles
        i = pairs[0]
        titles[i : i + 2] = [" ".join(titles[i : i + 2])]
    return titles


def units_in(row: Sequence[str]) -> list[str]:
    """The units in a row that holds nothing else; none for other rows."""
    cells = [cell.strip() for cell in uncommented(row)]
    filled = [cell for cell in cells if cell and cell not in ("[]", "()")]
    known = [cell for cell in filled if is_unit(cell.strip("()[]")) or re.fullmatch(r"[\[(][^\[\]()]*[\])]", cell)]
    return cells if filled and len(known) >= max(1, 0.6 * len(filled)) else []


def beside(
    names: Sequence[str], between: Sequence[Sequence[str]], rows: Sequence[Sequence[str]]
) -> tuple[Sequence[str], Sequence[Sequence[str]]]:
    """Names and units with one cell for each of the rows, where the first name is of none of them, or lacks."""
    width = len(rows[0])
    if len(names) == width + 1 and names[0].strip().endswith(":"):
        # "Interval data:" stands before the names, and nothing before the numbers.
        return names[1:], [row[1:] if row and not row[0].strip() else row for row in between]
    if len(names) == width - 1 and all(len(row) == width for row in rows) and _are_row_names(rows):
        return ["", *names], between
    return names, between


def _are_row_names(rows: Sequence[Sequence[str]]) -> bool:
    """Whether the first cells count the rows, as some programs do without a name above them."""
    first = [row[0].strip().strip('"') for row in rows]
    return len(rows) > 1 and any(first == list(map(str, range(k, k + len(rows)))) for k in (0, 1))


def is_remark(row: Sequence[str]) -> bool:
    """Whether a row is a line of words, rather than names or units."""
    return sum(1 for cell in row if cell.strip()) == 1 and not units_in(row)


def uncommented(row: Sequence[str]) -> list[str]:
    """The cells without the sign of a comment before the first."""
    first = row[0].strip() if row else ""
    if not first.startswith(COMMENT):
        return list(row)
    bare = first.lstrip("#%!/ ")
    return [bare, *row[1:]] if bare else list(row[1:])
