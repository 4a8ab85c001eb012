"""Tests in time on the page: one specimen, of which each file is kept as it came.

Their text is a line of JSON with the files in it, where that of sweeps is a table: so both cross to
workers, stand in sessions, and are known by their digest. A file has the name that a browser gave
for as long as a reader needs it.
"""

from __future__ import annotations

import base64
import json
import os
import re
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.files import json_of
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_up import turned
from springpot.measurement.opening import Test
from springpot.measurement.reader import LONGEST_NAME
from springpot.registry import open_measurement, open_tests

UNSAFE = re.compile(r"[^\w.+() -]", re.ASCII)
"""What has a meaning in paths, FILE#PART?COLUMN=UNIT@CONDITION or a terminal is none of these."""


def safe_name(name: str) -> str:
    r"""The last part of a name that a browser gave, with nothing in it that means more than a name.

    Examples
    --------
    >>> names = "../../etc/passwd", "C:\\\\data\\\\my damper.csv", "-rf?x=1"
    >>> [safe_name(name) for name in names]
    ['passwd', 'my damper.csv', '_rf_x_1']
    """
    # Both slashes: the browser may run on another system than this.
    last = re.split(r"[/\\]", name)[-1]
    # The end is kept, where the suffix stands.
    plain = UNSAFE.sub("_", last)[-LONGEST_NAME:].strip()
    # A hyphen would begin an option, and a dot hide the file.
    return re.sub(r"^[-.]+", "_", plain) or "data"


@contextmanager
def as_file(name: str, content: bytes) -> Iterator[Path]:
    """A file of that name in a folder of its own, which is the current one meanwhile.

    Errors name just the file.

    Only for worker processes, which do one thing at a time.
    """
    here = os.getcwd()
    with tempfile.TemporaryDirectory(prefix="springpot-") as folder:
        os.chdir(folder)
        try:
            # Relative, within the new folder: no name can lead out of it.
            path = Path(safe_name(name))
            path.write_bytes(content)
            yield path
        finally:
            # Before the folder is removed: no process may stay in what is gone.
            os.chdir(here)


SCHEMA = "springpot.tests/1"


@dataclass(frozen=True, eq=False)
class Specimen:
    """Tests of one specimen, at least one of them in time.

    Parameters
    ----------
    files : tuple of dict
        Each ``{"name", "choice", "content"}``: what was dropped, in base64, and what was answered.
    out : tuple of int
        Rows that are left out, ascending, counted through all tests.
    """

    files: tuple[dict[str, str], ...]
    out: tuple[int, ...] = ()

    @classmethod
    def of_file(cls, name: str, content: bytes, choice: str) -> Specimen:
        """The tests in one file."""
        return cls(
            ({"name": name, "choice": choice, "content": base64.b64encode(content).decode()},)
        )

    @cached_property
    def tests(self) -> tuple[Test, ...]:
        """All of them, without what is left out."""
        found = [test for file in self.files for test in _opened(file, open_tests)]
        if not self.out:
            return tuple(found)
        stays = np.ones(sum(map(len, found)), dtype=bool)
        stays[list(self.out)] = False
        ends = np.cumsum([len(test) for test in found])
        return tuple(
            test if rows.all() else test.subset(rows)
            for test, rows in zip(found, np.split(stays, ends[:-1]), strict=True)
            if rows.any()
        )

    @property
    def name(self) -> str:
        """What it is called."""
        return ", ".join(test.name for test in self.tests)

    def __len__(self) -> int:
        return sum(map(len, self.tests))

    def subset(self, rows: NDArray[np.bool_]) -> Specimen:
        """The same without some rows of its one test."""
        return replace(self, out=tuple(np.flatnonzero(~rows).tolist()))

    def joined(self, other: Specimen) -> Specimen:
        """With the tests of another."""
        return Specimen((*self.files, *other.files))

    def turned(self) -> Specimen:
        """With the channels turned that seem to count the other way, as opening it so would do.

        Raises
        ------
        DataError
            If a file holds several tests that do not all count so.
        """
        return replace(self, files=tuple(map(_turned, self.files)))

    def as_sweep(self) -> Measurement | None:
        """Its one file as points at frequencies, if that is what its signals are too."""
        if len(self.files) > 1:
            return None
        try:
            return _opened(self.files[0], open_measurement)
        except DataError:
            return None

    @property
    def sources(self) -> list[str]:
        """The files as a command names them."""
        return [f"{safe_name(file['name'])}{file['choice']}" for file in self.files]

    @property
    def text(self) -> str:
        """What `specimen_of` reads."""
        return json.dumps({"schema": SCHEMA, "files": self.files})


Tests = TypeVar("Tests")
Opened: TypeAlias = Measurement | Specimen


def _opened(file: dict[str, str], by: Callable[[str], Tests]) -> Tests:
    with as_file(file["name"], base64.b64decode(file["content"])) as path:
        return by(f"{path}{file['choice']}")


def _turned(file: dict[str, str]) -> dict[str, str]:
    found = [turned(test.provenance) for test in _opened(file, open_tests)]
    if not any(found):
        return file
    name = safe_name(file["name"])
    if len(set(found)) > 1:
        raise DataError(f"{name} holds several tests: open one alone, as '{max(found)}'")
    return {**file, "choice": found[0].removeprefix(name)}


def is_specimen(text: str) -> bool:
    """Whether a text is one of tests in time."""
    return text.startswith(f'{{"schema": "{SCHEMA}"')


def specimen_of(text: str) -> Specimen:
    """The tests in a text.

    Raises
    ------
    DataError
        If it is none, as that of a session may be that a stranger wrote.
    """
    try:
        files = json_of(text)["files"]
        kept = [{key: str(file[key]) for key in ("name", "choice", "content")} for file in files]
    except (ValueError, KeyError, TypeError) as error:
        raise DataError(f"these are no tests in time: {error}") from None
    return Specimen(tuple(kept))


def tests_in(data: Opened) -> tuple[Test, ...]:
    """The tests in what was opened, which every function of springpot takes."""
    if isinstance(data, Specimen):
        return data.tests
    return (data,)
