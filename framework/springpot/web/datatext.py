"""Data as the text of a CSV file that reads back bit for bit, between processes and in sessions."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from springpot.errors import DataError
from springpot.measurement.joining import joined as together
from springpot.measurement.measurement import Measurement
from springpot.measurement.reader import Part
from springpot.registry import open_in_time, open_measurement, parts_of, plugins

LONGEST = 80
"""Signs of a file's name that are kept."""
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
    plain = UNSAFE.sub("_", last)[-LONGEST:].strip()
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


def measured_in(
    name: str, content: bytes, choice: str = ""
) -> tuple[Measurement, tuple[Part, ...]]:
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
    DataError
        If it cannot be read.
    """
    with as_file(name, content) as path:
        return opened(f"{path}{choice}"), parts_of(path)


def opened(spec: str) -> Measurement:
    """What a file or data set holds, at frequencies.

    Raises
    ------
    OpenQuestion
        If its reader must be told more.
    DataError
        If it cannot be read, or holds a test in time, which this page does not judge.
    """
    try:
        return open_measurement(spec)
    except DataError:
        # Asked only where it did not open: nearly all that is dropped are sweeps.
        if not _in_time(spec):
            raise
    raise DataError(
        f"{spec} holds a test in time, and this page judges sweeps at frequencies; in a shell"
        f" 'springpot diagnose {spec} --model EXPR' judges it, 'springpot identify SWEEP {spec}"
        " --model EXPR' joins it to a sweep"
    )


def _in_time(spec: str) -> bool:
    """Whether the readers of tests in time take it.

    A sweep's reader would ask for columns that are not there.
    """
    try:
        return bool(open_in_time(spec))
    except DataError:
        return False


def text_of(measurement: Measurement) -> str:
    """The text of a CSV file that reads back as the same bits.

    Raises
    ------
    DataError
        If no plugin offers such a format.
    """
    for reader in plugins().items("reader"):
        if reader.text is not None:
            text: str = reader.text(measurement)
            return text
    raise DataError("no plugin offers a format to keep measurements in")


def measurement_of(text: str) -> Measurement:
    """The measurement in a text by `text_of`."""
    with as_file("data.csv", text.encode()) as path:
        return open_measurement(path)


def kept(measurement: Measurement, excluded: tuple[int, ...]) -> Measurement:
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
    return measurement.subset(rows)


def _copied(both: Measurement, count: int) -> bool:
    """Whether the rows from `count` on stand above already, digit for digit.

    A file that is added to itself by mistake would be a repeat without any scatter, and the noise
    floor nothing.
    """
    rows = np.column_stack([both.omega, both.storage, both.loss, *both.conditions.values()])
    # By their bytes: two numbers that were measured agree in a few digits, never in all.
    there = {row.tobytes() for row in rows[:count]}
    return all(row.tobytes() in there for row in rows[count:])


def joined(one: Measurement, other: Measurement) -> Measurement:
    """New data below those that are there, in their units.

    So that a next experiment joins the first.

    Raises
    ------
    DataError
        If one is a modulus and the other a stiffness, one lacks a condition of the other, or the
        new data are there already.
    """
    both = together([one, other])
    if _copied(both, len(one)):
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
    )
