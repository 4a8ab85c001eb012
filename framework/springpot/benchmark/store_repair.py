"""What can be saved of a store whose file is damaged.

Every row that can still be reached, in a fresh store.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Iterator

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
