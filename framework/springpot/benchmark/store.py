"""The store of a study: one SQLite file that only the coordinator writes, a transaction per batch of results."""

from __future__ import annotations

import json
import sqlite3
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from functools import cache
from itertools import groupby
from math import inf
from pathlib import Path
from typing import Any

from springpot.errors import StudyError

from .database import connect, lenient, one_line, refuse_foreign, replace_store, transaction
from .plan import Case, Cell, Plan
from .rows import CellRow, ProblemRow, TrialRow
from .salvage import KEYS, columns, save, whole
from .seal import seal, sound
from .trial import Status, TrialResult

SCHEMA = 3
"""Number of the layout below, kept in the file as ``user_version``."""

_TABLES = """
CREATE TABLE fact (name TEXT PRIMARY KEY, value TEXT NOT NULL, seal BLOB) WITHOUT ROWID;
CREATE TABLE problem (
    id INTEGER PRIMARY KEY, digest TEXT NOT NULL UNIQUE, dataset TEXT NOT NULL, kind TEXT NOT NULL,
    points INTEGER NOT NULL, stiffness_unit TEXT NOT NULL, model TEXT NOT NULL, objective TEXT NOT NULL,
    reference REAL, known REAL, truth TEXT, seal BLOB);
CREATE TABLE cell (
    id INTEGER PRIMARY KEY, digest TEXT NOT NULL UNIQUE, problem INTEGER NOT NULL REFERENCES problem (id),
    optimiser TEXT NOT NULL, options TEXT NOT NULL, budget INTEGER NOT NULL, seed TEXT NOT NULL,
    seal BLOB);
CREATE TABLE trial (
    cell INTEGER NOT NULL REFERENCES cell (id), repetition INTEGER NOT NULL, status TEXT NOT NULL,
    reason TEXT NOT NULL, best REAL, theta TEXT, parameter_error REAL, oracle REAL, evaluations INTEGER NOT NULL,
    gradients INTEGER NOT NULL, seconds REAL NOT NULL, batched INTEGER NOT NULL DEFAULT 0,
    seal BLOB, PRIMARY KEY (cell, repetition)) WITHOUT ROWID;
CREATE TABLE trace (
    cell INTEGER NOT NULL, repetition INTEGER NOT NULL, points BLOB NOT NULL, recommended BLOB, seen BLOB,
    PRIMARY KEY (cell, repetition));
"""
_UPGRADES = {
    1: """ALTER TABLE trial ADD COLUMN batched INTEGER NOT NULL DEFAULT 0;
ALTER TABLE trace ADD COLUMN recommended BLOB;
ALTER TABLE trace ADD COLUMN seen BLOB""",
    2: """ALTER TABLE fact ADD COLUMN seal BLOB;
ALTER TABLE problem ADD COLUMN seal BLOB;
ALTER TABLE cell ADD COLUMN seal BLOB;
ALTER TABLE trial ADD COLUMN seal BLOB""",
}
"""What turns each older layout into the next."""
SEALED = 3
"""The layout from which on every row has a seal."""


