"""Limits by kernel and clock on a piece of work, kept only in processes that are springpot's own.

The command line and the workers of the page say that they are (`own_process`). In anybody else's
Python nothing is limited: a timer, a signal or a limit of memory there is felt by all that runs
beside, in threads and debuggers too.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import TypeVar

T = TypeVar("T")

_TICK = 0.1
"""Seconds after which work that was told to end, and did not, is told again."""


class OverTime(BaseException):
    """Raised within work whose time is over; no `Exception`, which readers may well catch."""


class _Clock:
    """The handler of the signal that time is over."""

    def __init__(self) -> None:
        self.running = True

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """End what runs, if it runs still."""
        if self.running:
            raise OverTime


_own = False
_clock: _Clock | None = None


@contextmanager
def own_process() -> Iterator[None]:
    """Say that the process is springpot's own, so that work in it may be limited."""
    global _own
    before, _own = _own, True
    try:
        yield
    finally:
        _own = before


def limited(action: Callable[[], T], seconds: float, memory: int) -> T:
    """What `action` gives; in a process of springpot's own it is ended when it takes too much.

    Parameters
    ----------
    action : callable
        Work of the main thread, which alone hears signals; in any other it is not limited.
    seconds : float
        Of processor time of the process.
    memory : int
        Bytes beyond what the process has now; the kernel of Linux holds it to that.

    Raises
    ------
    OverTime, MemoryError
        If it takes more; within work that is limited already, the limits are those of the whole.
    """
    if not _own or _clock is not None or not _hears_signals():
        return action()
    with _unheard_in_finalisers():
        return _in_time(lambda: _in_memory(action, memory), seconds)


def _hears_signals() -> bool:
    return hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()


def _in_time(action: Callable[[], T], seconds: float) -> T:
    """What `action` gives; `OverTime` is raised within it when the time is over."""
    global _clock
    clock = _clock = _Clock()
    before = signal.signal(signal.SIGPROF, clock)
    try:
        try:
            # Again and again, for what is raised within a finaliser is lost.
            signal.setitimer(signal.ITIMER_PROF, seconds, _TICK)
            return action()
        finally:
            # A word may come before this assignment and skip it; the next is a tick away: what is
            # below is reached.
            clock.running = False
    finally:
        clock.running = False
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
        _clock = None


@contextmanager
def uncounted() -> Iterator[None]:
    """Let what springpot makes of the data not count as time of the reader that asks for it."""
    if _clock is None or not _hears_signals():
        yield
        return
    left, _ = signal.setitimer(signal.ITIMER_PROF, 0.0)
    try:
        yield
    finally:
        # Of zero seconds the timer would never end.
        signal.setitimer(signal.ITIMER_PROF, max(left, _TICK), _TICK)


@contextmanager
def _unheard_in_finalisers() -> Iterator[None]:
    """Let nothing be printed of a word that fell into a finaliser, where it is lost.

    It is said again.
    """
    before = sys.unraisablehook

    def hook(lost: sys.UnraisableHookArgs) -> None:
        if lost.exc_type is not OverTime:
            before(lost)

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before


def _in_memory(action: Callable[[], T], more: int) -> T:
    """What `action` gives with so many bytes more than the process has now.

    As far as the system can enforce it.
    """
    had = address_space()
    if had is None:
        return action()
    import resource

    _, hard = both = resource.getrlimit(resource.RLIMIT_AS)
    wanted = [had + more, *(limit for limit in both if limit != resource.RLIM_INFINITY)]
    resource.setrlimit(resource.RLIMIT_AS, (min(wanted), hard))
    try:
        return action()
    finally:
        # Before anything else, and by nothing that was not there: where memory is at its end
        # CPython 3.11 does not survive the call of a function.
        resource.setrlimit(resource.RLIMIT_AS, both)


def address_space() -> int | None:
    """Bytes that the process has been given.

    None where the system does not tell, or keeps no limit.
    """
    try:
        # The first number is the address space in pages, which the limit is about.
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        return pages * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, IndexError, AttributeError):
        return None
