"""What a page asks about, and session files: the data and every ladder of a page, to open again.

An answer depends on no more than data, a model, accepted effects, left-out points and a seed. Data
go between processes and into sessions as the text of a CSV file that reads back bit for bit; a
session is read as data that a stranger wrote. Tests in time are one specimen, of which each file is
kept as it came, in a line of JSON: so they too cross to workers, stand in sessions, and are known
by their digest. A file has the name that a browser gave for as long as a reader needs it.
"""

from __future__ import annotations

import base64
import hashlib
import json
import os
import re
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from springpot.constraints import parameters_of
from springpot.errors import DataError
from springpot.files import bytes_of, json_of
from springpot.measurement.conversion import FILE, joined as together
from springpot.measurement.measurement import Measurement
from springpot.measurement.mixed_up import turned
from springpot.measurement.opening import Test
from springpot.measurement.reader import LONGEST_NAME, Part
from springpot.registry import open_measurement, open_tests, parts_of, plugins
from springpot.rheology.grammar import LONGEST
from springpot.rheology.typed import is_law

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


TESTS = "springpot.tests/1"


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
        return json.dumps({"schema": TESTS, "files": self.files})


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
    return text.startswith(f'{{"schema": "{TESTS}"')


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


Kept = TypeVar("Kept", bound=Opened)


def measured_in(name: str, content: bytes, choice: str = "") -> tuple[Opened, tuple[Part, ...]]:
    """What an uploaded file holds, by the same readers and budget as a file that is named.

    Parameters
    ----------
    name : str
        As the browser gave it.
    content : bytes
        Of the file.
    choice : str
        What the user says beside: ``#2``, ``?storage=Pa``, ``@temperature=20``, or several in this
        order.

    Raises
    ------
    OpenQuestion
        If its reader must be told more.
    DataError
        If it cannot be read.
    """
    with as_file(name, content) as path:
        first = open_tests(f"{path}{choice}")[0]
        # A sweep comes alone.
        if isinstance(first, Measurement):
            return first, parts_of(path)
    return Specimen.of_file(name, content, choice), ()


def opened(spec: str) -> tuple[Opened, tuple[Part, ...]]:
    """What a file or data set that the command line names holds, with its parts.

    Raises
    ------
    OpenQuestion, DataError
        As `measured_in`.
    """
    name = re.sub(r"[#?@].*$", "", spec)
    for path in (Path(spec), Path(name)):
        if path.is_file():
            return measured_in(path.name, bytes_of(path), spec[len(str(path)) :])
    return open_measurement(spec), parts_of(spec)


def text_of(measurement: Opened) -> str:
    """The text of a CSV file that reads back as the same bits; of tests in time their files.

    Raises
    ------
    DataError
        If no plugin offers such a format.
    """
    if isinstance(measurement, Specimen):
        return measurement.text
    for reader in plugins().items("reader"):
        if reader.text is not None:
            text: str = reader.text(measurement)
            return text
    raise DataError("no plugin offers a format to keep measurements in")


def data_of(text: str) -> Opened:
    """The data in a text by `text_of`."""
    if is_specimen(text):
        return specimen_of(text)
    return measurement_of(text)


def measurement_of(text: str) -> Measurement:
    """The measurement in a text by `text_of`."""
    with as_file("data.csv", text.encode()) as path:
        return open_measurement(path)


def kept(measurement: Kept, excluded: tuple[int, ...]) -> Kept:
    """The data without the rows that are left out; what is relative to their temperature stays so.

    Raises
    ------
    DataError
        If a row is not there or none is left.
    """
    if not excluded:
        return measurement
    # They ascend: the last is the largest.
    if excluded[-1] >= len(measurement):
        raise DataError(
            f"{measurement.name} has {len(measurement)} points; there is no point {excluded[-1]}"
            " in it"
        )
    if len(excluded) == len(measurement):
        raise DataError(f"{measurement.name}: all points are left out; take some back")
    rows = np.ones(len(measurement), dtype=bool)
    rows[list(excluded)] = False
    rest: Any = measurement.subset(rows)
    return rest  # type: ignore[no-any-return]


def _there(both: Measurement, count: int) -> NDArray[np.bool_]:
    """Which of the rows from `count` on stand above already, digit for digit.

    A file that is added to itself by mistake would be a repeat without any scatter, and the noise
    floor nothing.
    """
    rows = np.column_stack([both.omega, both.storage, both.loss, *both.conditions.values()])
    # By their bytes: two numbers that were measured agree in a few digits, never in all.
    there = {row.tobytes() for row in rows[:count]}
    return np.array([row.tobytes() in there for row in rows[count:]])


