"""Time signals in binary files: MATLAB (version 5 to 7), and TDMS of LabVIEW through npTDMS.

In MATLAB they are vectors named as in CSV, or the columns of one matrix. Their names carry the
units (``t_s``, ``disp_mm``, ``force_N``), or the user says them: ``FILE?t=s,x=mm,F=N``. Channels of
TDMS go by name, with units from their properties.

Every size in a MATLAB file is checked against what is there before it is believed: the general
reader in SciPy ends the whole process on some broken files. Text, cells, objects and sparse arrays
are passed over. The layout is that of "MAT-File Format", The MathWorks.
"""

from __future__ import annotations

import logging
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from math import prod
from pathlib import Path
from struct import unpack_from
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.errors import DataError
from springpot.measurement import Choice, Signals, budget_of, bytes_of
from springpot.rheology import Real

from .channels import channel_of, places_of, reader_of_signals, signals_from

_STORED = {
    1: "i1",
    2: "u1",
    3: "i2",
    4: "u2",
    5: "i4",
    6: "u4",
    7: "f4",
    9: "f8",
    12: "i8",
    13: "u8",
}
_MATRIX, _COMPRESSED = 14, 15
_STRUCT, _NUMERIC = 2, range(6, 16)
_COMPLEX = 0x0800
HEADER = 128
_DEEPEST = 4


class BrokenFile(ValueError):
    """A size or a type that cannot be."""


@dataclass(frozen=True)
class _Element:
    kind: int
    data: memoryview


def arrays_in(content: bytes, most: int) -> dict[str, NDArray[np.float64]]:
    """Arrays by name; those in structures as ``name.field``.

    Parameters
    ----------
    content : bytes
        The file.
    most : int
        Bytes that it may unpack to.

    Raises
    ------
    BrokenFile
        If the file is broken or unpacks to more.
    """
    # The last two bytes of the header are "MI" as the writing machine stores the number of these
    # letters.
    order = "<"
    if content[126:128] == b"MI":
        order = ">"
    arrays: dict[str, NDArray[np.float64]] = {}
    for element in _elements(memoryview(content)[HEADER:], order, padded=False):
        if element.kind == _COMPRESSED:
            unpacked = _unpacked(element.data, most)
            # What may be unpacked is counted over the whole file: many small bombs are one.
            most -= len(unpacked)
            inner = list(_elements(memoryview(unpacked), order))
        else:
            inner = [element]
        for matrix in inner:
            if matrix.kind == _MATRIX and len(matrix.data):
                arrays |= _matrix(matrix.data, order, "", 0)
    return arrays


def _unpacked(packed: memoryview, most: int) -> bytes:
    try:
        # One byte more than may be shows that there is too much, without unpacking it.
        content = zlib.decompressobj().decompress(packed, max(most, 0) + 1)
    except zlib.error as error:
        raise BrokenFile(str(error)) from None
    if len(content) > most:
        raise BrokenFile("it unpacks to too much; save the three vectors alone")
    return content


