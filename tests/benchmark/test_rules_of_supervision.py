"""What the coordinator of workers does of each word, by hand: no process is started."""

from __future__ import annotations

import pickle
from types import SimpleNamespace

import pytest

from springpot.benchmark import supervisor
from springpot.benchmark.plan import WorkOrder
from springpot.benchmark.supervisor import Backlog, LocalEngine, Worker
from springpot.benchmark.trial import Status, TrialResult
from springpot.errors import StudyError

NOW = 1000.0


class Line:
    """A worker's or the server's line, from which given words come."""

    def __init__(self, *words):
        self.words, self.sent, self.closed = list(words), [], False

    def poll(self):
        return bool(self.words)

    def recv_bytes(self):
        word = self.words.pop(0)
        if isinstance(word, Exception):
            raise word
        return word

    recv = recv_bytes

    def send(self, tasks):
        self.sent.append(list(tasks))

    def close(self):
        self.closed = True


class Server:
    """A fork server that only notes what it is asked for."""

    def __init__(self, ready=True, *words):
        self.ready, self.channel = ready, Line(*words)
        self.killed, self.forked, self.closed = [], [], False

    def fork(self, number):
        self.forked.append(number)
        return Line()

    def kill(self, number):
        self.killed.append(number)

    def cause(self):
        return "signal 9"

    def close(self):
        self.closed = True


CELLS = (0, 0, 1)
"""The entrant of each cell."""


def plan_of(deadline=10.0, runs=1):
    return SimpleNamespace(
        name="made",
        deadline=deadline,
        runs_of=lambda task: runs,
        cells=[SimpleNamespace(entrant=entrant) for entrant in CELLS],
    )


def order(cell, *repetitions):
    return WorkOrder(cell, repetitions or (0,))


@pytest.fixture
def engine(monkeypatch):
    monkeypatch.setattr(supervisor, "monotonic", lambda: NOW)
    made = LocalEngine(plan_of(), None, 2)
    made._fork_server = Server()
    return made


def worker(engine, *tasks, entrant=0, since=NOW, begun=True, words=()):
    number = next(engine._numbers)
    engine._workers[number] = Worker(number, entrant, Line(*words), since=since, begun=begun)
    engine._workers[number].batches.extend([task] for task in tasks)
    return engine._workers[number]


def result(cell=0, status=Status.BUDGET):
    return TrialResult(cell, 0, status)


@pytest.mark.parametrize(
    ("mean", "running", "given"),
    [
        (0.0, 0, 1),
        (0.03, 0, 1),
        (0.03, 1, 0),
        (0.016, 0, 1),
        (0.015, 0, 2),
        (0.0099, 0, 3),
        (0.0099, 1, 3),
        (0.0099, 2, 0),
        (0.0001, 0, 32),
        (5.0, 0, 1),
        (5.0, 1, 0),
    ],
)
def test_quick_trials_are_handed_out_by_many_and_one_batch_ahead(engine, mean, running, given):
    busy = worker(engine, *[order(0)] * running)
    engine._means[0] = mean
    engine._backlog = Backlog(engine._plan, [order(0, i) for i in range(100)])
    engine._fill(busy)
    assert sum(map(len, busy.connection.sent)) == given
    assert sum(map(len, busy.batches)) == running + given


def test_a_batch_has_the_time_of_one_trial_and_none_is_made_of_who_failed_in_one(engine):
    engine._means[0] = 0.001
    assert engine._depth(0) == 30
    engine._plan.deadline = 0.04
    assert engine._depth(0) == 10
    engine._singly.add(0)
    assert engine._depth(0) == 1


def test_a_worker_without_work_ends_where_another_s_comes_next(engine):
    idle = worker(engine)
    engine._backlog = Backlog(engine._plan, [order(2)])
    engine._fill(idle)
    assert (engine._fork_server.killed, engine._workers) == ([idle.number], {})
    engine._backlog = Backlog(engine._plan, [])
    idle = worker(engine)
    engine._fill(idle)
    assert list(engine._workers) == [idle.number]


def test_as_many_are_hired_as_there_are_places_and_tasks(engine):
    tasks = [order(0, i) for i in range(5)]
    engine._backlog = Backlog(engine._plan, tasks)
    assert engine._staff()
    assert engine._fork_server.forked == [1, 2]
    assert [each.batches[0] for each in engine._workers.values()] == [tasks[:1], tasks[1:2]]
    engine._fork_server.ready = False
    engine._workers.clear()
    assert engine._staff()
    assert engine._fork_server.forked == [1, 2]
    engine._backlog = Backlog(engine._plan, [])
    assert not engine._staff()
    worker(engine, order(0))
    assert engine._staff()


def test_a_suspect_runs_alone(engine):
    engine._suspects.append(order(2))
    busy = worker(engine, order(0))
    assert engine._staff()
    assert engine._fork_server.forked == []
    busy.batches.clear()
    assert engine._staff()
    assert engine._fork_server.killed == [busy.number]
    [only] = engine._workers.values()
    assert (only.entrant, list(only.batches), list(engine._suspects)) == (1, [[order(2)]], [])


