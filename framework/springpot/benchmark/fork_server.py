"""A server with the imports and the study, which forks a clean worker for each optimiser.

It runs no optimiser itself. It is started as a program, in a session of its own: Ctrl-C does not
reach it, no socket needs a path, and it serves the command, a thread of an executor and a worker of
a cluster alike. Once its coordinator is gone, it ends whatever it has forked, and itself. A worker
runs the batches that it is sent and answers each.
"""

from __future__ import annotations

import os
import pickle
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from importlib import import_module
from multiprocessing import spawn
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any, NoReturn

from springpot.errors import SpringpotError, StudyError
from springpot.processes import (
    LEAVING,
    adopt_orphans,
    cause_of,
    end_children,
    end_group,
    end_with_parent,
    limit_memory,
    settings,
)

from .plan import Plan, WorkOrder
from .summary import load_script
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
            tasks: list[WorkOrder] = connection.recv()
        except (EOFError, OSError):
            return
        results, worn = _results(shop, tasks, lambda: connection.send_bytes(BEGUN))
        # An optimiser may have closed or replaced them; what it printed is not worth a trial.
        with suppress(OSError, ValueError, AttributeError):
            sys.stdout.flush()
            sys.stderr.flush()
        connection.send((results, worn))
        if worn:
            return


def _results(
    shop: Workshop, tasks: list[WorkOrder], begun: Callable[[], None]
) -> tuple[list[list[TrialResult]], bool]:
    """The results of each task, and whether their process changed and must not be used again."""
    try:
        shop.warm_up(tasks[0], begun)
        # After the first use, which may well start a thread that a library keeps for all that
        # follow.
        before = settings()
        results = shop.run(tasks)
        worn = settings() != before
    except BaseException as error:
        # Nothing interrupts a worker from outside: whatever this is, the optimiser raised it.
        reason = f"{type(error).__name__}: {error}"
        return [failure(task, Status.ERROR, reason) for task in tasks], True
    # What it leaves running would take time from the trials that follow.
    left = end_children()
    if left:
        noun = "process"
        if left > 1:
            noun = "processes"
        results = [failure(task, Status.ERROR, f"left {left} {noun} behind") for task in tasks]
    full = any(result.status is Status.MEMORY for own in results for result in own)
    return results, worn or left > 0 or full


READY, BROKEN, BORN, ENDED = "ready", "broken", "born", "ended"
"""What the server tells its coordinator."""
FORK, KILL = "fork", "kill"
"""What it is told."""
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""One thread of a matrix library in each process.

There are as many processes as processors already.
"""
INSIDE = "SPRINGPOT_NURSERY"
"""Environment variable that keeps a script, loaded again in the server, from starting its study."""


class ForkServer:
    """The coordinator's view of it.

    Parameters
    ----------
    parcel : Parcel
        The study.
    """

    def __init__(self, parcel: Parcel) -> None:
        if os.environ.get(INSIDE):
            raise StudyError(
                "a study that is started by its own script needs: if __name__ == '__main__':"
                " around it"
            )
        # What an optimiser prints is no part of the command's own output.
        printed = 2
        complaints: int | None = None
        if parcel.quiet:
            printed = complaints = subprocess.DEVNULL
        ours, theirs = socket.socketpair()
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, *_flags(), "-c", _program(theirs.fileno())],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=printed,
                stderr=complaints,
                env=os.environ | dict.fromkeys(THREADS, "1") | {INSIDE: "1"},
                start_new_session=True,
            )
        # Two ways over one socket: messages, and the ends of pipes, which no message can hold.
        self._socket = ours
        self.channel = Connection(os.dup(ours.fileno()))
        self.ready = False
        with suppress(OSError):  # its end is noticed by whoever listens
            self.channel.send((_preparation(parcel), parcel))

    def fork(self, number: int) -> Connection:
        """A new process, known by its number, and the line to it.

        A dead server is noticed by whoever listens.
        """
        ours, theirs = socket.socketpair()
        with theirs, suppress(OSError):
            self.channel.send((FORK, number))
            socket.send_fds(self._socket, [b"f"], [theirs.fileno()])
        return Connection(ours.detach())

    def kill(self, number: int) -> None:
        """End a process and all that it started."""
        with suppress(OSError):
            self.channel.send((KILL, number))

    def cause(self) -> str:
        """How it ended."""
        code = self._process.wait()
        # A wait status: the signal in its low byte, the exit code in the one above.
        status = code << 8
        if code < 0:
            status = -code
        return cause_of(status)

    def close(self) -> None:
        """End it and all that it has forked."""
        self.channel.close()
        self._socket.close()
        # One that still imports does not listen yet; it has forked nothing.
        if not self.ready:
            self._process.kill()
        try:
            self._process.wait(LEAVING)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def _flags() -> list[str]:
    """The interpreter's own options, such as ``-W``."""
    flags: list[str] = subprocess._args_from_interpreter_flags()  # type: ignore[attr-defined]
    return flags


