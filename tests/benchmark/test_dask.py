"""A study on a real dask cluster of separate worker processes, of which one is killed."""

import os
import subprocess
import sys
from pathlib import Path
from time import monotonic, sleep

import pytest
from benchmark_fakes import small_study

from springpot.benchmark import run_study
from springpot.errors import StudyError

pytest.importorskip("distributed", reason="dask is not installed")
PATH = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])


def spawn(folder, *arguments):
    command = [sys.executable, "-m", *arguments]
    with (folder / "log").open("a") as log:
        return subprocess.Popen(command, stdout=log, stderr=log, cwd=folder, env={**os.environ, "PYTHONPATH": PATH})


@pytest.fixture
def cluster(tmp_path):
    """Address of a scheduler with two workers, and the workers' processes."""
    where = tmp_path / "scheduler.json"
    quiet = ["--no-dashboard"]
    scheduler = spawn(
        tmp_path, "distributed.cli.dask_scheduler", "--scheduler-file", str(where), "--port", "0", *quiet
    )
    options = ["--nworkers", "1", "--nthreads", "1", "--no-nanny", *quiet, "--scheduler-file", str(where)]
    workers = [spawn(tmp_path, "distributed.cli.dask_worker", *options) for _ in range(2)]
    end = monotonic() + 30
    while not where.exists() and monotonic() < end:
        sleep(0.05)
    from distributed import Client

    with Client(scheduler_file=str(where), timeout=30) as client:
        client.wait_for_workers(2, timeout=30)
        address = client.scheduler.address
    yield address, workers
    for process in [*workers, scheduler]:
        process.kill()
        process.wait()


def test_a_cluster_that_loses_a_worker_gives_the_bytes_of_a_serial_run(cluster, tmp_path, monkeypatch):
    address, workers = cluster
    study = small_study(repetitions=10)
    run_study(study, engine="serial", out=tmp_path / "serial", quiet=True)
    from springpot.benchmark import Store

    add, calls = Store.add, []

    def kill_one(self, results, cells):
        calls.append(len(list(results)))
        if len(calls) == 3:
            workers[0].kill()
        add(self, results, cells)

    monkeypatch.setattr(Store, "add", kill_one)
    outcome = run_study(study, engine=f"dask:{address}", out=tmp_path / "dask", quiet=True)
    assert (outcome.ran, outcome.failed) == (80, 0)
    there, here = (tmp_path / name / "small" / "summary.csv" for name in ("serial", "dask"))
    assert there.read_bytes() == here.read_bytes()


def test_no_scheduler_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setattr("springpot.benchmark.engine.ANSWER", 0.5)
    with pytest.raises(StudyError, match=r"no dask scheduler answers at tcp://127\.0\.0\.1:9") as caught:
        run_study(small_study(), engine="dask:tcp://127.0.0.1:9", out=tmp_path, quiet=True)
    assert "\n" not in str(caught.value)
