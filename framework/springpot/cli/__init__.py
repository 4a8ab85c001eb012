"""The command line ``springpot``: each command is a small module, loaded when it is called."""

from __future__ import annotations

import gc
import os
import signal
import sys
from collections.abc import Sequence
from types import FrameType
from typing import NoReturn


class CtrlC:
    """The handler of Ctrl-C, which remembers that it was pressed.

    A library that is just being imported may turn the interruption into an error of its own (numpy
    into an `ImportError`, a half-made module into an `AttributeError`): whoever sees that error
    asks here for its cause.
    """

    def __init__(self) -> None:
        self.pressed = False

    def __call__(self, number: int, frame: FrameType | None) -> NoReturn:
        """Interrupt what runs."""
        self.pressed = True
        raise KeyboardInterrupt


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line and leave with its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        By default those of this process.
    """
    # The matrices of a fit are small: threads only wait for one another, a factor of twenty on a
    # busy machine.
    for library in ("OPENBLAS", "MKL", "OMP"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    # Modules and arrays are no rubbish: to look for it at each 700th object takes an eighth of a
    # short command.
    gc.set_threshold(50_000)
    _open_streams()
    # Before anything is imported: it is imports that Ctrl-C meets in the first second.
    ctrl_c = CtrlC()
    signal.signal(signal.SIGINT, ctrl_c)
    try:
        from springpot.limits import own_process

        from .group import exit_code, run
    except BaseException:
        if not ctrl_c.pressed:
            raise
        _leave(130)
    if arguments is None:
        arguments = sys.argv[1:]
    given = list(arguments)
    with own_process():
        code = exit_code(lambda: run(given))
    _leave(code)


def _leave(code: int) -> NoReturn:
    # Where Ctrl-C came while a string was run, of which dataclasses are made, CPython remembers it
    # as unhandled and ends by the signal instead of with this code; the next string that is run
    # makes it forget.
    exec("")
    sys.exit(code)


def _open_streams() -> None:
    """Let what a service has started with closed streams read nothing, and write to nowhere."""
    for fd, (name, mode) in enumerate((("stdin", "r"), ("stdout", "w"), ("stderr", "w"))):
        if getattr(sys, name) is not None:
            continue
        # Else the next file that is opened would get the number, and whatever is printed would be
        # written into it.
        nowhere = os.open(os.devnull, os.O_RDWR)
        if nowhere != fd:
            os.dup2(nowhere, fd)
            os.close(nowhere)
        setattr(sys, name, os.fdopen(fd, mode, closefd=False))
