"""Tasks on an executor's worker.

Run there by a local engine of one process, so that what a trial does ends there.
"""

from __future__ import annotations

import threading

from .plan import Task
from .supervisor import LocalEngine
from .trial import TrialResult
from .worker import Parcel

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

    def run(self, parcel: Parcel, tasks: list[Task]) -> list[TrialResult]:
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


def run_tasks(parcel: Parcel, tasks: list[Task]) -> list[TrialResult]:
    """Run tasks anywhere: what an executor's workers are given."""
    return _here.keeper.run(parcel, tasks)
