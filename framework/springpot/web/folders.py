"""Folders of the workbench: the one that is watched, and the studies below the one it began in.

What the files of a watched folder hold is joined as often as one of them has grown. Nothing waits
for it here: the page asks again and again, so that no thread outlives it. Of studies it is told how
far they are, with their tables.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections import defaultdict
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from springpot.benchmark.standings import Findings, tables_of
from springpot.benchmark.store import Store
from springpot.benchmark.study_plots import attained
from springpot.benchmark.study_report import study_html
from springpot.errors import DataError, SpringpotError
from springpot.files import bytes_of
from springpot.measurement.measurement import Measurement
from springpot.report.page import Table
from springpot.writing import DIGITS, suggested

from .sessions import Opened, data_of, digest_of, joined, joined_anew, measured_in, text_of

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


class Folder(NamedTuple):
    """What a watched folder may hold."""

    settled: float
    """Seconds after which nobody writes on at a last line that has no end.

    A program that writes through a buffer stops in the midst of a number.
    """
    files: int
    """Files of a folder: one for each frequency of a long sweep."""


WATCHED = Folder(settled=10.0, files=500)
PASSED = (".", "~")
"""With what the names of files begin that other programs hide, or have open."""

Seen = tuple[str, int, int, bool]
"""Name, bytes, time of the last change, and whether that is long ago."""


def seen_in(folder: Path, now: float) -> list[Seen]:
    """The files of a folder by name.

    Raises
    ------
    DataError
        If it is none, or holds too many.
    """
    try:
        found = []
        for path in sorted(folder.iterdir()):
            if path.name.startswith(PASSED) or not path.is_file():
                continue
            known = path.stat()
            settled = now - known.st_mtime > WATCHED.settled
            found.append((path.name, known.st_size, known.st_mtime_ns, settled))
    except OSError as error:
        raise DataError(f"{folder} cannot be watched: {error.strerror}") from None
    if len(found) > WATCHED.files:
        raise DataError(f"{folder} holds {len(found)} files: at most {WATCHED.files} are watched")
    return found


@lru_cache(maxsize=2 * WATCHED.files)
def _read(folder: Path, seen: Seen, choice: str) -> Opened | str:
    """What a file holds so far, or why it waits; read again only when it has changed."""
    name, _, _, settled = seen
    try:
        content = bytes_of(folder / name)
        # A last line without an end may hold half a number.
        if not settled and not content.endswith(b"\n") and b"\0" not in content:
            content = content[: content.rfind(b"\n") + 1]
        if not content:
            return f"{name}: no whole line so far"
        return measured_in(name, content, choice)[0]
    except SpringpotError as error:
        return " ".join(str(error).split())


def _together(
    folder: Path, files: list[Seen], base: Opened | None, choice: str
) -> tuple[Opened | None, list[str], list[str]]:
    """All that can be joined, the names of these files, and why the others wait."""
    data, used, waits = base, [], []
    for seen in files:
        found = _read(folder, seen, choice)
        if isinstance(found, str):
            waits.append(found)
            continue
        try:
            if data is None:
                data = found
            elif data is base:
                # What the open data hold already was saved with them.
                data = joined_anew(data, found)
            else:
                data = joined(data, found)
            used.append(seen[0])
        except SpringpotError as error:
            waits.append(" ".join(str(error).split()))
    return data, used, waits


def folder_of(spec: str) -> tuple[Path, str]:
    """A folder, and what is said of all of its files behind it."""
    # A name may hold the sign itself.
    if Path(spec).is_dir():
        return Path(spec).resolve(), ""
    name, sign, said = spec.partition("?")
    return Path(name).resolve(), sign + said


def watched(
    folder: str, known: str, base: str, before: str
) -> tuple[dict[str, Any], Opened | None]:
    """What is new in a folder, and the data if they are others than before.

    Parameters
    ----------
    folder : str
        Which, as `folder_of` takes it.
    known : str
        Signature of what was told last: of the same nothing more is told.
    base, before : str
        Text of the data that the files join, and of those that are open; empty for none.

    Returns
    -------
    dict
        ``folder``, ``signature``; where that is new ``files`` (names), ``waits`` (lines), ``rows``
        (where each row of the data before stands now).
    Measurement or Specimen or None
        The data.
    """
    place, choice = folder_of(folder)
    files = seen_in(place, time.time())
    asked = json.dumps([files, digest_of(base), choice])
    signature = hashlib.sha256(asked.encode()).hexdigest()
    if signature == known:
        return {"folder": place.name, "signature": signature}, None
    start = data_of(base) if base else None
    data, used, waits = _together(place, files, start, choice)
    told = {"folder": place.name, "signature": signature, "files": used, "waits": waits}
    if data is None or not used or text_of(data) == before:
        return told, None
    return {**told, "rows": _moved(data_of(before), data) if before else []}, data


def _moved(before: Opened, now: Opened) -> list[int | None]:
    """Where each row of the data before stands now: files grow, and others stand behind them."""
    if not isinstance(before, Measurement) or not isinstance(now, Measurement):
        return [row if row < len(now) else None for row in range(len(before))]
    names = [name for name in before.conditions if name in now.conditions]
    places = defaultdict(list)
    for row, key in reversed(list(enumerate(_keys(now, names)))):
        places[key].append(row)
    return [places[key].pop() if places[key] else None for key in _keys(before, names)]


def _keys(data: Measurement, names: list[str]) -> list[bytes]:
    columns = [data.omega, data.storage, data.loss, *(data.conditions[name] for name in names)]
    return [row.tobytes() for row in np.column_stack(columns)]