def _specimen(data: Opened) -> Specimen:
    if isinstance(data, Specimen):
        return data
    return Specimen.of_file(f"{data.name}.csv", text_of(data).encode(), "")


def joined(one: Opened, other: Opened) -> Opened:
    """New data below those that are there, in their units: a next experiment joins the first.

    Sweeps become one table; with a test in time they are tests of one specimen.

    Raises
    ------
    DataError
        If one is a modulus and the other a stiffness, one lacks a condition of the other, or the
        new data are there already.
    """
    first, second = _sweep(one), _sweep(other)
    if first is None or second is None:
        return _specimen(one).joined(_specimen(other))
    return _one_table(first, second)


def joined_anew(one: Opened, other: Opened) -> Opened:
    """As `joined`, without the rows of the other that the first holds already."""
    first, second = _sweep(one), _sweep(other)
    if first is None or second is None:
        return joined(one, other)
    if _is_copy(first, second):
        return one
    new = ~_there(together([first, second]), len(first))
    if not new.any():
        return one
    return _one_table(first, second.subset(new))


def _sweep(data: Opened) -> Measurement | None:
    """As points at frequencies: a record of one frequency is one of them."""
    if isinstance(data, Specimen):
        return data.as_sweep()
    return data


def _is_copy(one: Measurement, other: Measurement) -> bool:
    alike = one.units == other.units and np.array_equal(one.omega, other.omega)
    return alike and np.array_equal(one.stiffness, other.stiffness)


def _one_table(one: Measurement, other: Measurement) -> Measurement:
    # A copy is no second test to anybody, and refused before it could be looked at.
    both = one if _is_copy(one, other) else together([one, other])
    if both is one or _there(both, len(one)).all():
        raise DataError(
            f"{other.name}: all of its points stand in the open data already; nothing was added"
        )
    # Only what was measured twice is a repeat: files of one frequency each are one sweep.
    known = one.repeat is not None or other.repeat is not None
    again = known or bool(np.intersect1d(one.omega, other.omega).size)
    repeat = None
    if again:
        repeat = both.repeat
    return Measurement(
        both.omega,
        both.stiffness,
        sd=both.sd,
        conditions=both.conditions,
        repeat=repeat,
        units=both.units,
        name=both.name,
        provenance={**one.provenance, "joined with": other.name},
        labels={FILE: np.concatenate([_files(one), _files(other)])},
    )


def _files(data: Measurement) -> NDArray[np.str_]:
    """From which file each row (n,) came, which may be a specimen by itself."""
    return data.labels.get(FILE, np.full(len(data), data.name))


