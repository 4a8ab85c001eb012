"""springpot's own tables: columns ``name [unit]`` separated by comma, semicolon or tab.

Needed: ``frequency [Hz]`` or ``omega [rad/s]``, and ``storage [kN/m]`` with ``loss [kN/m]`` (any
stiffness, pressure or torsion unit), or ``magnitude [..]`` with ``phase [deg]`` or ``loss_factor
[-]``. Optional: ``storage_sd`` and ``loss_sd`` (in the unit of storage unless they say another),
``temperature [degC]``, ``amplitude [mm]`` or ``[-]``, ``repeat``; ``h3_re [-]`` and ``h3_im [-]``,
the third force harmonic over the first with phases counted from the displacement, and so for 2, 4,
... Any other column of numbers is a condition, any other column of words (or marked ``[text]``) a
label; both can be chosen by ``FILE@name=value``. Lines beginning with ``#`` are kept as provenance.
"""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.measurement import (
    Choice,
    Measurement,
    Reader,
    Units,
    guarded,
    guarded_line,
    unguarded,
    unguarded_line,
)
from springpot.measurement.replicates import NOTE, stands_again

from .cleaning import cleaned
from .columns import NOTES_OF_VALUES, ROLES, TEXT, assign, measurement_of, sign_note
from .generic import read as read_any
from .grid import MISSING, head_text, shortest, text_of
from .proposals import offers
from .table import Column, header_of, name_and_unit, table_of
from .titles import heading

_CELSIUS, _UNIT = "degC", "unit "
_TWICE = "measured twice"
"""Comment of a file whose rows of one frequency were all meant."""
_TOLD = "told in"
"""Comment of a file that springpot wrote, whose frequencies are in rad/s whatever the data came in.
"""
_NOT_MEASURED = frozenset(
    word for word in MISSING if word and not word.casefold().strip("+-").startswith(("nan", "inf"))
)
"""What spreadsheets and people write for no value.

An empty cell, nan or inf is more likely a slip, and is told.
"""


def recognises(head: bytes) -> float:
    """High for a header with a frequency and a modulus of these names, units in square brackets."""
    _, titles = header_of(head_text(head))
    names = {name_and_unit(title)[0] for title in titles}
    units = {name_and_unit(title)[0] for title in titles if title.endswith("]")}
    if not (units & {"frequency", "omega"} and units & {"storage", "magnitude"}):
        return 0.0
    if not names & {"loss", "phase", "loss_factor"}:
        return 0.0
    # Another's table may call the amplitude a strain: then the reader of any table knows more names
    # than this one.
    foreign = {role for title in titles if (role := heading(title).role) in ROLES} - names
    if foreign and not head.lstrip(b"\xef\xbb\xbf").startswith(b"# name: "):
        return 0.7
    return 0.9


def read(path: Path, choice: Choice) -> Measurement:
    """The measurement in a file.

    Raises
    ------
    DataError
        One line with file, line, column and what to mend.
    """
    if choice:
        # Options are for what a file leaves open, which springpot's own tables do not.
        return read_any(path, choice)
    return parse(text_of(path), path.stem)


def parse(text: str, name: str) -> Measurement:
    """The measurement in a text, with this name where the text itself gives none."""
    table = table_of(text)
    roles, others = assign(tuple(map(_as_written, table.columns)))
    notes: dict[str, str] = {}
    if any(cell.strip() in _NOT_MEASURED for column in roles.values() for cell in column.cells):
        roles, others, notes = cleaned(roles, others)
    comments = {key: unguarded_line(value) for key, value in table.comments.items()}
    provenance = {
        key: value for key, value in comments.items() if key not in ("name", _TWICE, _TOLD)
    }
    measurement = measurement_of(roles, others, comments.get("name", name), {**provenance, **notes})
    told = {**measurement.provenance, **sign_note(measurement, roles)}
    measurement = replace(measurement, provenance=told)
    if _TOLD in comments:
        measurement = replace(measurement, units=_told(measurement.units, comments[_TOLD]))
    # A file that springpot wrote of repeated frequencies says so, since it must be readable again.
    if _TWICE not in table.comments:
        measurement = _numbered(measurement)
        _check_duplicates(measurement, roles.get("omega") or roles["frequency"])
    if "name" in comments:
        # What springpot wrote itself has known all its columns.
        return measurement
    asked = offers(measurement, [heading(column.title) for column in table.columns], Choice())
    return replace(measurement, provenance={**measurement.provenance, **asked})


def _told(units: Units, words: str) -> Units:
    """The units with the words of data that were written again.

    What is not understood changes nothing.
    """
    clock, _, letter = (part.strip() for part in words.partition(","))
    try:
        return replace(units, clock=clock, letter=letter)
    except DataError:
        return units


def _as_written(column: Column) -> Column:
    """A column without what keeps a spreadsheet from running its words."""
    named = replace(column, title=unguarded(column.title), name=unguarded(column.name))
    if column.unit != TEXT:
        # Of cells only words are guarded when they are written.
        return named
    return replace(named, cells=list(map(unguarded, column.cells)))


