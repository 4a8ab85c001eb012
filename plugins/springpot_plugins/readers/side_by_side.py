"""Curves side by side in one table.

Storage and loss once for each temperature, frequency or sample.

What makes the difference stands in the titles (``G' at 20 °C [Pa]``), in a row above them, or is
not said, where the same titles come again. A table is taken apart only where each part is complete;
otherwise it stays as it is.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import groupby

from springpot.measurement import Choice, normal_unit

from .blocks import Block
from .choices import CURVES, WHOLE, as_said
from .grid import is_number
from .names import FREQUENCIES, fold
from .title_words import CurveName, curve_in_cell, curve_of_number
from .titles import UNITS, Heading, Vocabulary, heading, title_again

_COPY = re.compile(r"\.(\d{1,3})\Z")
"""What programs put behind a title that comes again."""
_SEGMENT = re.compile(r"\d{1,4}\|\d{1,6}\Z")
_WIDEST = 2000
"""Columns beyond which a table stays as it is: each is looked up in several ways."""

Columns = list[tuple[int, Heading]]
"""Columns of one curve: where they stand, and what they are."""


def apart(blocks: Iterable[Block], choice: Choice | None = None) -> list[Block]:
    """The blocks, those with several curves side by side as one block for each.

    Parameters
    ----------
    blocks : iterable of Block
        The tables of a file.
    choice : Choice, optional
        What the user says; where it names columns by number or title, tables stay whole. ``curves``
        says what the numbers are by which curves are called.
    """
    given: Mapping[str, str] = {}
    if choice is not None:
        given = choice.columns
    title = given.get(CURVES, "")
    parts: list[Block] = []
    for block in blocks:
        shared = {each: title_again(block.headings, each) for each in given}
        shared = {key: title for key, title in shared.items() if title}
        # Numbers and titles are those of the file: in the parts the columns stand elsewhere. But a
        # title that stands above a column of each curve means all of them.
        if any(key not in (*block.words.said, *WHOLE, *shared) for key in given):
            parts.append(block)
            continue
        headings = list(block.headings)
        for i, each in enumerate(headings):
            for key, title in shared.items():
                if each.title == title:
                    headings[i] = as_said(each, given[key], block.words)
        for segment in _segments(replace(block, headings=tuple(headings))):
            parts += _apart(segment, title)
    return parts


def _segments(block: Block) -> list[Block]:
    """Sweeps one below the other whose rows are numbered as ``2|1``: segment and point."""
    first = [row[0].strip() for row in block.rows]
    if block.headings[0].role is not None or not all(map(_SEGMENT.match, first)):
        return [block]
    made, start = [], 0
    for number, run in groupby(cell.partition("|")[0] for cell in first):
        stop = start + len(list(run))
        rows, lines = block.rows[start:stop], block.lines[start:stop]
        made.append(
            replace(block, name=f"{block.name} segment {number}".strip(), rows=rows, lines=lines)
        )
        start = stop
    if len(made) == 1:
        made = [block]
    # The numbers of segment and point have served their purpose, and are no condition.
    return [
        replace(each, headings=each.headings[1:], rows=[row[1:] for row in each.rows])
        for each in made
    ]


def _apart(block: Block, title: str) -> list[Block]:
    headings = block.headings
    if len(headings) > _WIDEST:
        return [block]
    labels, above = _labels(block), block.above
    if labels:
        # Each part has its own of these as its name; the row of all of them would state the others'
        # as well.
        above = above[:-1]
    # The surest sign first: a title that states its condition, before one that merely comes again.
    for marked in (
        _by_title(headings),
        _by_label(headings, labels, block.words),
        _by_plain_title(headings, block.words),
        _again(headings, block.words),
    ):
        curves = _curves(headings, marked, block.words)
        if curves and all(_is_complete(columns, block.words) for _, columns in curves):
            certain = _are_temperatures([curve for curve, _ in curves])
            named = [(_called(curve, title), columns) for curve, columns in curves]
            made = [_part(block, above, curve, columns, certain) for curve, columns in named]
            return [part for part in made if part.rows] or [block]
    return [block]


def _called(curve: CurveName, title: str) -> CurveName:
    """The curve, where the user says of what its name is the number: ``temperature [degC]``."""
    meaning = heading(title)
    if not title or curve.title or not is_number(curve.text) or meaning.role is None:
        return curve
    if meaning.role == "repeat":
        return replace(curve, title="repeat", value=curve.text)
    if meaning.unit is None:
        return curve
    return replace(
        curve,
        title=f"{meaning.role} [{normal_unit(meaning.unit)}]",
        value=curve.text.replace(",", "."),
    )


def _by_title(headings: Sequence[Heading]) -> list[tuple[Heading, CurveName | None]]:
    return [(heading_, heading_.curve) for heading_ in headings]


def _by_label(
    headings: Sequence[Heading], labels: Sequence[CurveName | None], words: Vocabulary
) -> list[tuple[Heading, CurveName | None]]:
    if not labels or any(heading_.curve for heading_ in headings):
        return []
    return [(_uncopied(each, words), name) for each, name in zip(headings, labels, strict=True)]


def _by_plain_title(
    headings: Sequence[Heading], words: Vocabulary
) -> list[tuple[Heading, CurveName | None]]:
    """Titles such as ``G'_A [Pa]``, if no column of moduli is without such a name."""
    if any(heading_.role in words.values for heading_ in headings):
        return []
    return _by_title([words.plainly(heading_) for heading_ in headings])


