"""What a process that runs foreign code needs: limits, its surroundings, and how it ended."""

from __future__ import annotations

import atexit
import ctypes
import locale
import os
import resource
import signal
import sys
import threading
from collections.abc import Callable, Container, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from select import select
from time import monotonic
from typing import Any, NoReturn

import numpy as np

from springpot.limits import address_space


def _folder() -> str:
    try:
        return os.getcwd()
    # It may have been removed.
    except OSError:
        return ""


def _handler(number: int) -> tuple[Callable[[], Any], Callable[[Any], Any]]:
    return lambda: signal.getsignal(number), lambda was: signal.signal(number, was)


def _put_environment(was: dict[str, str]) -> None:
    for name in set(os.environ) - set(was):
        del os.environ[name]
    os.environ.update(was)


KEPT: dict[str, tuple[Callable[[], Any], Callable[[Any], Any]]] = {
    "the recursion limit": (sys.getrecursionlimit, sys.setrecursionlimit),
    "the working folder": (_folder, os.chdir),
    "where modules are looked for": (
        lambda: list(sys.path),
        lambda was: sys.path.__setitem__(slice(None), was),
    ),
    "the environment's variables": (lambda: dict(os.environ), _put_environment),
    "NumPy's way with errors": (np.geterr, lambda was: np.seterr(**was)),
    "the locale": (
        lambda: locale.setlocale(locale.LC_ALL),
        lambda was: locale.setlocale(locale.LC_ALL, was),
    ),
    "what is done with errors": (
        lambda: sys.excepthook,
        lambda was: setattr(sys, "excepthook", was),
    ),
    **{
        f"what is done at {name}": _handler(getattr(signal, name))
        for name in ("SIGINT", "SIGTERM", "SIGALRM")
        if hasattr(signal, name)
    },
}
"""What is told of each, how it is read and how it is set."""


def surroundings() -> tuple[Any, ...]:
    """The state of all of it, to be compared."""
    return tuple(read() for read, _ in KEPT.values())


@contextmanager
def kept_surroundings(tell: Callable[[str], None], owns: Callable[[str], bool]) -> Iterator[None]:
    """Put back what is changed meanwhile, and tell of it in a sentence.

    Parameters
    ----------
    tell : callable
        Given what was changed and undone; and what was left running, which cannot be.
    owns : callable
        Whether a module is that of the code: only its own functions are taken from those that run
        at the exit.
    """
    before, late, changed = surroundings(), list[Callable[..., Any]](), list[str]()
    running = set(threading.enumerate())
    register = atexit.register

    def noted(function: Callable[..., Any], *given: Any, **named: Any) -> Callable[..., Any]:
        late.append(function)
        return register(function, *given, **named)

    atexit.register = noted  # type: ignore[assignment]
    try:
        yield
    finally:
        atexit.register = register
        for (name, (_, put)), was, now in zip(KEPT.items(), before, surroundings(), strict=True):
            if was != now:
                # What cannot be put back, such as a folder that is gone, is told all the same.
                with suppress(Exception):
                    put(was)
                changed.append(name)
        own = [function for function in late if owns(str(getattr(function, "__module__", "")))]
        for function in own:
            atexit.unregister(function)
        if own:
            changed.append("what runs at the exit of the program")
        if changed:
            tell(f"it changes {', '.join(changed)}: that is undone")
        if left := [thread.name for thread in threading.enumerate() if thread not in running]:
            tell(f"it leaves a thread running ({', '.join(left)}), which nothing can end")


CHILDREN = Path("/proc/thread-self/children")
ADOPT = 36
"""PR_SET_CHILD_SUBREAPER of Linux's prctl(2)."""
LEAVING = 5.0
"""Seconds in which a process ends after it was told to, and its pipes close after it."""
TIMERS = (signal.ITIMER_REAL, signal.ITIMER_VIRTUAL, signal.ITIMER_PROF)


def limit_memory(mebibytes: int) -> None:
    """Let the address space grow by so much at most, where the system tells its present size."""
    had = address_space()
    if had is None:
        return
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    # On top of what is mapped now: libraries take three times as many addresses as memory, before
    # any trial.
    wanted = had + mebibytes * 2**20
    # A negative one says that there is no limit yet.
    if hard >= 0:
        wanted = min(wanted, hard)
    resource.setrlimit(resource.RLIMIT_AS, (wanted, hard))


def adopt_orphans() -> None:
    """Let descendants that lose their parent become children of this process.

    Where the system can do that.

    A process that leaves its group and its parent, as daemons do, would otherwise be found by
    nobody.
    """
    _ask(ADOPT, 1)