def _numbered(measurement: Measurement) -> Measurement:
    """The rows as repeats, where each frequency was measured so many times in a row.

    Nothing else can have been meant: a sweep up and down, or one before and one after an ageing,
    stands otherwise.
    """
    number = stands_again(measurement)
    if number is None:
        return measurement
    count = int(np.bincount(number)[0])
    points = number.reshape(-1, count)
    if np.any(points != points[:, :1]):
        return measurement
    note = (
        f"each of {len(points)} frequencies was measured {count} times in a row: taken for repeats,"
        " their scatter for the noise"
    )
    repeat = np.tile(np.arange(1, count + 1), len(points))
    # In the place of the note that asks for such numbers.
    return replace(measurement, repeat=repeat, provenance={**measurement.provenance, NOTE: note})


def _check_duplicates(measurement: Measurement, column: Column) -> None:
    """Two rows of one frequency, one set of conditions and one repeat are seldom both meant."""
    pairs = _twins(measurement)
    if not len(pairs):
        return
    first, row = min(((int(low), int(high)) for low, high in pairs), key=lambda pair: pair[1])
    advice = "give it another repeat"
    if measurement.repeat is None:
        advice = "number the sweeps in a column repeat"
    raise column.error(
        f"the frequency {column.cells[row].strip()} stands already in line {column.lines[first]} "
        f"with the same conditions; {advice} or leave out the row",
        row,
    )


def _twins(measurement: Measurement) -> NDArray[np.int64]:
    """Pairs of rows that nothing tells apart, the earlier first; shape (k, 2)."""
    # As a key nan would differ from itself; two gaps tell nothing apart.
    keys = [np.nan_to_num(values, nan=-np.inf) for values in measurement.conditions.values()]
    keys += [
        np.unique(words, return_inverse=True)[1].astype(float)
        for words in measurement.labels.values()
    ]
    if measurement.repeat is not None:
        keys.append(measurement.repeat.astype(float))
    keys.append(measurement.omega)
    order = np.lexsort(keys)
    same = np.ones(max(len(order) - 1, 0), dtype=bool)
    for key in keys:
        same &= key[order][1:] == key[order][:-1]
    places = np.flatnonzero(same)
    return np.sort(np.column_stack([order[places], order[places + 1]]), axis=1)


def text_from(measurement: Measurement) -> str:
    """The text of a file that reads back as the same numbers, bit for bit."""
    columns = _columns(measurement)
    stream = io.StringIO()
    comments = {"name": measurement.name}
    # The numbers are in rad/s, so that they come back bit for bit; this tells in what they were
    # measured.
    comments[_TOLD] = ", ".join(filter(None, (measurement.units.clock, measurement.units.letter)))
    comments |= measurement.provenance
    if len(_twins(measurement)):
        # Otherwise the file would be refused for it when it is read again.
        comments[_TWICE] = "some frequencies, as they were read"
    for key, value in comments.items():
        if not key.startswith(_UNIT) and key not in NOTES_OF_VALUES:
            stream.write(f"# {key}: {guarded_line(' '.join(str(value).split()))}\n")
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow([guarded(title) for title, _ in columns])
    writer.writerows(zip(*(cells for _, cells in columns), strict=True))
    return stream.getvalue()


def write_csv(measurement: Measurement, path: str | Path) -> None:
    """Write a measurement to a file that `read` gives back bit for bit.

    Raises
    ------
    DataError
        If the file cannot be written.
    """
    try:
        Path(path).write_text(text_from(measurement), encoding="utf-8")
    except OSError as error:
        raise DataError(f"cannot write {path}: {error.strerror or error}") from None


def _columns(measurement: Measurement) -> list[tuple[str, list[str]]]:
    unit, moved = measurement.units.stiffness, measurement.units.amplitude
    units = {"temperature": _CELSIUS, "amplitude": moved}
    columns = [
        ("omega [rad/s]", _cells(measurement.omega)),
        (f"storage [{unit}]", _cells(measurement.storage)),
        (f"loss [{unit}]", _cells(measurement.loss)),
    ]
    if measurement.sd is not None:
        columns += [
            (f"storage_sd [{unit}]", _cells(measurement.sd.real)),
            (f"loss_sd [{unit}]", _cells(measurement.sd.imag)),
        ]
    for key, values in measurement.conditions.items():
        own_unit = units.get(key, measurement.provenance.get(f"{_UNIT}{key}", ""))
        title = key
        if own_unit:
            title = f"{key} [{own_unit}]"
        columns.append((title, _cells(values)))
    if measurement.repeat is not None:
        columns.append(("repeat", [str(value) for value in measurement.repeat.tolist()]))
    if measurement.harmonics is not None:
        # The first harmonic is the stiffness itself.
        for order, values in enumerate(measurement.harmonics.T, 2):
            columns += [
                (f"h{order}_re [-]", _cells(values.real)),
                (f"h{order}_im [-]", _cells(values.imag)),
            ]
    for key, words in measurement.labels.items():
        # Marked, since a word may look like a number.
        columns.append(
            (f"{key} [{TEXT}]", [guarded(" ".join(word.split())) for word in words.tolist()])
        )
    return columns


def _cells(values: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> list[str]:
    """Shortest decimals that read back as the same bits; nothing for nan."""
    return list(map(shortest, values.tolist()))


READER = Reader(
    "springpot-csv",
    "CSV with columns name [unit]: frequency [Hz] or omega [rad/s], storage, loss",
    recognises,
    read,
    text=text_from,
)
