"""How a store is laid out in SQLite: its tables, what asks for their rows, and what a row means.

Each row has a seal, a checksum by which damage is noticed and named instead of shown as a result.
Of a store whose file is damaged every row that can still be reached is saved into a fresh one.
Several programs at once do no harm, and whatever goes wrong is one line.
"""

from __future__ import annotations

import json
import marshal
import os
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import asdict, fields
from functools import cache
from hashlib import blake2b
from pathlib import Path
from time import monotonic, sleep
from typing import Any

from springpot.errors import StudyError

from .plan import Cell, Plan, ProblemRow, RaceCase
from .trial import TrialResult

PATIENCE = 60.0
"""Seconds to wait for another program that holds the file."""


def connect(path: Path, write: bool) -> sqlite3.Connection:
    """A connection in autocommit mode; its caller closes it.

    Parameters
    ----------
    path : Path
        The SQLite file.
    write : bool
        Create it where there is none, and allow writing.

    Raises
    ------
    sqlite3.DatabaseError
        If it cannot be opened.
    """
    db = sqlite3.connect(_address(path, write), uri=True, timeout=PATIENCE, isolation_level=None)
    # A damaged name must not end the reading of all that is sound.
    db.text_factory = lenient
    try:
        if write:
            _log_ahead(db)
            # With a write-ahead log a power cut loses the last trials at most, and damages nothing.
            db.execute("PRAGMA synchronous = NORMAL")
        else:
            db.execute("PRAGMA query_only = ON")
    except BaseException:
        db.close()
        raise
    return db


def lenient(text: bytes) -> str:
    """Any bytes as text: what is damaged is noticed by its seal, not by the one who reads it."""
    return text.decode("utf-8", "replace")


def refuse_foreign(path: Path, tables: frozenset[str]) -> None:
    """Look into a file that is there without touching it.

    Raises
    ------
    StudyError
        If it is a database of other tables, or no database.
    """
    if not path.is_file() or not path.stat().st_size:
        return
    # Immutable, or SQLite would leave files beside a database that is not ours.
    with closing(
        sqlite3.connect(path.absolute().as_uri() + "?mode=ro&immutable=1", uri=True)
    ) as db:
        if not _has_log(path):
            require_tables(db, path, tables)
            return
        # Half of a log may be folded into the file where the disk was full: the two together are
        # sound, and the file alone, of which any page may be missing, tells for certain only whose
        # it is.
        with suppress(sqlite3.DatabaseError, UnicodeDecodeError):
            present = _tables(db)
            if present and tables.isdisjoint(present):
                raise _foreign(path)


def _has_log(path: Path) -> bool:
    log = path.with_name(f"{path.name}-wal")
    return log.is_file() and log.stat().st_size > 0


def _tables(db: sqlite3.Connection) -> set[str]:
    return {row[0] for row in db.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}


def require_tables(db: sqlite3.Connection, path: Path, tables: frozenset[str]) -> None:
    """Refuse an open database of other tables.

    Raises
    ------
    StudyError
        If it has any, and not these.
    """
    try:
        present = _tables(db)
    except (sqlite3.OperationalError, UnicodeDecodeError):
        return  # another program is just writing it, or it is damaged: told by whoever reads on
    # An empty database is a store of which nothing but the beginning has been written yet.
    if present and not tables <= present:
        raise _foreign(path)


def _foreign(path: Path) -> StudyError:
    return StudyError(f"{path} is damaged or no study store: move it away and run again")


def fold(db: sqlite3.Connection) -> None:
    """Bring all that is in the log into the file, which is whole without it from then on.

    Raises
    ------
    sqlite3.OperationalError
        If there is no room: that a log could not be folded is told by no `close`.
    """
    db.execute("PRAGMA journal_mode = DELETE")


def replace_store(fresh: Path, path: Path) -> None:
    """Put a closed database without a log in the place of another, whose log goes with it."""
    remove_log(path)
    fresh.replace(path)