def _again(
    headings: Sequence[Heading], words: Vocabulary
) -> list[tuple[Heading, CurveName | None]]:
    """Titles that come again: each time one does, the next curve begins."""
    seen: set[str] = set()
    made: list[tuple[Heading, CurveName | None]] = []
    number = 1
    for heading_ in (_uncopied(each, words) for each in headings):
        key = fold(heading_.title)
        if key and key in seen:
            number, seen = number + 1, set()
        seen.add(key)
        made.append((heading_, CurveName(f"curve {number}")))
    if number == 1:
        return []
    return made


def _uncopied(copy: Heading, words: Vocabulary) -> Heading:
    """A title without the number that programs put behind one that comes again: ``G' [Pa].1``."""
    match = _COPY.search(copy.title)
    if copy.role is not None or match is None:
        return copy
    plain = words.heading(copy.title[: match.start()])
    if plain.role is None:
        return copy
    return replace(plain, unit=plain.unit or copy.unit)


def _labels(block: Block) -> list[CurveName | None]:
    """What the row above the titles says of each column; empty where it names no curve."""
    if not block.above:
        return []
    row = block.above[-1]
    # Two cells of which the first ends in a colon are a key and its value, as in any report.
    if not 1 < len(row) <= len(block.headings) or (len(row) == 2 and row[0].endswith(":")):
        return []
    name_of: Callable[[str], CurveName] = curve_in_cell
    first, cells = heading(row[0]), list(row)
    if first.role in {"temperature", *FREQUENCIES} and first.unit is not None:
        unit = normal_unit(first.unit)
        cells[0] = ""
        if unit not in UNITS[str(first.role)] or not all(is_number(cell) for cell in cells if cell):
            return []
        name_of = partial(curve_of_number, unit=unit)
    elif any(map(is_number, cells)) and cells[0]:
        # Numbers from the first cell on are a row of a table, not the names of curves.
        return []
    curve_names: list[CurveName | None] = [None] * len(cells)
    for place, cell in enumerate(cells):
        if cell:
            curve_names[place] = name_of(cell)
    if sum(curve is not None for curve in curve_names) < 2:
        return []
    curve_names += [None] * (len(block.headings) - len(curve_names))
    for i in range(1, len(curve_names)):
        # One cell stands for those to its right, as where cells are merged.
        curve_names[i] = curve_names[i] or curve_names[i - 1]
    return curve_names


