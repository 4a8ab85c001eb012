"""Documents of derived quantities: whole, and the few lines of them in another answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from springpot.identification.value import Quantities, Quantity

from .text import Listing, Passage, Prose, TextTable, shown

FEW = 6
"""Rows in another answer, where not everything is asked for."""
OUTSIDE = "outside     of what was measured: it holds only if the model does"


def quantities_document(answer: Quantities) -> list[Passage]:
    """A row for each, and what there is none of."""
    outside = OUTSIDE if any(row.outside for row in answer) else ""
    table: Passage = Prose("nothing can be told")
    if len(answer):
        table = quantities_table(answer, answer.rows)
    below = Listing([*(f"note        {note}" for note in answer.notes), *filter(None, [outside])])
    return [Prose(answer.title), table, below]


def quantities_passages(answer: Quantities | None, verbose: bool = False) -> list[Passage]:
    """Within another answer: a few that were measured; all of them if `verbose`.

    Parameters
    ----------
    answer : Quantities or None
        Of none there is no passage.
    verbose : bool
        Whether what lies outside of the measured range, and what there is none of, is told too.
    """
    if answer is None:
        return []
    if verbose:
        return quantities_document(answer)[1:] if answer.rows or answer.notes else []
    rows = [row for row in answer if not row.outside][:FEW]
    return [quantities_table(answer, rows)] if rows else []


def quantities_table(answer: Quantities, rows: Sequence[Quantity]) -> TextTable:
    """A row for each of these, with its place and who says it; what is the same for all below."""
    shared = set.intersection(*(set(row.at.items()) for row in rows))
    same = {name: value for name, value in rows[0].at.items() if (name, value) in shared}
    cells = []
    for row in rows:
        size, interval = shown(row.value)
        source = f"{row.source}, outside" if row.outside else row.source
        own = {name: value for name, value in row.at.items() if name not in same}
        place = replace(row, at=own).place(answer.units) or "-"
        cells.append([row.name, size, interval, row.value.unit, place, source])
    headers = ("quantity", "value", "95 % interval", "unit", "at", "from")
    told = [f"at {replace(rows[0], at=same).place(answer.units)}"] if same else []
    if answer.without:
        told.insert(0, f"of the material, without {', '.join(answer.without)}")
    legend = {"quantity": "; ".join(told)} if told else {}
    return TextTable(headers, cells, frozenset({"value"}), ("at",), legend)
