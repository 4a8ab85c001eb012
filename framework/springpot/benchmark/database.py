"""SQLite as a store needs it.

Several programs at once do no harm, and whatever goes wrong is one line.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from time import monotonic, sleep

from springpot.errors import StudyError

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
