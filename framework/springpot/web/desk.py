"""The desk: hands tasks to worker processes, shares and keeps answers, ends what nobody awaits."""

from __future__ import annotations

import asyncio
import json
import os
import sys
from collections import OrderedDict
from collections.abc import AsyncIterator, Callable
from contextlib import suppress
from typing import Any

from springpot.processes import LEAVING

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""The matrices of a fit are small: more threads only wait for one another."""
KEPT = 64 << 20
"""Bytes of answers that are kept: some hundred rungs."""

PROGRAM = "from springpot.web.worker import main; main()"
ASIDE = "import os; getattr(os, 'nice', int)(15)"
"""What a process does first that stands back for others: 19 would be the last of all."""
Line = bytes


class DeskWorker:
    """One process, which does one task after another.

    Parameters
    ----------
    aside : bool
        Whether it stands back for all others on a machine that has no processor left.
    """

    def __init__(self, aside: bool = False) -> None:
        self._process: asyncio.subprocess.Process | None = None
        self._leaving: set[asyncio.Task[Any]] = set()
        self._program = f"{ASIDE}; {PROGRAM}" if aside else PROGRAM

    async def start(self) -> None:
        """Start the process; it imports what it needs while it waits."""
        self._process = await asyncio.create_subprocess_exec(
            sys.executable,
            # With the path of the server, so that both import the same.
            "-c",
            f"import sys; sys.path[:] = {sys.path!r}; {self._program}",
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            # A pipe that nobody reads would fill, and stop the worker.
            stderr=asyncio.subprocess.DEVNULL,
            env=os.environ | dict.fromkeys(THREADS, "1"),
            # Our own process answers in lines of any length.
            limit=sys.maxsize,
        )

    async def perform(
        self, task: str, arguments: dict[str, Any], told: Callable[[Line], None]
    ) -> Line:
        """The last line of a task's answer; lines before it tell its stages.

        However this is left before its end, the process is ended: it may be in the midst of
        anything.
        """
        if not self.alive:
            await self.start()
        process = self._process
        assert process is not None
        assert process.stdin is not None
        assert process.stdout is not None
        done = False
        try:
            process.stdin.write(json.dumps({"task": task, "arguments": arguments}).encode() + b"\n")
            await process.stdin.drain()
            while line := await process.stdout.readline():
                # By its first word: an answer of megabytes need not be parsed to be passed on.
                if line.startswith((b'{"result"', b'{"error"')):
                    done = True
                    return line
                if line.startswith(b'{"stage"'):
                    told(line)
            return _error(
                "the computation ended before it was done: out of memory, or a crash of a library"
            )
        except (OSError, ValueError) as error:
            return _error(f"the computation was lost: {type(error).__name__}")
        finally:
            if not done:
                self.end()

    @property
    def alive(self) -> bool:
        """Whether there is a process."""
        return self._process is not None and self._process.returncode is None

    def end(self) -> None:
        """End the process; the next task gets a new one."""
        # Forgotten first: whoever asks meanwhile starts a new one.
        process, self._process = self._process, None
        if process is not None and process.returncode is None:
            with suppress(ProcessLookupError):
                process.kill()
        if process is not None:
            leaving = asyncio.ensure_future(process.communicate(b""))
            self._leaving.add(leaving)
            leaving.add_done_callback(self._leaving.discard)

    async def close(self) -> None:
        """End the process, and wait until it and all that were ended before are gone."""
        self.end()
        # Its pipes too: those that are open when the loop closes cannot be closed any more. Not for
        # ever: what a worker has left behind may hold them.
        if self._leaving:
            await asyncio.wait(self._leaving, timeout=LEAVING)


class _Running:
    """A task for which one or several wait."""

    def __init__(self) -> None:
        self.listeners: list[asyncio.Queue[Line]] = []
        self.last: Line = b""
        self.work: asyncio.Task[None] | None = None

    def told(self, line: Line) -> None:
        """Tell all who wait."""
        self.last = line
        for listener in self.listeners:
            listener.put_nowait(line)


class Desk:
    """Workers for short and for long tasks, one for what nobody waits for, and their answers.

    Parameters
    ----------
    long : int
        Workers for long tasks: as many fits run side by side.
    """

    def __init__(self, long: int = 2) -> None:
        self._lanes = {
            "short": [DeskWorker()],
            "long": [DeskWorker() for _ in range(long)],
            "quiet": [DeskWorker(aside=True)],
        }
        self._free: dict[str, asyncio.Queue[DeskWorker]] = {}
        self._queues: dict[str, list[_Running]] = {lane: [] for lane in self._lanes}
        self._running: dict[str, _Running] = {}
        self._closing = False
        self._kept: OrderedDict[str, Line] = OrderedDict()

    async def open(self) -> None:
        """Start a worker of each kind that is waited for, so that no answer waits for its imports.

        Further ones start when they are needed: they would only take time from the first.
        """
        for lane, workers in self._lanes.items():
            # The last who worked is the first who works again: it has the imports, and remembers
            # ladders.
            self._free[lane] = asyncio.LifoQueue()
            if lane != "quiet":
                await workers[0].start()
            for worker in reversed(workers):
                self._free[lane].put_nowait(worker)

    async def close(self) -> None:
        """End all workers."""
        # First, or each task that is cancelled would start a worker for the next.
        self._closing = True
        for running in self._running.values():
            if running.work is not None:
                running.work.cancel()
        for workers in self._lanes.values():
            for worker in workers:
                await worker.close()

    async def ask(
        self, task: str, arguments: dict[str, Any], lane: str = "short", key: str = ""
    ) -> AsyncIterator[Line]:
        """Lines of the answer: stages, and at last ``{"result": ...}`` or ``{"error": ...}``.

        Parameters
        ----------
        task, arguments
            What is to be done, see `springpot.web.tasks`.
        lane : {"short", "long", "quiet"}
            Which workers do it.
        key : str
            Of an answer that is the same whenever it is asked: it is computed once and kept. When
            the last who waits for it leaves, the computation is ended.
        """
        if key in self._kept:
            self._kept.move_to_end(key)
            yield self._kept[key]
            return
        # Without a key nobody else can ask for the same.
        name = key or f"only {id(arguments)}"
        running = self._running.get(name)
        if running is None:
            running = self._running[name] = _Running()
            running.work = asyncio.create_task(
                self._work(name, running, task, arguments, lane, key)
            )
        mine: asyncio.Queue[Line] = asyncio.Queue()
        running.listeners.append(mine)
        # Who joins late sees the stage that was reached, and not nothing until the next one.
        if running.last:
            mine.put_nowait(running.last)
        try:
            while True:
                line = await mine.get()
                yield line
                if not line.startswith(b'{"stage"'):
                    return
        finally:
            # Here ends the wait of a browser that has gone, too.
            running.listeners.remove(mine)
            if not running.listeners and running.work is not None:
                running.work.cancel()
                # Who asks for it again begins anew, and does not wait for what is being ended.
                self._running.pop(name, None)

    async def _work(
        self,
        name: str,
        running: _Running,
        task: str,
        arguments: dict[str, Any],
        lane: str,
        key: str,
    ) -> None:
        line = _error("the computation was cancelled")
        try:
            worker = await self._turn(running, lane)
            try:
                line = await worker.perform(task, arguments, running.told)
            finally:
                if not worker.alive and not self._closing:
                    # At once, so that the next task need not wait for its imports.
                    await worker.start()
                self._free[lane].put_nowait(worker)
            # Errors are not kept: what failed may do better when it is asked again.
            if key and line.startswith(b'{"result"'):
                self._keep(key, line)
        finally:
            # Another may stand under this name already, begun after this one was left.
            if self._running.get(name) is running:
                del self._running[name]
            # Whoever waits hears an end, of what was cancelled too.
            running.told(line)

    async def _turn(self, running: _Running, lane: str) -> DeskWorker:
        """A worker, as soon as one is free; who waits hears how many wait before."""
        free, queue = self._free[lane], self._queues[lane]
        if free.empty():
            queue.append(running)
            _tell_places(queue)
        try:
            return await free.get()
        finally:
            if running in queue:
                queue.remove(running)
                _tell_places(queue)

    def _keep(self, key: str, line: Line) -> None:
        self._kept[key] = line
        # The newest stays, however large: it was asked for just now.
        while len(self._kept) > 1 and sum(map(len, self._kept.values())) > KEPT:
            self._kept.popitem(last=False)


def _tell_places(queue: list[_Running]) -> None:
    for place, running in enumerate(queue, 1):
        stage = f"others compute: place {place} of {len(queue)} in the queue"
        running.told(json.dumps({"stage": stage}).encode() + b"\n")


def _error(says: str) -> Line:
    return json.dumps({"error": says, "fault": True}).encode() + b"\n"
