"""A table as a paper wants it: some columns, some rows, fewer digits, a caption and a label."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from springpot.errors import StudyError
from springpot.report.tables import Entry, Interval, Table, escaped_latex, text


def for_paper(
    table: Table, columns: Sequence[str] = (), rows: Sequence[str] = (), digits: int | None = None
) -> Table:
    """Part of a table, with its numbers rounded.

    Parameters
    ----------
    table : Table
        The whole.
    columns : sequence of str
        Headings to keep, in this order; all by default.
    rows : sequence of str
        ``HEADING=VALUE``: rows that have one of the values given for each heading.
    digits : int, optional
        Significant digits, 1 to 4.

    Raises
    ------
    StudyError
        If there is no such column, with those that there are, or no row is left.
    """
    wanted: dict[int, set[str]] = {}
    for choice in rows:
        heading, equals, value = (part.strip() for part in choice.partition("="))
        if not (heading and equals and value):
            raise StudyError(f"'{choice}': choose rows as HEADING=VALUE, such as optimiser=cma-es")
        # Several values of one heading are alternatives, several headings are all required.
        wanted.setdefault(_place(table, heading), set()).add(value)
    kept = [
        row for row in table.rows if all(text(row[i]) in values for i, values in wanted.items())
    ]
    if rows and not kept:
        raise StudyError(f"the table '{table.title}' has no row with {' and '.join(rows)}")
    places = [_place(table, heading) for heading in columns] or list(range(len(table.columns)))
    cells = [tuple(_rounded(row[i], digits) for i in places) for row in kept]
    return replace(table, columns=tuple(table.columns[i] for i in places), rows=cells)


def captioned(latex: str, caption: str | None, label: str | None) -> str:
    """A LaTeX tabular as a floating table, where there is a caption or a label for it."""
    if caption is None and label is None:
        return latex
    lines = [r"\begin{table}", r"\centering"]
    if caption is not None:
        lines.append(rf"\caption{{{escaped_latex(caption)}}}")
    if label is not None:
        lines.append(rf"\label{{{label}}}")
    return "\n".join([*lines, latex.rstrip("\n"), r"\end{table}"]) + "\n"


def _place(table: Table, heading: str) -> int:
    if heading not in table.columns:
        raise StudyError(
            f"the table '{table.title}' has no column '{heading}': it has"
            f" {', '.join(table.columns)}"
        )
    return table.columns.index(heading)


def _rounded(entry: Entry, digits: int | None) -> Entry:
    # Whole numbers are counts, of which no digit is doubtful.
    if digits is None or entry is None or isinstance(entry, str | int):
        return entry
    if isinstance(entry, Interval):
        return Interval(
            *(float(f"{end:.{digits}g}") for end in (entry.value, entry.low, entry.high))
        )
    return float(f"{entry:.{digits}g}")
