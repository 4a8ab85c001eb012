"""A real dask cluster of separate processes on this machine."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, sleep

START = 300.0
"""Seconds in which a scheduler and its workers must be there on a busy machine."""


@dataclass(frozen=True)
class Cluster:
    """Where it listens, and its processes."""

    address: str
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]]


@contextmanager
def cluster(folder: Path, count: int = 2) -> Iterator[Cluster]:
    """A scheduler and so many workers of one thread; nobody starts a lost one again."""
    where = folder / "scheduler.json"
    scheduler = _spawn(
        folder,
        "distributed.cli.dask_scheduler",
        "--scheduler-file",
        str(where),
        "--port",
        "0",
        "--no-dashboard",
    )
    options = [
        "--nworkers",
        "1",
        "--nthreads",
        "1",
        "--no-nanny",
        "--no-dashboard",
        "--scheduler-file",
        str(where),
    ]
    workers = [_spawn(folder, "distributed.cli.dask_worker", *options) for _ in range(count)]
    try:
        end = monotonic() + START
        while not where.exists() and monotonic() < end:
            sleep(0.05)
        from distributed import Client

        with Client(scheduler_file=str(where), timeout=START) as client:
            client.wait_for_workers(count, timeout=START)
            address = client.scheduler.address
        yield Cluster(address, scheduler, workers)
    finally:
        for process in [*workers, scheduler]:
            process.kill()
            process.wait()


def _spawn(folder: Path, *arguments: str) -> subprocess.Popen[bytes]:
    paths = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    with (folder / "log").open("a") as log:
        return subprocess.Popen(
            [sys.executable, "-m", *arguments],
            stdout=log,
            stderr=log,
            cwd=folder,
            env={**os.environ, "PYTHONPATH": paths},
        )
