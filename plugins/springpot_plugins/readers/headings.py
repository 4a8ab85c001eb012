"""Names and units above a table, one for each of its columns."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

from springpot.measurement import MODULUS_UNITS, normal_unit

from .grid import COMMENT
from .titles import SWEEPS, Heading, Vocabulary, is_unit, unbracketed

_WITH_DEVIATION = frozenset({"storage", "loss"})
_DEVIATIONS = frozenset(
    (
        *(
            "±",
            "+/-",
            "+-",
            "sd",
            "s.d",
            "std",
            "std.",
            "stdev",
            "st.dev",
            "std dev",
            "std. dev",
            "stddev",
            "σ",
            "sigma",
        ),
        *(
            "standard deviation",
            "uncertainty",
            "standardabweichung",
            "unsicherheit",
            "écart-type",
            "écart type",
        ),
        *("ecart-type", "ecart type", "desviación estándar", "deviazione standard"),
    )
)
_COUNTED = re.compile(r"[._ ]\d{1,3}\Z")
"""What programs put behind a title that comes again."""
_MOST_JOINED = 200
"""Words above a table that are tried in pairs; each joining looks at all of them again."""


def headings_of(
    names: Sequence[str],
    between: Iterable[Sequence[str]],
    width: int,
    words: Vocabulary = SWEEPS,
) -> tuple[Heading, ...]:
    """Titles with the units from the row below them, at least `width` of them."""
    titles = [unquoted(cell.strip()) for cell in uncommented(names, width)]
    if len(titles) > width:
        titles = _rejoined(titles, names, width, words)
    units: list[str | None] = [None] * max(len(titles), width)
    titles += [""] * (len(units) - len(titles))
    for row in between:
        if (row_units := units_in(row, width)) and len(row_units) <= len(units):
            units = _beside_titles(row_units, titles, words)
        elif len(row) == len(titles):
            below = [unquoted(cell.strip()) for cell in uncommented(row, width)]
            titles = _in_two_rows(titles, below, words)
    for place, (title, unit) in enumerate(zip(titles, units, strict=True)):
        if unit and not title and words.heading(unit).role:
            # A name that stands in the row of units, as where pandas names the index below the
            # columns.
            titles[place], units[place] = unit, None
    return with_deviations(
        words.heading(title, unit) for title, unit in zip(titles, units, strict=True)
    )


def named_above(
    headings: Sequence[Heading], above: Sequence[str], words: Vocabulary
) -> tuple[Heading, ...]:
    """The headings, where one that is only a unit takes the name that stands in the row above.

    Parameters
    ----------
    headings : sequence of Heading
        Of the last row above the numbers: ``Hz``, ``G'``, ``G''``.
    above : sequence of str
        Cells of the row before it: ``f``, ``run 1``, an empty one.
    words : Vocabulary
        What the titles mean.
    """
    made = list(headings)
    for place, (each, name) in enumerate(zip(headings, above, strict=False)):
        if each.role is None and _fits(name, unbracketed(each.title), words):
            made[place] = words.heading(name, each.title)
    return tuple(made)


def with_deviations(headings: Iterable[Heading]) -> tuple[Heading, ...]:
    """The headings, where a mere "±" or "SD" is the deviation of the column before it."""
    made: list[Heading] = []
    for each in headings:
        if (
            made
            and made[-1].role in _WITH_DEVIATION
            and each.role is None
            and _says_deviation(each)
        ):
            role = f"{made[-1].role}_sd"
            each = replace(each, name=role, role=role, unit=each.unit or made[-1].unit)
        made.append(each)
    return tuple(made)


def _says_deviation(each: Heading) -> bool:
    word = _COUNTED.sub("", each.name.strip().strip("().").casefold())
    # A share of the value is no standard deviation in the unit of the modulus.
    return word in _DEVIATIONS and normal_unit(each.unit or "Pa") in MODULUS_UNITS


def _beside_titles(
    units: Sequence[str], titles: Sequence[str], words: Vocabulary
) -> list[str | None]:
    """The units under their titles.

    A column without one, such as a counter, leaves no gap between blanks.
    """
    spare = [None] * (len(titles) - len(units))
    from_left, from_right = [*units, *spare], [*spare, *units]
    # From the left unless the other way fits better: most tables are written so.
    left, right = (
        sum(_fits(title, unit, words) for title, unit in zip(titles, side, strict=False))
        for side in (from_left, from_right)
    )
    if right > left:
        return from_right
    return from_left


def _fits(title: str, unit: str | None, words: Vocabulary) -> bool:
    """Whether this is a unit of what the title names."""
    known = words.units.get(words.heading(title).role or "")
    return bool(unit) and known is not None and normal_unit(str(unit)) in known


def _in_two_rows(titles: list[str], below: Sequence[str], words: Vocabulary) -> list[str]:
    """Names that go on in the next row (``Storage``, ``modulus``), where that makes more known."""
    whole = [f"{title} {more}".strip() for title, more in zip(titles, below, strict=False)]
    if len(whole) == len(titles) and _known_among(whole, words) > _known_among(titles, words):
        return whole
    return titles


def _known_among(titles: Sequence[str], words: Vocabulary) -> int:
    """How many of the titles name something that is known."""
    return sum(1 for title in titles if words.heading(title).role)


def unquoted(cell: str) -> str:
    """Without quotes around it; the one of G" stays."""
    if len(cell) > 1 and cell[0] == cell[-1] == '"':
        return cell[1:-1]
    return cell


