"""How quantities are told to people."""

from __future__ import annotations

from springpot.report.text import TextTable
from springpot.report.values import shown

from .quantity import Quantities


def told(answer: Quantities, columns: int | None = None) -> str:
    """A row for each, and what there is none of.

    Parameters
    ----------
    answer : Quantities
        The answer.
    columns : int, optional
        Of the window.
    """
    rows = []
    for row in answer:
        size, interval = shown(row.value)
        source = f"{row.source}, outside" if row.outside else row.source
        place = row.place(answer.units) or "-"
        rows.append([row.name, size, interval, row.value.unit, place, source])
    headers = ("quantity", "value", "95 % interval", "unit", "at", "from")
    table = TextTable(headers, rows, frozenset({"value"}), spare=("at",))
    if columns is not None and rows:
        table = table.fitted(columns)
    title = f"{answer.model} fitted to {answer.name}" if answer.model else answer.name
    lines = [title, "", *([table.plain()] if rows else ["nothing can be told"])]
    lines += [f"note        {note}" for note in answer.notes]
    if any(row.outside for row in answer):
        lines.append("outside     of what was measured: it holds only if the model does")
    return "\n".join(lines)
