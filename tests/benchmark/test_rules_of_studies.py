"""What a study accepts, what is left to do, and what a process tells of a trial, by hand."""

from __future__ import annotations

import io
from concurrent.futures import Future
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from benchmark_fakes import OMEGA, TRUTH, Moody, Walk, artificial, measurement, small_study

from springpot.benchmark import fork_server, plan as plans, runner, study as studies, summary, trial
from springpot.benchmark.fork_server import Parcel
from springpot.benchmark.plan import BLOCK, WorkOrder
from springpot.benchmark.runner import ExecutorEngine
from springpot.benchmark.trial import Bell, Status, TrialResult, TwinProblem, Workshop
from springpot.errors import OptionError, StudyError
from springpot.identification import BatchedOptimiser, Card, Optimiser, run
from springpot.identification.problem import Problem
from springpot.measurement import DataSet


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"name": "a.b-c_d"}, ""),
        ({"name": ".a"}, "study name '.a'"),
        ({"name": "a b"}, "study name 'a b'"),
        ({"models": "own"}, "models must be a list with at least one entry"),
        ({"models": []}, "models must be a list with at least one entry"),
        ({"repetitions": 1e4}, ""),
        ({"repetitions": 1}, ""),
        ({"repetitions": 0}, "repetitions must be a whole number from 1 on"),
        ({"budget": 2.5}, "budget must be a whole number from 1 on"),
        ({"budget": True}, "budget must be a whole number from 1 on"),
        ({"memory": np.inf}, "memory must be a whole number from 1 on"),
        ({"deadline": 0}, "deadline must be a positive number"),
        ({"deadline": 6}, ""),
        ({"target": "a"}, "target must be a positive number"),
        ({"accuracy": -1.0}, "accuracy must be a positive number"),
        ({"min_success": 1}, ""),
        ({"min_success": 1.01}, "min_success must be a share of at most 1"),
        ({"min_success": 0}, "min_success must be a positive number"),
        ({"max_seconds": None}, ""),
        ({"max_seconds": np.nan}, "max_seconds must be a positive number"),
        ({"seed": -3}, ""),
        ({"seed": 0.5}, "seed must be a whole number"),
        ({"stop_at_target": 1}, "stop_at_target must be True or False"),
        ({"stop_at_target": np.True_}, ""),
        ({"finish": 3}, "finish must be a function of two paths"),
    ],
)
def test_what_a_study_is_told(changes, says):
    if says:
        with pytest.raises(StudyError, match=says):
            small_study(**changes)
        return
    made = small_study(**changes)
    for key, value in changes.items():
        assert getattr(made, key) == value
    assert isinstance(made.deadline, float)
    assert isinstance(made.repetitions, int)
    assert isinstance(made.stop_at_target, bool)


def test_options_of_a_study_are_changed_one_by_one():
    made = small_study()
    assert made.with_options() is made
    assert (made.with_options(7).budget, made.with_options(7).repetitions) == (7, 4)
    assert (made.with_options(None, 9).budget, made.with_options(None, 9).repetitions) == (300, 9)
    required = small_study(min_success=0.5, max_seconds=2).plan().requirements
    assert required == {"min_success": 0.5, "max_seconds": 2.0}


@pytest.mark.parametrize(
    ("given", "label"),
    [
        (Walk(), "walk"),
        (Walk, "walk"),
        (Walk(shrink=0.5), "walk(shrink=0.5)"),
        (("mine", Walk(shrink=0.5)), "mine"),
        (Moody(mood="hang", shrink=0.5), "moody(shrink=0.5, mood=hang)"),
        ("least-squares", "least-squares"),
    ],
)
def test_an_entrant_is_called_by_what_differs(given, label):
    assert studies._entrant(given).label == label


def test_a_study_names_each_once():
    with pytest.raises(StudyError, match="optimiser 'walk' occurs twice"):
        small_study(optimisers=[Walk(), Walk()]).plan()
    with pytest.raises(StudyError, match="data set 'kelvin' occurs twice"):
        small_study(datasets=[artificial(), artificial()]).plan()
    with pytest.raises(StudyError, match="is no optimiser"):
        small_study(optimisers=[3]).plan()