class Store:
    """The store at a path.

    Every row carries a seal. What no longer fits its seal is damaged: it is left out or shown as a failed trial, and
    told in one line on standard error.

    Parameters
    ----------
    path : Path
        The SQLite file.
    write : bool
        Create it where there is none, and allow writing.
    mend : bool
        Where the file's structure is damaged, put what can be saved into a new one in its place.

    Raises
    ------
    StudyError
        If it cannot be used: damaged beyond reading, of a newer version, read-only, on a full disk, absent.
    """

    def __init__(self, path: Path, write: bool = False, mend: bool = False) -> None:
        self.path = path
        self._told = self._saved = False
        with one_line(path):
            if write:
                path.parent.mkdir(parents=True, exist_ok=True)
            elif not path.is_file():
                raise StudyError(f"there are no results at {path}: run the study first")
            refuse_foreign(path, frozenset(KEYS))
            self._db = connect(path, write)
        try:
            with one_line(path):
                self._require_version(write)
                if not whole(self._db, _expected()):
                    self._save(write, mend)
        except BaseException:
            self._db.close()
            raise

    def _save(self, write: bool, mend: bool) -> None:
        """Go on with what can be read of a file whose structure is damaged."""
        if write and not mend:
            raise StudyError(f"{self.path} is damaged: --retry-failed saves what can be read and runs the rest again")
        # Beside the damaged file, which is replaced only when all that can be saved is in the new one.
        fresh = self.path.with_name(f"{self.path.name}.mended")
        fresh.unlink(missing_ok=True)
        saved = connect(fresh, write) if write else sqlite3.connect(":memory:", isolation_level=None)
        saved.text_factory = lenient
        _create(saved)
        with transaction(saved):
            save(self._db, saved)
        self._db.close()
        if write:
            saved.close()
            replace_store(fresh, self.path)
            saved = connect(self.path, write)
        self._db, self._saved = saved, True
        self._tell("the file is damaged; what can be read is used")

    def _require_version(self, write: bool) -> None:
        if write:
            with transaction(self._db):
                if self._version() == 0 and not self._db.execute("SELECT 1 FROM sqlite_master").fetchone():
                    _create(self._db)
                self._upgrade()
        if self._version() > SCHEMA:
            raise StudyError(
                f"{self.path} was written by a newer springpot (schema {self._version()}): update springpot"
            )
        if self._version() in _UPGRADES:
            raise StudyError(f"{self.path} was written by an older springpot: run the study again, nothing is lost")
        if self._version() < SCHEMA:
            raise StudyError(f"{self.path} is no study store: move it away and run again")

    def _upgrade(self) -> None:
        # One version at a time: each upgrade knows only the one before it.
        while (version := self._version()) in _UPGRADES:
            for statement in _UPGRADES[version].split(";"):
                self._db.execute(statement)
            self._db.execute(f"PRAGMA user_version = {version + 1}")
            if version + 1 == SEALED:
                self._seal_all()

    def _seal_all(self) -> None:
        """Take what an older version wrote as it is."""
        for table, query in {"fact": _FACTS, "problem": _PROBLEMS, "cell": _CELLS, "trial": _ALL_TRIALS}.items():
            keys = KEYS[table].split(", ")
            match = " AND ".join(f"{key} = ?" for key in keys)
            seals = [(seal(row[:-1]), *row[: len(keys)]) for row in self._db.execute(query)]
            self._db.executemany(f"UPDATE {table} SET seal = ? WHERE {match}", seals)

    def _version(self) -> int:
        version: int = self._db.execute("PRAGMA user_version").fetchone()[0]
        return version

    def _tell(self, damage: str) -> None:
        """Say what is damaged, once."""
        if not self._told:
            self._told = True
            print(f"note: {self.path}: {damage}; 'springpot run STUDY.py --retry-failed' mends it", file=sys.stderr)

    def __enter__(self) -> Store:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; the last one to do so folds the log into it."""
        self._db.close()

    def register(self, plan: Plan, facts: Mapping[str, str]) -> dict[int, int]:
        """Enter a plan's problems and cells and make it the one that tables show.

        Parameters
        ----------
        plan : Plan
            The study.
        facts : mapping of str to str
            Versions, machine, command.

        Returns
        -------
        dict
            From index of a cell in the plan to its number in the store.
        """
        shown = json.dumps([(cell.digest, plan.entrants[cell.entrant].label) for cell in plan.cells])
        told = {"name": plan.name, "cells": shown, "repetitions": str(plan.repetitions), "seed": str(plan.seed)}
        told |= {"budget": str(plan.budget), "target": repr(plan.target), "accuracy": repr(plan.accuracy), **facts}
        with one_line(self.path), transaction(self._db):
            problems = [self._enter("problem", _problem_columns(case)) for case in plan.cases]
            cells = {cell.index: self._enter("cell", _cell_columns(plan, cell, problems)) for cell in plan.cells}
            told["optima"] = json.dumps(
                {n: case.optimum for n, case in zip(problems, plan.cases, strict=True) if case.optimum is not None}
            )
            # Facts are those of the last plan: a store shows one study, though it keeps the trials of all.
            self._db.execute("DELETE FROM fact")
            self._db.executemany("INSERT INTO fact VALUES (?, ?, ?)", [(*fact, seal(fact)) for fact in told.items()])
        return cells

    def _enter(self, table: str, columns: dict[str, object]) -> int:
        """The number of a row, which is written if it is not there, and again if it is not what it should be."""
        names, marks = ", ".join(columns), ", ".join("?" * len(columns))
        self._db.execute(f"INSERT OR IGNORE INTO {table} ({names}) VALUES ({marks})", tuple(columns.values()))
        find = f"SELECT id, {names}, seal FROM {table} WHERE digest = ?"
        found = self._db.execute(find, (columns["digest"],)).fetchone()
        number = int(found[0])
        right = (*columns.values(), seal((number, *columns.values())))
        if found[1:] != right:
            changes = ", ".join(f"{name} = ?" for name in (*columns, "seal"))
            self._db.execute(f"UPDATE {table} SET {changes} WHERE id = ?", (*right, number))
        return number

    def finished(self, cell: int) -> set[int]:
        """Repetitions of a cell that are done."""
        with one_line(self.path):
            return {row[0] for row in self._db.execute("SELECT repetition FROM trial WHERE cell = ?", (cell,))}

    def add(self, results: Iterable[TrialResult], cells: Mapping[int, int]) -> None:
        """Keep results in one transaction; one that is there already (from another run) stays as it is."""
        trials, traces = [], []
        for r in results:
            cell = cells[r.cell]
            theta = None if r.theta is None else json.dumps(r.theta)
            columns = (
                cell, r.repetition, str(r.status), r.reason, r.best, theta, r.parameter_error, r.oracle,
                r.evaluations, r.gradients, r.seconds, r.batched,
            )  # fmt: skip
            trace = (r.trace, r.recommended, r.seen) if r.trace else (None, None, None)
            trials.append((*columns, seal((*columns, *trace))))
            if r.trace:
                traces.append((cell, r.repetition, *trace))
        with one_line(self.path), transaction(self._db):
            # The trace of a trial that was dropped because it was damaged may still be there.
            self._db.executemany(_DROP_STRAY, [key[:2] for key in traces])
            self._db.executemany(f"INSERT OR IGNORE INTO trial VALUES ({', '.join('?' * 13)})", trials)
            self._db.executemany("INSERT OR IGNORE INTO trace VALUES (?, ?, ?, ?, ?)", traces)

    def forget_failed(self, cells: Iterable[int]) -> int:
        """Drop the trials of `cells` that failed or are damaged, so that they run again; how many there were."""
        wanted = set(cells)
        with one_line(self.path), transaction(self._db):
            lost = [
                row[:2]
                for row in self._db.execute(_ALL_TRIALS)
                if not sound(row) or (row[0] in wanted and Status(row[2]).failed)
            ]
            for table in ("trial", "trace"):
                self._db.executemany(f"DELETE FROM {table} WHERE cell IS ? AND repetition IS ?", lost)
        return len(lost)

    def facts(self) -> dict[str, str]:
        """What is known of the study and of its last run."""
        with one_line(self.path):
            rows = list(self._db.execute(_FACTS))
            empty = not (rows or self._saved) and self._db.execute("SELECT 1 FROM cell").fetchone() is None
            described = empty or {row[0] for row in rows} >= _TOLD
        if not (described and all(sound(row) for row in rows)):
            raise StudyError(
                f"{self.path}: the description of the study is damaged: run the study again, its trials are kept"
            )
        return {name: value for name, value, _ in rows}

    def cells(self) -> list[CellRow]:
        """The cells of the study as it was last run, in its order; those that are damaged are left out."""
        shown: list[tuple[str, str]] = json.loads(self.facts().get("cells", "[]"))
        with one_line(self.path):
            rows = [row for row in self._db.execute(_PROBLEMS) if sound(row)]
            problems = {row[0]: ProblemRow(*[row[0], *row[2:-2], json.loads(row[-2])]) for row in rows}
            found = {row[1]: row for row in self._db.execute(_CELLS) if sound(row) and row[2] in problems}
        if lost := [label for digest, label in shown if digest not in found]:
            self._tell(f"{len(lost)} cells are damaged and left out, the first of {lost[0]}")
        kept = [(label, found[digest]) for digest, label in shown if digest in found]
        return [CellRow(row[0], problems[row[2]], label, *row[3:6]) for label, row in kept]

    def bests(self) -> dict[int, float]:
        """Best objective of each problem, by its number: the smallest of all trials kept and at the truth.

        Where trials ended at a target it is the optimum from which that was reckoned, so that they are judged by
        what they raced for.
        """
        planned = {int(n): best for n, best in json.loads(self.facts().get("optima", "{}")).items()}
        with one_line(self.path):
            known = {row[0]: row[9] for row in self._db.execute(_PROBLEMS) if sound(row) and row[9] is not None}
            problem = {row[0]: row[2] for row in self._db.execute(_CELLS) if sound(row)}
            found: dict[int, float] = {}
            for row in self._db.execute(_ALL_TRIALS):
                number = problem.get(row[0])
                if number is not None and row[4] is not None and sound(row):
                    found[number] = min(found.get(number, inf), row[4])
        return {number: min(found.get(number, inf), known.get(number, inf)) for number in found | known} | planned

    def trials(self) -> Iterator[tuple[int, list[TrialRow]]]:
        """Cell number and trials of every cell, up to the study's repetitions; one cell at a time in memory.

        A damaged trial is one that failed.
        """
        limit = int(self.facts().get("repetitions", "0"))
        labels = {cell.id: f"{cell.label} on {cell.problem.dataset}, {cell.problem.model}" for cell in self.cells()}
        with one_line(self.path):
            problems = {row[0] for row in self._db.execute(_PROBLEMS) if sound(row)}
            known = {row[0] for row in self._db.execute(_CELLS) if sound(row) and row[2] in problems}
            for cell, group in groupby(self._db.execute(_ALL_TRIALS), key=lambda row: row[0]):
                rows = [self._trial(row, labels.get(cell, f"cell {cell}")) for row in group]
                kept = [row for row in rows if row is not None and row.repetition < limit]
                if kept and cell in known:
                    yield cell, kept

    def _trial(self, row: Sequence[Any], where: str) -> TrialRow | None:
        """A trial; one that is damaged has no numbers, and one whose own number is damaged is none."""
        if sound(row):
            return TrialRow(*[row[1], Status(row[2]), *row[3:12], row[12] or b"", *row[13:15]])
        self._tell(f"the trial {where}, repetition {row[1]} is damaged and counted as failed")
        if not isinstance(row[1], int) or row[1] < 0:
            return None
        return TrialRow(row[1], Status.DAMAGED, DAMAGED, None, None, None, None, 0, 0, 0.0, 0, b"")


_TOLD = {"name", "cells", "repetitions", "seed", "budget", "target", "accuracy", "optima"}
DAMAGED = "its record in the store is damaged: --retry-failed runs it again"
_FACTS = "SELECT name, value, seal FROM fact ORDER BY name"
_PROBLEMS = """SELECT id, digest, dataset, kind, points, stiffness_unit, model, objective, reference, known, truth,
seal FROM problem"""
_CELLS = "SELECT id, digest, problem, optimiser, options, budget, seed, seal FROM cell"
_ALL_TRIALS = """SELECT cell, repetition, status, reason, best, theta, parameter_error, oracle, evaluations,
gradients, seconds, batched, points, recommended, seen, seal FROM trial LEFT JOIN trace USING (cell, repetition)
ORDER BY cell, repetition"""
_DROP_STRAY = """DELETE FROM trace WHERE cell = ?1 AND repetition = ?2
AND NOT EXISTS (SELECT 1 FROM trial WHERE cell = ?1 AND repetition = ?2)"""


@cache
def _expected() -> dict[str, list[str]]:
    """Names of the columns of each table."""
    with closing(sqlite3.connect(":memory:")) as db:
        _create(db)
        return columns(db)


def _create(db: sqlite3.Connection) -> None:
    """The tables of an empty store."""
    for statement in _TABLES.split(";"):
        db.execute(statement)
    db.execute(f"PRAGMA user_version = {SCHEMA}")


def _problem_columns(case: Case) -> dict[str, object]:
    source = case.source
    return {
        "digest": case.digest,
        "dataset": source.name,
        "kind": source.kind,
        "points": len(source.measurement),
        "stiffness_unit": source.measurement.units.stiffness,
        "model": case.model,
        "objective": case.objective.name,
        "reference": case.reference,
        "known": case.known,
        "truth": json.dumps(dict(source.truth)),
    }


def _cell_columns(plan: Plan, cell: Cell, problems: list[int]) -> dict[str, object]:
    entrant = plan.entrants[cell.entrant]
    return {
        "digest": cell.digest,
        "problem": problems[cell.case],
        "optimiser": entrant.optimiser.name,
        "options": entrant.options,
        "budget": plan.budget,
        "seed": str(plan.seed),
    }
