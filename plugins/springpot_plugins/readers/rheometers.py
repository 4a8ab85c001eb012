"""Exports of Anton Paar RheoCompass and RheoPlus, and of Malvern rSpace.

Those of Anton Paar are short or full, in the instrument's language; Malvern writes one table for
all actions of a sequence, units in parentheses.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import Path

from .above import facts_of, pairs_in, with_conditions_above
from .blocks import Block, blocks_of
from .dynamic import reader_of_blocks
from .grid import grid_of, head_text, text_of
from .names import fold

_INTERVAL = re.compile(
    r"^[\" \t]{0,20}"
    r"(?:interval|abschnitt|messabschnitt|tramo|интервал|przedział|úsek|aralık|区间|區間|区間|间隔|インターバル|구간)"
    r"[^\t;,:：\n]{0,50}[:：]",
    re.IGNORECASE | re.MULTILINE,
)
_FIRST = re.compile(
    r"^[\"\s]{0,20}"
    r"(?:test|project|projet|projekt|proyecto|progetto|projeto|essai|versuch|prueba|prova|ensayo|messung|name|"
    r"プロジェクト|試験|テスト|项目|測試|测试|试验|프로젝트|시험|проект|испытание|badanie)"
    r" {0,20}[:：][\"\t;, ]",
    re.IGNORECASE,
)
_SERIES = re.compile(
    r"Data Series Information|Datenreihen-Info|Informations? sur les séries", re.IGNORECASE
)
_EASTERN = ("結果", "结果", "결과", "результат", "wynik")
_RESULTS = frozenset(
    map(
        fold,
        ("result", "résultat", "ergebnis", "resultado", "risultato", "name", "test", *_EASTERN),
    )
)
_INVALID = (
    *(
        "invalid",
        "ungültig",
        "ungultig",
        "inválido",
        "non valido",
        "ongeldig",
        "nieprawid",
        "neplatn",
        "недейств",
    ),
    *("无效", "無効", "무효"),
)


def _is_rheocompass(head: bytes) -> float:
    """High for the lines that stand above an interval."""
    text = head_text(head)
    return min(
        1.0,
        0.8 * bool(_INTERVAL.search(text) or _SERIES.search(text))
        + 0.18 * bool(_FIRST.match(text)),
    )


def _of_rheocompass(path: Path) -> tuple[list[Block], dict[str, str]]:
    """The intervals and what stands above them."""
    blocks, _ = blocks_of(grid_of(text_of(path)))
    made, pairs, result = [], [], ""
    for i, block in enumerate(blocks, 1):
        here = pairs_in(block.above)
        pairs += here
        result = next((value for key, value in here if fold(key) in _RESULTS - {"test"}), result)
        number = next(
            (
                value.split()[0]
                for key, value in here
                if _INTERVAL.match(f"{key}:") and value.split()
            ),
            "",
        )
        name = f"{result} interval {number or i}".strip()
        made.append(_valid(replace(block, name=name)))
    return with_conditions_above(made), facts_of(pairs)


def _valid(block: Block) -> Block:
    """The block without the points that the instrument calls invalid."""
    keep = [i for i, row in enumerate(block.rows) if not _is_invalid(row)]
    if len(keep) == len(block.rows):
        return block
    return replace(block, rows=[block.rows[i] for i in keep], lines=[block.lines[i] for i in keep])


def _is_invalid(row: Sequence[str]) -> bool:
    # The word stands in parentheses beside the number of the point.
    marked = "\n".join(cell.lower() for cell in row[:2] if "(" in cell)
    return any(word in marked for word in _INVALID)


RHEOCOMPASS = reader_of_blocks(
    "rheocompass",
    "Anton Paar RheoCompass and RheoPlus, short or full, in any language",
    _is_rheocompass,
    _of_rheocompass,
    "Anton Paar RheoCompass",
)


_MARKS = (
    "(sequence)(s)",
    "(action)(s)",
    "(elastic component)",
    "(viscous component)",
    "Action Name",
)


def _is_malvern(head: bytes) -> float:
    """High for the names of an rSpace table."""
    first = head_text(head[:8000]).lstrip("\ufeff \r\n").splitlines()[:1]
    # Two of these names are enough, one alone may be anybody's.
    marks = [mark for line in first for mark in _MARKS if mark in line]
    return min(1.0, 0.49 * len(marks))


def _of_malvern(path: Path) -> tuple[list[Block], dict[str, str]]:
    """One block for each action, in order; the file says nothing of the instrument."""
    blocks, _ = blocks_of(grid_of(text_of(path)))
    made: list[Block] = []
    for block in blocks:
        place = next(
            (i for i, h in enumerate(block.headings) if h.title.startswith("Action")), None
        )
        if place is None:
            made.append(block)
            continue
        start = 0
        # Only rows that follow one another: the same action may come again later in a sequence.
        for name, run in groupby(row[place].strip() for row in block.rows):
            stop = start + len(list(run))
            made.append(
                replace(
                    block, name=name, rows=block.rows[start:stop], lines=block.lines[start:stop]
                )
            )
            start = stop
    # The columns of all actions stand in one table: those of the others are empty.
    return [_without_blank_columns(block) for block in made], {}


def _without_blank_columns(block: Block) -> Block:
    """The columns that hold anything, so that an action shows what it measured."""
    filled = [any(row[i].strip() for row in block.rows) for i in range(len(block.headings))]
    keep = [i for i, there in enumerate(filled) if there]
    rows = [[row[i] for i in keep] for row in block.rows]
    return replace(block, headings=tuple(block.headings[i] for i in keep), rows=rows)


MALVERN = reader_of_blocks(
    "malvern", "Malvern rSpace, exported as CSV", _is_malvern, _of_malvern, "Malvern rSpace"
)
