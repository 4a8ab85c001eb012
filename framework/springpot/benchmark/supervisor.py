"""The local engine: trials in supervised processes, which may crash, hang or run out of memory.

Each process is forked from a clean server for one optimiser and sees no trial of another. Quick
trials are sent in batches, which are believed as a whole or run again one by one: what went wrong
in one of them is then told of that one.
"""

from __future__ import annotations

import pickle
from collections import Counter, deque
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import count
from multiprocessing.connection import Connection, wait
from time import monotonic
from typing import Any, NamedTuple

from springpot.errors import StudyError
from springpot.processes import end_group

from .fork_server import BEGUN, BORN, BROKEN, ENDED, READY, ForkServer, Parcel
from .plan import Plan, WorkOrder
from .trial import Status, TrialResult, failure


class Patience(NamedTuple):
    """How long the engine waits, and how much it does at once."""

    start: float
    """Seconds that the server may take until it is ready; no trial's deadline runs before that.

    It takes about one: a hundred times as much is left for a cold disk and a busy machine.
    """
    imports: float
    """Seconds that an optimiser may take beside the deadline until it asks for its first value.

    In each new process: the largest libraries take three to import, and ten times as much is left
    for a cold disk and a busy machine.
    """
    ahead: float
    """Seconds of work in a batch.

    A worker has another in its pipe, so that it never waits for the coordinator, who needs
    milliseconds to keep one."""
    deepest: int
    """Most tasks in a batch: what a worker that dies gives back is done again by another."""
    newest: float
    """Weight of the newest trial in the mean time of an optimiser's.

    Early ones carry first-use costs that later ones do not, and a mean of all would keep them.
    """
    orphaned: int
    """Times that the server may end before what it did is given up.

    During a trial that runs alone, before that is blamed; between trials, before the study gives
    up. Once proves nothing: the trial before may have ended the server, and its result have come
    first.
    """
    idle: float
    """Seconds after its last task that the engine's processes are kept.

    A new server costs about a second.
    """
    answer: float
    """Seconds in which a scheduler must answer.

    A third of the time that dask itself would wait, in silence.
    """
    soon: float
    most: int
    """Seconds within which a batch that comes back was too small, and tasks in the largest: of
    trials of milliseconds an executor would else spend more on its own work than on theirs.
    """
    look: float
    """Seconds after which an executor is looked after where nothing has come.

    Soon enough for one who waits, and nothing
    beside the trials."""


ENGINE = Patience(
    start=120.0,
    imports=30.0,
    ahead=0.03,
    deepest=32,
    newest=0.2,
    orphaned=3,
    idle=60.0,
    answer=10.0,
    soon=0.5,
    most=256,
    look=1.0,
)


@dataclass(eq=False)
class Worker:
    """The coordinator's view of a worker process, which serves one entrant."""

    number: int
    entrant: int
    connection: Connection
    since: float = field(default_factory=monotonic)
    batches: deque[list[WorkOrder]] = field(default_factory=deque)
    deaf: bool = False
    begun: bool = False
    pid: int | None = None

    def give(self, batch: list[WorkOrder]) -> None:
        """Send tasks; the clock of the first batch starts now if the worker was idle."""
        if not self.batches:
            self.since = monotonic()
        self.batches.append(batch)
        with suppress(OSError):
            # That a worker is dead is told by the server, and its tasks are given to another.
            self.connection.send(batch)

    def begin(self) -> None:
        """Its optimiser has asked for its first value: the clock starts now."""
        self.begun, self.since = True, monotonic()


