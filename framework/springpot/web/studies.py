"""The studies below the folder in which the workbench was started.

How far they are, and their tables.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from springpot.benchmark.report.study import study_html
from springpot.benchmark.standings import Findings, study_tables
from springpot.benchmark.store import Store
from springpot.errors import DataError, SpringpotError
from springpot.report.tables import Table
from springpot.suggestions import suggested

RESULTS = Path("results")
SHOWN = ("choice", "summary", "ranks", "failures")
"""Tables of a report that fit a screen."""


def _stores() -> dict[str, Path]:
    """The studies by name: nothing that a browser says is ever part of a path."""
    return {path.parent.name: path for path in sorted(RESULTS.glob("*/*.sqlite"))}


def studies() -> list[dict[str, Any]]:
    """Every study with its cells, and its trials: all that are planned, done and failed.

    The latter grow in a run.
    """
    return [_progress(name, path) for name, path in _stores().items()]


def _progress(name: str, path: Path) -> dict[str, Any]:
    try:
        with Store(path) as store:
            cells = store.cells()
            ended = []
            for _, trials in store.raced():
                ended += [trial.status for trial in trials]
            facts = store.facts()
    # One store that cannot be read must not hide the others.
    except SpringpotError as error:
        return {"name": name, "says": str(error)}
    failed = sum(status.failed for status in ended)
    total = len(cells) * int(facts["repetitions"])
    counts = {"cells": len(cells), "total": total, "done": len(ended), "failed": failed}
    return {
        "name": name,
        **counts,
        "started": facts.get("started", ""),
        "changed": path.stat().st_mtime,
        "says": "",
    }


def study(name: str) -> dict[str, Any]:
    """Tables of one study.

    Raises
    ------
    DataError
        If there is no such study here.
    """
    path = _store_of(name)
    with Store(path) as store:
        tables = dict(study_tables(store, SHOWN))
    return {**_progress(name, path), "tables": [_plain(table) for table in tables.values()]}


def report_of(name: str) -> dict[str, str]:
    """The report of one study, one file for a colleague.

    Raises
    ------
    DataError
        If there is no such study here.
    """
    with Store(_store_of(name)) as store:
        return {"name": f"{name}-report.html", "text": study_html(Findings.of(store))}


def _store_of(name: str) -> Path:
    path = _stores().get(name)
    if path is None:
        raise DataError(
            f"there is no study '{name[:40]}' in {RESULTS}; run"
            f" '{suggested('run', 'STUDY.py')}' here"
        )
    return path


def _plain(table: Table) -> dict[str, Any]:
    rows = [[_cell(entry) for entry in row] for row in table.rows]
    return {"title": table.title, "columns": list(table.columns), "rows": rows, "note": table.note}


def _cell(entry: Any) -> str:
    # Only intervals have ends; which class they are of need not be known here.
    if hasattr(entry, "low"):
        return f"{entry.value:.4g} [{entry.low:.4g}, {entry.high:.4g}]"
    if isinstance(entry, float):
        return f"{entry:.4g}"
    return str(entry)