def test_an_optimiser_may_be_named_with_options():
    plan = small_study(optimisers=["cma-es", "cma-es:sigma=0.5", ("wide", "cma-es:sigma=1")]).plan()
    assert [entrant.label for entrant in plan.entrants] == ["cma-es", "cma-es(sigma=0.5)", "wide"]
    assert plan.entrants[2].optimiser.sigma == 1.0
    with pytest.raises(OptionError, match="cma-es has no option 'width'"):
        small_study(optimisers=["cma-es:width=1"]).plan()


def test_problems_of_a_study(stays):
    plan = small_study(models=["own", "springpot"], stop_at_target=True).plan()
    stays(
        {
            "cases": [
                [case.source.name, case.model, case.reference, case.known, case.optimum]
                for case in plan.cases
            ],
            "stops": [plan.stop_value(case) for case in plan.cases],
            "cells": [[cell.index, cell.case, cell.entrant] for cell in plan.cells],
            "size": plan.size,
            "streams": [
                np.random.default_rng(plan.stream(cell, r)).random()
                for cell in plan.cells[:3]
                for r in (0, 1)
            ],
        },
        within=1e-4,
    )
    assert replace(plan, stop_at_target=False).stop_value(plan.cases[0]) == -np.inf


class Together(BatchedOptimiser):
    name = "together"
    card = Card("in batches", batched=True)

    def minimise_batch(self, problems, budget, rngs):
        """It is never run."""


class Sure(Walk):
    name = "sure"
    card = Card("no chance", stochastic=False)


def test_work_is_dealt_out_by_optimiser_and_in_blocks():
    plan = small_study(datasets=[artificial()], repetitions=BLOCK + 2).plan()
    plan = replace(plan, entrants=(plan.entrants[0], SimpleNamespace(optimiser=Together())))
    done = {cell.index: set() for cell in plan.cells}
    done[plan.cells[0].index] = set(range(1, BLOCK + 2))
    batched = next(cell for cell in plan.cells if cell.entrant == 1)
    done[batched.index] = {0, BLOCK}
    orders = list(plan.tasks(lambda cell: done[cell.index]))
    assert orders[0] == WorkOrder(plan.cells[0].index, (0,))
    own = [each.repetitions for each in orders if each.cell == batched.index]
    assert own == [tuple(range(1, BLOCK)), (BLOCK + 1,)]
    entrants = [plan.cells[each.cell].entrant for each in orders]
    assert entrants == sorted(entrants)
    together = WorkOrder(batched.index, (1, 2, 3))
    assert plan.flown_together(together)
    assert plan.runs_of(together) == 4
    assert plan.runs_of(WorkOrder(batched.index, (1,))) == 1
    assert plan.runs_of(WorkOrder(plan.cells[0].index, (1, 2))) == 2
    sure = replace(plan, entrants=(SimpleNamespace(optimiser=Sure()), plan.entrants[1]))
    assert sure.runs_of(WorkOrder(plan.cells[0].index, (1, 2))) == 1
    # One run without randomness stands for all of its block.
    first = next(sure.tasks(lambda cell: {0, 1} if cell.index == plan.cells[0].index else set()))
    assert first.repetitions == tuple(range(BLOCK))


def test_progress_is_told_at_tenths_and_not_more_often_than_every_ten_seconds(monkeypatch):
    now, stream = [0.0], io.StringIO()
    monkeypatch.setattr(runner, "monotonic", lambda: now[0])
    lines = runner.ProgressLines("made", 100, stream)

    def at(seconds, done, failed=0):
        now[0] = seconds
        lines.update(done, failed)
        return len(stream.getvalue().splitlines())

    assert at(1.0, 1) == 1
    assert at(20.0, 10) == 1
    assert at(20.0, 11) == 2
    assert at(29.9, 40, 2) == 2
    assert at(30.0, 40, 2) == 3
    lines.close()
    assert len(stream.getvalue().splitlines()) == 3
    now[0] = 40.0
    lines._state = (100, 2)
    lines.close()
    assert stream.getvalue().splitlines() == [
        "made: 1 of 100 trials, 1 s",
        "made: 11 of 100 trials, 20 s",
        "made: 40 of 100 trials, 2 failed, 30 s",
        "made: 100 of 100 trials, 2 failed, 40 s",
    ]


