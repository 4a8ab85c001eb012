"""``springpot tables``: the tables of a study that has been run, to stdout or beside its results."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .common import FILE, emit, json_option

if TYPE_CHECKING:
    from springpot.benchmark import Table

FORMATS = ("md", "csv", "latex", "html")


@click.command("tables", epilog="Example: springpot tables optimiser-comparison --format latex --table summary")
@click.argument("study", metavar="STUDY")
@click.option("--format", "kind", type=click.Choice(FORMATS), default="md", show_default=True)
@click.option("--table", "wanted", metavar="NAME", help="Only this table, such as summary; all by default.")
@click.option("--write", is_flag=True, help="Write files beside the study's results instead of printing.")
@click.option("--report", is_flag=True, help="Write the report, one HTML file, instead of printing.")
@click.option(
    "--out", type=FILE, default=Path("results"), show_default=True, metavar="DIR", help="Where results are."
)
@json_option
def command(study: str, kind: str, wanted: str | None, write: bool, report: bool, out: Path, as_json: bool) -> None:
    """Print the tables of STUDY: its name, its script, its folder or its .sqlite file."""
    from springpot.benchmark import FORMATS as WRITERS
    from springpot.benchmark import write_tables

    if write or report:
        paths = write_tables(study, [kind], out) if write else []
        if report:
            from springpot.report.study import write_study_report

            paths.append(write_study_report(study, out))
        emit({"schema": "springpot.files/1", "files": paths}, as_json, lambda: print(*paths, sep="\n"))
        return
    tables = _chosen(study, wanted, out)
    result = {"schema": "springpot.tables/1", "study": study, "tables": [_plain(*entry) for entry in tables.items()]}
    to_text = WRITERS[kind][1]
    emit(result, as_json, lambda: print("\n".join(to_text(table) for table in tables.values()), end=""))


def _chosen(study: str, wanted: str | None, out: Path) -> dict[str, Table]:
    from springpot.benchmark import Store, store_path
    from springpot.benchmark.findings import TABLES, study_tables
    from springpot.errors import StudyError

    if wanted is not None and wanted not in TABLES:
        raise StudyError(f"unknown table '{wanted}': {study} has {', '.join(TABLES)}")
    with Store(store_path(study, out)) as store:
        return dict(study_tables(store, TABLES if wanted is None else [wanted]))


def _plain(name: str, table: Table) -> dict[str, Any]:
    rows = [[_cell(entry) for entry in row] for row in table.rows]
    return {"name": name, "title": table.title, "columns": list(table.columns), "rows": rows, "note": table.note}


def _cell(entry: Any) -> Any:
    """An interval as an object, anything else as it is."""
    if hasattr(entry, "low"):
        return {"value": entry.value, "low": entry.low, "high": entry.high}
    return entry
