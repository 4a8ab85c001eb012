"""Engines: the same bytes whoever runs the trials, and survival of whatever a trial does."""

import sys
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from benchmark_fakes import (
    Fixed,
    Heavy,
    Moody,
    Mute,
    Sleepy,
    Walk,
    artificial,
    moody_study,
    small_study,
)

from soaked import soaked
from springpot.benchmark import FORMATS, Status, Store, run_study, runner, supervisor
from springpot.benchmark.runner import ExecutorEngine
from springpot.errors import StudyError

ACCURACY = [f"summary.{suffix}" for suffix, _ in FORMATS.values()]


def tables(folder: Path) -> dict[str, bytes]:
    return {name: (folder / "small" / name).read_bytes() for name in ACCURACY}


def trials(path: Path):
    """Trials by optimiser label."""
    with Store(path) as store:
        labels = {cell.id: cell.label for cell in store.cells()}
        return {labels[number]: rows for number, rows in store.trials()}


@pytest.fixture(scope="module")
def serial(tmp_path_factory):
    folder = tmp_path_factory.mktemp("serial")
    run_study(small_study(), engine="serial", out=folder, quiet=True)
    return tables(folder)


@pytest.mark.soak_cases("2")
@pytest.mark.parametrize("workers", [soaked(1), 2])
def test_local_workers_give_the_bytes_of_a_serial_run(serial, tmp_path, workers):
    outcome = run_study(small_study(), workers=workers, out=tmp_path, quiet=True)
    assert (outcome.trials, outcome.ran, outcome.failed) == (32, 32, 0)
    assert tables(tmp_path) == serial


@pytest.mark.soak
def test_any_executor_gives_the_bytes_of_a_serial_run(serial, tmp_path):
    with ThreadPoolExecutor(2) as threads:
        run_study(small_study(), engine=threads, out=tmp_path / "threads", quiet=True)
    with ProcessPoolExecutor(1, mp_context=get_context("forkserver")) as processes:
        run_study(small_study(), engine=processes, out=tmp_path / "processes", quiet=True)
    assert tables(tmp_path / "threads") == serial
    assert tables(tmp_path / "processes") == serial


FAULTS = {
    "segfault": (Status.CRASH, "SIGSEGV"),
    "vanish": (Status.CRASH, "exit code 7"),
    "eat": (Status.MEMORY, ""),
    "exit": (Status.ERROR, "SystemExit: enough"),
    "throw": (Status.ERROR, "ValueError: out of"),
    "orphan": (Status.ERROR, "left 1 process behind"),
}


@pytest.fixture(scope="module")
def faulty(tmp_path_factory):
    """A study in which every fault happens, beside one good optimiser."""
    entrants = [*(Moody(mood=mood) for mood in FAULTS), Walk()]
    study = moody_study("fine", optimisers=entrants, memory=160, repetitions=1)
    return run_study(study, workers=2, out=tmp_path_factory.mktemp("faulty"), quiet=True)


@pytest.mark.parametrize("mood", FAULTS)
def test_a_fault_becomes_a_status_and_the_study_goes_on(faulty, mood):
    status, reason = FAULTS[mood]
    assert (faulty.ran, faulty.failed) == (len(FAULTS) + 1, len(FAULTS))
    rows = trials(faulty.store)
    (row,) = rows[f"moody(mood={mood})"]
    assert (row.status, row.best) == (status, None)
    assert reason in row.reason
    assert [row.status for row in rows["walk"]] == [Status.BUDGET]
    assert mood == "eat" or reason in (faulty.store.parent / "failures.md").read_text()


@pytest.mark.soak
def test_a_hang_ends_at_its_deadline_also_where_that_is_an_integer(tmp_path, capfd):
    outcome = run_study(moody_study("hang", deadline=1), workers=2, out=tmp_path, quiet=True)
    rows = trials(outcome.store)
    assert [row.status for row in rows["moody(mood=hang)"]] == [Status.TIMEOUT] * 3
    assert rows["moody(mood=hang)"][0].reason == "ended after the deadline of 1 s"
    assert capfd.readouterr().err == ""
    assert [row.status for row in rows["walk"]] == [Status.BUDGET] * 3


@pytest.mark.soak
def test_the_clock_starts_at_the_first_value_also_after_a_worker_was_ended(tmp_path):
    """What a library takes to be imported is no trial's time, in no process."""
    study = moody_study("fine", optimisers=[Heavy()], repetitions=4, deadline=0.4)
    outcome = run_study(study, workers=1, out=tmp_path, quiet=True)
    plan, (rows,) = study.plan(), trials(outcome.store).values()
    hung = [np.random.default_rng(plan.stream(plan.cells[0], r)).random() < 0.5 for r in range(4)]
    assert {True, False} == set(hung)
    assert [row.status is Status.TIMEOUT for row in rows] == hung
    assert all(
        row.reason == "ended after the deadline of 0.4 s" for row in rows if row.status.failed
    )


