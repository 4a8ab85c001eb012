"""TA Instruments thermal analysis text (DMA Q800, RSA).

Signals are listed as ``Sig1 ...`` above ``StartOfData``.
"""

from __future__ import annotations

import re
from itertools import groupby
from pathlib import Path

from .blocks import Block
from .dynamic import reader_of_blocks
from .grid import is_number, lines_of
from .header_facts import facts_of, pairs_in
from .text import head_text, text_of
from .titles import heading

_SIGNAL = re.compile(r"^Sig\d{1,3}[ \t]+(\S.*)$")
_START = "StartOfData"


def recognises(head: bytes) -> float:
    """High for the list of signals; the numbers may begin far below."""
    lines = head_text(head).splitlines()
    named = sum(1 for line in lines if _SIGNAL.match(line))
    announced = any(line.startswith(("Nsig", _START)) for line in lines)
    if named < 2 or not announced:
        return 0.0
    return 0.97


def _parsed(path: Path) -> tuple[list[Block], dict[str, str]]:
    """One block for each segment of the method, and what the lines above the numbers say."""
    lines = lines_of(text_of(path))
    start = next((i + 1 for i, line in enumerate(lines) if line.startswith(_START)), len(lines))
    titles = [match[1].strip() for line in lines[:start] if (match := _SIGNAL.match(line))]
    headings = tuple(map(heading, titles))
    numbered = [(line.split(), i) for i, line in enumerate(lines[start:], start + 1)]
    blocks: list[Block] = []
    for is_row, run in groupby(
        numbered, lambda row: len(row[0]) == len(titles) and all(map(is_number, row[0]))
    ):
        if is_row:
            # What is no row of all signals marks the end of a segment.
            cells, places = zip(*run, strict=True)
            blocks.append(Block(f"segment {len(blocks) + 1}", headings, cells, places))
    return blocks, facts_of(pairs_in(line.split("\t") for line in lines[:start]))


READER = reader_of_blocks(
    "ta-thermal",
    "TA Instruments DMA (Q800, RSA), exported as text with Sig1, Sig2 and so on",
    recognises,
    _parsed,
    "TA thermal analysis",
)
