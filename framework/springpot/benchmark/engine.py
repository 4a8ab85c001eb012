"""Engines: where trials run. Each turns an iterable of tasks into a stream of results in no order."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Any, Protocol

from springpot.errors import StudyError

from .plan import Plan, Task
from .trial import Status, TrialResult, Workshop, failure
from .worker import Parcel, run_tasks

ANSWER = 10.0
"""Seconds in which a scheduler must answer."""


class Engine(Protocol):
    """Runs tasks and gives their results as they come."""

    def run(self, tasks: Iterable[Task]) -> Iterator[list[TrialResult]]:
        """Results in no order."""
        ...


class SerialEngine:
    """Runs tasks one by one in this process, without protection: for tests and debugging."""

    def __init__(self, plan: Plan) -> None:
        self._shop = Workshop(plan)

    def run(self, tasks: Iterable[Task]) -> Iterator[list[TrialResult]]:
        """Results in the order of the tasks."""
        for task in tasks:
            yield self._shop.run(task)


class ExecutorEngine:
    """Runs tasks on anything shaped like `concurrent.futures.Executor`.

    Parameters
    ----------
    executor : Executor
        Its workers must be able to import springpot.
    parcel : object
        The study's `Parcel`, or what the executor turns into it on a worker (a scattered future).
    width : int
        Batches under way at once.
    batch : int
        Tasks in each.
    close : callable, optional
        Called at the end of a run.
    """

    def __init__(
        self, executor: Executor, parcel: Any, width: int, batch: int = 4, close: Callable[[], None] | None = None
    ) -> None:
        self._executor, self._parcel, self._width, self._batch = executor, parcel, width, batch
        self._close = close

    def run(self, tasks: Iterable[Task]) -> Iterator[list[TrialResult]]:
        """Results in no order; a batch whose worker dies is tried once more, task by task.

        Raises
        ------
        StudyError
            If the executor itself is broken.
        """
        queue = iter(tasks)
        busy: dict[Future[list[TrialResult]], list[Task]] = {}
        try:
            while True:
                while len(busy) < self._width and (batch := list(islice(queue, self._batch))):
                    self._submit(busy, batch)
                if not busy:
                    return
                for future in wait(busy, return_when=FIRST_COMPLETED).done:
                    yield from self._collect(busy, future)
        finally:
            for future in busy:
                future.cancel()
            if self._close is not None:
                self._close()

    def _submit(self, busy: dict[Future[list[TrialResult]], list[Task]], batch: list[Task]) -> None:
        try:
            busy[self._executor.submit(run_tasks, self._parcel, batch)] = batch
        except (BrokenExecutor, RuntimeError) as error:
            raise StudyError(f"the executor takes no more work: {error}") from error

    def _collect(
        self, busy: dict[Future[list[TrialResult]], list[Task]], future: Future[list[TrialResult]]
    ) -> Iterator[list[TrialResult]]:
        batch = busy.pop(future)
        error = future.exception()
        if error is None:
            yield future.result()
        elif isinstance(error, BrokenExecutor):
            raise StudyError(f"the executor is broken: {error}")
        elif len(batch) > 1:
            for task in batch:
                self._submit(busy, [task])
        else:
            yield failure(batch[0], Status.CRASH, f"{type(error).__name__}: {error}")


def check_engine(engine: str | Executor | None) -> None:
    """Refuse what is no engine, before any work and even where none is left.

    Raises
    ------
    StudyError
        If there is no such engine.
    """
    named = engine in (None, "local", "serial") or (isinstance(engine, str) and engine.startswith("dask:"))
    if not named and (isinstance(engine, str) or not hasattr(engine, "submit")):
        raise StudyError(f"unknown engine '{engine}': use local, serial, dask:ADDRESS or an executor")


def make_engine(plan: Plan, script: Path | None, workers: int | None, engine: str | Executor | None) -> Engine:
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

    Raises
    ------
    StudyError
        If there is no such engine or its library is missing.
    """
    check_engine(engine)
    width = workers or cores()
    if engine is None or engine == "local":
        from .supervisor import LocalEngine

        return LocalEngine(plan, Parcel.of(plan, script), width)
    if engine == "serial":
        return SerialEngine(plan)
    if isinstance(engine, str):
        return _dask(engine.removeprefix("dask:"), Parcel.of(plan, script))
    return ExecutorEngine(engine, Parcel.of(plan, script), 2 * width)


def cores() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _dask(address: str, parcel: Parcel) -> Engine:
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise StudyError(f"engine dask:{address} needs dask: pip install distributed") from None
    try:
        client = distributed.Client(address, timeout=ANSWER)
    except (OSError, ValueError, TimeoutError) as error:
        raise StudyError(f"no dask scheduler answers at {address}: {error}") from None
    threads = sum(client.nthreads().values())
    # Scattered once: every batch then carries a key instead of the data.
    future = client.scatter(parcel, broadcast=True)
    return ExecutorEngine(client.get_executor(pure=False), future, 2 * max(1, threads), close=client.close)
