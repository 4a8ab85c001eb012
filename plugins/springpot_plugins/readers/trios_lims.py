"""TA Instruments TRIOS "export to LIMS": every line begins with a word that says what it is."""

from __future__ import annotations

from pathlib import Path

from .blocks import Block
from .dynamic import reader_of_blocks
from .grid import lines_of
from .header_facts import facts_of
from .text import head_text, text_of
from .titles import heading


def recognises(head: bytes) -> float:
    """High for the first line or the lines of a step."""
    text = head_text(head)
    if "LIMS export format" in text[:500]:
        return 1.0
    if "\nVariables\t" not in text or "\nUnits\t" not in text:
        return 0.0
    return 0.95


def _parsed(path: Path) -> tuple[list[Block], dict[str, str]]:
    """The steps and what the header says."""
    pairs: list[tuple[str, str]] = []
    steps: list[list[tuple[int, list[str]]]] = []
    for number, line in enumerate(lines_of(text_of(path)), 1):
        if line.startswith(("[Step]", "[step]")):
            steps.append([])
        elif steps and "\t" in line:
            steps[-1].append((number, line.split("\t")))
        elif "\t" in line:
            key, _, value = line.partition("\t")
            pairs.append((key, value))
    return [block for step in steps if (block := _block(step)) is not None], facts_of(pairs)


def _block(step: list[tuple[int, list[str]]]) -> Block | None:
    header = {
        cells[0]: cells[1:] for _, cells in step if cells[0] in ("Step name", "Variables", "Units")
    }
    titles = [title.strip() for title in header.get("Variables", [])]
    data = [(number, cells[1:]) for number, cells in step if cells[0] == "Data point"]
    if not titles or not data:
        return None
    # The line of units ends where the last columns have none.
    units = [*header.get("Units", []), *[""] * len(titles)]
    headings = tuple(heading(title, unit) for title, unit in zip(titles, units, strict=False))
    width = len(titles)
    rows = [[*cells[:width], *[""] * (width - len(cells))] for _, cells in data]
    return Block(
        " ".join(header.get("Step name", [])).strip(),
        headings,
        rows,
        [number for number, _ in data],
    )


READER = reader_of_blocks(
    "trios-lims", "TA Instruments TRIOS, exported to LIMS", recognises, _parsed, "TA TRIOS LIMS"
)