def remove_log(path: Path) -> None:
    """Remove the log of a database, or it would be folded into whatever comes in its place."""
    for suffix in ("-wal", "-shm"):
        path.with_name(path.name + suffix).unlink(missing_ok=True)


def _address(path: Path, write: bool) -> str:
    # Links are left to SQLite: one that leads to itself is its error, and one line.
    address = path.absolute().as_uri()
    if write:
        return address + "?mode=rwc"
    # A reader takes part in the log like a writer, so that a study may run meanwhile. In a folder
    # where it cannot, nobody else writes either.
    if os.access(path.parent, os.W_OK):
        return f"{address}?mode=rw"
    return f"{address}?immutable=1"


def _log_ahead(db: sqlite3.Connection) -> None:
    """Turn the write-ahead log on.

    SQLite waits for others everywhere but here: of two programs that turn it on at once, one gets
    an error.
    """
    end = monotonic() + PATIENCE
    while True:
        try:
            db.execute("PRAGMA journal_mode = WAL")
            return
        except sqlite3.OperationalError as error:
            if "locked" not in str(error) or monotonic() > end:
                raise
            sleep(0.01)


@contextmanager
def transaction(db: sqlite3.Connection) -> Iterator[None]:
    """All or nothing; the right to write is asked for at once.

    For that SQLite can wait without a deadlock.
    """
    db.execute("BEGIN IMMEDIATE")
    try:
        yield
    except BaseException:
        if db.in_transaction:
            db.execute("ROLLBACK")
        raise
    db.execute("COMMIT")


@contextmanager
def one_line(path: Path) -> Iterator[None]:
    """Turn what SQLite and the system say of the file at `path` into one line that helps."""
    try:
        yield
    except sqlite3.DatabaseError as error:
        raise StudyError(_explained(path, error)) from error
    except UnicodeDecodeError as error:  # SQLite's own message holds a damaged name
        raise StudyError(
            _explained(path, sqlite3.DatabaseError("its tables have damaged names"))
        ) from error
    except OSError as error:
        raise StudyError(f"cannot write {path}: {error.strerror or error}") from error


def _explained(path: Path, error: sqlite3.DatabaseError) -> str:
    told = " ".join(str(error).split())
    if "full" in told:
        return (
            f"cannot write {path}: the disk is full; free some space and run again, finished trials"
            " are kept"
        )
    if "readonly" in told or "unable to open" in told:
        return f"cannot write {path}: no permission; choose another folder with --out"
    if "locked" in told or "locking" in told:
        return f"{path} is locked by another program: close it and run again"
    if isinstance(error, sqlite3.OperationalError) and "disk I/O" in told:
        return (
            f"cannot use {path}: {told}; see whether its disk is full, and run again: finished"
            " trials are kept"
        )
    return f"{path} is damaged or no study store ({told}): move it away and run again"


KEYS = {
    "fact": "name",
    "problem": "id",
    "cell": "id",
    "trial": "cell, repetition",
    "trace": "cell, repetition",
}
"""The tables, and the order in which the rows of each lie in the file."""
DAMAGES = (sqlite3.DatabaseError, UnicodeDecodeError)
"""What SQLite says of a damaged file; the second if its own message holds a damaged name."""


def columns(db: sqlite3.Connection) -> dict[str, list[str]]:
    """Names of the columns of each table."""
    return {table: [row[1] for row in db.execute(f"PRAGMA table_info({table})")] for table in KEYS}


def whole(db: sqlite3.Connection, expected: dict[str, list[str]]) -> bool:
    """Whether the file's own structure is sound."""
    try:
        return columns(db) == expected and db.execute("PRAGMA integrity_check(1)").fetchone() == (
            "ok",
        )
    except DAMAGES:
        return False


