"""Exports of a study for other tools: IOHanalyzer, COCO, CSV, Parquet."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from io import StringIO
from pathlib import Path
from typing import Any

from springpot.errors import OutputError, StudyError
from springpot.files import write_text, write_with
from springpot.measurement import guarded

from .columns import TABLES, Columns, required
from .rows import CellRow, ProblemRow, TrialRow
from .store import Store
from .study import Study
from .summary import store_path


@dataclass(frozen=True)
class Export:
    """What was written.

    Parameters
    ----------
    folder : Path
        Where.
    files : tuple of Path
        The files.
    trials, left_out : int
        Trials in them, and those without a value that are not.
    hint : str
        How to open it.
    """

    folder: Path
    files: tuple[Path, ...]
    trials: int
    left_out: int
    hint: str = ""


@dataclass(frozen=True, eq=False)
class Block:
    """The trials of one optimiser on one problem, as other tools number them.

    Parameters
    ----------
    cell : CellRow
        Problem and optimiser.
    folder : str
        Folder of the optimiser, different for each.
    function : int
        Number of the problem, counted from 1 in the order of the study.
    dimension : int
        Parameters searched.
    best : float
        Smallest objective known of the problem.
    trials : tuple of TrialRow
        Those with a value.
    """

    cell: CellRow
    folder: str
    function: int
    dimension: int
    best: float
    trials: tuple[TrialRow, ...]

    @property
    def name(self) -> str:
        """Data set, model and objective in one word."""
        return function_name(self.cell.problem)


def export(study: Study | str | Path, kind: str, folder: Path | None = None, out: Path = Path("results")) -> Export:
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
    with Store(path) as store:
        return WRITERS[kind](store, created(path.parent / kind if folder is None else folder))


def created(folder: Path) -> Path:
    """The folder, made if it is missing.

    Raises
    ------
    OutputError
        If it cannot be.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot write {folder}: {error.strerror or error}") from error
    return folder


def blocks(store: Store) -> Iterator[Block]:
    """Every cell of a study that has a trial with a value, one at a time."""
    cells = {cell.id: cell for cell in store.cells()}
    numbers = {number: i for i, number in enumerate(dict.fromkeys(c.problem.id for c in cells.values()), 1)}
    folders = _folders([cell.label for cell in cells.values()])
    bests = store.bests()
    for number, rows in store.trials():
        sound = tuple(row for row in rows if row.trace)
        if number in cells and sound:
            cell, dimension = cells[number], len(sound[0].theta)
            folder, problem = folders[cell.label], cell.problem.id
            yield Block(cell, folder, numbers[problem], dimension, bests[problem], sound)


def _folders(labels: list[str]) -> dict[str, str]:
    """A folder name for each label, no two the same even where file systems ignore case."""
    found: dict[str, str] = {}
    taken: set[str] = set()
    for label in dict.fromkeys(labels):
        name, n = slug(label), 1
        while name.lower() in taken:
            n += 1
            name = f"{slug(label)}-{n}"
        taken.add(name.lower())
        found[label] = name
    return found


def left_out(store: Store) -> int:
    """Trials without a value, which other tools have no way to tell of."""
    shown = {cell.id for cell in store.cells()}
    return sum(not row.trace for number, rows in store.trials() if number in shown for row in rows)


def function_name(problem: ProblemRow) -> str:
    """Data set, model and objective in one word."""
    return slug(f"{problem.dataset}_{problem.model}_{problem.objective}")


def slug(text: str) -> str:
    """`text` as a file name."""
    return "".join(c if c.isalnum() or c in "-_." else "-" for c in text)


def write_csv(store: Store, folder: Path) -> Export:
    """One CSV file of trials and one of their traces; numbers in full."""
    files = [write_text(folder / f"{name}.csv", _csv(read(store))) for name, read in TABLES.items()]
    return _whole(store, folder, files, "one row for each trial in trials.csv, one for each point in traces.csv")


def _csv(columns: Columns) -> str:
    stream = StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(map(guarded, columns))
    writer.writerows([_cell(value) for value in row] for row in zip(*columns.values(), strict=True))
    return stream.getvalue()


def _cell(value: Any) -> Any:
    return guarded(value) if isinstance(value, str) else value


def write_parquet(store: Store, folder: Path) -> Export:
    """The same as Parquet, with the study's facts as metadata."""
    arrow, parquet = (required(name, "export to parquet") for name in ("pyarrow", "pyarrow.parquet"))
    files = []
    for name, read in TABLES.items():
        table = arrow.table(read(store)).replace_schema_metadata(store.facts())
        files.append(write_with(folder / f"{name}.parquet", partial(parquet.write_table, table)))
    return _whole(store, folder, files, "open with pandas, polars, DuckDB or anything that reads Parquet")


def _whole(store: Store, folder: Path, files: list[Path], hint: str) -> Export:
    return Export(folder, tuple(files), sum(len(rows) for _, rows in store.trials()), 0, hint)


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
