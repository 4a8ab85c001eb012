"""Opens what a user names.

A file of any known format or a registered data set, with conditions chosen by ``@``.

Of a file, ``#`` chooses a part and ``?`` says what it leaves open:
``FILE#2?frequency=Hz@temperature=20``.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from difflib import get_close_matches
from itertools import islice
from pathlib import Path
from typing import TypeVar

from springpot.errors import DataError
from springpot.files import keep_input
from springpot.inputs import require_regular
from springpot.owners import owned

from .budget import within_budget
from .catalogue import DataSet
from .from_signals import OneTest, measurement_of_tests, one_test
from .measurement import Measurement
from .naming import (
    LISTED,
    file_and_choice,
    in_quotes,
    is_file,
    names_file,
    short,
    temperature_offer,
    without_rows,
)
from .reader import Choice, Part, Reader
from .recognition import guarded, surest, to_type
from .selection import conditions, select
from .signals import Signals

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
    near = get_close_matches(text, known, n=3, cutoff=0.5)
    hint = "see 'springpot list datasets'"
    if near:
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


def signals_to_measurement(
    paths: Sequence[str | Path],
    readers: Iterable[Reader],
    *,
    omega: float | None = None,
    n_harmonics: int = 5,
    window: tuple[float, float] | None = None,
    name: str | None = None,
) -> Measurement:
    """Step one of the paper for files: one row of K' and K'' for each file of time signals.

    Parameters
    ----------
    paths : sequence of str or Path
        Files of displacement and force against time, one test in each; ``FILE?force=kN`` says what
        is left open.
    readers : iterable of Reader
        The known formats.
    omega, n_harmonics, window, name
        As in `measurement_from_signals`.

    Raises
    ------
    DataError
        If a file holds no time signals or cannot be evaluated.
    """
    known = list(readers)
    evaluated = (
        evaluated_in(path, known, omega=omega, n_harmonics=n_harmonics, window=window)
        for path in paths
    )
    return measurement_of_tests(evaluated, name)


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
    signals = within_budget(path, lambda: _signals_by(path, choice, list(readers)))
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
        otherwise = f"otherwise springpot inspect {in_quotes(str(path))} shows what it holds"
        raise DataError(
            f"{path}: these are no signals against time (read as {reader.name});"
            f" {advice}; {otherwise}"
        )
    return guarded(reader, path, lambda: load(path, choice), choice)