def save(damaged: sqlite3.Connection, fresh: sqlite3.Connection) -> None:
    """Copy the rows that can be read; the tables of `fresh` are there and empty.

    Seals are looked at later.
    """
    for table, names in columns(fresh).items():
        put = f"INSERT OR IGNORE INTO {table} VALUES ({', '.join('?' * len(names))})"
        for row in _rows(damaged, table):
            try:
                fresh.execute(put, row)
            except DAMAGES:
                continue  # what no longer fits a column was damaged
    _save_singly(damaged, fresh)


def _rows(db: sqlite3.Connection, table: str) -> Iterator[tuple[object, ...]]:
    """Rows from the beginning to the first damage, and from the end to the last."""
    keys = KEYS[table].split(", ")
    for way in ("ASC", "DESC"):
        order = ", ".join(f"{key} {way}" for key in keys)
        yield from _until_damage(db, f"SELECT * FROM {table} ORDER BY {order}")
    # Without an index, which may be what is damaged.
    yield from _until_damage(db, f"SELECT * FROM {table} NOT INDEXED")


def _until_damage(
    db: sqlite3.Connection, query: str, values: Iterable[object] = ()
) -> Iterator[tuple[object, ...]]:
    try:
        yield from db.execute(query, tuple(values))
    except DAMAGES:
        return


def _save_singly(damaged: sqlite3.Connection, fresh: sqlite3.Connection) -> None:
    """Ask for each trial that lies between two damages by its key."""
    # Between two damages no order leads to a row, but its own key may.
    cells = [row[0] for row in fresh.execute("SELECT id FROM cell")]
    (last,) = fresh.execute(
        "SELECT MAX(repetition) FROM trial WHERE typeof(repetition) = 'integer'"
    ).fetchone()
    known = {
        table: set(fresh.execute(f"SELECT cell, repetition FROM {table}"))
        for table in ("trial", "trace")
    }
    for table, there in known.items():
        count = len(fresh.execute(f"SELECT * FROM {table} LIMIT 0").description)
        put = f"INSERT OR IGNORE INTO {table} VALUES ({', '.join('?' * count)})"
        # More repetitions than anybody runs are the sign of a damaged number.
        wanted = [
            (cell, r)
            for cell in cells
            for r in range(min(last or 0, 10**5) + 1)
            if (cell, r) not in there
        ]
        for key in wanted:
            for row in _until_damage(
                damaged, f"SELECT * FROM {table} WHERE cell = ? AND repetition = ?", key
            ):
                fresh.execute(put, row)


SCHEMA = 8
"""Number of the layout below, kept in the file as ``user_version``.

The tables are those of 7, in which a problem had other digests on another processor.
"""

TABLES = """
CREATE TABLE fact (name TEXT PRIMARY KEY, value TEXT NOT NULL, seal BLOB) WITHOUT ROWID;
CREATE TABLE problem (
    id INTEGER PRIMARY KEY, digest TEXT NOT NULL UNIQUE, dataset TEXT NOT NULL, kind TEXT NOT NULL,
    points INTEGER NOT NULL, stiffness_unit TEXT NOT NULL, model TEXT NOT NULL,
    objective TEXT NOT NULL, reference REAL, known REAL, truth TEXT, seal BLOB);
CREATE TABLE cell (
    id INTEGER PRIMARY KEY, digest TEXT NOT NULL UNIQUE,
    problem INTEGER NOT NULL REFERENCES problem (id), optimiser TEXT NOT NULL,
    options TEXT NOT NULL, budget INTEGER NOT NULL, seed TEXT NOT NULL, seal BLOB);
CREATE TABLE trial (
    cell INTEGER NOT NULL REFERENCES cell (id), repetition INTEGER NOT NULL, status TEXT NOT NULL,
    reason TEXT NOT NULL, best REAL, theta TEXT, parameter_error REAL, oracle REAL,
    evaluations INTEGER NOT NULL, gradients INTEGER NOT NULL, seconds REAL NOT NULL,
    batched INTEGER NOT NULL DEFAULT 0, seal BLOB, processor REAL, processor_batched REAL,
    reference REAL, known REAL, optimum REAL, covered REAL,
    PRIMARY KEY (cell, repetition)) WITHOUT ROWID;
CREATE TABLE trace (
    cell INTEGER NOT NULL, repetition INTEGER NOT NULL, points BLOB NOT NULL,
    recommended BLOB, seen BLOB, PRIMARY KEY (cell, repetition));
"""
NO_REFERENCES = 2
"""The form of `marshal` in which equal values are equal bytes, whatever objects hold them."""

