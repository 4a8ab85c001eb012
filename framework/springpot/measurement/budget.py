"""What reading a file may take, stated and enforced here and nowhere else.

A reader gets a regular file, at most `TIMES` its size plus `SPARE` of memory, and `SECONDS` plus the time for its
size of processor time. Whatever ends for want of these ends in one line.
"""

from __future__ import annotations

import ctypes
import os
import stat
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from springpot.errors import DataError

T = TypeVar("T")

SECONDS = 5.0
"""Of processor time for any file: the largest instrument export among the tests takes a tenth of it."""
BYTES_A_SECOND = 10e6
"""For each of which there is one more second: text is parsed at two to four times this rate."""
TIMES = 10
"""Bytes of memory for each of a file: a table needs about seven while its cells are text."""
SPARE = 200 << 20
"""Bytes of memory for any file: libraries that a reader imports, and an archive that unpacks."""
_TICK = 0.1
"""Seconds after which a reader that was told to end, and did not, is told again."""

_ONE = threading.RLock()
"""One file is read at a time: the limit of memory is that of the whole process."""


class OverTime(BaseException):
    """Raised within a reader whose time is over; no `Exception`, which readers may well catch."""


@dataclass(frozen=True)
class Budget:
    """What reading one file may take.

    Parameters
    ----------
    seconds : float
        Of processor time.
    memory : int
        Bytes, beyond what the process had before.
    """

    seconds: float
    memory: int


def budget_of(path: Path) -> Budget:
    """What reading this file may take."""
    try:
        size = path.stat().st_size
    except (OSError, ValueError):
        size = 0
    return Budget(SECONDS + size / BYTES_A_SECOND, TIMES * size + SPARE)


def require_regular(path: Path) -> None:
    """Refuse what has no end or must be waited for; what is not there at all is found when it is opened.

    Raises
    ------
    DataError
        If the path is a pipe, a socket or a device.
    """
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):
        return
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise DataError(f"{path}: a pipe or device, no regular file; save what comes from it, and open that")


def within_budget(path: Path, action: Callable[[], T]) -> T:
    """What `action` gives, which reads the file; ended when it takes more than the file is worth.

    Processor time is that of the thread where the system tells it, so that a busy machine changes nothing. Memory is
    limited by the kernel on Linux, and not elsewhere.

    Raises
    ------
    DataError
        If the file is a pipe or device, or time or memory ended.
    """
    require_regular(path)
    budget = budget_of(path)
    try:
        with _ONE, _limited_memory(budget.memory), _unheard_in_finalisers():
            return _in_time(budget.seconds, action)
    except OverTime:
        spent = f"more than {budget.seconds:.1f} s of processor time"
    except MemoryError:
        spent = f"more than {budget.memory >> 20} MiB of memory"
    raise DataError(
        f"{path}: reading it was ended: it takes {spent}, too much for its size; save only the table that matters, "
        "in several files if need be ('springpot signals' reads time signals of any length)"
    )


def _in_time(seconds: float, action: Callable[[], T]) -> T:
    """What `action` gives; `OverTime` is raised within it when the time is over."""
    watch = _Watch(seconds)
    watch.start()
    try:
        try:
            with _watched_by(watch):
                return action()
        finally:
            # A mere assignment, within which nothing can be raised. One word may have been said before it and be
            # heard while the watch is called back, and one more be on its way: both are over when that is done twice.
            watch.running = False
            watch.recall()
    except OverTime:
        watch.recall()
        raise


@contextmanager
def _unheard_in_finalisers() -> Iterator[None]:
    """Let nothing be printed of a word that fell into a finaliser, where it is lost: it is said again."""
    before = sys.unraisablehook

    def hook(lost: sys.UnraisableHookArgs) -> None:
        if lost.exc_type is not OverTime:
            before(lost)

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before


_HERE = threading.local()
"""The watch of each thread that reads."""


@contextmanager
def _watched_by(watch: _Watch) -> Iterator[None]:
    before = getattr(_HERE, "watch", None)
    _HERE.watch = watch
    try:
        yield
    finally:
        _HERE.watch = before


@contextmanager
def uncounted() -> Iterator[None]:
    """Let what springpot itself makes of the data not count as time of the reader that asks for it."""
    watch = getattr(_HERE, "watch", None)
    if watch is None:
        yield
        return
    watch.paused = True
    start = watch.clock()
    try:
        yield
    finally:
        watch.until += watch.clock() - start
        watch.paused = False


class _Watch(threading.Thread):
    """Waits beside the thread that made it, and tells it to end."""

    def __init__(self, seconds: float) -> None:
        super().__init__(name="springpot-reading", daemon=True)
        self._target = threading.get_ident()
        self.clock = _clock_of(self._target)
        self.until = self.clock() + seconds
        self.running, self.paused = True, False
        self._speaking = False
        self._ended = threading.Event()

    def run(self) -> None:
        """Wake when the time may be over; again and again, for what is raised within a finaliser is lost."""
        while self.running and not self._ended.wait(max(self.until - self.clock(), _TICK)):
            # Set before it is looked whether to speak; no lock, which the other might leave without releasing it.
            self._speaking = True
            if self.running and not self.paused and self.clock() >= self.until:
                _raise_in(self._target, OverTime)
            self._speaking = False

    def recall(self) -> None:
        """Let the word that may be on its way be heard here, or take it back."""
        while self._speaking:
            time.sleep(0)
        _raise_in(self._target, None)
        self._ended.set()


def _clock_of(thread: int) -> Callable[[], float]:
    """Processor time of a thread; where the system does not tell it, the time of day."""
    if hasattr(time, "pthread_getcpuclockid"):
        clock = time.pthread_getcpuclockid(thread)
        return lambda: time.clock_gettime(clock)
    return time.monotonic


def _raise_in(thread: int, error: type[BaseException] | None) -> None:
    """Raise an error in another thread before its next step, or take back one that was not yet raised."""
    # An empty one stands for NULL, which takes back.
    what = ctypes.py_object()
    if error is not None:
        what = ctypes.py_object(error)
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), what)


@contextmanager
def _limited_memory(more: int) -> Iterator[None]:
    """Let the process have so many bytes more than it has now, as far as the system can hold it to that."""
    had = _address_space()
    if had is None:
        yield
        return
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    wanted = [had + more, *(limit for limit in (soft, hard) if limit != resource.RLIM_INFINITY)]
    resource.setrlimit(resource.RLIMIT_AS, (min(wanted), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _address_space() -> int | None:
    """Bytes that the process has been given; None where the system does not tell, or keeps no limit."""
    try:
        # The first number is the address space in pages, which the limit is about.
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        return pages * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, IndexError, AttributeError):
        return None