def test_a_task_is_taken_of_its_own_entrant_alone_and_comes_back_in_order():
    backlog = Backlog(plan_of(), [order(0), order(1), order(2)])
    assert backlog.take(1) is None
    assert backlog.take(0) == order(0)
    backlog.put_back([order(0, 7), order(0, 8)])
    assert backlog.first() == order(0, 7)
    assert [backlog.take(0) for _ in range(3)] == [order(0, 7), order(0, 8), order(1)]
    assert backlog.take(0) is None
    assert backlog.take(1) == order(2)
    assert backlog.first() is None
    assert backlog.take(1) is None


def test_a_deadline_is_that_of_all_runs_and_imports_count_once(engine):
    engine._plan = plan_of(10.0, 3)
    assert engine._limit(worker(engine, order(0))) == 30.0
    fresh = worker(engine, order(0), begun=False)
    assert engine._limit(fresh) == 60.0
    engine._silent.add(0)
    assert engine._limit(fresh) == 30.0


@pytest.mark.parametrize(("ages", "seconds"), [((), 1.0), ((4.0, 7.0), 3.0), ((10.5,), 0.0)])
def test_it_waits_until_the_first_deadline(engine, ages, seconds):
    worker(engine, since=0.0)
    for age in ages:
        worker(engine, order(0), since=NOW - age)
    assert engine._patience() == pytest.approx(seconds + 0.001)


@pytest.mark.parametrize(
    ("begun", "age", "late"), [(True, 10.0, 0), (True, 10.1, 1), (False, 40.0, 0), (False, 40.1, 1)]
)
def test_who_is_late_is_ended_and_told(engine, begun, age, late, monkeypatch):
    monkeypatch.setattr(supervisor, "wait", lambda channels, timeout: [])
    slow = worker(engine, order(0, 3), order(0, 4), since=NOW - age, begun=begun)
    results = engine._listen()
    assert len(results) == late
    assert (slow.number not in engine._workers) == bool(late)
    if late:
        [found] = results
        assert (found.status, found.repetition) == (Status.TIMEOUT, 3)
        assert found.seconds == (10.0 if begun else 40.0)
        words = (
            "ended after the deadline of 10 s",
            "ended after 40 s, in which it asked for no value",
        )
        assert found.reason == words[not begun]
        assert engine._silent == (set() if begun else {0})
        assert engine._backlog.first() == order(0, 4)


@pytest.mark.parametrize(
    ("ready", "waited", "ends"), [(False, 120.0, False), (False, 120.5, True), (True, 999.0, False)]
)
def test_a_server_that_is_never_ready_ends_the_study(engine, ready, waited, ends, monkeypatch):
    monkeypatch.setattr(supervisor, "wait", lambda channels, timeout: [])
    engine._fork_server.ready, engine._asked = ready, NOW - waited
    if ends:
        with pytest.raises(StudyError, match="workers were not ready after 120 s"):
            engine._listen()
    else:
        assert engine._listen() == []


def test_the_mean_time_of_a_trial_follows_the_newest_by_a_fifth(engine):
    quick = worker(engine, order(0), order(0), since=NOW - 2.0, begun=False)
    engine._orphaned[None] = 2
    assert engine._take(quick, [[result()]], False) == [result()]
    assert (engine._means, quick.since, quick.begun) == ({0: 2.0}, NOW, True)
    assert engine._orphaned[None] == 0
    quick.since = NOW - 7.0
    engine._take(quick, [[result()]], False)
    assert engine._means == {0: pytest.approx(3.0)}
    assert list(engine._workers) == [quick.number]
    assert not quick.batches
    quick.give([order(0, 1), order(0, 2)])
    quick.since = NOW - 16.0
    assert engine._take(quick, [[result()], [result()]], False) == [result(), result()]
    assert engine._means == {0: pytest.approx(4.0)}


@pytest.mark.parametrize(
    "worn",
    [False, True],
)
def test_a_worn_process_ends(engine, worn):
    used = worker(engine, order(0), order(0, 5))
    engine._take(used, [[result()]], worn)
    assert (used.number not in engine._workers) == worn
    assert (engine._backlog.first() == order(0, 5)) == worn


@pytest.mark.parametrize("fault", ["worn", "garbled", "lost", "late", "orphaned"])
def test_a_batch_in_which_something_went_wrong_is_run_again_one_by_one(engine, fault, monkeypatch):
    monkeypatch.setattr(supervisor, "wait", lambda channels, timeout: [])
    batch = [order(0, 0), order(0, 1)]
    told = worker(engine)
    told.give(batch)
    if fault == "worn":
        found = engine._take(told, [[result()], [result()]], True)
    elif fault == "garbled":
        found = engine._garbled(told, TypeError("no results"))
    elif fault == "lost":
        found = engine._lost(told, "exit code 3")
    elif fault == "late":
        told.since = NOW - 99.0
        found = engine._listen()
    else:
        found = engine._orphan(engine._fork_server)
        assert list(engine._suspects) == batch
        engine._backlog.put_back(engine._suspects)
        engine._singly.add(0)
    assert found == []
    assert not engine._workers
    engine._means[0] = 0.001
    engine._suspects.clear()
    engine._fork_server = Server()
    assert engine._staff()
    assert [list(each.batches) for each in engine._workers.values()] == [[[one]] for one in batch]


