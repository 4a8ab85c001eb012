"""The local engine: trials in supervised worker processes, of which any may crash, hang or run out of memory."""

from __future__ import annotations

import os
import signal
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.context import ForkServerContext
from multiprocessing.process import BaseProcess
from time import monotonic
from typing import Any

from springpot.errors import StudyError

from .plan import Plan, Task
from .trial import Status, TrialResult, failure
from .worker import BROKEN, READY, Parcel, serve

PRELOAD = ["scipy.optimize", "springpot.benchmark.warm"]
START = 120.0
"""Seconds that a worker may take until it is ready; no trial's deadline runs before that."""
AHEAD = 0.02
"""Seconds of work that wait in a worker's pipe, so that it never waits for the coordinator."""
DEEPEST = 32
"""Most tasks that wait there."""


@dataclass(eq=False)
class Worker:
    """The coordinator's view of a worker process."""

    process: BaseProcess
    connection: Connection
    ready: bool = False
    since: float = field(default_factory=monotonic)
    tasks: deque[Task] = field(default_factory=deque)

    def give(self, tasks: list[Task]) -> None:
        """Send tasks; the clock of the first starts now if the worker was idle."""
        if not self.tasks:
            self.since = monotonic()
        self.tasks.extend(tasks)
        with suppress(OSError):
            # A dead worker is noticed by its sentinel, and its tasks are given to another.
            self.connection.send(tasks)

    def kill(self) -> None:
        """End the worker and every process its trials left behind."""
        pid = self.process.pid
        if pid is not None:
            with suppress(OSError):
                os.killpg(pid, signal.SIGKILL)
            with suppress(OSError):
                os.kill(pid, signal.SIGKILL)
        self.process.join(1.0)
        self.connection.close()


