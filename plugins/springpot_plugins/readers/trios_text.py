"""TA Instruments TRIOS as CSV or text.

A header of keys and values, then steps of names, units and numbers.
"""

from __future__ import annotations

import re
from pathlib import Path

from .blocks import Block, blocks_of
from .dynamic import reader_of_blocks
from .grid import grid_of
from .header_facts import facts_of, pairs_in
from .text import head_text, text_of

_STEP = re.compile(r"^[ \t]{0,20}\"?\[step\]", re.IGNORECASE | re.MULTILINE)
_HEADER = re.compile(
    r"^\"?(?:Filename|proceduresegments|Trios version|\[File Parameters\])\b", re.I | re.M
)
_LIMS = re.compile(r"LIMS export|^Variables\t", re.MULTILINE)


def recognises(head: bytes) -> float:
    """High for the sections of a TRIOS export."""
    text = head_text(head)
    if _LIMS.search(text):
        # The export to LIMS has a reader of its own.
        return 0.0
    return 0.5 * bool(_STEP.search(text)) + 0.48 * bool(_HEADER.search(text))


def _parsed(path: Path) -> tuple[list[Block], dict[str, str]]:
    """The steps, and what stands above each of them."""
    blocks, _ = blocks_of(grid_of(text_of(path)))
    return blocks, facts_of(pairs_in(row for block in blocks for row in block.above))


READER = reader_of_blocks(
    "trios", "TA Instruments TRIOS, exported as CSV or text", recognises, _parsed, "TA TRIOS"
)
