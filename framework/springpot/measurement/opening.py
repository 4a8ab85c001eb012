"""Opens what a user names: files of any known format and registered data sets.

Conditions behind ``@`` choose rows (``temperature=20``, ``frequency=1..10``, ``row=3``); of a file
``#`` chooses a part and ``?`` says what it leaves open: ``FILE#2?frequency=Hz@temperature=20``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import TypeAlias, TypeVar

from springpot.errors import DataError, SpringpotError, described, owned
from springpot.files import keep_input, require_regular, within_budget
from springpot.writing import NAMED, near_names, suggested

from .covered import OtherTest
from .from_signals import OneTest, one_test
from .measurement import Measurement
from .mixed_up import NOTE, runs_together
from .reader import (
    LISTED,
    Choice,
    Part,
    Reader,
    file_and_choice,
    guarded,
    in_quotes,
    is_file,
    names_file,
    short,
    surest,
    temperature_offer,
    to_type,
    without_rows,
)
from .rows import rows_with
from .signals import Signals
from .timetest import TimeTest

Test: TypeAlias = Measurement | TimeTest | OtherTest
"""What was measured on one specimen: a sweep, a test in time, or one of a further kind."""
PROMISED = "promised accuracy"
"""Of a provenance, what a data set says of its instrument; a comment in a file is no such word."""
EXAMPLE = "temperature=20,amplitude=1 or frequency=1..10"


def together(names: Iterable[str]) -> str:
    """Several tests in one name; of many in one file it says how many they are.

    Examples
    --------
    >>> from springpot.measurement.opening import together
    >>> together(["sweep", "creep#1", "creep#2"])
    'sweep + creep#1 + creep#2'
    >>> together(["sweep", *(f"creep#{number}" for number in range(1, 22))])
    'sweep + creep (21 tests)'
    """
    files: dict[str, list[str]] = {}
    for name in names:
        files.setdefault(name.partition("#")[0], []).append(name)
    told: list[str] = []
    for file, tests in files.items():
        told += tests if len(tests) <= NAMED else [f"{file} ({len(tests)} tests)"]
    return " + ".join(told)


def sweep_of(tests: Sequence[Test]) -> Measurement | None:
    """The sweep that stands alone; None where a test in time is among the tests."""
    if isinstance(tests[0], Measurement) and len(tests) == 1:
        return tests[0]
    return None


def conditions(text: str, where: str) -> dict[str, str]:
    """Conditions and their values, of text such as ``temperature=20,frequency=1..10``.

    Parameters
    ----------
    text : str
        The conditions, with commas between them; a value of words may hold commas too.
    where : str
        What they stand in, for the message.

    Raises
    ------
    DataError
        If a part of it is none.

    Examples
    --------
    >>> from springpot.measurement.opening import conditions
    >>> conditions("temperature=20,frequency=1..10", "FILE@temperature=20,frequency=1..10")
    {'temperature': '20', 'frequency': '1..10'}
    """
    wanted = {}
    # A comma that no further condition follows belongs to a value, which may be anybody's words.
    for part in re.split(r",(?=[^,=]*=)", text):
        key, equals, value = (piece.strip() for piece in part.partition("="))
        # A value may be empty, as a remark is that was not written.
        if not (key and equals):
            raise DataError(f"'{where}': write conditions as {EXAMPLE}")
        wanted[key] = value
    return wanted


def select(measurement: Measurement, wanted: Mapping[str, str]) -> Measurement:
    """The rows that have all the wanted conditions.

    Parameters
    ----------
    measurement : Measurement
        The data.
    wanted : mapping of str to str
        Condition, label, ``repeat``, ``frequency`` in Hz, ``omega`` in rad/s or ``row`` (the first
        is 1), and its value or range: ``1..10``, ``..10`` or ``1..``, ends included. Numbers match
        within 0.5 K for ``temperature``, 5 % for ``amplitude`` and 1 % otherwise; words match
        whole, or by their beginning.

    Raises
    ------
    DataError
        If there is no such column or value, with those that there are.

    Examples
    --------
    >>> import springpot
    >>> from springpot.measurement import select
    >>> select(springpot.read("artificial-hidden"), {"frequency": "1..10"})
    <Measurement artificial-hidden@frequency=1..10: 17 points, 1.13 to 9.93 Hz>
    """
    rows = rows_with(measurement, wanted)
    if not rows.any():
        # Each condition alone has rows, or one of them would have been refused by name.
        chosen = ", ".join(f"{key}={value}" for key, value in wanted.items())
        raise DataError(f"{measurement.name}: no row has {chosen} together")
    chosen = ",".join(f"{key}={value}" for key, value in wanted.items())
    part = measurement.subset(rows, f"{measurement.name}@{chosen}")
    if NOTE not in part.provenance:
        return part
    # Of the tests that stood together fewer may be left, or one.
    known = {key: value for key, value in part.provenance.items() if key != NOTE}
    named_already = frozenset[str]()
    if "note parts" in known:
        named_already = frozenset({"step"})
    return replace(
        part, provenance={**known, **runs_together(part.conditions, part.labels, named_already)}
    )


def without(measurement: Measurement, unwanted: Mapping[str, str]) -> Measurement:
    """The rows that lack one of the conditions, as part of the same data; see `select`.

    Raises
    ------
    DataError
        If there is no such column or value, or nothing would be left.

    Examples
    --------
    >>> import springpot
    >>> from springpot.measurement import without
    >>> len(without(springpot.read("artificial-hidden"), {"frequency": "1..10"}))
    23
    """
    left = tests_without([measurement], unwanted)
    assert isinstance(left[0], Measurement)
    return left[0]


def tests_without(tests: Sequence[Test], unwanted: Mapping[str, str]) -> list[Test]:
    """Tests of one specimen without the rows, or samples, that have all of these conditions.

    Parameters
    ----------
    tests : sequence of Measurement or TimeTest
        The tests.
    unwanted : mapping of str to str
        As in `select`; of a test in time also ``time`` in s and ``sample``, and of several tests
        ``test``, a name or its beginning, alone for the whole of it. What names no test is left out
        of all that know the column.

    Raises
    ------
    DataError
        If no test has such a column or value, or nothing would be left.

    Examples
    --------
    >>> import springpot
    >>> from springpot.measurement.opening import tests_without
    >>> test = springpot.TimeTest.of_relaxation([0.1, 1.0, 10.0], [3.0, 2.0, 1.0])
    >>> tests_without([test], {"time": "..0.5"})
    [<TimeTest relaxation: relaxation, 2 samples, 1 to 10 s>]
    """
    meant, rest = _meant(tests, unwanted)
    left: list[Test] = []
    faults: list[DataError] = []
    for test in tests:
        if test not in meant:
            left.append(test)
            continue
        try:
            kept = ~rows_with(test, rest)
        except DataError as error:
            # Another test may have what this one lacks.
            faults.append(error)
            left.append(test)
            continue
        if kept.any():
            left.append(test.subset(kept))
    if len(faults) == len(meant):
        raise faults[0]
    if not left:
        raise DataError(f"{tests[0].name}: nothing would be left")
    return left


def _meant(tests: Sequence[Test], unwanted: Mapping[str, str]) -> tuple[list[Test], dict[str, str]]:
    """The tests that are named, or all of them, and the conditions on their rows."""
    rest = dict(unwanted)
    # A column of words may have that name, and then it is meant.
    if "test" not in rest or any("test" in test.labels for test in tests):
        return list(tests), rest
    name = rest.pop("test")
    for fits in (str.__eq__, str.startswith):
        if named := [test for test in tests if fits(test.name, name)]:
            return named, rest
    known = ", ".join(test.name for test in tests)
    raise DataError(f"there is no test '{name}' (there are: {known})")


@dataclass(frozen=True)
class DataSet:
    """A data set that can be named instead of a file.

    Parameters
    ----------
    name : str
        What users type.
    summary : str
        One sentence on what was measured, or that nothing was.
    load : callable
        Gives the measurement, or a tuple of tests of one specimen (`TimeTest` and `Measurement`);
        called only when the set is used.
    kind : str
        ``measured``, ``artificial`` or ``reconstruction`` (computed from published parameters,
        never measured).
    licence : str
        Terms under which the numbers may be used.
    citation : str
        Who measured, where it was published.
    doi, origin : str
        Of the publication, and where the numbers can be got.
    size : int
        Number of points, 0 if unknown before loading.
    truth : mapping of str to float
        Element parameters behind artificial data and reconstructions.
    model : str
        Model behind them, or the one used in the literature.
    fit : str
        What the literature found with it.
    test : str
        Instrument, geometry and kind of test.
    columns : tuple of str
        What is given, with units: ``omega [rad/s]``.
    stiffness_scale : float or None
        The paper's k-bar for these data.
    objective : str
        By which they are raced, where that is part of the problem.
    best : float or None
        Least objective known of the model behind them, in the box, by that objective.
    physics : tuple of str
        What is known to be in the data: friction, a shift with temperature, an artefact of the
        instrument.
    aliases : tuple of str
        Other names.
    remote : str
        Address from which it is downloaded when it is first used; empty where it is on this
        machine.
    unavailable : str
        Empty, or why the set cannot be loaded here and how to mend it.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> from springpot.measurement import DataSet
    >>> two_points = Measurement([1.0, 2.0], [1j, 2j])
    >>> DataSet("two-points", "made up", lambda: two_points, kind="artificial").open()
    <Measurement measurement: 2 points, 0.159 to 0.318 Hz>
    """

    name: str
    summary: str
    load: Callable[[], Measurement | tuple[Test, ...]]
    kind: str = "measured"
    licence: str = ""
    citation: str = ""
    doi: str = ""
    origin: str = ""
    size: int = 0
    truth: dict[str, float] = field(default_factory=dict)
    model: str = ""
    fit: str = ""
    test: str = ""
    columns: tuple[str, ...] = ()
    stiffness_scale: float | None = None
    objective: str = ""
    best: float | None = None
    physics: tuple[str, ...] = ()
    aliases: tuple[str, ...] = ()
    remote: str = ""
    unavailable: str = ""

    @property
    def where(self) -> str:
        """In one word: ``here``, ``download``, or ``missing``."""
        if self.unavailable:
            return "missing"
        if self.remote:
            return "download"
        return "here"

    def open(self) -> Measurement:
        """The measurement.

        Raises
        ------
        DataError
            If the set is unavailable here, its plugin fails, or it holds tests in time.
        """
        sweep = sweep_of(self.tests())
        if sweep is None:
            raise DataError(f"data set '{self.name}' holds tests in time: it is no single sweep")
        return sweep

    def tests(self) -> tuple[Test, ...]:
        """What was measured: a sweep, or all tests of one specimen.

        Raises
        ------
        DataError
            If the set is unavailable here, or its plugin fails.
        """
        if self.unavailable:
            raise DataError(f"data set '{self.name}' is unavailable: {self.unavailable}")
        try:
            loaded = self.load()
        except DataError as error:
            raise DataError(f"{owned('data set', self.name)}: {error}") from error
        except (SpringpotError, MemoryError):
            raise
        except Exception as error:
            raise DataError(
                f"{owned('data set', self.name)} cannot be loaded: {described(error)}"
            ) from error
        if isinstance(loaded, Measurement):
            return (loaded,)
        if not (loaded and isinstance(loaded, tuple) and all(isinstance(t, Test) for t in loaded)):
            raise DataError(
                f"{owned('data set', self.name)} gives {loaded!r:.80}, which is no measurement"
            )
        return loaded


T = TypeVar("T")

HEAD = 1 << 16
"""Bytes by which a reader recognises its format."""


def open_measurement(
    spec: str | Path, datasets: Iterable[DataSet], readers: Iterable[Reader]
) -> Measurement:
    """The measurement that `spec` names.

    Parameters
    ----------
    spec : str or Path
        A file, or the name of a data set, either with conditions: ``nist-srm2491@temperature=20``;
        a file also with a part and what it leaves open: ``FILE#2?frequency=Hz``.
    datasets : iterable of DataSet
        The registered data sets.
    readers : iterable of Reader
        The known formats; the one that is surest of a file's content reads it.

    Raises
    ------
    DataError
        If there is no such thing, it cannot be read, or no row has the conditions.
    """
    text = str(spec)
    if is_file(text):
        return _read(Path(text), Choice(), readers)
    # A file may have an @ in its name: only what is no file is taken apart.
    stem = without_rows(text)
    if stem != text:
        return select(
            _named(stem, datasets, readers), conditions(text[len(stem) + 1 :], short(text))
        )
    if names_file(text):
        return _named(text, datasets, readers)
    name, at, wanted = text.rpartition("@")
    # A value may hold one too, as in binder=PG 64-22 @ 58: what follows it is then no condition.
    while "@" in name and "=" not in wanted:
        name, _, more = name.rpartition("@")
        wanted = f"{more}@{wanted}"
    if not at:
        return _named(text, datasets, readers)
    return select(_named(name, datasets, readers), conditions(wanted, short(text)))


def _named(text: str, datasets: Iterable[DataSet], readers: Iterable[Reader]) -> Measurement:
    name, choice = file_and_choice(text)
    if is_file(name):
        return _read(Path(name), choice, readers)
    # Files were looked for first: a data set that a plugin adds must not hide a file of the user's.
    listed = list(datasets)
    known: dict[str, DataSet] = {}
    for data in listed:
        known |= dict.fromkeys(data.aliases, data)
    known |= {data.name: data for data in listed}  # a name goes before the alias of another set
    if text in known:
        return known[text].open()
    if choice and name in known:
        raise DataError(
            f"'{short(text)}': '#' and '?' are for files; choose from a data set by"
            f" {name}@temperature=20"
        )
    text = name
    if text and (beside := _files_like(text)):
        raise DataError(
            f"'{short(text)}': there is no such file or data set: did you mean"
            f" {' or '.join(beside)}?"
        )
    # A stroke or an ending: it was meant as a file.
    if text and ("/" in text or "\\" in text or re.search(r"\.\w{1,5}$", text)):
        raise DataError(f"{short(text)}: there is no such file")
    hint = f"see '{suggested('list datasets')}'"
    if near := near_names(text, known):
        hint = f"did you mean {', '.join(near)}?"
    raise DataError(f"'{short(text)}' is neither a file nor a registered data set: {hint}")


def _files_like(text: str) -> list[str]:
    """Files beside the one named, with its name but another ending, or nearly its name."""
    path = Path(text)
    try:
        names = [entry.name for entry in islice(path.parent.iterdir(), LISTED) if entry.is_file()]
    except (OSError, ValueError):
        # A folder that cannot be listed, or text that is no path: then there is nothing to propose.
        return []
    # The very name with another ending is surer than one that only looks like it.
    same = sorted(
        name for name in names if Path(name).stem == path.name and not name.startswith(".")
    )
    near = get_close_matches(path.name, names, n=2, cutoff=0.8)
    return [str(path.parent / name) for name in (same or near)[:2]]


def read_head(path: Path) -> bytes:
    """The first bytes of a file.

    Raises
    ------
    DataError
        If it is a folder, a pipe or device, empty, or cannot be read.
    """
    # A pipe or a device may never end, or wait for ever.
    require_regular(path)
    if path.is_dir():
        raise DataError(f"{path}: this is a folder, name a file in it")
    try:
        with path.open("rb") as stream:
            # Only the beginning: readers are asked whether they know the format, and none need see
            # the whole file for that.
            head = stream.read(HEAD)
            if len(head) == HEAD and not _below_remarks([head]):
                # Recognition must not see remarks alone, however many there are.
                stream.seek(0)
                head = (_below_remarks(stream) + stream.read(HEAD))[:HEAD]
    except FileNotFoundError:
        beside, hint = _files_like(str(path)), ""
        if beside:
            hint = f": did you mean {' or '.join(beside)}?"
        raise DataError(f"{short(str(path))}: there is no such file{hint}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise DataError(f"{short(str(path))}: cannot be read: {reason}") from None
    if not head:
        raise DataError(f"{path}: the file is empty")
    # Of a data set the command line knows only the name.
    keep_input(path)
    return head


def _below_remarks(lines: Iterable[bytes]) -> bytes:
    """The first line that is neither blank nor a comment; nothing where there is none."""
    for piece in lines:
        for line in piece.splitlines(keepends=True):
            bare = line.strip(b"\xef\xbb\xbf \t\r\n")
            if bare and not bare.startswith(b"#"):
                return line
    return b""


def pick_reader(path: Path, readers: Iterable[Reader]) -> Reader:
    """The reader that is surest of the file's content.

    Raises
    ------
    DataError
        If none recognises it.
    """
    known = list(readers)
    # By content and not by the ending: instruments write .txt, .csv and .dat as they please.
    best, sure = surest(known, read_head(path))
    if best is None or not sure > 0:
        names = ", ".join(reader.name for reader in known) or "none"
        hint = "it takes columns with names above numbers"
        # Some programs save a page of HTML under the name of a spreadsheet.
        if read_head(path).lstrip(b"\xef\xbb\xbf \r\n\t").startswith(b"<"):
            hint = "HTML or XML, save it as .xlsx or CSV"
        raise DataError(f"{path}: no reader recognises this file: {hint} (readers: {names})")
    return best


def _read(path: Path, choice: Choice, readers: Iterable[Reader]) -> Measurement:
    def read() -> Measurement:
        reader = pick_reader(path, readers)
        measurement = guarded(reader, path, lambda: reader.read(path, choice), choice)
        if not isinstance(measurement, Measurement):
            given = f"gives {measurement!r:.80}, which is no measurement"
            raise DataError(f"{path}: the {owned('reader', reader.name)} {given}")
        provenance = dict(measurement.provenance)
        for key, text in provenance.items():
            if key.startswith("note "):
                provenance[key] = to_type(path, text, choice)
        # A number in the file's name is only offered: what the file itself says comes first.
        if "temperature" not in measurement.conditions:
            provenance |= temperature_offer(path)
        return replace(measurement, provenance=provenance)

    # A damaged file, or a reader's fault, must not hold the program up for ever.
    return within_budget(path, read)


def parts_of(spec: str | Path, readers: Iterable[Reader]) -> tuple[Part, ...]:
    """The steps, sweeps or sheets of the file that `spec` names.

    None for anything that holds but one.

    Raises
    ------
    DataError
        If the file cannot be read.
    """
    path = file_and_choice(without_rows(str(spec)))[0]
    if not is_file(path):
        return ()
    return _parts(Path(path), list(readers))


def _parts(path: Path, readers: list[Reader]) -> tuple[Part, ...]:
    return within_budget(path, lambda: _parts_by(pick_reader(path, readers), path))


def _parts_by(reader: Reader, path: Path) -> tuple[Part, ...]:
    list_parts = reader.parts
    if list_parts is None:
        return ()
    listed = guarded(reader, path, lambda: list_parts(path))
    # A reader does not know under which name the user opened the file.
    return tuple(replace(part, says=to_type(path, part.says, Choice())) for part in listed)


def open_signals(spec: str | Path, readers: Iterable[Reader]) -> Signals:
    """The displacement and force against time in the file that a user names.

    Raises
    ------
    DataError
        If the file holds no time signals.
    """
    name, choice = file_and_choice(str(spec))
    path = Path(name)
    return within_budget(path, lambda: _signals_by(path, choice, list(readers)))


def evaluated_in(
    spec: str | Path,
    readers: Iterable[Reader],
    *,
    omega: float | None = None,
    n_harmonics: int = 5,
    window: tuple[float, float] | None = None,
) -> OneTest:
    """What the time signals of one file come to: a row of a measurement.

    Raises
    ------
    DataError
        If the file holds no time signals or cannot be evaluated.
    """
    name, choice = file_and_choice(str(spec))
    path = Path(name)
    signals = open_signals(spec, readers)
    test = one_test(signals, omega=omega, n_harmonics=n_harmonics, window=window)
    return replace(test, notes=tuple(to_type(path, note, choice) for note in test.notes))


def _signals_by(path: Path, choice: Choice, readers: list[Reader]) -> Signals:
    reader = pick_reader(path, readers)
    if reader.signals is None and choice.columns:
        # Who says which columns are time and force means signals, whatever their names look like.
        reader = pick_reader(path, [each for each in readers if each.signals is not None])
    load = reader.signals
    if load is None:
        advice = "if they are, say which by name or number: " + in_quotes(
            f"{path}?NAME=time[s],NAME=displacement[mm],NAME=force[N]"
        )
        otherwise = f"otherwise {suggested('inspect', path)} shows what it holds"
        raise DataError(
            f"{path}: these are no signals against time (read as {reader.name});"
            f" {advice}; {otherwise}"
        )
    return guarded(reader, path, lambda: load(path, choice), choice)


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
    return within_budget(path, lambda: _read_test(path, choice, list(readers)))


def _read_test(
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


@dataclass(frozen=True)
class Measured:
    """What was measured of a problem, not of an optimiser on it.

    Parameters
    ----------
    part : str
        The part of its suite that it belongs to by these, such as ``hard``.
    features : mapping of str to float
        By name.
    """

    part: str
    features: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Suite:
    """A versioned collection of problems: its name says which version, and nothing in it changes.

    Parameters
    ----------
    name : str
        What users type; its problems are called ``NAME/PROBLEM``.
    summary : str
        One sentence on what it holds.
    load : callable
        Gives the problems, each a `DataSet` with its own model and objective; called only when the
        suite is used.
    measure : callable, optional
        Gives what was measured of each problem, by its name.

    Examples
    --------
    >>> import springpot
    >>> suite = springpot.plugins().find("suite", "springpot-60")
    >>> len(suite.problems)
    60
    """

    name: str
    summary: str
    load: Callable[[], tuple[DataSet, ...]]
    measure: Callable[[], Mapping[str, Measured]] = dict

    @cached_property
    def problems(self) -> tuple[DataSet, ...]:
        """Its problems, in their order."""
        return self.load()

    @cached_property
    def measured(self) -> Mapping[str, Measured]:
        """What was measured of each problem, by its name."""
        return self.measure()

    def problem(self, name: str) -> DataSet:
        """One of them, by its whole name.

        Raises
        ------
        DataError
            If it has none of that name.
        """
        known = {problem.name: problem for problem in self.problems}
        if name in known:
            return known[name]
        # By what follows the suite's own name, which all of them share.
        short = {each.partition("/")[2]: each for each in known}
        near = get_close_matches(name.partition("/")[2], short, n=3)
        hint = f"see '{suggested('list suites', self.name)}'"
        if near:
            hint = f"did you mean {' or '.join(short[each] for each in near)}?"
        raise DataError(f"suite {self.name} has no problem '{name}': {hint}")