class LocalEngine:
    """Runs tasks in worker processes of this machine.

    Parameters
    ----------
    plan : Plan
        The study, which sets deadline and memory.
    parcel : Parcel
        The same on its way to the workers.
    workers : int
        Number of processes.
    """

    def __init__(self, plan: Plan, parcel: Parcel, workers: int) -> None:
        self._plan, self._parcel, self._count = plan, parcel, workers
        self._context = _forkserver()
        self._workers: list[Worker] = []
        self._queue: Iterator[Task] = iter(())
        self._returned: deque[Task] = deque()
        self._exhausted = False
        self._mean = 0.0
        self._stillborn = 0

    def run(self, tasks: Iterable[Task]) -> Iterator[list[TrialResult]]:
        """Results as they come, in no order; a worker that is lost is replaced.

        Raises
        ------
        StudyError
            If workers cannot start at all.
        """
        self._queue = iter(tasks)
        try:
            while self._staff():
                if results := self._listen():
                    yield results
        finally:
            for worker in self._workers:
                worker.kill()
            self._workers.clear()

    def _next(self) -> Task | None:
        if self._returned:
            return self._returned.popleft()
        task = None if self._exhausted else next(self._queue, None)
        self._exhausted = task is None
        return task

    def _staff(self) -> bool:
        """Give every worker enough to do, and hire where one is missing; False once all is done."""
        depth = 1 if self._mean <= 0 else int(min(max(AHEAD / self._mean, 1), DEEPEST))
        for worker in self._workers:
            if worker.ready and len(worker.tasks) <= depth // 2:
                self._fill(worker, depth)
        while len(self._workers) < self._count and self._waiting():
            self._hire()
        return any(worker.tasks for worker in self._workers) or self._waiting()

    def _waiting(self) -> bool:
        task = self._next()
        if task is not None:
            self._returned.appendleft(task)
        return task is not None

    def _fill(self, worker: Worker, depth: int) -> None:
        found: list[Task] = []
        while len(worker.tasks) + len(found) < depth and (task := self._next()) is not None:
            found.append(task)
        if found:
            worker.give(found)

    def _hire(self) -> None:
        ours, theirs = self._context.Pipe()
        arguments = (theirs, self._parcel, self._plan.memory)
        process = self._context.Process(target=serve, args=arguments, daemon=True)
        process.start()
        theirs.close()
        self._workers.append(Worker(process, ours))

    def _listen(self) -> list[TrialResult]:
        channels: dict[Any, Worker] = {w.connection: w for w in self._workers}
        channels |= {w.process.sentinel: w for w in self._workers}
        heard = wait(list(channels), timeout=self._patience())
        results: list[TrialResult] = []
        for worker in dict.fromkeys(channels[channel] for channel in heard):
            results += self._hear(worker, dead=worker.process.sentinel in heard)
        now = monotonic()
        for worker in [w for w in self._workers if now - w.since > self._limit(w)]:
            results += self._overdue(worker)
        return results

    def _patience(self) -> float:
        """Seconds until the first deadline."""
        now = monotonic()
        running = [w.since + self._limit(w) - now for w in self._workers if w.tasks or not w.ready]
        return max(0.0, min(running, default=1.0)) + 0.001

    def _limit(self, worker: Worker) -> float:
        if not worker.ready:
            return START
        return self._plan.deadline * len(worker.tasks[0].repetitions) if worker.tasks else float("inf")

    def _hear(self, worker: Worker, dead: bool) -> list[TrialResult]:
        results: list[TrialResult] = []
        try:
            while worker in self._workers and worker.connection.poll():
                results += self._take(worker, *worker.connection.recv())
        except (EOFError, OSError):
            dead = True
        if dead and worker in self._workers:
            worker.process.join(1.0)
            results += self._lost(worker)
        return results

    def _take(self, worker: Worker, word: str, content: Any) -> list[TrialResult]:
        now = monotonic()
        if word == BROKEN:
            raise StudyError(f"study {self._plan.name}: a worker cannot start: {content}")
        if word == READY:
            worker.ready, worker.since, self._stillborn = True, now, 0
            return []
        results: list[TrialResult] = content
        worker.tasks.popleft()
        # A sliding mean: early trials carry first-use costs that later ones do not.
        self._mean += (now - worker.since - self._mean) * (0.2 if self._mean else 1.0)
        worker.since = now
        if any(result.status is Status.MEMORY for result in results):
            # What a trial could not free would be charged to the next one.
            self._dismiss(worker)
        return results

    def _lost(self, worker: Worker) -> list[TrialResult]:
        results: list[TrialResult] = []
        if not worker.ready:
            self._stillborn += 1
            if self._stillborn > 2 * self._count:
                raise StudyError(f"study {self._plan.name}: workers die at the start ({_cause(worker.process)})")
        elif worker.tasks:
            results = failure(
                worker.tasks.popleft(), Status.CRASH, _cause(worker.process), monotonic() - worker.since
            )
        self._dismiss(worker)
        return results

    def _overdue(self, worker: Worker) -> list[TrialResult]:
        if not worker.ready:
            raise StudyError(f"study {self._plan.name}: a worker was not ready after {START:g} s")
        limit = self._limit(worker)
        results = failure(worker.tasks.popleft(), Status.TIMEOUT, f"ended after the deadline of {limit:g} s", limit)
        self._dismiss(worker)
        return results

    def _dismiss(self, worker: Worker) -> None:
        self._returned.extendleft(reversed(worker.tasks))
        worker.tasks.clear()
        worker.kill()
        self._workers.remove(worker)


def _cause(process: BaseProcess) -> str:
    code = process.exitcode
    if code is None or code >= 0:
        return f"the process ended with exit code {code}"
    try:
        return f"the process was ended by {signal.Signals(-code).name}"
    except ValueError:
        return f"the process was ended by signal {-code}"


def _forkserver() -> ForkServerContext:
    """Processes forked from a server that has the imports done; one thread each, as workers share the cores."""
    context = get_context("forkserver")
    context.set_forkserver_preload(PRELOAD)
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    before = {name: os.environ.get(name) for name in names}
    os.environ.update(dict.fromkeys(names, "1"))
    try:
        from multiprocessing.forkserver import ensure_running

        ensure_running()
    finally:
        for name, value in before.items():
            os.environ.pop(name) if value is None else os.environ.update({name: value})
    return context
