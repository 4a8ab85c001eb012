"""Arrays of numbers in MATLAB files of version 5 to 7.

Every size is checked against what is there before it is believed: the general reader in SciPy ends
the whole process on some broken files. Text, cells, objects and sparse arrays are passed over. The
layout is that of "MAT-File Format", The MathWorks.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from math import prod
from struct import unpack_from

import numpy as np
from numpy.typing import NDArray

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
