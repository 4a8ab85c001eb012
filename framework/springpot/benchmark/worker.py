"""A worker process: forked for one optimiser, it runs the tasks it is sent and answers each."""

from __future__ import annotations

import os
import pickle
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path

from springpot.errors import StudyError
from springpot.processes import end_children, limit_memory, settings, unpacked

from .plan import Plan, Task
from .script import load_script
from .trial import Status, TrialResult, Workshop, failure


@dataclass(frozen=True)
class Parcel:
    """A plan on its way to a worker.

    Parameters
    ----------
    script : str
        The user's script, which the worker loads first so that optimisers defined in it are found;
        or empty.
    plan : bytes
        The pickled plan; it only ever travels between the processes of one study.
    quiet : bool
        Drop what optimisers print; otherwise it goes to standard error.
    own_program : bool
        Let workers find what the running program itself defines; not where that is an executor's.
    """

    script: str
    plan: bytes
    quiet: bool = False
    own_program: bool = True

    @classmethod
    def of(
        cls, plan: Plan, script: Path | None, quiet: bool = False, own_program: bool = True
    ) -> Parcel:
        """A parcel of `plan`.

        Raises
        ------
        StudyError
            If something in it is defined where no worker can import it.
        """
        try:
            packed = pickle.dumps(plan)
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            raise StudyError(
                f"study {plan.name} cannot be sent to workers, define its parts in a file: {error}"
            ) from None
        path = ""
        if script is not None:
            # In full: a worker may be in another folder.
            path = os.path.realpath(script)
        return cls(path, packed, quiet, own_program)

    def unpacked(self) -> Plan:
        """The plan, with the script loaded that defines parts of it."""
        if self.script:
            load_script(Path(self.script))
        plan: Plan = pickle.loads(self.plan)
        return plan

    def open(self) -> Workshop:
        """The workshop in which the plan's trials run."""
        return Workshop(self.unpacked())


BEGUN = b"begun"
"""What a worker sends once.

Its optimiser has asked for its first value, and its imports are behind it.
"""


def answer(blob: bytes) -> tuple[list[TrialResult], bool]:
    """The results that a worker has sent, and whether it ends now.

    Raises
    ------
    Exception
        Of any kind, if they are none.
    """
    # An optimiser can change how results are written, and the coordinator must run no code of its.
    results, worn = unpacked(blob, TrialResult, Status)
    return results, worn


def serve(connection: Connection, shop: Workshop) -> None:
    """Life of a worker.

    Parameters
    ----------
    connection : Connection
        To the coordinator; its end is the worker's end.
    shop : Workshop
        Where trials run.
    """
    # Now, and not in the server: each worker may grow by so much beyond what it was born with.
    limit_memory(shop.plan.memory)
    while True:
        try:
            tasks: list[Task] = connection.recv()
        except (EOFError, OSError):
            return
        for task in tasks:
            results, worn = _result(shop, task, lambda: connection.send_bytes(BEGUN))
            # An optimiser may have closed or replaced them; what it printed is not worth a trial.
            with suppress(OSError, ValueError, AttributeError):
                sys.stdout.flush()
                sys.stderr.flush()
            connection.send((results, worn))
            if worn:
                return


def _result(
    shop: Workshop, task: Task, begun: Callable[[], None]
) -> tuple[list[TrialResult], bool]:
    """The results of a task, and whether its process changed and must not be used again."""
    try:
        shop.warm_up(task, begun)
        # After the first use, which may well start a thread that a library keeps for all that
        # follow.
        before = settings()
        results = shop.run(task)
        worn = settings() != before
    except BaseException as error:
        # Nothing interrupts a worker from outside: whatever this is, the optimiser raised it.
        return failure(task, Status.ERROR, f"{type(error).__name__}: {error}"), True
    # What it leaves running would take time from the trials that follow.
    left = end_children()
    if left:
        noun = "process"
        if left > 1:
            noun = "processes"
        results = failure(task, Status.ERROR, f"left {left} {noun} behind")
    return results, worn or any(r.status in (Status.MEMORY, Status.CHANGED) for r in results)
