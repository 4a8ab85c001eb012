"""``springpot tables``: tables of a study that has been run, to stdout or beside its results.

A table as a paper wants it: some columns, some rows, fewer digits, a caption and a label.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from springpot.cli.common import DATA, INPUT, emit, json_option, results_option
from springpot.errors import StudyError
from springpot.report.page import FORMATS, Entry, Interval, Table, escaped_latex, text


@click.command("tables", epilog="Example: springpot tables race --format latex --table summary")
@click.argument("study", type=DATA, metavar="STUDY")
@click.option("--format", "kind", type=click.Choice(list(FORMATS)), default="md", show_default=True)
@click.option(
    "--table", "wanted", metavar="NAME", help="Only this table, such as summary; all by default."
)
@click.option(
    "--write", is_flag=True, help="Write files beside the study's results instead of printing."
)
@click.option(
    "--report", is_flag=True, help="Write the report, one HTML file, instead of printing."
)
@results_option("Where results are.")
@click.option(
    "--column",
    "columns",
    multiple=True,
    metavar="HEADING",
    help="Only these columns, in this order.",
)
@click.option(
    "--row",
    "rows",
    multiple=True,
    metavar="HEADING=VALUE",
    help="Only rows like this; may be repeated.",
)
@click.option(
    "--digits", type=click.IntRange(1, 4), metavar="N", help="Significant digits; 4 by default."
)
@click.option(
    "--beside",
    type=INPUT,
    metavar="FILE",
    help="Show the trials of this archive too, without running them.",
)
@click.option("--caption", metavar="TEXT", help="Of a floating table in LaTeX.")
@click.option("--label", metavar="NAME", help="For \\ref in LaTeX.")
@json_option
def command(
    study: str,
    kind: str,
    wanted: str | None,
    write: bool,
    report: bool,
    out: Path,
    columns: tuple[str, ...],
    rows: tuple[str, ...],
    digits: int | None,
    beside: Path | None,
    caption: str | None,
    label: str | None,
    as_json: bool,
) -> None:
    """Print the tables of STUDY: its name, script, folder, .sqlite file or archive (.zip).

    For a paper: springpot tables race --table summary --format latex --column optimiser --column
    success --digits 3 --row model=fractional-zener --caption "The race" --label tab:race
    """
    # Files are whole tables: columns and rows are chosen for what is printed into a paper.
    if write or report:
        paths = _written(study, out, [kind] if write else [], report, beside)
        files = {"schema": "springpot.files/1", "files": paths}
        emit(files, as_json, lambda: print(*paths, sep="\n"))
        return
    if (columns or rows or caption or label) and wanted is None:
        raise click.UsageError("say which table with --table")
    if (caption or label) and kind != "latex":
        raise click.UsageError("--caption and --label are for --format latex")
    tables = {
        name: for_paper(table, columns, rows, digits)
        for name, table in _chosen(study, wanted, out, beside).items()
    }
    result = {
        "schema": "springpot.tables/1",
        "study": study,
        "tables": [_plain(*entry) for entry in tables.items()],
    }
    to_text = FORMATS[kind][1]
    texts = [captioned(to_text(table), caption, label) for table in tables.values()]
    emit(result, as_json, lambda: print("\n".join(texts), end=""))


def _written(
    study: str, out: Path, kinds: list[str], report: bool, beside: Path | None
) -> list[Path]:
    """Files of tables, of one kind or none, and of the report beside a study's results."""
    from springpot.benchmark.standings import write_tables

    paths = list(write_tables(study, kinds, out, beside)) if kinds else []
    if report:
        from springpot.benchmark.study_report import write_study_report

        paths.append(write_study_report(study, out, beside))
    return paths


def _chosen(study: str, wanted: str | None, out: Path, beside: Path | None) -> dict[str, Table]:
    from springpot.benchmark.archive import opened
    from springpot.benchmark.standings import study_tables, table_names
    from springpot.benchmark.summary import store_path
    from springpot.errors import StudyError

    with opened(store_path(study, out), beside) as store:
        names = table_names(store)
        if wanted is not None and wanted not in names:
            raise StudyError(f"unknown table '{wanted}': {study} has {', '.join(names)}")
        return dict(study_tables(store, [wanted] if wanted else names))


def _plain(name: str, table: Table) -> dict[str, Any]:
    rows = [[_cell(entry) for entry in row] for row in table.rows]
    return {
        "name": name,
        "title": table.title,
        "columns": list(table.columns),
        "rows": rows,
        "note": table.note,
    }


def _cell(entry: Any) -> Any:
    """An interval as an object, anything else as it is."""
    if hasattr(entry, "low"):
        return {"value": entry.value, "low": entry.low, "high": entry.high}
    return entry


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
