"""A study on a real dask cluster of processes: harm to workers, scheduler and trials."""

import os
import signal

import pytest
from dask_cluster import cluster
from faulty_optimisers import race
from test_faulty_optimisers import check, trials

from soaked import soaked
from springpot.benchmark import Store, run_study, runner
from springpot.errors import StudyError

pytest.importorskip("distributed", reason="dask is not installed")

DEEDS = [
    "segfault",
    "success without a result",
    "sleep",
    "kill its parent",
    "an error",
]


@pytest.fixture(scope="module")
def dask(tmp_path_factory):
    """For the tests in their order.

    A fault hurts no process, then a worker is lost, at last the scheduler.
    """
    with cluster(tmp_path_factory.mktemp("cluster")) as found:
        yield found


@pytest.fixture
def another(tmp_path):
    with cluster(tmp_path, count=1) as found:
        yield found


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("undisturbed")
    return trials(
        run_study(race([], 3), engine="serial", out=folder, quiet=True, tables=False).store
    )


def at_third_call(monkeypatch, deed):
    """Let something happen while a study is at work."""
    add, calls = Store.add, []

    def adding(self, results, cells):
        calls.append(1)
        if len(calls) == 3:
            deed()
        add(self, results, cells)

    monkeypatch.setattr(Store, "add", adding)


@pytest.mark.soak_cases("1")
@pytest.mark.parametrize("repetitions", [1, soaked(3)])
def test_a_fault_in_a_trial_is_its_status_there_too(dask, undisturbed, tmp_path, repetitions):
    study = race(DEEDS, repetitions)
    outcome = run_study(
        study, engine=f"dask:{dask.address}", out=tmp_path, quiet=True, tables=False
    )
    found = trials(outcome.store)
    check(found, undisturbed, DEEDS, repetitions)
    assert "SIGSEGV" in found["faulty segfault", 0][1]
    assert found["faulty sleep", 0][:2] == ("timeout", "ended after the deadline of 2 s")
    assert all(worker.poll() is None for worker in dask.workers), (
        "a trial has ended a worker of the cluster"
    )


@pytest.mark.soak
def test_a_cluster_that_loses_a_worker_gives_the_bits_of_a_serial_run(
    dask, undisturbed, tmp_path, monkeypatch
):
    at_third_call(monkeypatch, dask.workers[0].kill)
    outcome = run_study(
        race([], 3), engine=f"dask:{dask.address}", out=tmp_path, quiet=True, tables=False
    )
    assert (outcome.ran, outcome.failed) == (12, 0)
    assert trials(outcome.store) == undisturbed


@pytest.mark.soak_cases("9-dask")
@pytest.mark.parametrize(
    ("number", "one"), [(signal.SIGKILL, "dask"), soaked(signal.SIGTERM, "another")]
)
def test_a_scheduler_that_dies_is_one_line_and_the_study_goes_on_later(
    number, one, request, tmp_path, monkeypatch
):
    dask = request.getfixturevalue(one)
    at_third_call(monkeypatch, lambda: os.kill(dask.scheduler.pid, number))
    study = race([], 6)
    with pytest.raises(StudyError, match="finished trials are kept, run again to go on") as caught:
        run_study(study, engine=f"dask:{dask.address}", out=tmp_path, quiet=True, tables=False)
    assert "\n" not in str(caught.value)
    monkeypatch.undo()
    kept = len(trials(tmp_path / "faulty" / "faulty.sqlite"))
    outcome = run_study(study, engine="serial", out=tmp_path, quiet=True, tables=False)
    assert 0 < kept < 24
    assert outcome.ran == 24 - kept
    alone = run_study(study, engine="serial", out=tmp_path / "alone", quiet=True, tables=False)
    assert trials(outcome.store) == trials(alone.store)


@pytest.mark.soak
def test_no_scheduler_is_one_line(tmp_path, monkeypatch):
    monkeypatch.setattr(runner, "ENGINE", runner.ENGINE._replace(answer=0.5))
    with pytest.raises(
        StudyError, match=r"no dask scheduler answers at tcp://127\.0\.0\.1:9"
    ) as caught:
        run_study(race([]), engine="dask:tcp://127.0.0.1:9", out=tmp_path, quiet=True)
    assert "\n" not in str(caught.value)
