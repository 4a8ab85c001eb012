"""Runs a study: plans it, lets an engine work, keeps every result at once, writes the tables.

An engine turns tasks into an unordered stream of results. A task on an executor's worker is run
there by a local engine of one process, so that what a trial does ends there. Progress of a run: a
bar on a terminal, plain lines elsewhere.
"""

from __future__ import annotations

import logging
import os
import platform
import shlex
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from contextlib import (
    ExitStack,
    closing,
    contextmanager,
    redirect_stderr,
    redirect_stdout,
    suppress,
)
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib import import_module
from itertools import islice
from pathlib import Path
from time import monotonic
from typing import Any, NamedTuple, Protocol, TextIO

from springpot.benchmark.supervisor import ENGINE
from springpot.errors import SpringpotError, StudyError, below, plain
from springpot.registry import versions

from .archive import Archive, rivals_of
from .fork_server import Parcel
from .plan import Plan, WorkOrder
from .standings import write_tables
from .store import Store
from .study import Study
from .summary import load_study, store_path
from .supervisor import LocalEngine
from .trial import Status, TrialResult, Workshop, failure


class _Keeper:
    """The engine of one thread; it is closed when another study comes, or none for a while."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._parcel: Parcel | None = None
        self._engine: LocalEngine | None = None
        self._rest = threading.Timer(ENGINE.idle, self.close)

    def run(self, parcel: Parcel, tasks: list[WorkOrder]) -> list[TrialResult]:
        """The results of tasks."""
        with self._lock:
            self._rest.cancel()
            # The next tasks are nearly always of the same study.
            if self._engine is None or parcel != self._parcel:
                self._end()
                self._parcel, self._engine = parcel, LocalEngine(parcel.unpacked(), parcel, 1)
            try:
                return [result for results in self._engine.work(tasks) for result in results]
            except BaseException:
                # Half-done work would be mistaken for that of the next tasks.
                self._end()
                raise
            finally:
                self._rest = threading.Timer(ENGINE.idle, self.close)
                self._rest.daemon = True
                self._rest.start()

    def close(self) -> None:
        """End its processes."""
        with self._lock:
            self._end()

    def _end(self) -> None:
        if self._engine is not None:
            self._engine.close()
        self._engine = None


class _Here(threading.local):
    """What belongs to this thread: a worker of a cluster may run tasks in several at once."""

    def __init__(self) -> None:
        self.keeper = _Keeper()


_here = _Here()


def run_tasks(parcel: Parcel, tasks: list[WorkOrder]) -> list[TrialResult]:
    """Run tasks anywhere: what an executor's workers are given."""
    return _here.keeper.run(parcel, tasks)


class Engine(Protocol):
    """Runs tasks and gives their results as they come."""

    def run(self, tasks: Iterable[WorkOrder]) -> Iterator[list[TrialResult]]:
        """Results in no order."""


class SerialEngine:
    """Runs tasks one by one in this process, without protection: for tests and debugging.

    Parameters
    ----------
    plan : Plan
        The study.
    quiet : bool
        Drop what optimisers print; otherwise it goes to standard error.
    """

    def __init__(self, plan: Plan, quiet: bool = False) -> None:
        self._shop, self._quiet = Workshop(plan), quiet

    def run(self, tasks: Iterable[WorkOrder]) -> Iterator[list[TrialResult]]:
        """Results in the order of the tasks."""
        for task in tasks:
            with ExitStack() as stack:
                aside = sys.stderr
                if self._quiet:
                    aside = stack.enter_context(open(os.devnull, "w"))
                stack.enter_context(redirect_stdout(aside))
                stack.enter_context(redirect_stderr(aside))
                self._shop.warm_up(task)
                results = self._shop.run([task])[0]
            yield results


class Batch(NamedTuple):
    """Tasks that are out, and when they were given."""

    tasks: list[WorkOrder]
    began: float


