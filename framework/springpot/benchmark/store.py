"""The store of a study: one SQLite file that only the coordinator writes, a transaction per batch of results."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.errors import StudyError
from springpot.rheology import Real

from .database import connect, one_line, transaction
from .plan import Case, Cell, Plan
from .trace import unpack, unpack_values
from .trial import Status, TrialResult

SCHEMA = 2
"""Number of the layout below, kept in the file as ``user_version``."""

_TABLES = """
CREATE TABLE fact (name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE problem (
    id INTEGER PRIMARY KEY, digest TEXT NOT NULL UNIQUE, dataset TEXT NOT NULL, kind TEXT NOT NULL,
    points INTEGER NOT NULL, stiffness_unit TEXT NOT NULL, model TEXT NOT NULL, objective TEXT NOT NULL,
    reference REAL, known REAL, truth TEXT);
CREATE TABLE cell (
    id INTEGER PRIMARY KEY, digest TEXT NOT NULL UNIQUE, problem INTEGER NOT NULL REFERENCES problem (id),
    optimiser TEXT NOT NULL, options TEXT NOT NULL, budget INTEGER NOT NULL, seed TEXT NOT NULL);
CREATE TABLE trial (
    cell INTEGER NOT NULL REFERENCES cell (id), repetition INTEGER NOT NULL, status TEXT NOT NULL,
    reason TEXT NOT NULL, best REAL, theta TEXT, parameter_error REAL, oracle REAL, evaluations INTEGER NOT NULL,
    gradients INTEGER NOT NULL, seconds REAL NOT NULL, batched INTEGER NOT NULL DEFAULT 0,
    PRIMARY KEY (cell, repetition)) WITHOUT ROWID;
CREATE TABLE trace (
    cell INTEGER NOT NULL, repetition INTEGER NOT NULL, points BLOB NOT NULL, recommended BLOB, seen BLOB,
    PRIMARY KEY (cell, repetition));
"""
_UPGRADES = {
    1: """ALTER TABLE trial ADD COLUMN batched INTEGER NOT NULL DEFAULT 0;
ALTER TABLE trace ADD COLUMN recommended BLOB;
ALTER TABLE trace ADD COLUMN seen BLOB"""
}
"""What turns each older layout into the next."""


@dataclass(frozen=True)
class ProblemRow:
    """What the store knows of one problem."""

    id: int
    dataset: str
    kind: str
    points: int
    stiffness_unit: str
    model: str
    objective: str
    reference: float
    known: float | None
    truth: Mapping[str, float]


@dataclass(frozen=True)
class CellRow:
    """One problem and one entrant."""

    id: int
    problem: ProblemRow
    label: str
    optimiser: str
    options: str
    budget: int


@dataclass(slots=True)
class TrialRow:
    """One finished trial."""

    repetition: int
    status: Status
    reason: str
    best: float | None
    theta_text: str | None
    parameter_error: float | None
    oracle: float | None
    evaluations: int
    gradients: int
    seconds: float
    batched: int
    trace: bytes
    recommended: bytes | None = None
    seen: bytes | None = None

    @property
    def theta(self) -> Mapping[str, float]:
        """Element parameters by name, empty if the trial failed."""
        found: dict[str, float] = json.loads(self.theta_text) if self.theta_text else {}
        return found

    def improvements(self) -> tuple[NDArray[np.int64], Real]:
        """Evaluation numbers (n,) and objectives (n,) of the improvements."""
        return unpack(self.trace)

    def recommendations(self) -> tuple[NDArray[np.int64], Real] | None:
        """Evaluation numbers (n,) and noise-free objectives (n,) of what was best at the time; may rise.

        None where the truth is unknown or was not kept.
        """
        if self.recommended is None:
            return None
        evaluations, values = self.improvements()
        return evaluations, unpack_values(self.recommended) if self.recommended else values

    def oracle_trace(self) -> tuple[NDArray[np.int64], Real] | None:
        """Evaluation numbers (n,) and values (n,) of the best noise-free objective among all that was evaluated.

        None where the truth is unknown or was not kept.
        """
        if self.seen is None:
            return None
        return unpack(self.seen) if self.seen else self.improvements()


class Store:
    """The store at a path.

    Parameters
    ----------
    path : Path
        The SQLite file.
    write : bool
        Create it where there is none, and allow writing.

    Raises
    ------
    StudyError
        If it cannot be used: damaged, of a newer version, read-only, on a full disk, absent.
    """

    def __init__(self, path: Path, write: bool = False) -> None:
        self.path = path
        with one_line(path):
            if write:
                path.parent.mkdir(parents=True, exist_ok=True)
            elif not path.is_file():
                raise StudyError(f"there are no results at {path}: run the study first")
            self._db = connect(path, write)
        try:
            with one_line(path):
                self._require_version(write)
        except BaseException:
            self._db.close()
            raise

    def _require_version(self, write: bool) -> None:
        if write:
            with transaction(self._db):
                if self._version() == 0 and not self._db.execute("SELECT 1 FROM sqlite_master").fetchone():
                    for statement in _TABLES.split(";"):
                        self._db.execute(statement)
                    self._db.execute(f"PRAGMA user_version = {SCHEMA}")
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
        while (version := self._version()) in _UPGRADES:
            for statement in _UPGRADES[version].split(";"):
                self._db.execute(statement)
            self._db.execute(f"PRAGMA user_version = {version + 1}")

    def _version(self) -> int:
        version: int = self._db.execute("PRAGMA user_version").fetchone()[0]
        return version

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
            self._db.executemany("INSERT OR REPLACE INTO fact VALUES (?, ?)", told.items())
        return cells

    def _enter(self, table: str, columns: dict[str, object]) -> int:
        names, marks = ", ".join(columns), ", ".join("?" * len(columns))
        self._db.execute(f"INSERT OR IGNORE INTO {table} ({names}) VALUES ({marks})", tuple(columns.values()))
        number: int = self._db.execute(f"SELECT id FROM {table} WHERE digest = ?", (columns["digest"],)).fetchone()[0]
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
            trials.append(
                (cell, r.repetition, str(r.status), r.reason, r.best, theta, r.parameter_error, r.oracle,
                 r.evaluations, r.gradients, r.seconds, r.batched)
            )  # fmt: skip
            if r.trace:
                traces.append((cell, r.repetition, r.trace, r.recommended, r.seen))
        with one_line(self.path), transaction(self._db):
            self._db.executemany(f"INSERT OR IGNORE INTO trial VALUES ({', '.join('?' * 12)})", trials)
            self._db.executemany("INSERT OR IGNORE INTO trace VALUES (?, ?, ?, ?, ?)", traces)

    def forget_failed(self, cells: Iterable[int]) -> int:
        """Drop the trials of `cells` that failed, so that they run again; how many there were."""
        failed = [str(status) for status in Status if status.failed]
        marks = ", ".join("?" * len(failed))
        drop = f"DELETE FROM trial WHERE cell = ? AND status IN ({marks})"
        with one_line(self.path), transaction(self._db):
            return sum(self._db.execute(drop, (cell, *failed)).rowcount for cell in cells)

    def facts(self) -> dict[str, str]:
        """What is known of the study and of its last run."""
        with one_line(self.path):
            return dict(self._db.execute("SELECT name, value FROM fact ORDER BY name"))

    def cells(self) -> list[CellRow]:
        """The cells of the study as it was last run, in its order."""
        facts = self.facts()
        with one_line(self.path):
            problems = {row[0]: _problem(row) for row in self._db.execute(_PROBLEMS)}
            found = {row[0]: row[1:] for row in self._db.execute(_CELLS)}
        shown: list[tuple[str, str]] = json.loads(facts.get("cells", "[]"))
        rows = ((label, found[digest]) for digest, label in shown)
        return [CellRow(row[0], problems[row[1]], label, *row[2:]) for label, row in rows]

    def bests(self) -> dict[int, float]:
        """Best objective of each problem, by its number: the smallest of all trials kept and at the truth.

        Where trials ended at a target it is the optimum from which that was reckoned, so that they are judged by
        what they raced for.
        """
        planned = {int(n): best for n, best in json.loads(self.facts().get("optima", "{}")).items()}
        with one_line(self.path):
            found = {number: best for number, best in self._db.execute(_BESTS) if best is not None}
            known = dict(self._db.execute("SELECT id, known FROM problem WHERE known IS NOT NULL"))
        return {number: min(found.get(number, inf), known.get(number, inf)) for number in found | known} | planned

    def trials(self) -> Iterator[tuple[int, list[TrialRow]]]:
        """Cell number and trials of every cell, up to the study's repetitions; one cell at a time in memory."""
        limit = int(self.facts().get("repetitions", "0"))
        with one_line(self.path):
            rows = self._db.execute(_TRIALS, (limit,))
            for cell, group in groupby(rows, key=lambda row: row[0]):
                yield cell, [_trial(row) for row in group]


_BESTS = "SELECT problem, MIN(best) FROM trial JOIN cell ON cell.id = trial.cell GROUP BY problem"
_PROBLEMS = (
    """SELECT id, dataset, kind, points, stiffness_unit, model, objective, reference, known, truth FROM problem"""
)
_CELLS = "SELECT digest, id, problem, optimiser, options, budget FROM cell"
_TRIALS = """SELECT cell, repetition, status, reason, best, theta, parameter_error, oracle, evaluations, gradients,
seconds, batched, points, recommended, seen FROM trial LEFT JOIN trace USING (cell, repetition)
WHERE repetition < ? ORDER BY cell, repetition"""


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


def _problem(row: Sequence[Any]) -> ProblemRow:
    return ProblemRow(*[*row[:-1], json.loads(row[-1])])


def _trial(row: Sequence[Any]) -> TrialRow:
    return TrialRow(*[row[1], Status(row[2]), *row[3:12], row[12] or b"", *row[13:]])
