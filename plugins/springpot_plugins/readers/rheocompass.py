"""Anton Paar RheoCompass and RheoPlus: short and full exports in the instrument's language."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from .blocks import Block, blocks_of
from .conditions_above import with_conditions_above
from .dynamic import reader_of_blocks
from .grid import grid_of
from .header_facts import facts_of, pairs_in
from .names import fold
from .text import head_text, text_of

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


def recognises(head: bytes) -> float:
    """High for the lines that stand above an interval."""
    text = head_text(head)
    return min(
        1.0,
        0.8 * bool(_INTERVAL.search(text) or _SERIES.search(text))
        + 0.18 * bool(_FIRST.match(text)),
    )


def _parsed(path: Path) -> tuple[list[Block], dict[str, str]]:
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


READER = reader_of_blocks(
    "rheocompass",
    "Anton Paar RheoCompass and RheoPlus, short or full, in any language",
    recognises,
    _parsed,
    "Anton Paar RheoCompass",
)