class ExecutorEngine:
    """Runs tasks on anything shaped like `concurrent.futures.Executor`.

    Each of its workers runs them in supervised processes of its own, so that what a trial does
    harms nobody there.

    Parameters
    ----------
    executor : Executor
        Its workers must be able to import springpot.
    parcel : object
        The study's `Parcel`, or what the executor turns into it on a worker (a scattered future).
    width : int
        Batches under way at once.
    batch : int
        Tasks in the first ones; they double while they come back soon, and halve when they do not.
    close : callable, optional
        Called at the end of a run.
    complaint : callable, optional
        Asked every second: why nothing more can be expected of the executor, or nothing.
    """

    def __init__(
        self,
        executor: Executor,
        parcel: Any,
        width: int,
        batch: int = 4,
        close: Callable[[], None] | None = None,
        complaint: Callable[[], str] = str,
    ) -> None:
        self._executor, self._parcel, self._width, self._batch = executor, parcel, width, batch
        self._least = batch
        self._close, self._complaint = close, complaint

    def run(self, tasks: Iterable[WorkOrder]) -> Iterator[list[TrialResult]]:
        """Results in no order; a batch whose worker dies is tried once more, task by task.

        Raises
        ------
        StudyError
            If the executor itself is broken.
        """
        queue = iter(tasks)
        busy: dict[Future[list[TrialResult]], Batch] = {}
        try:
            while True:
                # Not all at once: a study of a million trials would fill the scheduler's memory.
                while len(busy) < self._width and (batch := list(islice(queue, self._batch))):
                    self._submit(busy, batch)
                if not busy:
                    return
                done = wait(busy, timeout=ENGINE.look, return_when=FIRST_COMPLETED).done
                if lost := self._complaint():
                    raise StudyError(f"{lost}; finished trials are kept, run again to go on")
                for future in done:
                    yield from self._collect(busy, future)
        finally:
            for future in busy:
                # Nobody waits for these any more.
                future.cancel()
            if self._close is not None:
                self._close()

    def _submit(self, busy: dict[Future[list[TrialResult]], Batch], batch: list[WorkOrder]) -> None:
        try:
            future = self._executor.submit(run_tasks, self._parcel, batch)
            busy[future] = Batch(batch, monotonic())
        except (BrokenExecutor, RuntimeError) as error:
            raise StudyError(f"the executor takes no more work: {error}") from error

    def _collect(
        self,
        busy: dict[Future[list[TrialResult]], Batch],
        future: Future[list[TrialResult]],
    ) -> Iterator[list[TrialResult]]:
        batch, began = busy.pop(future)
        if future.cancelled():
            raise StudyError(
                "the executor has cancelled its work; finished trials are kept, run again to go on"
            )
        error = future.exception()
        if error is None:
            self._sized(len(batch), monotonic() - began)
            yield future.result()
        elif isinstance(error, SpringpotError):
            raise error
        elif isinstance(error, BrokenExecutor):
            raise StudyError(f"the executor is broken: {error}")
        # Singly: then only the trial that its worker dies of is told as failed.
        elif len(batch) > 1:
            for task in batch:
                self._submit(busy, [task])
        else:
            yield failure(batch[0], Status.CRASH, f"{type(error).__name__}: {error}")

    def _sized(self, tasks: int, seconds: float) -> None:
        """Fit the next batches to what one of so many tasks took."""
        if seconds < ENGINE.soon and tasks == self._batch:
            self._batch = min(2 * self._batch, ENGINE.most)
        elif seconds > 4 * ENGINE.soon:
            self._batch = max(self._batch // 2, self._least)


def check_engine(engine: str | Executor | None) -> None:
    """Refuse what is no engine, before any work and even where none is left.

    Raises
    ------
    StudyError
        If there is no such engine.
    """
    named = engine in (None, "local", "serial") or (
        isinstance(engine, str) and engine.startswith("dask:")
    )
    if not named and (isinstance(engine, str) or not hasattr(engine, "submit")):
        raise StudyError(
            f"unknown engine '{engine}': use local, serial, dask:ADDRESS or an executor"
        )


def make_engine(
    plan: Plan,
    script: Path | None,
    workers: int | None,
    engine: str | Executor | None,
    quiet: bool = False,
) -> Engine:
    """The engine that a user asked for.

    Parameters
    ----------
    plan : Plan
        The study.
    script : Path, optional
        Script that workers load first.
    workers : int, optional
        Processes; by default one for each core.
    engine : str or Executor, optional
        ``local`` (default), ``serial``, ``dask:ADDRESS`` or an executor.
    quiet : bool
        Drop what optimisers print; otherwise it goes to standard error.

    Raises
    ------
    StudyError
        If there is no such engine or its library is missing.
    """
    check_engine(engine)
    width = workers or cores()
    if engine is None or engine == "local":
        return LocalEngine(plan, Parcel.of(plan, script, quiet), width)
    if engine == "serial":
        return SerialEngine(plan, quiet)
    if isinstance(engine, str):
        # What runs on a cluster's worker is the cluster's own program.
        return _dask(
            engine.removeprefix("dask:"), Parcel.of(plan, script, quiet, own_program=False)
        )
    # Twice as many batches as workers: the next is there when a worker has done the last.
    return ExecutorEngine(engine, Parcel.of(plan, script, quiet), 2 * width)


def cores() -> int:
    """Processors that this process may use."""
    # A job or container may be given fewer processors than the machine has.
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _dask(address: str, parcel: Parcel) -> Engine:
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise StudyError(
            f"engine dask:{address} needs dask: pip install 'springpot[cluster]'"
        ) from None
    # What it logs of a scheduler that is gone fills a screen; we tell it in one line.
    for name in ("distributed", "distributed.client", "tornado", "tornado.application"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        client = distributed.Client(address, timeout=ENGINE.answer)
        threads = sum(client.nthreads().values())
        # Scattered once: every batch then carries a key instead of the data.
        future = client.scatter(parcel, broadcast=True)
    except (OSError, ValueError, TimeoutError) as error:
        raise StudyError(f"no dask scheduler answers at {address}: {error}") from None

    def complaint() -> str:
        if client.status == "running":
            return ""
        return f"the dask scheduler at {address} is gone"

    def close() -> None:
        with suppress(Exception):  # a scheduler that is gone cannot be told goodbye
            client.close(timeout=ENGINE.answer)

    executor = client.get_executor(pure=False)
    return ExecutorEngine(executor, future, 2 * max(1, threads), close=close, complaint=complaint)


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
