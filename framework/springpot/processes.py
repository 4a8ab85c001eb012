"""What a process that runs foreign code needs: limits, and a plain word on how it ended."""

from __future__ import annotations

import ctypes
import os
import resource
import signal
import sys
import threading
from collections.abc import Container
from contextlib import suppress
from pathlib import Path

import numpy as np

from springpot.limits import address_space

CHILDREN = Path("/proc/thread-self/children")
ADOPT = 36
"""PR_SET_CHILD_SUBREAPER of Linux's prctl(2)."""
TIMERS = (signal.ITIMER_REAL, signal.ITIMER_VIRTUAL, signal.ITIMER_PROF)


def limit_memory(mebibytes: int) -> None:
    """Let the address space grow by so much and no more, where the system tells its present size."""
    had = address_space()
    if had is None:
        return
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    # On top of what is mapped now: libraries take three times as many addresses as memory, before any trial.
    wanted = had + mebibytes * 2**20
    # A negative one says that there is no limit yet.
    if hard >= 0:
        wanted = min(wanted, hard)
    resource.setrlimit(resource.RLIMIT_AS, (wanted, hard))


def adopt_orphans() -> None:
    """Let every descendant that loses its parent become a child of this process, where the system can do that.

    A process that leaves its group and its parent, as daemons do, would otherwise be found by nobody.
    """
    with suppress(OSError, AttributeError):
        # Python has no such call of its own.
        ctypes.CDLL(None).prctl(ADOPT, 1, 0, 0, 0)


def children_of(listing: Path = CHILDREN) -> list[int]:
    """The child processes of this one, or those of another file of that kind; none where the system lists none."""
    try:
        return [int(pid) for pid in listing.read_text().split()]
    except OSError:
        return []


def end_children(known: Container[int] = ()) -> int:
    """End the child processes of this one that still run, but for those known; how many there were."""
    running = 0
    for pid in children_of():
        if pid in known:
            continue
        with suppress(OSError):
            # One that has ended by itself is only collected, and did no harm.
            if os.waitpid(pid, os.WNOHANG)[0] == 0:
                running += 1
                os.kill(pid, signal.SIGKILL)
                # Collected, or it would be listed as a child for as long as this process runs.
                os.waitpid(pid, 0)
    return running


def end_group(pid: int) -> None:
    """End a process that leads a group of its own, and all that it started, in whatever group."""
    # Listed before it ends: then its children have other parents, and nothing tells whose they were.
    away = _descendants(pid)
    with suppress(OSError):
        os.killpg(pid, signal.SIGKILL)
    for one in (pid, *away):
        # The first may not have come to lead a group yet, the others may have left it.
        with suppress(OSError):
            os.kill(one, signal.SIGKILL)


def _descendants(pid: int) -> list[int]:
    """Children of a process, their children and so on, where the system lists them."""
    descendants = []
    for listing in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in children_of(listing):
            descendants += [child, *_descendants(child)]
    return descendants


def settings() -> tuple[object, ...]:
    """What foreign code may leave changed in a process, to the harm of whatever runs there next."""
    return (
        tuple(sys.path),
        sys.getrecursionlimit(),
        _folder(),
        threading.active_count(),
        signal.getsignal(signal.SIGALRM),
        tuple(signal.getitimer(timer) != (0.0, 0.0) for timer in TIMERS),
        tuple(np.geterr().items()),
    )


def _folder() -> str:
    try:
        return os.getcwd()
    # It may have been removed.
    except OSError:
        return ""


def cause_of(status: int) -> str:
    """How a process ended, from what `os.waitpid` says of it."""
    code = os.waitstatus_to_exitcode(status)
    if code >= 0:
        return f"the process ended with exit code {code}"
    try:
        return f"the process was ended by {signal.Signals(-code).name}"
    except ValueError:
        return f"the process was ended by signal {-code}"