def _program(fd: int) -> str:
    return (
        f"import sys; sys.path[:] = {sys.path!r}; from springpot.benchmark.fork_server import main;"
        f" main({fd})"
    )


def _preparation(parcel: Parcel) -> dict[str, Any]:
    """What lets the server find what the program that runs the study defines, for `spawn`."""
    data: dict[str, Any] = spawn.get_preparation_data("springpot-fork-server")
    unwanted = ["authkey", "start_method", "log_to_stderr", "log_level"]
    if parcel.script or not parcel.own_program:
        unwanted += ["init_main_from_name", "init_main_from_path"]
    for key in unwanted:
        data.pop(key, None)
    return data


def main(fd: int) -> None:
    """Life of the fork server; `fd` is its line to the coordinator."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    adopt_orphans()
    line = socket.socket(fileno=fd)
    # Messages by one end and file descriptors by the other, of one socket.
    channel = Connection(os.dup(fd))
    try:
        preparation, parcel = channel.recv()
        spawn.prepare(preparation)
        import_module("scipy.optimize")  # what most optimisers need, once for all
        shop = parcel.open()
    except (EOFError, OSError, pickle.UnpicklingError):
        return
    except (Exception, SystemExit) as error:
        reason = f"{type(error).__name__}: {error}"
        if isinstance(error, SpringpotError):
            reason = str(error)
        with suppress(OSError):
            channel.send((BROKEN, 0, reason))
        return
    with suppress(OSError):
        channel.send((READY, 0, ""))
        _Family(line, channel, shop).live()


class _Family:
    """The processes that a fork server has forked."""

    def __init__(self, line: socket.socket, channel: Connection, shop: Workshop) -> None:
        self._line, self._channel, self._shop = line, channel, shop
        self._children: dict[int, int] = {}
        # A signal may come at any line: it only rings, and the children are looked after where
        # nothing is half done.
        self._bell, self._ring = os.pipe()
        os.set_blocking(self._ring, False)
        os.set_blocking(self._bell, False)
        signal.signal(signal.SIGCHLD, lambda *_: None)
        signal.set_wakeup_fd(self._ring, warn_on_full_buffer=False)

    def live(self) -> None:
        """Fork, end and report until the coordinator is gone."""
        try:
            while True:
                heard = wait([self._channel, self._bell])
                if self._bell in heard:
                    os.read(self._bell, 4096)
                    self._report()
                if self._channel in heard:
                    self._obey(*self._channel.recv())
        except (EOFError, OSError):
            return
        finally:
            for pid in self._children:
                end_group(pid)
                os.waitpid(pid, 0)
            self._end_strays()

    def _obey(self, word: str, number: int) -> None:
        if word == FORK:
            self._fork(number)
            return
        for pid, known in self._children.items():
            if known == number:
                end_group(pid)

    def _fork(self, number: int) -> None:
        fds, parent = socket.recv_fds(self._line, 1, 1)[1], os.getpid()
        pid = os.fork()
        if pid == 0:
            self._be_born(fds[0], parent)
        os.close(fds[0])
        self._children[pid] = number
        self._channel.send((BORN, number, pid))

    def _be_born(self, fd: int, parent: int) -> NoReturn:
        """In the child: leave everything of the fork server behind and work."""
        try:
            # Of a server that is killed nobody may know it yet, or it was to be ended just then.
            end_with_parent(parent)
            # A session of its own, so that whatever an optimiser starts is ended with it.
            os.setsid()
            adopt_orphans()
            signal.set_wakeup_fd(-1)
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            self._line.close()
            self._channel.close()
            os.close(self._bell)
            os.close(self._ring)
            serve(Connection(fd), self._shop)
        except BaseException as error:
            print(f"springpot: a worker ends: {type(error).__name__}: {error}", file=sys.stderr)
            os._exit(1)
        os._exit(0)

    def _report(self) -> None:
        """Tell of the children that have ended, and end what they left in their groups."""
        while self._children:
            # Until there is none left: several ends may ring only once.
            pid, status = os.waitpid(-1, os.WNOHANG)
            if pid == 0:
                return
            number = self._children.pop(pid, None)
            end_group(pid)
            self._end_strays()
            if number is not None:
                self._channel.send((ENDED, number, cause_of(status)))

    def _end_strays(self) -> None:
        """End what came here because the worker that started it is gone."""
        # Each that ends may leave children of its own here.
        while end_children(known=self._children):
            continue
