"""What is told beside an answer: what is being done, and the command to go on with."""

from __future__ import annotations

import sys
from threading import Event, Lock, Thread
from time import monotonic
from types import TracebackType
from typing import Any

import click
from click.core import ParameterSource

from springpot import writing
from springpot.errors import below, plain

from .common import window

MEANING = (
    "geometry",
    "fix",
    "bounds",
    "tie",
    "exclude",
    "own",
    "share",
    "specimen",
    "population",
    "effects",
    "effect",
    "without",
    "along",
    "accuracy",
    "robust",
    "seed",
)
"""Options by which the same files give another answer; those of outputs are none."""


def suggested(verb: str, *words: object) -> str:
    """A command of springpot with the options of this one that it takes and that change its answer.

    Parameters
    ----------
    verb : str
        See `springpot.writing.suggested`.
    *words : object
        Data and options that follow from the answer.
    """
    return writing.suggested(verb, *words, *kept_by(verb))


def kept_by(verb: str) -> list[str]:
    """Options, with their values, that were given to this command and that another takes too."""
    context = click.get_current_context(silent=True)
    if context is None:
        return []
    group = context.find_root().command
    other = group.get_command(context, verb) if isinstance(group, click.Group) else None
    taken = {each.name for each in other.params} if other is not None else set()
    words: list[str] = []
    for option in context.command.params:
        name = option.name or ""
        given = context.get_parameter_source(name) is ParameterSource.COMMANDLINE
        if name in MEANING and name in taken and given:
            words += _words(option.opts[-1], context.params[name])
    return words


def _words(option: str, value: Any) -> list[str]:
    values = value if isinstance(value, (tuple, list)) else [value]
    return [word for each in values for word in (option, str(each))]


PATIENCE = 1.0
"""Seconds that nobody asks about."""


class Waiting:
    """Tells stages of a long answer.

    In place and with seconds on a terminal, else each kind of stage in a line.
    """

    def __init__(self) -> None:
        # A daemon, so that it never keeps a process alive that wants to end.
        self._thread = Thread(target=self._tick, daemon=True)
        self._lock, self._over = Lock(), Event()
        self._began, self._begun, self._stage, self._kind = monotonic(), False, "", ""

    def __enter__(self) -> Waiting:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._over.set()
        with self._lock:
            # Written over by blanks: the answer must not begin behind what is left of the last
            # stage.
            if self._begun and sys.stderr.isatty():
                print(f"\r{' ' * window()}\r", end="", file=below(sys.stderr), flush=True)
            self._begun = False
        # Where it still ran, an optimiser would not be protected in a process of its own.
        self._thread.join()

    def told(self, stage: str) -> None:
        """What is being done now."""
        with self._lock:
            self._stage = stage
            if self._begun:
                self._show()

    def _tick(self) -> None:
        """Show the stage once a second: on a terminal the seconds are a sign that work goes on."""
        while not self._over.wait(PATIENCE):
            with self._lock:
                if self._over.is_set():
                    return
                self._begun = True
                if self._stage:
                    self._show()

    def _show(self) -> None:
        if sys.stderr.isatty():
            line = plain(f"{self._stage}, {monotonic() - self._began:.0f} s")
            # Only this return is for the terminal; names in the stage come from strangers.
            # No longer than the window: what is broken cannot be written over.
            width = window()
            print(f"\r{line:{width}.{width}}", end="", file=below(sys.stderr), flush=True)
            return
        # One line for all the models that are fitted, not one for each.
        kind = self._stage.split()[0]
        if kind != self._kind:
            print(self._stage, file=sys.stderr, flush=True)
        self._kind = kind