def end_with_parent(parent: int) -> None:
    """Let this process be killed when the one that forked it ends, even while it is stopped.

    Where the system can do that.

    Parameters
    ----------
    parent : int
        The number of that process, which may have ended already.
    """
    pdeathsig = 1  # PR_SET_PDEATHSIG of Linux's prctl(2)
    _ask(pdeathsig, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


def _ask(option: int, value: int) -> None:
    """Something of the system, by prctl(2)."""
    with suppress(OSError, AttributeError):
        # Python has no such call of its own.
        ctypes.CDLL(None).prctl(option, value, 0, 0, 0)


def children_of(listing: Path = CHILDREN) -> list[int]:
    """The child processes of this one, or those of another file of that kind.

    None where the system lists none.
    """
    try:
        return [int(pid) for pid in listing.read_text().split()]
    except OSError:
        return []


def end_children(known: Container[int] = ()) -> int:
    """End this process's children that still run, but for those known; how many there were."""
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
    # Listed before it ends: then its children have other parents, and nothing tells whose they
    # were.
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
    timers = tuple(signal.getitimer(timer) != (0.0, 0.0) for timer in TIMERS)
    return (threading.active_count(), timers, surroundings())


def cause_of(status: int) -> str:
    """How a process ended, from what `os.waitpid` says of it."""
    code = os.waitstatus_to_exitcode(status)
    if code >= 0:
        return f"the process ended with exit code {code}"
    try:
        return f"the process was ended by {signal.Signals(-code).name}"
    except ValueError:
        return f"the process was ended by signal {-code}"


@dataclass(frozen=True)
class Ended:
    """How a process ended that was a copy of this one.

    Parameters
    ----------
    message : bytes
        What it had sent by then.
    late : bool
        Whether it was ended because its time was over.
    cause : str
        How it ended.
    """

    message: bytes
    late: bool
    cause: str


def can_copy() -> bool:
    """Whether `elsewhere` is safe here."""
    # A copy holds this thread alone: a lock that another one held would stay locked in it for ever.
    return threading.active_count() == 1 and hasattr(os, "fork")


def elsewhere(
    action: Callable[[Callable[[bytes], object]], None], deadline: float, memory: int = 0
) -> Ended:
    """Let a copy of this process do something; whatever happens to it there ends with it.

    Parameters
    ----------
    action : callable
        What it does; it is given a function that sends bytes here.
    deadline : float
        Seconds that it may take.
    memory : int
        MiB by which it may grow; 0 sets no limit.
    """
    answer, report = os.pipe()
    lifeline, alive = os.pipe()
    sys.stdout.flush()  # or both would write what waits there
    # Ctrl-C reaches both: until each has come to where it ends in order, it waits.
    had = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        # A copy and no fresh process: all that is needed is there without being sent.
        pid = os.fork()
    except OSError:
        signal.pthread_sigmask(signal.SIG_SETMASK, had)
        raise
    if pid == 0:
        os.close(answer)
        os.close(alive)
        _work(action, memory, report, lifeline)
    message: list[bytes] = []
    try:
        os.close(report)
        os.close(lifeline)
        signal.pthread_sigmask(signal.SIG_SETMASK, had)
        late = not _heard(answer, monotonic() + deadline, message)
    finally:
        end_group(pid)
        status = os.waitpid(pid, 0)[1]
        os.close(answer)
        os.close(alive)
    return Ended(b"".join(message), late, cause_of(status))


def _heard(fd: int, end: float, parts: list[bytes]) -> bool:
    """Put all that is written into `parts` until the other side closes; whether it does in time."""
    while select([fd], [], [], max(0.0, end - monotonic()))[0]:
        part = os.read(fd, 1 << 16)
        if not part:
            return True
        parts.append(part)
    return False


def _work(
    action: Callable[[Callable[[bytes], object]], None], memory: int, report: int, lifeline: int
) -> NoReturn:
    """In the copy: act, and send what there is to say."""
    code = 1
    try:
        # A group of its own: whatever is started can be ended with it, and Ctrl-C does not reach
        # it.
        os.setsid()
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        adopt_orphans()
        # What it prints is no part of the command's own output, and what is typed or piped is not
        # for it.
        os.dup2(2, 1)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        if memory:
            limit_memory(memory)
        # If the process that waits is killed, nobody else would end this one.
        threading.Thread(target=_die_with_parent, args=(lifeline,), daemon=True).start()
        # It closes with the process: were it closed before, the one that waits would end this one
        # in the middle of its own end, and tell of a signal.
        with os.fdopen(report, "wb", buffering=0, closefd=False) as stream:
            action(stream.write)
        end_children()
        sys.stdout.flush()
        code = 0
    finally:
        # Without the parent's own farewell: its open files and its exit handlers are not this
        # copy's.
        os._exit(code)


def _die_with_parent(lifeline: int) -> None:
    os.read(lifeline, 1)
    os.killpg(0, 9)
