"""Exports of a study for other tools: IOHanalyzer, COCO, CSV, Parquet."""

from __future__ import annotations

import csv
from collections.abc import Callable
from functools import partial
from io import StringIO
from pathlib import Path
from typing import Any

from springpot.errors import StudyError
from springpot.files import write_text, write_with
from springpot.measurement.csv_safe import guarded

from .columns import TABLES, Columns, required
from .exported import Export, created
from .store import Store
from .study import Study
from .summary import store_path


def export(
    study: Study | str | Path, kind: str, folder: Path | None = None, out: Path = Path("results")
) -> Export:
    """Write a study's results for another tool.

    Parameters
    ----------
    study : Study, str or Path
        A study, its script, its store, its folder, or its name.
    kind : str
        ``ioh``, ``coco``, ``csv`` or ``parquet``.
    folder : Path, optional
        Where; by default a folder of that name beside the results.
    out : Path
        Folder of all results.

    Raises
    ------
    StudyError
        If there are no results, the format is unknown or its library is missing.
    OutputError
        If a file cannot be written.
    """
    if kind not in WRITERS:
        raise StudyError(f"unknown export format '{kind}': use {', '.join(WRITERS)}")
    path = store_path(study, out)
    if folder is None:
        folder = path.parent / kind
    # Opened first: a study that has no results leaves no empty folder behind.
    with Store(path) as store:
        return WRITERS[kind](store, created(folder))


def write_csv(store: Store, folder: Path) -> Export:
    """One CSV file of trials and one of their traces; numbers in full."""
    files = [write_text(folder / f"{name}.csv", _csv(read(store))) for name, read in TABLES.items()]
    return _whole(
        store,
        folder,
        files,
        "one row for each trial in trials.csv, one for each point in traces.csv",
    )


def _csv(columns: Columns) -> str:
    stream = StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    # A spreadsheet would take a name that begins with = for a formula.
    writer.writerow(map(guarded, columns))
    writer.writerows([_cell(value) for value in row] for row in zip(*columns.values(), strict=True))
    return stream.getvalue()


def _cell(value: Any) -> Any:
    if isinstance(value, str):
        return guarded(value)
    return value


def write_parquet(store: Store, folder: Path) -> Export:
    """The same as Parquet, with the study's facts as metadata."""
    arrow, parquet = (
        required(name, "export to parquet") for name in ("pyarrow", "pyarrow.parquet")
    )
    files = []
    for name, read in TABLES.items():
        # A file that is passed on alone still says what it was made with.
        table = arrow.table(read(store)).replace_schema_metadata(store.facts())
        files.append(write_with(folder / f"{name}.parquet", partial(parquet.write_table, table)))
    return _whole(
        store, folder, files, "open with pandas, polars, DuckDB or anything that reads Parquet"
    )


def _whole(store: Store, folder: Path, files: list[Path], hint: str) -> Export:
    return Export(folder, tuple(files), sum(len(rows) for _, rows in store.trials()), 0, hint)


# These two are imported only when they are asked for: every run of a study would pay for them.
def _ioh(store: Store, folder: Path) -> Export:
    from .export_ioh import write_ioh

    return write_ioh(store, folder)


def _coco(store: Store, folder: Path) -> Export:
    from .export_coco import write_coco

    return write_coco(store, folder)


WRITERS: dict[str, Callable[[Store, Path], Export]] = {
    "ioh": _ioh,
    "coco": _coco,
    "csv": write_csv,
    "parquet": write_parquet,
}
"""Name of a format to its writer."""