def _curves(
    headings: Sequence[Heading],
    marked: Sequence[tuple[Heading, CurveName | None]],
    words: Vocabulary,
) -> list[tuple[CurveName, Columns]]:
    """The columns of each curve, with those that all share.

    None where there is nothing to take apart.
    """
    curves: dict[str, tuple[CurveName, Columns]] = {}
    shared: Columns = []
    for place, (heading_, curve) in enumerate(marked):
        if curve is None:
            shared.append((place, heading_))
        else:
            curves.setdefault(_key(curve), (curve, []))[1].append((place, heading_))
    # A modulus that all share belongs to none of them: then the marks are no curves.
    if not curves or any(heading_.role in words.values for _, heading_ in shared):
        return []
    named = list(curves.values())
    # One curve is a table as it is, unless its mark states a condition that would be lost.
    if len(named) == 1 and not named[0][0].title:
        return []
    clock = _clock(named, words)
    return [(curve, _with_shared(columns, shared, clock, words)) for curve, columns in named]


def _key(curve: CurveName) -> str:
    if not curve.title:
        return curve.text.casefold()
    # By its value: "20 °C" and "20.0 °C" are one curve.
    return f"{curve.title}={float(curve.value):g}"


def _clock(curves: Sequence[tuple[CurveName, Columns]], words: Vocabulary) -> Columns:
    """The columns before the values of the first curve, for the others that have no clock."""
    columns = curves[0][1]
    first = next((i for i, (_, each) in enumerate(columns) if each.role in words.values), 0)
    return columns[:first]


def _with_shared(columns: Columns, shared: Columns, clock: Columns, words: Vocabulary) -> Columns:
    roles = {heading_.role for _, heading_ in columns}
    if not roles & words.clocks and not any(each.role in words.clocks for _, each in shared):
        shared = [*shared, *clock]
    return [
        *(
            (place, heading_)
            for place, heading_ in shared
            if heading_.role not in roles or not heading_.role
        ),
        *columns,
    ]


def _is_complete(columns: Columns, words: Vocabulary) -> bool:
    """Whether the columns are a whole table, each role of which is there once."""
    roles = [str(heading_.role) for _, heading_ in columns if heading_.role]
    values = [role for role in roles if role in words.values or role in words.clocks]
    curve_names = {
        heading_.curve.role for _, heading_ in columns if heading_.curve and heading_.curve.title
    }
    return len(values) == len(set(values)) and words.complete({*roles, *curve_names})


def _are_temperatures(curve_names: Sequence[CurveName]) -> bool:
    """Whether numbers before a mere C are temperatures.

    Where they are several, and nothing else is.
    """
    return len({curve.value for curve in curve_names}) > 1 and all(
        curve.role == "temperature" for curve in curve_names
    )


def has_condition(curve: CurveName, roles: Iterable[str]) -> bool:
    """Whether columns of these roles say what a name says."""
    if curve.role in FREQUENCIES:
        # A curve at 1 Hz and a column of omega say the same of each row.
        return not FREQUENCIES.isdisjoint(roles)
    return curve.role in set(roles)


def _part(
    block: Block, above: list[list[str]], curve: CurveName, columns: Columns, certain: bool
) -> Block:
    places = [place for place, _ in columns]
    # A row that ends early has nothing for this curve.
    filled = [i for i, row in enumerate(block.rows) if any(row[place].strip() for place in places)]
    roles = {str(heading_.role) for _, heading_ in columns}
    known = curve.title and (certain or not curve.bare) and not has_condition(curve, roles)
    stated: dict[str, str] = {}
    if known:
        stated[curve.title] = curve.value
    name = " ".join(word for word in (block.name, curve.text) if word)
    return replace(
        block,
        name=name,
        headings=tuple(heading_ for _, heading_ in columns),
        rows=[[block.rows[i][place] for place in places] for i in filled],
        lines=[block.lines[i] for i in filled],
        above=above,
        constants={**block.constants, **stated},
    )