def _rejoined(titles: list[str], names: Sequence[str], width: int, words: Vocabulary) -> list[str]:
    """Names with spaces in a file separated by spaces: joined where only the whole is known.

    What a bracket opens is one name in any case, if it closes.
    """
    titles = _bracketed(titles)
    while width < len(titles) < min(4 * width + 8, _MOST_JOINED):
        known = [bool(words.heading(title).role) for title in titles]
        pairs = [
            i
            for i in range(len(titles) - 1)
            if words.heading(" ".join(titles[i : i + 2])).role
            # Two names that are both known by themselves are two columns, whatever they are
            # together.
            and not (known[i] and known[i + 1])
        ]
        if not pairs:
            # Where the names that hold anything are as many as the numbers, the empty ones were
            # wider gaps.
            filled = [cell for cell in titles if cell]
            if len(filled) == width:
                return filled
            break
        i = pairs[0]
        titles[i : i + 2] = [" ".join(titles[i : i + 2])]
    return titles


def _bracketed(titles: Sequence[str]) -> list[str]:
    """The titles, those from one that opens a bracket to the one that closes it as one."""
    made: list[str] = []
    begun = 0
    for i, title in enumerate(titles):
        made.append(title)
        whole = " ".join(titles[begun : i + 1])
        if all(whole.count(a) == whole.count(b) for a, b in ("()", "[]")):
            made[len(made) - (i + 1 - begun) :] = [whole]
            begun = i + 1
    return made


def units_in(row: Sequence[str], width: int = 0) -> list[str]:
    """The units in a row that holds nothing else; none for other rows.

    Beside numbers in `width` columns, where that is known.
    """
    cells = [cell.strip() for cell in uncommented(row, width)]
    filled = [cell for cell in cells if cell and cell not in ("[]", "()")]
    known = [
        cell
        for cell in filled
        if is_unit(cell.strip("()[]")) or re.fullmatch(r"[\[(][^\[\]()]*[\])]", cell)
    ]
    # Not all: a column that is of no interest may have a unit that is not known.
    if filled and len(known) >= max(1, 0.6 * len(filled)):
        return cells
    return []


def beside(
    names: Sequence[str], between: Sequence[Sequence[str]], rows: Sequence[Sequence[str]]
) -> tuple[Sequence[str], Sequence[Sequence[str]]]:
    """Names and units, one cell a row, where the first name is of none of the rows, or lacks."""
    width = len(rows[0])
    bare = uncommented(names, width)
    if len(bare) == width + 1 and bare[0].strip().endswith(":"):
        # "Interval data:" stands before the names, and nothing before the numbers.
        return bare[1:], [_without_key(uncommented(row, width), width) for row in between]
    if len(names) == width - 1 and all(len(row) == width for row in rows) and _are_row_names(rows):
        return ["", *names], between
    return names, between


def _without_key(row: Sequence[str], width: int) -> Sequence[str]:
    """A row without the blank, or the word such as "Units:", that stands before its columns."""
    first = "".join(row[:1]).strip()
    if not first or (len(row) == width + 1 and first.endswith(":")):
        return row[1:]
    return row


def _are_row_names(rows: Sequence[Sequence[str]]) -> bool:
    """Whether the first cells count the rows, as some programs do without a name above them."""
    first = [row[0].strip().strip('"') for row in rows]
    return len(rows) > 1 and any(first == list(map(str, range(k, k + len(rows)))) for k in (0, 1))


def is_remark(row: Sequence[str]) -> bool:
    """Whether a row is a line of words, rather than names or units."""
    return sum(1 for cell in row if cell.strip()) == 1 and not units_in(row)


def uncommented(row: Sequence[str], width: int = 0) -> list[str]:
    """The cells without the sign of a comment before the first.

    In a cell of its own it is a comment only where it stands above none of `width` columns: above
    one, "#" names a counter, and "%" is the unit of a strain.
    """
    if not row or not row[0].strip().startswith(COMMENT):
        return list(row)
    bare = row[0].strip().lstrip("#%!/ ")
    if not bare:
        return list(row[len(row) > width :])
    return [bare, *row[1:]]