SIZE = 8
"""Bytes of a checksum: of 2^64 damaged rows one would pass."""


def seal(values: tuple[Any, ...]) -> bytes:
    """Checksum of a row's values.

    Texts, numbers, bytes or None, of which each has one way to be written: 1 is told from 1.0, and
    both from "1".
    """
    # The digits of its numbers as text would take half of the time of reading a store.
    return blake2b(marshal.dumps(values, NO_REFERENCES), digest_size=SIZE).digest()


def sound(row: Sequence[Any]) -> bool:
    """Whether the last value of a row is the seal of those before it."""
    return bool(row[-1] == seal(tuple(row[:-1])))


FACTS = "SELECT name, value, seal FROM fact ORDER BY name"
PROBLEMS = """SELECT id, digest, dataset, kind, points, stiffness_unit, model, objective,
reference, known, truth, seal FROM problem"""
CELLS = "SELECT id, digest, problem, optimiser, options, budget, seed, seal FROM cell"
DROP_STRAY = """DELETE FROM trace WHERE cell = ?1 AND repetition = ?2
AND NOT EXISTS (SELECT 1 FROM trial WHERE cell = ?1 AND repetition = ?2)"""

_TRACE = {"points": "trace", "recommended": "recommended", "seen": "seen"}
"""Columns of a trace, and what they hold of a trial."""


@cache
def expected() -> dict[str, list[str]]:
    """Names of the columns of each table."""
    # From the statements themselves: a list of columns kept beside them would drift from it.
    with closing(sqlite3.connect(":memory:")) as db:
        create(db)
        return columns(db)


@cache
def _names(table: str) -> list[str]:
    """Columns of a table that hold what is kept, in the order in which they are sealed."""
    # Read off the layout, so that a column added there needs no second place here.
    return [name for name in expected()[table] if name != "seal"]


@cache
def _kinds(table: str) -> dict[str, type]:
    """What the numbers in its columns are."""
    with closing(sqlite3.connect(":memory:")) as db:
        create(db)
        declared = db.execute(f"PRAGMA table_info({table})").fetchall()
    numbers = {"REAL": float, "INTEGER": int}
    return {row[1]: numbers[row[2]] for row in declared if row[2] in numbers}


def _as_kept(table: str, values: dict[str, Any]) -> dict[str, Any]:
    """The values as SQLite gives them back.

    A seal of 6 is none of the 6.0 that a column of real numbers has.
    """
    kinds = _kinds(table)
    return {
        name: kinds[name](value) if name in kinds and value is not None else value
        for name, value in values.items()
    }


def insertion(table: str) -> str:
    """The statement that enters a row of all columns unless there is one."""
    # The seal comes behind what it seals, wherever its column stands.
    names = sorted(expected()[table], key="seal".__eq__)
    return (
        f"INSERT OR IGNORE INTO {table} ({', '.join(names)}) VALUES ({', '.join('?' * len(names))})"
    )


def create(db: sqlite3.Connection) -> None:
    """The tables of an empty store."""
    for statement in TABLES.split(";"):
        db.execute(statement)
    db.execute(f"PRAGMA user_version = {SCHEMA}")


ALL_TRIALS = f"""SELECT {", ".join([*_names("trial"), *_TRACE])}, seal
FROM trial LEFT JOIN trace USING (cell, repetition) ORDER BY cell, repetition"""
ONE_TRIAL = ALL_TRIALS.replace("ORDER BY", "WHERE cell = ? AND repetition = ? ORDER BY")


