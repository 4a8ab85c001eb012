"""What foreign code may leave changed in the process around it, and how to put it back."""

from __future__ import annotations

import atexit
import locale
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np


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