def test_traces_are_told_at_any_evaluation():
    assert trial.improvements(np.array([3.0, 3.0, 2.0, 5.0, 1.0])) == [
        (1, 3.0),
        (3, 2.0),
        (5, 1.0),
    ]
    numbers, values = trial.unpack(trial.pack([(1, 3.0), (300, 2.0)]))
    assert (numbers.tolist(), values.tolist()) == ([1, 300], [3.0, 2.0])
    asked = np.array([1, 299, 300, 900])
    assert trial.at(numbers, values, asked).tolist() == [3.0, 3.0, 2.0, 2.0]
    assert trial.at(np.array([5]), np.array([1.0]), np.array([4])).tolist() == [np.inf]
    grid = trial.geometric_grid(1000)
    assert (grid[0], grid[-1], len(np.unique(grid)) == len(grid)) == (1, 1000, True)
    assert trial.geometric_grid(1).tolist() == [1]
    assert trial.unpack_values(trial.pack_values(np.array([1.5, 2.5]))).tolist() == [1.5, 2.5]


def test_errors_are_relative_unless_the_truth_is_nothing():
    assert trial.relative_error(np.array([1.1, 2.0]), np.array([1.0, -2.0])) == pytest.approx(2.0)
    assert trial.relative_error(np.array([1.1, 0.3]), np.array([1.0, 0.0])) == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("status", "failed", "kept"),
    [
        ("converged", False, (Status.CONVERGED, "")),
        ("failed: MemoryError: no", True, (Status.MEMORY, "MemoryError: no")),
        ("failed: no finite value", True, (Status.INVALID, "no finite value")),
        ("failed: ValueError: no", True, (Status.ERROR, "ValueError: no")),
    ],
)
def test_how_a_run_ended(status, failed, kept):
    assert trial._status(SimpleNamespace(status=status, failed=failed)) == kept


def at(twin, point):
    """What is kept of a run that evaluates one point."""

    class There(Optimiser):
        name, card = "there", Card("one point")

        def minimise(self, problem, budget, rng):
            problem(point)

    return twin.judge(0, 0, run(There(), twin.problem, 1, np.random.default_rng(0), diary=True))


def test_a_twin_without_noise_judges_what_was_found():
    plan = small_study(datasets=[artificial(), artificial(0.02, "noisy")]).plan()
    exact, noisy = (TwinProblem(case) for case in plan.cases[::2])
    assert (exact.noisy, noisy.noisy) == (False, True)
    unknown = DataSet("own", "of a laboratory", lambda: measurement(0.01, "own"))
    bare = TwinProblem(small_study(datasets=[unknown], models=["springpot"]).plan().cases[0])
    assert (bare.noisy, bare.clean, bare.truth) == (False, None, None)
    point = noisy.problem.space.from_theta(noisy.problem.model.vector(dict(TRUTH)))
    worth = at(noisy, point)
    assert worth.oracle == pytest.approx(0.0, abs=1e-20)
    assert worth.parameter_error == pytest.approx(0.0, abs=1e-12)
    assert worth.best > 0.0
    assert at(bare, 0.5 * (bare.problem.lower + bare.problem.upper)).oracle is None


def shop(mood="fine", **changes):
    optimisers = [("moody", Moody(mood=mood)), ("walk", Walk())]
    return Workshop(small_study(datasets=[artificial()], optimisers=optimisers, **changes).plan())