def _elements(data: memoryview, order: str, padded: bool = True) -> Iterator[_Element]:
    """Elements one after the other; those of four bytes and less are packed into their tag."""
    place = 0
    while place + 8 <= len(data):
        first, size = unpack_from(order + "II", data, place)
        if first >> 16:
            kind, size, start, step = first & 0xFFFF, first >> 16, place + 4, 8
            if size > 4:
                raise BrokenFile("a small element is too large")
        else:
            kind, start = first, place + 8
            # Elements are filled up to whole eight bytes, compressed ones at the top of the file
            # are not.
            filled = -(-size // 8) * 8
            if not padded and kind == _COMPRESSED:
                filled = size
            step = 8 + filled
        if start + size > len(data):
            raise BrokenFile("it is cut off")
        yield _Element(kind, data[start : start + size])
        place += step


def _matrix(data: memoryview, order: str, outer: str, depth: int) -> dict[str, NDArray[np.float64]]:
    parts = _elements(data, order)
    flags, sizes, name = (next(parts, None) for _ in range(3))
    if (
        flags is None
        or sizes is None
        or name is None
        or len(flags.data) != 8
        or sizes.kind != 5
        or len(sizes.data) % 4
    ):
        raise BrokenFile("a matrix without flags, size or name")
    (flag,) = unpack_from(order + "I", flags.data)
    shape = tuple(np.frombuffer(sizes.data, order + "i4").tolist())
    # MATLAB knows nothing below a matrix: a number is 1 by 1.
    if not 2 <= len(shape) <= 8 or min(shape) < 0:
        raise BrokenFile("a matrix of impossible size")
    title = outer + bytes(name.data).decode("latin-1")
    if flag & 0xFF in _NUMERIC and not flag & _COMPLEX:
        return {title: _numbers(next(parts, None), shape, order)}
    if flag & 0xFF == _STRUCT and prod(shape) == 1 and depth < _DEEPEST:
        return _fields(parts, order, title, depth)
    return {}


def _numbers(part: _Element | None, shape: tuple[int, ...], order: str) -> NDArray[np.float64]:
    """The real part, column by column as MATLAB stores it, in whatever type it was packed into."""
    if part is None or part.kind not in _STORED:
        raise BrokenFile("a matrix without numbers")
    kind = np.dtype(order + _STORED[part.kind])
    if len(part.data) != prod(shape) * kind.itemsize:
        raise BrokenFile("a matrix whose size and contents differ")
    return np.frombuffer(part.data, kind).astype(np.float64).reshape(shape, order="F")


def _fields(
    parts: Iterator[_Element], order: str, title: str, depth: int
) -> dict[str, NDArray[np.float64]]:
    length, names = next(parts, None), next(parts, None)
    if length is None or names is None or len(length.data) != 4:
        raise BrokenFile("a structure without fields")
    (width,) = unpack_from(order + "i", length.data)
    if not 0 < width <= 256 or len(names.data) % width:
        raise BrokenFile("a structure with impossible names")
    text = bytes(names.data)
    arrays: dict[str, NDArray[np.float64]] = {}
    for start in range(0, len(text), width):
        # Names of fields have one length, and end at the first zero byte.
        field = text[start : start + width].split(b"\0", 1)[0].decode("latin-1")
        part = next(parts, None)
        if part is None:
            raise BrokenFile("a structure that lacks a field")
        if part.kind == _MATRIX and len(part.data):
            arrays |= _matrix(part.data, order, f"{title}.{field}", depth + 1)
    return arrays


MOST_CHANNELS = 64
"""Columns of a matrix at most: a larger one is no table of signals."""


def _is_matlab(head: bytes) -> float:
    """High for the first line of a MATLAB file."""
    return float(head.startswith(b"MATLAB ") and len(head) >= HEADER)


def _of_matlab(path: Path, choice: Choice) -> Signals:
    """The signals in a file.

    Raises
    ------
    DataError
        If the file is of version 7.3, broken, unpacks to too much, or lacks a channel or its unit.
    """
    columns = _columns(_arrays(path))
    if not columns:
        raise DataError("no vectors of numbers; save t_s, disp_mm and force_N from MATLAB with -v7")
    titles = list(columns)
    places = places_of(titles, [], choice)
    chosen = [columns[titles[i]] for i in places.columns]
    if len({len(values) for values in chosen}) > 1:
        lengths = ", ".join(f"{titles[i]}: {len(columns[titles[i]])}" for i in places.columns)
        raise DataError(f"time, displacement and force differ in length ({lengths})")
    return signals_from(chosen, places, path, "MATLAB")


def _arrays(path: Path) -> dict[str, NDArray[np.float64]]:
    content = bytes_of(path)
    if content.startswith(b"MATLAB 7.3"):
        raise DataError("MATLAB 7.3 files are HDF5; save it with -v7, or as CSV")
    try:
        return arrays_in(content, budget_of(path).memory)
    except BrokenFile as error:
        raise DataError(f"no readable MATLAB file: {error}") from None


def _columns(arrays: dict[str, NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
    """Vectors by name, those in a structure by the names of its fields.

    Columns of a matrix by name and number.
    """
    vectors: dict[str, NDArray[np.float64]] = {}
    for name, array in arrays.items():
        key = name.rpartition(".")[2]
        flat = array.reshape([size for size in array.shape if size != 1] or [1], order="F")
        if flat.size < 2:
            continue
        if flat.ndim == 1:
            vectors.setdefault(key, flat)
        elif flat.ndim == 2 and min(flat.shape) <= MOST_CHANNELS:
            tall = flat
            if flat.shape[0] < flat.shape[1]:
                # Samples are more than channels, whichever way they were saved.
                tall = flat.T
            vectors |= {f"{key}:{i}": tall[:, i - 1] for i in range(1, tall.shape[1] + 1)}
    return vectors


MATLAB = reader_of_signals(
    "signals-mat",
    "MATLAB .mat (to version 7) with vectors of time, displacement and force",
    _is_matlab,
    _of_matlab,
)


_UNIT_KEYS = ("unit_string", "NI_UnitDescription", "Unit", "unit", "units")
_SAMPLE = 8
"""Bytes of a number."""


def _is_tdms(head: bytes) -> float:
    """High for the first four bytes of a TDMS segment."""
    return float(head.startswith(b"TDSm"))


def _of_tdms(path: Path, choice: Choice) -> Signals:
    """The signals in a file; time from a channel of that name or from the sampling interval.

    Raises
    ------
    DataError
        If npTDMS is not installed, the file is broken, or a channel or its unit is missing.
    """
    try:
        from nptdms import TdmsFile
        from nptdms.log import log_manager
    except ImportError:
        raise DataError("TDMS files need npTDMS: pip install 'springpot[instruments]'") from None
    # What npTDMS would print of a file that is cut off is said by the error, or does no harm.
    log_manager.set_level(logging.CRITICAL)
    try:
        with TdmsFile.open(path) as file:
            return _of_channels(file, choice, path)
    except (DataError, MemoryError):
        raise
    except Exception as error:
        # Broken files fail within npTDMS in many ways.
        reason = (str(error).splitlines() or [""])[0]
        raise DataError(f"no readable TDMS file: {type(error).__name__}: {reason:.80}") from None


def _of_channels(file: Any, choice: Choice, path: Path) -> Signals:
    channels: list[Any] = []
    for group in file.groups():
        channels += filter(len, group.channels())
    most = budget_of(path).memory // _SAMPLE
    # Before any is read: a broken index claims any length.
    if any(not 0 <= len(channel) <= most for channel in channels):
        raise DataError("a channel claims more samples than the file can hold")
    titles = [str(channel.name) for channel in channels]
    units = [
        next((str(c.properties[key]) for key in _UNIT_KEYS if key in c.properties), "")
        for c in channels
    ]
    if not any(channel_of(title)[0] == "time" for title in titles):
        # LabVIEW writes the interval of a waveform as a property, and no channel of times.
        timed = next(
            (c for c in channels if float(c.properties.get("wf_increment", 0) or 0) > 0), None
        )
        if timed is not None:
            channels, titles, units = [*channels, timed], [*titles, "time"], [*units, "s"]
    places = places_of(titles, units, choice)
    made = [_values(channels[i], titles[i], i >= len(set(channels))) for i in places.columns]
    length = min(map(len, made))
    return signals_from([values[:length] for values in made], places, path, "TDMS")


def _values(channel: Any, title: str, is_clock: bool) -> Real:
    if is_clock:
        step, start = (
            float(channel.properties["wf_increment"]),
            float(channel.properties.get("wf_start_offset", 0)),
        )
        return np.asarray(start + step * np.arange(len(channel)), dtype=float)
    values = np.asarray(channel[:])
    if values.dtype.kind == "M":
        return np.asarray((values - values[0]) / np.timedelta64(1, "s"), dtype=float)
    if values.dtype.kind not in "fiu":
        raise DataError(f"channel '{title:.40}' holds no numbers")
    return values.astype(float)


TDMS = reader_of_signals(
    "signals-tdms",
    "LabVIEW TDMS with channels of time (or a sampling interval), displacement and force",
    _is_tdms,
    _of_tdms,
)
