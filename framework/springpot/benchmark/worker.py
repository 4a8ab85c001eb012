"""A worker process: gets the plan once, then runs the tasks it is sent and answers each."""

from __future__ import annotations

import os
import pickle
import resource
import signal
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from multiprocessing import parent_process
from multiprocessing.connection import Connection, wait
from pathlib import Path

from springpot.errors import SpringpotError, StudyError

from .plan import Plan, Task
from .script import load_script
from .trial import Status, TrialResult, Workshop, failure

READY, DONE, BROKEN = "ready", "done", "broken"
CHILDREN = Path("/proc/thread-self/children")


@dataclass(frozen=True)
class Parcel:
    """A plan on its way to a worker.

    Parameters
    ----------
    script : str
        The user's script, which the worker loads first so that optimisers defined in it are found; or empty.
    plan : bytes
        The pickled plan; it only ever travels between the processes of one study.
    """

    script: str
    plan: bytes

    @classmethod
    def of(cls, plan: Plan, script: Path | None) -> Parcel:
        """A parcel of `plan`.

        Raises
        ------
        StudyError
            If something in it is defined where no worker can import it.
        """
        try:
            return cls(str(script.resolve()) if script else "", pickle.dumps(plan))
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            raise StudyError(
                f"study {plan.name} cannot be sent to workers, define its parts in a file: {error}"
            ) from None

    def open(self) -> Workshop:
        """The workshop in which the plan's trials run."""
        if self.script:
            load_script(Path(self.script))
        plan: Plan = pickle.loads(self.plan)
        return Workshop(plan)


@lru_cache(maxsize=2)
def workshop(parcel: Parcel) -> Workshop:
    """The parcel's workshop, opened once in each process."""
    return parcel.open()


def run_tasks(parcel: Parcel, tasks: list[Task]) -> list[TrialResult]:
    """Run tasks anywhere: what an executor's workers are given."""
    shop = workshop(parcel)
    return [result for task in tasks for result in shop.run(task)]


def serve(connection: Connection, parcel: Parcel, memory: int) -> None:
    """Life of a local worker.

    Parameters
    ----------
    connection : Connection
        To the coordinator; its end is the worker's end.
    parcel : Parcel
        The study.
    memory : int
        MiB that a trial may take beyond what the worker has at the start.
    """
    # A group of its own: Ctrl-C reaches only the coordinator, which ends the group with all that a trial started.
    os.setsid()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_die_with_parent, daemon=True).start()
    try:
        shop = parcel.open()
    except (Exception, SystemExit) as error:
        told = str(error) if isinstance(error, SpringpotError) else f"{type(error).__name__}: {error}"
        connection.send((BROKEN, told))
        return
    _limit_memory(memory)
    connection.send((READY, None))
    _obey(connection, shop.run)


def _obey(connection: Connection, work: Callable[[Task], list[TrialResult]]) -> None:
    while True:
        try:
            tasks: list[Task] = connection.recv()
        except (EOFError, OSError):
            return
        for task in tasks:
            results = work(task)
            left = end_children()
            if left:
                results = failure(task, Status.ERROR, f"left {left} process{'es' if left > 1 else ''} behind")
            connection.send((DONE, results))


def end_children() -> int:
    """End the child processes of this one that still run, where the system lists them; how many there were."""
    try:
        children = [int(pid) for pid in CHILDREN.read_text().split()]
    except OSError:
        return 0
    running = 0
    for pid in children:
        with suppress(OSError):
            if os.waitpid(pid, os.WNOHANG)[0] == 0:
                running += 1
                os.kill(pid, signal.SIGKILL)
                os.waitpid(pid, 0)
    return running


def _die_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os.killpg(0, signal.SIGKILL)


def _limit_memory(mebibytes: int) -> None:
    """Let the address space grow by so much and no more, where the system tells its present size."""
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[0])
    except OSError:
        return
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    wanted = pages * resource.getpagesize() + mebibytes * 2**20
    resource.setrlimit(resource.RLIMIT_AS, (wanted if hard < 0 else min(wanted, hard), hard))