def test_a_bell_rings_once():
    rung = []
    bell = Bell(lambda: rung.append(1))
    bell(3)
    bell()
    assert rung == [1]
    made = shop()
    made.warm_up(WorkOrder(0, (0,)), lambda: rung.append(2))
    made.warm_up(WorkOrder(0, (1,)), lambda: rung.append(3))
    assert rung == [1, 2]


@pytest.mark.parametrize(
    ("mood", "status", "reason"),
    [
        ("fine", Status.BUDGET, ""),
        ("throw", Status.ERROR, "ValueError: out of"),
        ("exit", Status.ERROR, "SystemExit: enough"),
    ],
)
def test_what_an_optimiser_raises_is_a_status(monkeypatch, mood, status, reason):
    # Other tests may have left processes to this one.
    monkeypatch.setattr(fork_server, "end_children", lambda: 0)
    [[found]] = shop(mood).run([WorkOrder(0, (2,))])
    assert (found.status, found.reason, found.repetition) == (status, reason, 2)
    [own], worn = fork_server._results(shop(mood), [WorkOrder(0, (2,))], lambda: None)
    assert ([(each.status, each.reason) for each in own], worn) == ([(status, reason)], False)


def test_a_fault_of_the_worker_itself_wears_it(monkeypatch):
    made = shop()
    monkeypatch.setattr(made, "run", lambda tasks: 1 / 0)
    [own], worn = fork_server._results(made, [WorkOrder(0, (0, 1))], lambda: None)
    assert worn
    assert [each.reason for each in own] == ["ZeroDivisionError: division by zero"] * 2
    for left, words in ((1, "left 1 process behind"), (2, "left 2 processes behind")):
        monkeypatch.setattr(fork_server, "end_children", lambda left=left: left)
        [[own]], worn = fork_server._results(shop(), [WorkOrder(0, (0,))], lambda: None)
        assert (own.status, own.reason, worn) == (Status.ERROR, words, True)
    monkeypatch.setattr(fork_server, "end_children", lambda: 0)
    made = shop()
    monkeypatch.setattr(made, "run", lambda tasks: [[TrialResult(0, 0, Status.MEMORY)]])
    assert fork_server._results(made, [WorkOrder(0, (0,))], lambda: None)[1]


def test_a_parcel_lets_workers_find_what_the_program_defines(monkeypatch):
    data = {"authkey": 1, "name": "x", "init_main_from_path": "a.py", "start_method": "fork"}
    monkeypatch.setattr(fork_server.spawn, "get_preparation_data", lambda name: dict(data))
    plan = small_study().plan()
    parcel = Parcel.of(plan, None)
    assert (parcel.script, parcel.quiet, parcel.own_program) == ("", False, True)
    assert set(fork_server._preparation(parcel)) == {"name", "init_main_from_path"}
    assert set(fork_server._preparation(replace(parcel, own_program=False))) == {"name"}
    assert set(fork_server._preparation(replace(parcel, script="a.py"))) == {"name"}
    assert parcel.unpacked().name == plan.name
    with pytest.raises(StudyError, match="cannot be sent to workers"):
        Parcel.of(replace(plan, name=lambda: 3), None)


@pytest.mark.parametrize(("code", "status"), [(0, 0), (3, 3 << 8), (-9, 9)])
def test_a_server_s_end_is_told_by_its_code(code, status, monkeypatch):
    monkeypatch.setattr(fork_server, "cause_of", lambda given: given)
    server = fork_server.ForkServer.__new__(fork_server.ForkServer)
    server._process = SimpleNamespace(wait=lambda: code)
    assert server.cause() == status


def test_progress_is_measured_from_the_centre_or_from_no_answer():
    problem = Problem.of(
        studies.parse_model("springpot"), measurement(), studies._objective("paper"), None
    )
    centre = float(problem.evaluate(0.5 * (problem.lower + problem.upper)))
    nothing = float(np.sum(np.abs(problem.measurement.stiffness) ** 2))
    plain = problem.objective.value(
        np.zeros(len(OMEGA), dtype=complex), problem.measurement, problem.weights
    )
    assert plain <= nothing or plain > 0.0
    assert plans.reference_of(problem) == pytest.approx(min(centre, float(plain)))


