"""A disk that is full from some write on.

SQLite's own system calls are replaced, as its tests do it.
"""

from __future__ import annotations

import _sqlite3
import ctypes
import os
from collections.abc import Iterator
from contextlib import contextmanager
from errno import ENOSPC

PWRITE = ctypes.CFUNCTYPE(
    ctypes.c_ssize_t, ctypes.c_int, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int64, use_errno=True
)
SET = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p)
GET = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_void_p, ctypes.c_char_p)


class Vfs(ctypes.Structure):
    """SQLite's table of what it asks of the system, as far as its calls by name."""

    _fields_ = [
        *((name, ctypes.c_int) for name in ("version", "size_of_file", "longest_path")),
        *((name, ctypes.c_void_p) for name in ("next", "name", "data")),
        ("methods", ctypes.c_void_p * 13),
        ("set_call", SET),
        ("get_call", GET),
    ]


def system() -> Vfs | None:
    """The table that is used, or None where it is out of reach."""
    try:
        find = ctypes.CDLL(_sqlite3.__file__).sqlite3_vfs_find
    except (AttributeError, OSError):
        return None
    find.restype, find.argtypes = ctypes.POINTER(Vfs), [ctypes.c_char_p]
    vfs: Vfs = find(None).contents
    return vfs if vfs.version >= 3 else None


class Disk:
    """Counts writes, and lets them fail from one on: half of that one is written still.

    Parameters
    ----------
    room : float
        Writes that succeed.
    lasting : bool
        Whether all that follow fail as well.
    """

    def __init__(self, room: float, lasting: bool = True) -> None:
        self.room, self.lasting, self.writes = room, lasting, 0

    def write(self, fd: int, data: int, size: int, offset: int) -> int:
        self.writes += 1
        failing = self.writes > self.room + 1 if self.lasting else self.writes == self.room + 2
        if failing:
            ctypes.set_errno(ENOSPC)
            return -1
        # What is left of the room takes a part of the page, and the call that brings the rest
        # fails.
        if self.writes == self.room + 1:
            size //= 2
        return os.pwrite(fd, ctypes.string_at(data, size), offset)


@contextmanager
def filling(disk: Disk) -> Iterator[None]:
    """Let SQLite write to `disk` meanwhile."""
    vfs = system()
    assert vfs is not None
    call = PWRITE(disk.write)
    names = [name for name in (b"pwrite", b"pwrite64") if vfs.get_call(ctypes.addressof(vfs), name)]
    for name in names:
        vfs.set_call(ctypes.addressof(vfs), name, ctypes.cast(call, ctypes.c_void_p))
    try:
        yield
    finally:
        for name in names:
            # Nothing in its place is what was there at first.
            vfs.set_call(ctypes.addressof(vfs), name, None)