def test_words_of_a_worker_are_heard_to_the_last(engine):
    one = pickle.dumps(([[result()]], False))
    words = (supervisor.BEGUN, one, one)
    one = worker(engine, order(0), order(0), order(0), begun=False, words=words)
    assert engine._hear(one) == [result(), result()]
    assert (len(one.batches), one.begun, one.deaf) == (1, True, False)
    one.connection.words = [EOFError()]
    assert engine._hear(one) == []
    assert (one.deaf, engine._fork_server.killed) == (True, [one.number])
    two = worker(engine, order(0, 6), order(0, 7), words=[pickle.dumps(None)])
    [found] = engine._hear(two)
    assert (found.status, found.repetition) == (Status.CRASH, 6)
    assert found.reason == "its process answered with something that is no result (TypeError)"
    assert two.number not in engine._workers
    assert engine._backlog.first() == order(0, 7)


def test_a_clock_starts_once(monkeypatch):
    monkeypatch.setattr(supervisor, "monotonic", lambda: NOW)
    one = Worker(1, 0, Line(), since=1.0)
    one.begin()
    assert one.since == NOW
    one.since = 5.0
    one.give([order(0)])
    assert one.since == NOW
    one.since = 7.0
    one.give([order(1)])
    assert (one.since, one.connection.sent) == (7.0, [[order(0)], [order(1)]])


def test_a_worker_that_ended_leaves_its_answers_and_the_trial_it_died_of(engine):
    one = pickle.dumps(([[result()]], False))
    lost = worker(engine, order(0), order(0, 1), order(0, 2), since=NOW - 3.0, words=[one])
    first, second = engine._lost(lost, "exit code 3")
    assert first == result()
    assert (second.status, second.repetition, second.reason) == (Status.CRASH, 1, "exit code 3")
    # The clock of the second started with the answer of the first.
    assert second.seconds == 0.0
    assert engine._backlog.first() == order(0, 2)
    deaf = worker(engine, words=[one])
    deaf.deaf = True
    assert engine._lost(deaf, "exit code 3") == []


def test_words_of_the_server(engine):
    one = worker(engine, order(0, 4))
    words = [
        (supervisor.BORN, one.number, 77),
        (supervisor.BORN, 99, 78),
        (supervisor.READY, 0, ""),
    ]
    engine._fork_server = Server(False, *words)
    assert engine._hear_fork_server(engine._fork_server) == []
    assert (one.pid, engine._fork_server.ready) == (77, True)
    engine._fork_server.channel.words = [
        (supervisor.ENDED, 99, "x"),
        (supervisor.ENDED, 1, "signal 11"),
    ]
    [found] = engine._hear_fork_server(engine._fork_server)
    assert (found.repetition, found.reason) == (4, "signal 11")
    engine._fork_server.channel.words = [(supervisor.BROKEN, 0, "no memory")]
    with pytest.raises(StudyError, match="study made: a worker cannot start: no memory"):
        engine._hear_fork_server(engine._fork_server)


def test_a_server_that_ends_is_laid_to_a_trial_that_ran_alone_the_third_time(engine, monkeypatch):
    ended = []
    monkeypatch.setattr(supervisor, "end_group", ended.append)
    for time in range(3):
        engine._fork_server = Server()
        alone = worker(engine, order(0), order(0, 5))
        alone.pid = 40 + time
        found = engine._orphan(engine._fork_server)
        assert len(found) == (time == 2)
        assert list(engine._suspects) == [order(0)] * (time < 2)
        engine._suspects.clear()
        assert engine._workers == {}
        assert engine._fork_server is None
    assert ended == [40, 41, 42]
    assert (found[0].status, found[0].reason) == (
        Status.CRASH,
        "it ends the server of workers (signal 9)",
    )


def test_of_several_under_way_none_is_blamed_yet(engine):
    for _ in range(5):
        engine._fork_server = Server()
        worker(engine, order(0))
        worker(engine, order(1))
        worker(engine)
        assert engine._orphan(engine._fork_server) == []
    assert list(engine._suspects) == [order(0), order(1)] * 5


def test_a_server_that_ends_between_trials_ends_the_study_the_third_time(engine):
    for _ in range(2):
        engine._fork_server = Server()
        assert engine._orphan(engine._fork_server) == []
    engine._fork_server = Server()
    with pytest.raises(StudyError, match="the server of workers ends again and again"):
        engine._orphan(engine._fork_server)
    engine._fork_server = Server(False)
    with pytest.raises(StudyError, match="workers die at the start"):
        engine._orphan(engine._fork_server)
