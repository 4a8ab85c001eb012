"""Engines: where trials run. Each turns tasks into an unordered stream of results.

A task on an executor's worker is run there by a local engine of one process, so that what a trial
does ends there.
"""

from __future__ import annotations

import logging
import os
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from contextlib import ExitStack, redirect_stderr, redirect_stdout, suppress
from importlib import import_module
from itertools import islice
from pathlib import Path
from time import monotonic
from typing import Any, NamedTuple, Protocol

from springpot.errors import SpringpotError, StudyError

from .fork_server import Parcel
from .plan import Plan, WorkOrder
from .supervisor import LocalEngine
from .trial import Status, TrialResult, Workshop, failure

IDLE = 60.0
"""Seconds after its last task that the engine's processes are kept.

A new server costs about a second.
"""


class _Keeper:
    """The engine of one thread; it is closed when another study comes, or none for a while."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._parcel: Parcel | None = None
        self._engine: LocalEngine | None = None
        self._rest = threading.Timer(IDLE, self.close)

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
                self._rest = threading.Timer(IDLE, self.close)
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


ANSWER = 10.0
"""Seconds in which a scheduler must answer.

A third of the time that dask itself would wait, in silence.
"""
SOON, MOST = 0.5, 256
"""Seconds within which a batch that comes back was too small, and tasks in the largest: of trials
of milliseconds an executor would else spend more on its own work than on theirs."""
LOOK = 1.0
"""Seconds after which an executor is looked after where nothing has come.

Soon enough for one who waits, and nothing
beside the trials."""


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
                done = wait(busy, timeout=LOOK, return_when=FIRST_COMPLETED).done
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
        if seconds < SOON and tasks == self._batch:
            self._batch = min(2 * self._batch, MOST)
        elif seconds > 4 * SOON:
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
        client = distributed.Client(address, timeout=ANSWER)
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
            client.close(timeout=ANSWER)

    executor = client.get_executor(pure=False)
    return ExecutorEngine(executor, future, 2 * max(1, threads), close=close, complaint=complaint)
