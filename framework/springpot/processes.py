"""What a process that runs foreign code needs: limits, and a plain word on how it ended."""

from __future__ import annotations

import os
import resource
import signal
import sys
import threading
from contextlib import suppress
from pathlib import Path

import numpy as np

CHILDREN = Path("/proc/thread-self/children")
TIMERS = (signal.ITIMER_REAL, signal.ITIMER_VIRTUAL, signal.ITIMER_PROF)


def limit_memory(mebibytes: int) -> None:
    """Let the address space grow by so much and no more, where the system tells its present size."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[0])
    except OSError:
        return
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    wanted = pages * resource.getpagesize() + mebibytes * 2**20
    resource.setrlimit(resource.RLIMIT_AS, (wanted if hard < 0 else min(wanted, hard), hard))


def end_children() -> int:
    """End the child processes of this one that still run, where the system lists them; how many there were."""
    try:
        children = [int(pid) for pid in CHILDREN.read_text().split()]
    except OSError:
        return 0
    running = 0
    for pid in children:
        with suppress(OSError):
            # One that has ended by itself is only collected, and did no harm.
            if os.waitpid(pid, os.WNOHANG)[0] == 0:
                running += 1
                os.kill(pid, signal.SIGKILL)
                os.waitpid(pid, 0)
    return running


def end_group(pid: int) -> None:
    """End a process that leads a group of its own, and all that it started."""
    with suppress(OSError):
        os.killpg(pid, signal.SIGKILL)
    # It may not have come to lead one yet.
    with suppress(OSError):
        os.kill(pid, signal.SIGKILL)


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