class Backlog:
    """Tasks that wait for a worker.

    Parameters
    ----------
    plan : Plan
        The study.
    tasks : iterable of WorkOrder
        Those of one optimiser after those of another, so that workers seldom change.
    """

    def __init__(self, plan: Plan, tasks: Iterable[WorkOrder] = ()) -> None:
        self._plan, self._stream = plan, iter(tasks)
        self._returned: deque[WorkOrder] = deque()
        self._head: WorkOrder | None = next(self._stream, None)

    def entrant_of(self, task: WorkOrder) -> int:
        """Whose trials they are."""
        return self._plan.cells[task.cell].entrant

    def first(self) -> WorkOrder | None:
        """The task that should be done next, which stays here."""
        if self._returned:
            return self._returned[0]
        return self._head

    def take(self, entrant: int) -> WorkOrder | None:
        """The next task of an entrant, if it stands in front."""
        task = self.first()
        if task is None or self.entrant_of(task) != entrant:
            return None
        if self._returned:
            return self._returned.popleft()
        self._head = next(self._stream, None)
        return task

    def put_back(self, tasks: Iterable[WorkOrder]) -> None:
        """Take tasks back that were not begun."""
        self._returned.extendleft(reversed(list(tasks)))


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
        self._backlog = Backlog(plan)
        self._workers: dict[int, Worker] = {}
        self._numbers = count(1)
        self._fork_server: ForkServer | None = None
        self._asked = 0.0
        self._orphaned: Counter[WorkOrder | None] = Counter()
        self._suspects: deque[WorkOrder] = deque()
        self._means: dict[int, float] = {}
        self._singly: set[int] = set()
        self._silent: set[int] = set()

    def run(self, tasks: Iterable[WorkOrder]) -> Iterator[list[TrialResult]]:
        """Results as they come, in no order; a worker that is lost is replaced.

        Raises
        ------
        StudyError
            If workers cannot start at all.
        """
        try:
            yield from self.work(tasks)
        finally:
            self.close()

    def work(self, tasks: Iterable[WorkOrder]) -> Iterator[list[TrialResult]]:
        """The same, with server and workers kept for more; `close` ends them."""
        self._backlog = Backlog(self._plan, tasks)
        while self._staff():
            if results := self._listen():
                yield results

    def close(self) -> None:
        """End all processes."""
        for worker in self._workers.values():
            worker.connection.close()
        self._workers.clear()
        if self._fork_server is not None:
            self._fork_server.close()
            self._fork_server = None

    def _staff(self) -> bool:
        """Give every worker enough to do, and hire where one is missing; False once all is done."""
        busy = any(worker.batches for worker in self._workers.values())
        if not (busy or self._suspects or self._backlog.first()):
            return False
        if self._fork_server is None:
            self._fork_server, self._asked = ForkServer(self._parcel), monotonic()
        # Workers are forked from it: before it has its imports there is nothing to fork.
        if not self._fork_server.ready:
            return True
        if self._suspects:
            self._interrogate(self._fork_server, busy)
            return True
        for worker in list(self._workers.values()):
            self._fill(worker)
        while len(self._workers) < self._count and (task := self._backlog.first()) is not None:
            self._fill(self._hire(self._fork_server, self._backlog.entrant_of(task)))
        return True

    def _interrogate(self, fork_server: ForkServer, busy: bool) -> None:
        """Run a task during which the server ended alone.

        So that nobody else is blamed for what it does.
        """
        if busy:
            return
        for worker in list(self._workers.values()):
            self._dismiss(worker)
        task = self._suspects.popleft()
        self._hire(fork_server, self._backlog.entrant_of(task)).give([task])

    def _hire(self, fork_server: ForkServer, entrant: int) -> Worker:
        # Never used twice: a late word of a worker that has ended must not be taken for another's.
        number = next(self._numbers)
        # One entrant for life: what an optimiser leaves in a process must not reach another's
        # trials.
        self._workers[number] = Worker(number, entrant, fork_server.fork(number))
        return self._workers[number]

    def _fill(self, worker: Worker) -> None:
        depth = self._depth(worker.entrant)
        # Where trials are quick there is something to do while the next batch is on its way.
        if len(worker.batches) > (depth > 1):
            return
        batch: list[WorkOrder] = []
        while len(batch) < depth and (task := self._backlog.take(worker.entrant)) is not None:
            batch.append(task)
        if batch:
            worker.give(batch)
        elif not worker.batches and self._backlog.first() is not None:
            self._dismiss(worker)  # the next task is another optimiser's

    def _depth(self, entrant: int) -> int:
        """Tasks in a batch of an entrant's."""
        mean = self._means.get(entrant, 0.0)
        if not mean or entrant in self._singly:
            return 1
        # Quick trials are handed out by many, or workers would wait for the next; slow ones singly,
        # or they could not be shared. A batch has the time of one.
        return int(
            min(max(min(ENGINE.ahead, 0.25 * self._plan.deadline) / mean, 1), ENGINE.deepest)
        )

    def _listen(self) -> list[TrialResult]:
        fork_server = self._fork_server
        assert fork_server is not None
        channels: dict[Any, Worker] = {
            w.connection: w for w in self._workers.values() if not w.deaf
        }
        heard = wait([fork_server.channel, *channels], timeout=self._patience())
        results: list[TrialResult] = []
        for worker in [channels[channel] for channel in heard if channel in channels]:
            results += self._hear(worker)
        if fork_server.channel in heard:
            results += self._hear_fork_server(fork_server)
        now = monotonic()
        # After all has been heard: an answer that came in time must not count as late.
        for worker in [
            w for w in self._workers.values() if w.batches and now - w.since > self._limit(w)
        ]:
            results += self._overdue(worker)
        if (
            self._fork_server is fork_server
            and not fork_server.ready
            and now - self._asked > ENGINE.start
        ):
            raise StudyError(
                f"study {self._plan.name}: workers were not ready after {ENGINE.start:g} s"
            )
        return results

    def _patience(self) -> float:
        """Seconds until the first deadline."""
        now = monotonic()
        # Nobody needs to look more often than the next deadline: answers wake the wait themselves.
        running = [w.since + self._limit(w) - now for w in self._workers.values() if w.batches]
        # A little later than the deadline, or it would be looked at just before.
        return max(0.0, min(running, default=1.0)) + 0.001

    def _limit(self, worker: Worker) -> float:
        limit = self._plan.runs_of(worker.batches[0][0]) * self._plan.deadline
        # Who hangs before the first value is waited for once, and not in each of its trials.
        if not worker.begun and worker.entrant not in self._silent:
            limit += ENGINE.imports
        return limit

    def _hear(self, worker: Worker) -> list[TrialResult]:
        """What a worker has answered so far."""
        results: list[TrialResult] = []
        try:
            while worker.number in self._workers and worker.connection.poll():
                message = worker.connection.recv_bytes()
                if message == BEGUN:
                    worker.begin()
                else:
                    results += self._take(worker, *pickle.loads(message))
        except (EOFError, OSError):
            # Its end, or that of its line only; either way the server ends it and tells how it
            # ended.
            worker.deaf = True
            if self._fork_server is not None:
                self._fork_server.kill(worker.number)
        except Exception as error:
            results += self._garbled(worker, error)
        return results

    def _take(self, worker: Worker, told: list[list[TrialResult]], worn: bool) -> list[TrialResult]:
        batch = worker.batches[0]
        results = [result for own in told for result in own]
        if worn and len(batch) > 1:
            self._repeat(worker)
            return []
        worker.batches.popleft()
        self._orphaned[None] = 0
        worker.begun = True
        now, mean = monotonic(), self._means.get(worker.entrant, 0.0)
        # The first one is all that is known.
        weight = 1.0
        if mean:
            weight = ENGINE.newest
        self._means[worker.entrant] = mean + ((now - worker.since) / len(batch) - mean) * weight
        worker.since = now
        if worn:
            self._dismiss(worker)
        return results

    def _failed(
        self, worker: Worker, status: Status, reason: str, seconds: float = 0.0
    ) -> list[TrialResult]:
        """The end of a worker by the trial that it was at."""
        if len(worker.batches[0]) > 1:
            self._repeat(worker)
            return []
        results = failure(worker.batches.popleft()[0], status, reason, seconds)
        self._dismiss(worker)
        return results

    def _repeat(self, worker: Worker) -> None:
        """Run a batch again, one by one as all that follow of its entrant."""
        # Nobody knows which of them it was; from the same seeds it shows itself.
        self._singly.add(worker.entrant)
        self._dismiss(worker)

    def _garbled(self, worker: Worker, error: Exception) -> list[TrialResult]:
        if worker.batches:
            name = type(error).__name__
            reason = f"its process answered with something that is no result ({name})"
            return self._failed(worker, Status.CRASH, reason)
        self._dismiss(worker)
        return []

    def _hear_fork_server(self, fork_server: ForkServer) -> list[TrialResult]:
        results: list[TrialResult] = []
        try:
            while fork_server.channel.poll():
                word, number, detail = fork_server.channel.recv()
                if word == BROKEN:
                    raise StudyError(f"study {self._plan.name}: a worker cannot start: {detail}")
                fork_server.ready |= word == READY
                if word == BORN and number in self._workers:
                    self._workers[number].pid = detail
                if word == ENDED and number in self._workers:
                    results += self._lost(self._workers[number], detail)
        except (EOFError, OSError):
            results += self._orphan(fork_server)
        return results

    def _lost(self, worker: Worker, cause: str) -> list[TrialResult]:
        """What remains of a worker that has ended.

        Answers in its line, then the trial that it died of.
        """
        results: list[TrialResult] = []
        if not worker.deaf:
            results = self._hear(worker)
        if worker.batches and worker.number in self._workers:
            results += self._failed(worker, Status.CRASH, cause, monotonic() - worker.since)
        self._dismiss(worker)
        return results

    def _orphan(self, fork_server: ForkServer) -> list[TrialResult]:
        """The server has ended: begin again, with the trials that were under way one at a time."""
        cause = fork_server.cause()
        if not fork_server.ready:
            raise StudyError(f"study {self._plan.name}: workers die at the start ({cause})")
        running = [worker for worker in self._workers.values() if worker.batches]
        under_way = [task for worker in running for task in worker.batches.popleft()]
        alone: WorkOrder | None = None
        if len(under_way) == 1:
            alone = under_way[0]
        # With several under way nobody knows whose trial ended the server: they are tried one at a
        # time first.
        self._orphaned[alone] += len(under_way) < 2
        if self._orphaned[None] >= ENGINE.orphaned:
            raise StudyError(
                f"study {self._plan.name}: the server of workers ends again and again ({cause})"
            )
        results: list[TrialResult] = []
        for task in under_way:
            if self._orphaned[task] >= ENGINE.orphaned:
                results += failure(task, Status.CRASH, f"it ends the server of workers ({cause})")
            else:
                self._suspects.append(task)
        for worker in self._workers.values():
            self._give_back(worker)
            # Workers outlive their server: nobody would end them after it.
            if worker.pid is not None:
                end_group(worker.pid)
        self.close()
        return results

    def _overdue(self, worker: Worker) -> list[TrialResult]:
        limit = self._limit(worker)
        reason = f"ended after the deadline of {limit:g} s"
        if not worker.begun:
            self._silent.add(worker.entrant)
            reason = f"ended after {limit:g} s, in which it asked for no value"
        return self._failed(worker, Status.TIMEOUT, reason, limit)

    def _dismiss(self, worker: Worker) -> None:
        if self._workers.pop(worker.number, None) is None:
            return
        self._give_back(worker)
        worker.connection.close()
        if self._fork_server is not None:
            self._fork_server.kill(worker.number)

    def _give_back(self, worker: Worker) -> None:
        """Let others do what it has not done."""
        self._backlog.put_back([task for batch in worker.batches for task in batch])
        worker.batches.clear()
