"""The studies below the folder in which the workbench was started.

How far they are, and their tables.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from springpot.benchmark.standings import Findings, tables_of
from springpot.benchmark.store import Store
from springpot.benchmark.study_plots import attained
from springpot.benchmark.study_report import study_html
from springpot.errors import DataError, SpringpotError
from springpot.report.page import Table
from springpot.writing import DIGITS, suggested

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
    """Tables of one study, and how far each optimiser is at each number of evaluations.

    Raises
    ------
    DataError
        If there is no such study here.
    """
    path = _store_of(name)
    with Store(path) as store:
        findings = Findings.of(store)
    tables = [_plain(table) for _, table in tables_of(findings, SHOWN)]
    return {**_progress(name, path), "tables": tables, "attained": _attained(findings)}


def _attained(findings: Findings) -> dict[str, Any]:
    """Share of trials and targets that each optimiser has reached, the best one first."""
    if not findings.races:
        return {"evaluations": [], "shares": {}}
    shares = attained(findings.races)
    return {
        "evaluations": findings.scale.grid.tolist(),
        "shares": {name: np.round(share, DIGITS).tolist() for name, share in shares},
    }


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
    if entry is None:
        return "-"
    return str(entry)
