"""Progress of a run: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
from time import monotonic
from typing import Any, Protocol, TextIO

from springpot.terminal_safe import below, plain


class Progress(Protocol):
    """Told how far a run is."""

    def update(self, done: int, failed: int) -> None:
        """So many trials are kept, of which so many failed."""
        ...

    def close(self) -> None:
        """The run has ended."""
        ...


class Silent:
    """Says nothing."""

    def update(self, done: int, failed: int) -> None:
        """Nothing."""

    def close(self) -> None:
        """Nothing."""


class Lines:
    """A line at every tenth of the way, or every ten seconds, whichever is rarer.

    Parameters
    ----------
    name : str
        The study.
    total : int
        Trials of the study.
    stream : TextIO, optional
        Where lines go, by default standard error.
    """

    def __init__(self, name: str, total: int, stream: TextIO | None = None) -> None:
        self._name, self._total, self._stream = name, total, stream or sys.stderr
        self._start = self._last = monotonic()
        self._state = (0, 0)
        self._told: tuple[int, int] | None = None

    def update(self, done: int, failed: int) -> None:
        """Print if it is time to."""
        self._state = (done, failed)
        # Both: a quick study would fill a log with lines, and a slow one with the same line.
        step = self._told is None or (done - self._told[0]) * 10 >= self._total
        if self._told is None or (step and monotonic() - self._last >= 10.0):
            self._print()

    def close(self) -> None:
        """Print the last state."""
        if self._told != self._state:
            self._print()

    def _print(self) -> None:
        done, failed = self._told = self._state
        self._last = monotonic()
        trials = f"{done} of {self._total} trials"
        if failed:
            trials += f", {failed} failed"
        line = f"{self._name}: {trials}, {self._last - self._start:.0f} s"
        print(line, file=self._stream, flush=True)


class Bar:
    """A bar that is drawn in place.

    Parameters
    ----------
    name : str
        The study.
    total : int
        Trials of the study.
    """

    def __init__(self, name: str, total: int) -> None:
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )
        from rich.progress import Progress as RichProgress

        parts = (
            TextColumn("{task.description}", markup=False),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[fault]}"),
            TimeElapsedColumn(),
            TimeRemainingColumn(),
        )
        console = Console(file=below(sys.stderr), stderr=True)
        self._bar: Any = RichProgress(*parts, console=console)
        self._task = self._bar.add_task(plain(name), total=total, fault="")
        self._bar.start()

    def update(self, done: int, failed: int) -> None:
        """Move the bar."""
        fault = ""
        if failed:
            fault = f"{failed} failed"
        self._bar.update(self._task, completed=done, fault=fault)

    def close(self) -> None:
        """Leave the bar as it is."""
        self._bar.stop()


def make_progress(name: str, total: int) -> Progress:
    """A bar where standard error is a terminal, lines elsewhere."""
    if sys.stderr.isatty():
        return Bar(name, total)
    return Lines(name, total)
