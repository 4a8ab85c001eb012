"""Runs a study: plans it, lets an engine work, keeps every result at once, writes the tables.

Progress of a run: a bar on a terminal, plain lines elsewhere.
"""

from __future__ import annotations

import os
import platform
import shlex
import sys
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import ExitStack, closing, contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from time import monotonic
from typing import Any, TextIO

from springpot.errors import below, plain
from springpot.registry import versions

from .archive import Archive, rivals_of
from .engine import check_engine, make_engine
from .plan import Plan
from .standings import write_tables
from .store import Store
from .study import Study
from .summary import load_study, store_path


class Progress:
    """Told how far a run is; says nothing."""

    def update(self, done: int, failed: int) -> None:
        """So many trials are kept, of which so many failed."""

    def close(self) -> None:
        """The run has ended."""


class ProgressLines(Progress):
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


class Bar(Progress):
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
            Progress as RichProgress,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

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
    return ProgressLines(name, total)


@dataclass(frozen=True)
class Outcome:
    """What a run of a study came to.

    Parameters
    ----------
    store : Path
        The SQLite file.
    trials : int
        Trials of the study.
    ran, failed : int
        Trials of this run, and those of them that failed.
    tables : tuple of Path
        Files written.
    """

    store: Path
    trials: int
    ran: int
    failed: int
    tables: tuple[Path, ...]


def run_study(
    study: Study | str | Path,
    workers: int | None = None,
    engine: str | Executor | None = None,
    budget: int | None = None,
    repeats: int | None = None,
    out: Path = Path("results"),
    quiet: bool = False,
    retry_failed: bool = False,
    tables: bool = True,
    beside: Path | None = None,
) -> Outcome:
    """Run what is missing of a study, then write its tables.

    Parameters
    ----------
    study : Study, str or Path
        A study or the path of its script.
    workers : int, optional
        Processes; by default one for each core.
    engine : str or Executor, optional
        ``local`` (default), ``serial``, ``dask:ADDRESS`` or an executor.
    budget, repeats : int, optional
        Instead of the study's own.
    out : Path
        Folder of all results.
    quiet : bool
        Show no progress.
    retry_failed : bool
        Run trials that failed before, or whose records are damaged, once more.
    tables : bool
        Write the tables and what the study adds to them.
    beside : Path, optional
        An archive whose trials stand in the tables too; told before the first trial if they cannot.

    Raises
    ------
    SpringpotError
        If the study, its store or its engine cannot be used.
    KeyboardInterrupt
        After Ctrl-C; finished trials are kept.
    """
    if isinstance(study, Study):
        script, declared = None, study
    else:
        script = Path(study)
        with _aside(quiet):
            declared = load_study(study)
    # Before the plan, which reads all data: a slip in the name of an engine is told at once.
    check_engine(engine)
    plan = declared.with_options(budget, repeats).plan()
    path = store_path(declared, Path(out))
    with Store(path, write=True, mend=retry_failed) as store:
        # Before the first trial, so that a run that is interrupted can be shown and resumed.
        numbers = store.register(plan, provenance(plan))
        if beside is not None:
            rivals_of(store, Archive.read(beside))
        if retry_failed:
            store.forget_failed(numbers.values())
        ran, failed = _work(plan, store, numbers, script, workers, engine, quiet)
    written: list[Path] = []
    if tables:
        written = write_tables(path, beside=beside)
        if declared.finish is not None:
            with _aside(quiet):
                declared.finish(path, path.parent)
    return Outcome(path, plan.size, ran, failed, tuple(written))


@contextmanager
def _aside(quiet: bool) -> Iterator[None]:
    """Let what a script prints go to standard error, or nowhere."""
    with ExitStack() as stack:
        stream = sys.stderr
        if quiet:
            stream = stack.enter_context(open(os.devnull, "w"))
        stack.enter_context(redirect_stdout(stream))
        stack.enter_context(redirect_stderr(stream))
        yield


def _work(
    plan: Plan,
    store: Store,
    numbers: dict[int, int],
    script: Path | None,
    workers: int | None,
    engine: str | Executor | None,
    quiet: bool,
) -> tuple[int, int]:
    """Numbers of trials that ran and of those that failed."""
    # A store may hold more repetitions than are asked for now: those beyond are no part of this
    # run.
    kept = 0
    for number in numbers.values():
        kept += sum(repetition < plan.repetitions for repetition in store.finished(number))
    progress = Progress()
    if not quiet:
        progress = make_progress(plan.name, plan.size)
    progress.update(kept, 0)
    if kept == plan.size:
        progress.close()
        return 0, 0
    ran = failed = 0
    tasks = plan.tasks(lambda cell: store.finished(numbers[cell.index]))
    try:
        with closing(make_engine(plan, script, workers, engine, quiet).run(tasks)) as stream:  # type: ignore[type-var]
            for results in stream:
                # At once: whatever ends this process next, what is done is kept.
                store.add(results, numbers)
                ran += len(results)
                failed += sum(result.status.failed for result in results)
                progress.update(min(kept + ran, plan.size), failed)
    except KeyboardInterrupt:
        _say_goodbye(progress, plan, kept + ran)
        raise
    progress.close()
    return ran, failed


def _say_goodbye(progress: Progress, plan: Plan, done: int) -> None:
    progress.close()
    line = (
        f"{plan.name}: interrupted; {min(done, plan.size)} of {plan.size} trials are kept, run"
        " again to go on"
    )
    print(line, file=sys.stderr)


def provenance(plan: Plan) -> dict[str, str]:
    """Versions, machine and command of this run."""
    facts = {
        "python": platform.python_version(),
        "machine": platform.platform(),
        "processor": platform.machine(),
    }
    facts |= versions(
        entrant.optimiser.card.distribution
        for entrant in plan.entrants
        if entrant.optimiser.card.distribution
    )
    # As a module, ``python -m springpot``, the program is a file of another name.
    facts["command"] = shlex.join(
        [Path(sys.argv[0]).name.replace("__main__.py", "springpot"), *sys.argv[1:]]
    )
    facts["started"] = datetime.now(UTC).isoformat(timespec="seconds")
    return facts