def test_a_script_is_loaded_once_and_its_faults_are_told_by_line(tmp_path):
    path = tmp_path / "made_study.py"
    path.write_text("import math\n\nx = math.sqrt(-1)\n")
    with pytest.raises(StudyError, match=r"made_study.py, line 3: ValueError"):
        summary.load_script(path)
    path.write_text("x = (\n")
    with pytest.raises(StudyError, match=r"made_study.py, line 1: SyntaxError"):
        summary.load_script(path)
    path.write_text("x = 3\n")
    assert summary.load_script(path) is summary.load_script(path)
    with pytest.raises(StudyError, match="declares no study"):
        summary.load_study(path)
    with pytest.raises(StudyError, match="there is no study script"):
        summary.load_script(tmp_path / "none.py")
    assert summary.store_path("a", tmp_path) == tmp_path / "a" / "a.sqlite"
    (tmp_path / "b").mkdir()
    assert summary.store_path(tmp_path / "b", tmp_path) == tmp_path / "b" / "b.sqlite"
    assert summary.store_path("x/c.sqlite", tmp_path).name == "c.sqlite"


@pytest.mark.parametrize(
    ("processor", "evaluations", "each"),
    [(2.0, 4, 0.5), (None, 4, np.nan), (0.0, 4, np.nan), (2.0, 0, np.nan)],
)
def test_a_clock_that_shows_nothing_gives_no_rate(processor, evaluations, each):
    trials = summary.CellTrials(("processor", "evaluations"), [(processor, evaluations)])
    np.testing.assert_array_equal(summary._each(trials), [each])


def test_an_executor_has_no_more_batches_under_way_than_its_width():
    submitted = []

    def submit(action, parcel, batch):
        submitted.append(batch)
        future = Future()
        future.set_result([f"result of {each}" for each in batch])
        return future

    engine = ExecutorEngine(SimpleNamespace(submit=submit), None, width=2, batch=3)
    results = engine.run(range(12))
    assert len(next(results)) == 3
    assert submitted == [[0, 1, 2], [3, 4, 5]]
    # What comes back at once is followed by twice as many.
    assert len(list(results)) == 2
    assert submitted[2:] == [[6, 7, 8, 9, 10, 11]]


@pytest.mark.parametrize(
    ("inside", "minima", "known", "optimum"),
    [
        (1.0 + 0.9e-5, [], None, 1.0 + 0.9e-5),
        (1.0 + 1.1e-5, [1.1] * 5, None, 1.1),
        (1.0 + 1.1e-5, [1.1] + [1.1 + 0.9e-5] * 4, None, 1.1),
        (1.0 + 1.1e-5, [1.1] * 4 + [1.1 + 1.1e-5], None, None),
        (2.0, [1.1] * 5, 1.0 + 0.9e-5, 1.0 + 0.9e-5),
        (2.0, [1.1] * 5, 1.1 - 0.9e-5, 1.1),
        (2.0, [1.1] * 5, 1.1 - 1.1e-5, None),
    ],
)
def test_an_optimum_is_certain_to_a_hundredth_of_the_target(
    inside, minima, known, optimum, monkeypatch
):
    """Of a target of 5e-4 from 3 to 1: a slack of 1e-5."""
    box = SimpleNamespace(from_theta=lambda theta: np.zeros(1))
    problem = SimpleNamespace(
        model=None, measurement=None, objective=None, space=box, evaluate=lambda x: inside,
        lower=np.zeros(1), upper=np.ones(1),
    )  # fmt: skip
    best = SimpleNamespace(theta=np.zeros(1), cost=1.0)
    monkeypatch.setattr(plans, "fit", lambda *given: best)
    monkeypatch.setattr(plans, "minima_in_box", lambda problem: np.array(minima))
    assert plans._optimum(problem, 3.0, known, 5e-4) == optimum
