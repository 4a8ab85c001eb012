"""The store of a study.

One SQLite file that only the coordinator writes, a transaction per batch of results.
"""

from __future__ import annotations

import json
import sqlite3
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from itertools import groupby
from math import inf
from operator import itemgetter
from pathlib import Path
from typing import Any, TypeVar

from springpot.errors import StudyError
from springpot.writing import suggested

from .plan import ASKED, COMMON, Plan, ProblemRow
from .schema import (
    ALL_LEAST,
    ALL_TRIALS,
    CELLS,
    DRAWS,
    DROP_STRAY,
    FACTS,
    KEYS,
    LEAST,
    ONE_TRIAL,
    PROBLEMS,
    SCHEMA,
    archived_columns,
    broken_row,
    cell_columns,
    cells_told,
    connect,
    create,
    expected,
    fold,
    insertion,
    lenient,
    one_line,
    optima_told,
    problem_columns,
    problem_of,
    refuse_foreign,
    remove_log,
    replace_store,
    require_tables,
    save,
    seal,
    sound,
    trace_columns,
    transaction,
    trial_columns,
    trial_fields,
    whole,
)
from .summary import CellRow, CellTrials
from .trial import Status, TrialResult

_Row = TypeVar("_Row", bound=Sequence[Any])


class Store:
    """The store at a path.

    Every row carries a seal. What no longer fits its seal is damaged: it is left out or shown as a
    failed trial, and told in one line on standard error.

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
        If it cannot be used: damaged beyond reading, of a newer version, read-only, on a full disk,
        absent.
    """

    def __init__(self, path: Path, write: bool = False, mend: bool = False) -> None:
        self.path = path
        self._told = self._saved = False
        self._looked: tuple[tuple[int, int], set[tuple[object, object]]] | None = None
        with one_line(path):
            if write:
                path.parent.mkdir(parents=True, exist_ok=True)
            elif not path.is_file():
                raise StudyError(f"there are no results at {path}: run the study first")
            refuse_foreign(path, frozenset(KEYS))
            self._db = connect(path, write)
        try:
            with one_line(path):
                # Once more: the file alone may be empty, and what another program wrote still be in
                # its log.
                require_tables(self._db, path, frozenset(KEYS))
                self._require_version(write)
                if not whole(self._db, expected()):
                    self._save(write, mend)
        except BaseException:
            self._db.close()
            raise

    def _save(self, write: bool, mend: bool) -> None:
        """Go on with what can be read of a file whose structure is damaged."""
        if write and not mend:
            raise StudyError(
                f"{self.path} is damaged: --retry-failed saves what can be read and runs the rest"
                " again"
            )
        # Beside the damaged file, which is replaced only when all that can be saved is in the new
        # one.
        fresh = self.path.with_name(f"{self.path.name}.mended")
        # One that was left by an attempt that was interrupted is begun anew.
        fresh.unlink(missing_ok=True)
        remove_log(fresh)
        # Who only reads gets what can be saved in memory: no file is touched.
        if write:
            saved = connect(fresh, write)
        else:
            saved = sqlite3.connect(":memory:", isolation_level=None)
        # Text may be damaged as well: it is read as far as it goes.
        saved.text_factory = lenient
        # Rows are saved as they lie there, with their seals.
        create(saved)
        with transaction(saved):
            save(self._db, saved)
        self._db.close()
        if write:
            fold(saved)
            saved.close()
            replace_store(fresh, self.path)
            saved = connect(self.path, write)
        self._db, self._saved = saved, True
        self._tell("the file is damaged; what can be read is used")

    def _require_version(self, write: bool) -> None:
        if write:
            with transaction(self._db):
                if (
                    self._version() == 0
                    and not self._db.execute("SELECT 1 FROM sqlite_master").fetchone()
                ):
                    create(self._db)
        version = self._version()
        if version > SCHEMA:
            raise StudyError(
                f"{self.path} was written by a newer springpot (schema {version}): update springpot"
            )
        if 0 < version < SCHEMA:
            raise StudyError(
                f"{self.path} was written by an older springpot (schema {version}), to which the"
                " same data were others on another processor: move it away and run the study again"
            )
        if version != SCHEMA:
            raise StudyError(f"{self.path} is no study store: move it away and run again")

    def _version(self) -> int:
        version: int = self._db.execute("PRAGMA user_version").fetchone()[0]
        return version

    def _tell(self, damage: str) -> None:
        """Say what is damaged, once."""
        if not self._told:
            self._told = True
            print(
                f"note: {self.path}: {damage};"
                f" '{suggested('run', 'STUDY.py', '--retry-failed')}' mends it",
                file=sys.stderr,
            )

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
        # By digests: cells of an earlier plan stay in the file, and only those of this one are
        # shown.
        shown = json.dumps(
            [(cell.digest, plan.entrants[cell.entrant].label) for cell in plan.cells]
        )
        described = {"name": plan.name, "cells": shown}
        described |= {
            "repetitions": str(plan.repetitions),
            "seed": str(plan.seed),
            "budget": str(plan.budget),
        }
        described |= {"target": repr(plan.target), "accuracy": repr(plan.accuracy), **facts}
        if plan.requirements:
            described["requirements"] = json.dumps(dict(plan.requirements))
        if plan.stop_at_target:
            described["stop at target"] = "True"
        described |= dict(zip(ASKED, plan.asks, strict=False))
        if plan.noise:
            described["noise"] = json.dumps(plan.levels)
        if plan.x0 == COMMON:
            begin = [each.label for each in plan.entrants if each.optimiser.card.started]
            described["common start"] = json.dumps(begin)
        with one_line(self.path), transaction(self._db):
            problems = [self._enter("problem", problem_columns(case)) for case in plan.cases]
            cells = {
                cell.index: self._enter("cell", cell_columns(plan, cell, problems))
                for cell in plan.cells
            }
            described["optima"] = json.dumps(
                {
                    n: case.optimum
                    for n, case in zip(problems, plan.cases, strict=True)
                    if case.optimum is not None
                }
            )
            # Facts are those of the last plan: a store shows one study, though it keeps the trials
            # of all.
            self._db.execute("DELETE FROM fact")
            self._put_facts(described)
        return cells

    def describe(
        self, problems: Iterable[ProblemRow], optima: Mapping[int, float], facts: Mapping[str, str]
    ) -> None:
        """Enter a study as an archive tells it, whose cells are adopted next.

        Parameters
        ----------
        problems : iterable of ProblemRow
            What was raced on.
        optima : mapping of int to float
            From which targets were reckoned, by the place of the problem.
        facts : mapping of str to str
            Name, budget, versions, machine, command.
        """
        with one_line(self.path), transaction(self._db):
            numbers = [self._enter("problem", archived_columns(each)) for each in problems]
            known = json.dumps({numbers[i]: best for i, best in optima.items()})
            self._put_facts({**facts, "cells": "[]", "optima": known})

    def _put_facts(self, facts: Mapping[str, str]) -> None:
        self._db.executemany(
            "INSERT OR REPLACE INTO fact VALUES (?, ?, ?)",
            [(*fact, seal(fact)) for fact in facts.items()],
        )

    def copy_to(self, path: Path) -> None:
        """Write all of it into a new file."""
        with one_line(path), closing(sqlite3.connect(path)) as copy:
            self._db.backup(copy)

    def adopt(
        self,
        cells: Mapping[int, Mapping[str, object]],
        labels: Mapping[int, str],
        facts: Mapping[str, str],
    ) -> dict[int, int]:
        """Enter cells of another study of the same problems, shown behind one's own.

        Parameters
        ----------
        cells : mapping of int to mapping
            Columns of each, the problem by its digest.
        labels : mapping of int to str
            As they are shown.
        facts : mapping of str to str
            What is to be told of them.

        Returns
        -------
        dict
            From their numbers to those in this store.
        """
        shown = json.loads(self.facts()["cells"])
        shown += [(cells[i]["digest"], label) for i, label in labels.items()]
        told = {"cells": json.dumps(shown), **facts}
        with one_line(self.path), transaction(self._db):
            problems = {row["digest"]: row["id"] for row in self._rows(PROBLEMS) if sound(row)}
            numbers = {
                i: self._enter("cell", {**each, "problem": problems[each["problem"]]})
                for i, each in cells.items()
            }
            self._put_facts(told)
        return numbers

    def _enter(self, table: str, columns: dict[str, object]) -> int:
        """The number of a row, which is written where it is missing or not what it should be."""
        names, marks = ", ".join(columns), ", ".join("?" * len(columns))
        # Content is the key: the same cell of another run of the study is the same row.
        self._db.execute(
            f"INSERT OR IGNORE INTO {table} ({names}) VALUES ({marks})", tuple(columns.values())
        )
        row = self._rows(
            f"SELECT id, {names}, seal FROM {table} WHERE digest = ?", columns["digest"]
        ).fetchone()
        number = int(row["id"])
        right = (*columns.values(), seal((number, *columns.values())))
        if row[1:] != right:
            changes = ", ".join(f"{name} = ?" for name in (*columns, "seal"))
            self._db.execute(f"UPDATE {table} SET {changes} WHERE id = ?", (*right, number))
        return number

    def _rows(self, query: str, *values: object) -> sqlite3.Cursor:
        """What a query finds, every row to be read by the names of its columns."""
        cursor = self._db.cursor()
        cursor.row_factory = sqlite3.Row
        return cursor.execute(query, values)

    def finished(self, cell: int) -> set[int]:
        """Repetitions of a cell that are done."""
        with one_line(self.path):
            return {
                row["repetition"]
                for row in self._rows("SELECT repetition FROM trial WHERE cell = ?", cell)
            }

    def add(self, results: Iterable[TrialResult], cells: Mapping[int, int]) -> None:
        """Keep results in one transaction.

        One that is there already (from another run) stays as it is.
        """
        trials, traces = [], []
        for result in results:
            trial, trace = trial_columns(result, cells[result.cell]), trace_columns(result)
            trials.append((*trial.values(), seal((*trial.values(), *trace.values()))))
            if result.trace:
                traces.append((trial["cell"], trial["repetition"], *trace.values()))
        with one_line(self.path), transaction(self._db):
            # The trace of a trial that was dropped because it was damaged may still be there.
            self._db.executemany(DROP_STRAY, [key[:2] for key in traces])
            self._db.executemany(insertion("trial"), trials)
            self._db.executemany(insertion("trace"), traces)

    def forget_failed(self, cells: Iterable[int]) -> int:
        """Drop the trials of `cells` that failed or are damaged, so that they run again.

        How many there were.
        """
        wanted = set(cells)
        with one_line(self.path), transaction(self._db):
            lost = [
                (row["cell"], row["repetition"])
                for row in self._rows(ALL_TRIALS)
                if not sound(row) or (row["cell"] in wanted and Status(row["status"]).failed)
            ]
            self._drop(lost)
        return len(lost)

    def forget(self, cells: Iterable[int]) -> None:
        """Drop all trials of `cells`, so that they run again."""
        with one_line(self.path), transaction(self._db):
            self._drop([(cell, number) for cell in cells for number in self.finished(cell)])

    def _drop(self, trials: list[tuple[object, object]]) -> None:
        for table in ("trial", "trace"):
            self._db.executemany(f"DELETE FROM {table} WHERE cell IS ? AND repetition IS ?", trials)

    def facts(self) -> dict[str, str]:
        """What is known of the study and of its last run.

        Raises
        ------
        StudyError
            If no study was entered yet, or what is said of it is damaged.
        """
        with one_line(self.path):
            rows = list(self._rows(FACTS))
            empty = (
                not (rows or self._saved)
                and self._db.execute("SELECT 1 FROM cell").fetchone() is None
            )
        if empty:
            # A run that was ended in its first moment leaves the tables and nothing in them.
            raise StudyError(f"there are no results at {self.path} yet: run the study first")
        described = {row["name"] for row in rows} >= _TOLD
        if not (described and all(sound(row) for row in rows)):
            raise StudyError(
                f"{self.path}: the description of the study is damaged: run the study again, its"
                " trials are kept"
            )
        return {row["name"]: row["value"] for row in rows}

    def cells(self) -> list[CellRow]:
        """The cells of the study as it was last run, in its order.

        Those that are damaged are left out.
        """
        shown = cells_told(self.facts().get("cells", "[]"))
        with one_line(self.path):
            problems = {row["id"]: problem_of(row) for row in self._rows(PROBLEMS) if sound(row)}
            rows = [row for row in self._rows(CELLS) if sound(row) and row["problem"] in problems]
        by_digest = {row["digest"]: row for row in rows}
        if lost := [label for digest, label in shown if digest not in by_digest]:
            self._tell(f"{len(lost)} cells are damaged and left out, the first of {lost[0]}")
        kept = [(label, by_digest[digest]) for digest, label in shown if digest in by_digest]
        return [
            CellRow(
                row["id"],
                problems[row["problem"]],
                label,
                row["optimiser"],
                row["options"],
                row["budget"],
                row["digest"],
            )
            for label, row in kept
        ]

    def bests(self) -> dict[int, float]:
        """Best objective of each problem, by its number.

        The smallest of all trials kept and at the truth.

        Where trials ended at a target it is the optimum from which that was reckoned, so that they
        are judged by what they raced for.
        """
        planned = optima_told(self.facts().get("optima", "{}"))
        with one_line(self.path):
            problems = [row for row in self._rows(PROBLEMS) if sound(row)]
            known = {row["id"]: row["known"] for row in problems if row["known"] is not None}
            problem = {row["id"]: row["problem"] for row in self._rows(CELLS) if sound(row)}
            least: dict[int, float] = {}
            for cell, _, best in self._least():
                if (number := problem.get(cell)) is not None:
                    least[number] = min(least.get(number, inf), best)
        return {
            number: min(least.get(number, inf), known.get(number, inf)) for number in least | known
        } | planned

    def bests_of_draws(self) -> dict[tuple[int, int], float]:
        """Best objective of each problem and repetition, where a repetition has its own noise."""
        optima: dict[tuple[int, int], float] = {}
        least: dict[tuple[int, int], float] = {}
        with one_line(self.path):
            problem = {row["id"]: row["problem"] for row in self._rows(CELLS) if sound(row)}
            for row in self._sound(self._rows(DRAWS)):
                if row["cell"] not in problem:
                    continue
                key = (problem[row["cell"]], row["repetition"])
                if row["optimum"] is not None:
                    optima[key] = row["optimum"]
                values = [row[name] for name in ("best", "known") if row[name] is not None]
                least[key] = min([least.get(key, inf), *values])
        # Where trials end at a target, it is the one that they raced for.
        return least | optima

    def _least(self) -> Iterator[tuple[int, int, float]]:
        """Cell, repetition and objective of the trials that got furthest, none of them damaged."""
        first = [row for row in self._db.execute(LEAST) if row[2] is not None]
        # To look at a million seals for a thousand rows takes seconds.
        seen = (self._db.execute(ONE_TRIAL, row[:2]).fetchone() for row in first)
        if all(row is not None and sound(row) for row in seen):
            return iter(first)
        return self._sound(self._db.execute(ALL_LEAST))

    def _sound(self, rows: Iterable[_Row]) -> Iterator[_Row]:
        """Those rows whose trial is not damaged; they begin with its key."""
        damaged = None
        for row in rows:
            # Of no row nothing is looked at.
            damaged = self._damaged() if damaged is None else damaged
            if row[:2] not in damaged:
                yield row

    def _damaged(self) -> set[tuple[object, object]]:
        """Keys of the trials that are, each looked at once as long as nobody writes."""
        state = self._db.execute("PRAGMA data_version").fetchone()[0], self._db.total_changes
        if self._looked is None or self._looked[0] != state:
            rows = self._rows(ALL_TRIALS)
            found = {row[:2] for row in rows if not sound(row)}
            self._looked = state, found
        return self._looked[1]

    def trials(self) -> Iterator[tuple[int, CellTrials]]:
        """Cell number and trials of every cell, up to the study's repetitions.

        One cell at a time in memory.

        A damaged trial is one that failed.
        """
        limit = int(self.facts().get("repetitions", "0"))
        labels = {
            cell.id: f"{cell.label} on {cell.problem.dataset}, {cell.problem.model}"
            for cell in self.cells()
        }
        with one_line(self.path):
            problems = {row["id"] for row in self._rows(PROBLEMS) if sound(row)}
            known = {
                row["id"] for row in self._rows(CELLS) if sound(row) and row["problem"] in problems
            }
            for cell, group in groupby(self._db.execute(ALL_TRIALS), key=itemgetter(0)):
                where = labels.get(cell, f"cell {cell}")
                rows = [row if sound(row) else self._broken(row, where) for row in group]
                kept = [row for row in rows if row is not None and row[1] < limit]
                if kept and cell in known:
                    yield cell, CellTrials(trial_fields(), kept)
                # Or they would be in memory while those of the next are read.
                del rows, kept

    def raced(self) -> Iterator[tuple[CellRow, CellTrials]]:
        """The cells of the study as it was last run with their trials, one at a time in memory."""
        cells = {cell.id: cell for cell in self.cells()}
        for number, rows in self.trials():
            if number in cells:
                yield cells[number], rows
            del rows

    def _broken(self, row: tuple[Any, ...], where: str) -> tuple[Any, ...] | None:
        """A damaged trial, without numbers; one whose own number is damaged is none."""
        cell, repetition = row[:2]
        self._tell(f"the trial {where}, repetition {repetition} is damaged and counted as failed")
        if not isinstance(repetition, int) or repetition < 0:
            return None
        return broken_row(cell, repetition, DAMAGED)


_TOLD = {"name", "cells", "repetitions", "seed", "budget", "target", "accuracy", "optima"}
DAMAGED = "its record in the store is damaged: --retry-failed runs it again"