@pytest.mark.soak
def test_who_asks_for_no_value_is_waited_for_once_and_one_run_for_all_has_one_deadline(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(supervisor, "ENGINE", supervisor.ENGINE._replace(imports=0.5))
    study = moody_study("fine", optimisers=[Mute(), Fixed()], deadline=0.3)
    found = trials(run_study(study, workers=1, out=tmp_path, quiet=True).store)
    told = [
        f"ended after {seconds} s, in which it asked for no value" for seconds in (0.8, 0.3, 0.3)
    ]
    assert [row.reason for row in found["mute"]] == told
    assert {row.reason for row in found["fixed"]} == {"ended after the deadline of 0.3 s"}


@pytest.mark.soak
def test_times_are_those_of_the_processor_and_of_one_trial_alone(tmp_path):
    """What an optimiser that runs its repetitions side by side saves by that is told apart."""
    study = small_study(
        datasets=[artificial()],
        models=["own"],
        optimisers=["pso-paper", Sleepy()],
        repetitions=20,
        budget=2000,
    )
    found = trials(run_study(study, engine="serial", out=tmp_path, quiet=True).store)
    swarm, sleepy = found["pso-paper"], found["sleepy"]
    assert [row.processor is None for row in swarm] == [False] + 19 * [True]
    # Beside 19 others it is a tenth; a third leaves room for a busy machine.
    assert all(0 < row.processor_batched < swarm[0].processor / 3 for row in swarm)
    assert all(
        row.seconds - row.processor > 0.04 and row.processor_batched is None for row in sleepy
    )
    header, *lines = (tmp_path / "small" / "timing.csv").read_text().splitlines()
    assert header.endswith("one trial alone [s],an evaluation of it [us],share in a batch [s]")
    assert len(lines) == 2


@pytest.mark.soak
def test_a_library_that_swallows_the_end_stays_within_the_budget(tmp_path):
    outcome = run_study(moody_study("swallow"), workers=1, out=tmp_path, quiet=True)
    rows = trials(outcome.store)["moody(mood=swallow)"]
    assert [(row.status, row.evaluations) for row in rows] == [(Status.BUDGET, 300)] * 3


def test_failed_trials_run_again_only_if_asked(tmp_path, monkeypatch):
    study = moody_study("throw")
    run_study(study, engine="serial", out=tmp_path, quiet=True)
    monkeypatch.setattr(Moody, "throw", Moody.fine)
    assert run_study(study, engine="serial", out=tmp_path, quiet=True).ran == 0
    again = run_study(study, engine="serial", out=tmp_path, quiet=True, retry_failed=True)
    assert (again.ran, again.failed) == (3, 0)
    assert {row.status for rows in trials(again.store).values() for row in rows} == {Status.BUDGET}


def test_faults_in_this_process_are_statuses_too(tmp_path):
    outcome = run_study(moody_study("exit"), engine="serial", out=tmp_path, quiet=True)
    assert (outcome.ran, outcome.failed) == (6, 3)


def test_an_executor_whose_tasks_fail_reports_each(tmp_path):
    class Sour(ThreadPoolExecutor):
        """Loses every batch."""

        def submit(self, fn, /, *args, **kwargs):
            return super().submit(lambda: 1 / 0)

    with Sour(1) as executor:
        outcome = run_study(moody_study("fine"), engine=executor, out=tmp_path, quiet=True)
    assert (outcome.ran, outcome.failed) == (6, 6)
    assert {row.status for rows in trials(outcome.store).values() for row in rows} == {Status.CRASH}


@pytest.mark.soak
def test_workers_that_cannot_find_an_optimiser_say_so(tmp_path, monkeypatch):
    module = ModuleType("only_here")
    module.Hidden = type("Hidden", (Walk,), {"__module__": "only_here"})
    monkeypatch.setitem(sys.modules, "only_here", module)
    with pytest.raises(StudyError, match=r"a worker cannot start: .*only_here"):
        run_study(small_study(optimisers=[module.Hidden()]), workers=1, out=tmp_path, quiet=True)


def test_an_optimiser_defined_in_a_function_is_refused_in_one_line(tmp_path):
    class Local(Walk):
        """Known to this function only."""

    with pytest.raises(StudyError, match="cannot be sent to workers"):
        run_study(small_study(optimisers=[Local()]), workers=1, out=tmp_path, quiet=True)


@pytest.mark.soak
def test_unknown_engines_and_missing_dask_are_one_line(tmp_path, monkeypatch):
    with pytest.raises(StudyError, match="unknown engine 'slurm': use local"):
        run_study(small_study(), engine="slurm", out=tmp_path, quiet=True)
    run_study(small_study(), engine="serial", out=tmp_path, quiet=True)
    for nonsense in ("nonsense", 7):
        with pytest.raises(StudyError, match=f"unknown engine '{nonsense}'"):
            run_study(small_study(), engine=nonsense, out=tmp_path, quiet=True)
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(StudyError, match=r"needs dask: pip install 'springpot\[cluster\]'"):
        run_study(small_study(), engine="dask:tcp://127.0.0.1:1", out=tmp_path / "new", quiet=True)


def test_an_executor_has_a_batch_for_each_worker_and_one_that_waits(monkeypatch):
    monkeypatch.setattr(runner.Parcel, "of", lambda *given, **more: None)
    executor = SimpleNamespace(submit=None)
    assert runner.make_engine(None, None, 3, executor)._width == 6


def test_batches_grow_while_they_come_back_at_once_and_shrink_when_they_do_not():
    """Of trials of milliseconds a scheduler would else cost more than the trials do."""
    engine = ExecutorEngine(None, None, 2)
    sizes = []
    for seconds in [0.01] * 8 + [1.0, 30.0, 30.0]:
        engine._sized(engine._batch, seconds)
        sizes.append(engine._batch)
    assert sizes == [8, 16, 32, 64, 128, 256, 256, 256, 256, 128, 64]
    # The last of a study are few, and tell nothing of a whole batch.
    engine._sized(3, 0.01)
    assert engine._batch == 64
    for _ in range(9):
        engine._sized(engine._batch, 30.0)
    assert engine._batch == 4