LEAST = "SELECT cell, repetition, MIN(best) FROM trial GROUP BY cell"
"""The trial of each cell that got furthest."""
ALL_LEAST = "SELECT cell, repetition, best FROM trial WHERE best IS NOT NULL"
DRAWS = """SELECT cell, repetition, best, reference, known, optimum FROM trial
WHERE reference IS NOT NULL"""
"""What is known of the data of trials whose noise is their own."""


def problem_columns(case: RaceCase) -> dict[str, Any]:
    """A problem under the names of the columns."""
    source = case.source
    # What tables say of a problem is kept, not its data: these may be large, and their digest tells
    # them apart.
    values = {
        "digest": case.digest,
        "dataset": source.name,
        "kind": source.kind,
        "points": sum(len(test) for test in source.tests),
        "stiffness_unit": source.tests[0].units.stiffness,
        "model": case.model,
        "objective": case.objective.name,
        "reference": case.reference,
        "known": case.known,
        "truth": json.dumps(dict(source.truth)),
    }
    return _as_kept("problem", values)


def archived_columns(problem: ProblemRow) -> dict[str, Any]:
    """A problem of an archive likewise."""
    told = asdict(problem) | {"truth": json.dumps(dict(problem.truth))}
    # In the order of the table, in which a row is sealed.
    return _as_kept("problem", {name: told[name] for name in ("digest", *told) if name != "id"})


def cell_columns(plan: Plan, cell: Cell, problems: list[int]) -> dict[str, Any]:
    """A cell likewise; `problems` are the store's numbers of the plan's problems."""
    entrant = plan.entrants[cell.entrant]
    values = {
        "digest": cell.digest,
        "problem": problems[cell.case],
        "optimiser": entrant.optimiser.name,
        "options": entrant.options,
        "budget": plan.budget,
        "seed": str(plan.seed),
    }
    return _as_kept("cell", values)


def trial_columns(result: TrialResult, cell: int) -> dict[str, Any]:
    """What is kept of a trial in a cell of the store, under the names of the columns."""
    theta = None
    if result.theta is not None:
        theta = json.dumps(result.theta)
    # These are kept in another form than a trial has them.
    own = {"cell": cell, "status": str(result.status), "theta": theta}
    return _as_kept("trial", {name: getattr(result, name) for name in _names("trial")} | own)


def trace_columns(result: TrialResult) -> dict[str, bytes | None]:
    """Its trace, likewise."""
    # A trial without a trace has no row for one: a join gives nothing for each of these, and that
    # is what is sealed.
    if not result.trace:
        return dict.fromkeys(_TRACE)
    return {name: getattr(result, own) for name, own in _TRACE.items()}


@cache
def trial_fields() -> tuple[str, ...]:
    """What each column of `ALL_TRIALS` but the last, its seal, holds of a trial."""
    return (*_names("trial"), *_TRACE.values())


def broken_row(cell: int, repetition: int, reason: str) -> tuple[Any, ...]:
    """A row of `ALL_TRIALS` in the place of a damaged one, without numbers."""
    told = {"cell": cell, "repetition": repetition, "status": "damaged", "reason": reason}
    told |= {"evaluations": 0, "gradients": 0, "batched": 0, "seconds": 0.0}
    return tuple(told.get(name) for name in trial_fields())


def problem_of(row: sqlite3.Row) -> ProblemRow:
    """The problem of a row of `PROBLEMS`."""
    kept = {column.name: row[column.name] for column in fields(ProblemRow)}
    return ProblemRow(**kept | {"truth": json.loads(row["truth"])})


def cells_told(value: str) -> list[tuple[str, str]]:
    """Label and digest of each cell of the last run, as a fact tells them."""
    return [(str(label), str(digest)) for label, digest in json.loads(value)]


def optima_told(value: str) -> dict[int, float]:
    """The optimum of each problem by its number, as a fact tells them."""
    return {int(number): float(best) for number, best in json.loads(value).items()}