@dataclass(frozen=True)
class State:
    """One rung of one ladder.

    Parameters
    ----------
    data : str
        Digest of the text of the data, see `digest_of`.
    model : str
        Expression of the model at the foot of the ladder; empty for any material.
    accepted : tuple of str
        Effects in the order in which they were accepted.
    excluded : tuple of int
        Rows of the data that are left out, ascending.
    seed : int
        Of simulated noise.
    fixed : tuple of (str, float)
        Parameters that are held, in printed units, by name.
    options : str
        Whose parameters are and how they are tied, as on the command line: ``--own k:batch``.

    Examples
    --------
    >>> State("0" * 64, "fractional-maxwell").accepting("inertia").expression
    'fractional-maxwell + inertia'
    """

    data: str
    model: str = ""
    accepted: tuple[str, ...] = ()
    excluded: tuple[int, ...] = ()
    seed: int = 0
    fixed: tuple[tuple[str, float], ...] = ()
    options: str = ""

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> State:
        """The state in a request or a session file, which may hold anything.

        Raises
        ------
        DataError
            If something of it is missing or of the wrong kind.
        """
        try:
            state = cls(
                _text(given["data"]),
                _text(given.get("model", "")),
                tuple(_text(name) for name in _listed(given.get("accepted", ()))),
                tuple(sorted({_number(row) for row in _listed(given.get("excluded", ()))})),
                _number(given.get("seed", 0)),
                _held(given.get("fixed", {})),
                _text(given.get("options", "")),
            )
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise DataError(f"this is no state of the workbench: {error}") from None
        return state

    @property
    def key(self) -> str:
        """The same for the same state, and for no other."""
        # Sorted, so that equal states have equal texts.
        text = json.dumps(self.to_dict(), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()

    @property
    def expression(self) -> str:
        """The grown model as it is typed."""
        # A law has a + of its own.
        joins = (f"({name})" if is_law(name) and name[0] != "(" else name for name in self.accepted)
        return " + ".join([self.model or "material", *joins])

    def accepting(self, effect: str) -> State:
        """The next rung."""
        return replace(self, accepted=(*self.accepted, effect))

    @property
    def fix(self) -> dict[str, float] | None:
        """What is held, as `springpot.discover` takes it."""
        return dict(self.fixed) or None

    @property
    def known(self) -> dict[str, Any]:
        """What is held, shared and tied, as `springpot.discover` takes it."""
        return {"fix": self.fix, **parameters_of(self.options)}

    def to_dict(self) -> dict[str, Any]:
        """As JSON has it; where nothing is held or tied, nothing is said of it."""
        told = asdict(self) | {"fixed": self.fix, "options": self.options or None}
        return {key: value for key, value in told.items() if value is not None}


def digest_of(text: str) -> str:
    """SHA-256 of the text of a measurement, by which the page and the server name it."""
    return hashlib.sha256(text.encode()).hexdigest()


def _text(value: object) -> str:
    if not isinstance(value, str) or len(value) > LONGEST:
        raise ValueError(f"{str(value)[:40]!r} is no name")
    return value


def _number(value: object) -> int:
    # True is an int to Python.
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise ValueError(f"{str(value)[:40]!r} is no whole number from 0 on")
    return value


def _held(value: object) -> tuple[tuple[str, float], ...]:
    if not isinstance(value, dict):
        raise ValueError("what is held are names with their values")
    for number in value.values():
        if isinstance(number, bool) or not isinstance(number, int | float) or not isfinite(number):
            raise ValueError(f"{str(number)[:40]!r} is no number")
    return tuple(sorted((_text(name), float(number)) for name, number in value.items()))


def _listed(value: object) -> list[object]:
    if not isinstance(value, list | tuple):
        raise ValueError("a list is wanted")
    return list(value)


SCHEMA = "springpot.session/1"


def is_session(content: bytes) -> bool:
    """Whether a file looks like one."""
    # Not by its name, which a browser or a mail program may have changed.
    return content.lstrip()[:1] == b"{" and SCHEMA.encode() in content


def session_of(content: bytes) -> dict[str, Any]:
    """A session with nothing in it but what the page expects.

    Raises
    ------
    DataError
        If it is none, or holds what a page would not have written.
    """
    try:
        given = json_of(content.decode("utf-8-sig"), finite=True)
        if given["schema"] != SCHEMA:
            raise ValueError(f"its schema is {str(given['schema'])[:40]!r}, not {SCHEMA}")
        data = given["data"]
        text = data["text"]
        if not isinstance(text, str):
            raise ValueError("its data are no text")
        # What the file says of it is not believed: states go by the data that are really there.
        digest = digest_of(text)
        branches = [_branch(branch, digest) for branch in list(given["branches"])]
        if not branches:
            raise ValueError("it has no branch")
        # Which branch lay open may be any number in a strange file: it is kept within those that
        # there are.
        at = int(given.get("branch", 0))
        return {
            "schema": SCHEMA,
            "data": {
                "source": str(data.get("source", "data.csv"))[:200],
                "joined": bool(data.get("joined")),
                "text": text,
            },
            "branches": branches,
            "branch": min(max(at, 0), len(branches) - 1),
            "view": _view(given.get("view", {})),
        }
    except (
        KeyError,
        TypeError,
        ValueError,
        AttributeError,
        RecursionError,
        OverflowError,
        DataError,
    ) as error:
        words = " ".join(str(error).split())[:120]
        raise DataError(
            f"this is no session of the workbench ({words}); open one that it saved"
        ) from None


def _branch(branch: Mapping[str, Any], digest: str) -> dict[str, Any]:
    states = [
        replace(State.of({**state, "data": digest}), data=digest) for state in branch["states"]
    ]
    if not states:
        raise ValueError("a branch has no state")
    at = min(max(int(branch.get("at", 0)), 0), len(states) - 1)
    return {
        "name": safe_name(str(branch.get("name", "")))[:40],
        "states": [s.to_dict() for s in states],
        "at": at,
    }


def _view(view: Mapping[str, Any]) -> dict[str, Any]:
    """Words, numbers and switches only."""
    # The page sets what it knows and passes over the rest.
    return {str(key): value for key, value in view.items() if isinstance(value, str | int | float)}
