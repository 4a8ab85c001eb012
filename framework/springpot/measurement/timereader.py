"""Readers of tests in time, chosen by a file's content, and how they open a user's file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from .budget import within_budget
from .opening import read_head
from .other_test import OtherTest
from .reader import Choice, file_and_choice, guarded, is_file, surest, to_type, without_rows
from .timetest import TimeTest

SURE = 0.5
"""Confidence from which a file is taken for tests in time: below, it may be any table."""


@dataclass(frozen=True)
class TimeReader:
    """One layout of files with tests in time.

    Parameters
    ----------
    name : str
        Shown by ``springpot list readers``.
    summary : str
        One sentence on the layout.
    recognises : callable
        From the first bytes of a file to a confidence between 0 (not mine) and 1 (surely mine).
    read : callable
        From a path and a `Choice` to the tests, in the order of the file.
    """

    name: str
    summary: str
    recognises: Callable[[bytes], float]
    read: Callable[[Path, Choice], Sequence[TimeTest | OtherTest]]


def open_in_time(
    spec: str | Path, readers: Iterable[TimeReader]
) -> tuple[TimeTest | OtherTest, ...]:
    """The tests in time in the file that a user names.

    None where it is no file, or holds something else.

    Parameters
    ----------
    spec : str or Path
        ``FILE``, ``FILE#2`` for a part, ``FILE?temperature=25[degC]`` for what the file leaves
        open.
    readers : iterable of TimeReader
        The known layouts.

    Raises
    ------
    DataError
        If the file holds tests in time that cannot be used, in one line.
    """
    # Rows are chosen of sweeps: of a record they are no test.
    if without_rows(str(spec)) != str(spec):
        return ()
    name, choice = file_and_choice(str(spec))
    if not is_file(name) or Path(name).is_dir():
        return ()
    path = Path(name)
    return within_budget(path, lambda: _read(path, choice, list(readers)))


def _read(
    path: Path, choice: Choice, readers: Sequence[TimeReader]
) -> tuple[TimeTest | OtherTest, ...]:
    best, sure = surest(readers, read_head(path))
    # No error: whatever is no test in time may be a sweep, and is opened as one.
    if best is None or sure < SURE:
        return ()
    tests = guarded(best, path, lambda: tuple(best.read(path, choice)), choice)
    return tuple(_told(test, path, choice) for test in tests)


def _told(test: TimeTest | OtherTest, path: Path, choice: Choice) -> TimeTest | OtherTest:
    """The test with what is told of it as a user types it."""
    origin = {key: to_type(path, text, choice) for key, text in test.provenance.items()}
    return replace(test, provenance=origin)
