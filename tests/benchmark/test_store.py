"""The store: keeps everything once, survives, and says in one line why it cannot be used."""

import sqlite3
from dataclasses import replace
from multiprocessing import get_context

import numpy as np
import pytest
from benchmark_fakes import small_study
from hypothesis import given, settings, strategies as st

from springpot.benchmark import Status, Store
from springpot.benchmark.schema import SCHEMA
from springpot.benchmark.trial import TrialResult, pack, unpack
from springpot.errors import StudyError


@pytest.fixture
def path(tmp_path):
    return tmp_path / "small" / "small.sqlite"


def result(repetition=0, best=1.0, cell=0):
    trace = pack([(1, 9.0), (7, best)])
    return TrialResult(
        cell, repetition, Status.BUDGET, best=best, theta={"k": 1 / 3}, evaluations=9, trace=trace
    )


@settings(deadline=None)
@given(st.lists(st.floats(allow_nan=False, width=64), max_size=30), st.integers(1, 10**6))
def test_a_trace_is_kept_to_the_last_bit(values, step):
    trace = [(1 + i * step, value) for i, value in enumerate(values)]
    evaluations, kept = unpack(pack(trace))
    assert list(zip(evaluations.tolist(), kept.tolist(), strict=True)) == trace


def test_what_is_put_in_comes_out(path):
    plan = small_study().plan()
    with Store(path, write=True) as store:
        cells = store.register(plan, {"numpy": "9"})
        store.add([result(), result(1)], cells)
        store.add([TrialResult(1, 0, Status.CRASH, "gone", seconds=2.0)], cells)
    with Store(path) as store:
        assert store.facts()["numpy"] == "9"
        assert [cell.label for cell in store.cells()] == ["walk", "walk-slow"] * 4
        found = dict(store.trials())
    first, second = found[cells[0]]
    assert (first.best, first.theta, first.status) == (1.0, {"k": 1 / 3}, Status.BUDGET)
    assert first.improvements()[0].tolist() == [1, 7]
    assert second.repetition == 1
    (failed,) = found[cells[1]]
    assert (failed.status, failed.reason, failed.best, failed.trace) == (
        Status.CRASH,
        "gone",
        None,
        b"",
    )


def test_numbers_of_another_kind_are_no_damage(path, capfd):
    """SQLite gives 6.0 back for the 6 of a real column, and knows no numbers of NumPy."""
    plan = small_study().plan()
    first = replace(plan.cases[0], reference=7, known=np.float32(1.0))
    plan = replace(plan, cases=(first, *plan.cases[1:]), budget=np.int64(300))
    with Store(path, write=True) as store:
        cells = store.register(plan, {})
        store.add([TrialResult(0, 0, Status.TIMEOUT, "late", seconds=6)], cells)
        store.add(
            [replace(result(1), best=np.float32(2.0), evaluations=np.int64(9), processor=1)], cells
        )
    with Store(path) as store:
        late, other = dict(store.trials())[cells[0]]
    assert (late.status, late.seconds) == (Status.TIMEOUT, 6.0)
    assert (other.best, other.evaluations, other.processor) == (2.0, 9, 1.0)
    assert capfd.readouterr().err == ""


def test_the_first_result_of_a_trial_stays(path):
    with Store(path, write=True) as one, Store(path, write=True) as other:
        cells = one.register(small_study().plan(), {})
        assert other.register(small_study().plan(), {}) == cells
        one.add([result(best=1.0)], cells)
        other.add([result(best=2.0), result(1)], cells)
        assert one.finished(cells[0]) == {0, 1}
    with Store(path) as store:
        assert [row.best for row in dict(store.trials())[cells[0]]] == [1.0, 1.0]


def test_tables_show_the_study_as_it_was_last_run(path):
    with Store(path, write=True) as store:
        cells = store.register(small_study().plan(), {})
        store.add([result(0), result(3)], cells)
        store.register(small_study(repetitions=2, models=["own"]).plan(), {})
    with Store(path) as store:
        assert len(store.cells()) == 4
        assert [len(rows) for _, rows in store.trials()] == [1]


def test_half_a_transaction_is_none(path):
    def broken():
        yield result(0)
        raise KeyboardInterrupt

    with Store(path, write=True) as store:
        cells = store.register(small_study().plan(), {})
        with pytest.raises(KeyboardInterrupt):
            store.add(broken(), cells)
        assert store.finished(cells[0]) == set()
        store.add([result(0)], cells)
        assert store.finished(cells[0]) == {0}


def test_no_results_yet(path):
    with pytest.raises(StudyError, match="there are no results at"):
        Store(path)


@pytest.mark.parametrize(
    ("version", "told"),
    [
        (SCHEMA + 1, r"newer springpot \(schema {}\): update springpot$"),
        (SCHEMA - 1, r"older springpot \(schema {}\), .*: move it away and run the study again$"),
    ],
)
def test_a_newer_store_and_an_older_one_are_one_line(path, version, told):
    """What was run is neither run again in silence nor taken for trials of other digests."""
    Store(path, write=True).close()
    with sqlite3.connect(path) as db:
        db.execute(f"PRAGMA user_version = {version}")
    before = path.read_bytes()
    for write in (False, True):
        with pytest.raises(StudyError, match=told.format(version)):
            Store(path, write=write)
    assert path.read_bytes() == before


@pytest.mark.parametrize("write", [False, True])
def test_garbage_and_strangers_are_one_line(path, write):
    path.parent.mkdir()
    path.write_bytes(b"not a database at all " * 100)
    with pytest.raises(StudyError, match="damaged or no study store"):
        Store(path, write=write)
    path.unlink()
    with sqlite3.connect(path) as db:
        db.execute("CREATE TABLE recipes (name TEXT)")
    with pytest.raises(StudyError, match="no study store"):
        Store(path, write=write)


def read_all(path):
    with Store(path) as store:
        return store.cells(), store.bests(), list(store.trials())


@pytest.mark.parametrize("part", [0.15, 0.4, 0.7, 0.95])
def test_a_truncated_store_is_one_line(path, part):
    with Store(path, write=True) as store:
        cells = store.register(small_study().plan(), {})
        store.add([result(r, cell=c) for c in cells for r in range(200)], cells)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(part * len(whole))])
    with pytest.raises(StudyError, match="damaged or no study store") as caught:
        read_all(path)
    assert "\n" not in str(caught.value)


def test_a_full_disk_is_one_line_and_keeps_what_is_there(path):
    with Store(path, write=True) as store:
        cells = store.register(small_study().plan(), {})
        store.add([result(0)], cells)
        pages = store._db.execute("PRAGMA page_count").fetchone()[0]
        store._db.execute(f"PRAGMA max_page_count = {pages}")
        with pytest.raises(StudyError, match="the disk is full"):
            store.add([result(r) for r in range(1, 2000)], cells)
        assert store.finished(cells[0]) == {0}


def test_a_place_that_cannot_be_written_is_one_line(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(StudyError, match="cannot write"):
        Store(tmp_path / "file" / "small.sqlite", write=True)


def test_a_read_only_database_is_one_line(path, monkeypatch):
    Store(path, write=True).close()
    with Store(path) as store, pytest.raises(StudyError, match="no permission"):
        store.register(small_study().plan(), {})


def opens(path, barrier, told):
    """What a program of several does that start at the same moment."""
    barrier.wait()
    try:
        with Store(path, write=True) as store:
            cells = store.register(small_study().plan(), {})
            store.add([result()], cells)
        told.put("")
    except StudyError as error:
        told.put(str(error))


@pytest.mark.soak_cases("4")
@pytest.mark.parametrize("attempts", [4, pytest.param(25, marks=pytest.mark.soak)])
def test_programs_that_create_one_store_at_the_same_moment_all_succeed(tmp_path, attempts):
    context, several = get_context("fork"), 4
    barrier, told = context.Barrier(several), context.Queue()
    for attempt in range(attempts):
        path = tmp_path / str(attempt) / "small.sqlite"
        programs = [
            context.Process(target=opens, args=(path, barrier, told)) for _ in range(several)
        ]
        for program in programs:
            program.start()
        assert [told.get(timeout=60) for _ in programs] == [""] * several
        for program in programs:
            program.join()


@pytest.mark.soak
def test_a_reader_is_not_disturbed_by_a_study_that_starts_meanwhile(path):
    """It sees the store as it was, although the writer folds its log into the file repeatedly."""
    with Store(path, write=True) as store:
        cells = store.register(small_study().plan(), {})
        store.add([result(r, cell=c) for c in cells for r in range(100)], cells)
        store.register(small_study(repetitions=1000).plan(), {})
    with Store(path) as reader:
        trials = reader.trials()
        first = next(trials)
        with Store(path, write=True) as writer:
            for start in range(100, 1000, 100):
                writer.add(
                    [result(r, cell=c) for c in cells for r in range(start, start + 100)], cells
                )
                writer._db.execute("PRAGMA wal_checkpoint")
        assert [len(rows) for _, rows in [first, *trials]] == [100] * len(cells)
    with Store(path) as reader:
        assert [len(rows) for _, rows in reader.trials()] == [1000] * len(cells)


def test_a_damaged_trial_is_no_best_of_its_draw(path):
    """Of each repetition the best of its problem's cells, whose rows are whole."""
    plan = small_study().plan()
    with Store(path, write=True) as store:
        cells = store.register(plan, {})
        rows = [result(0, 4.0), result(1, 2.0), result(0, 1.0, 1), result(1, 3.0, 1)]
        store.add([replace(row, reference=5.0) for row in rows], cells)
        whole = store.bests_of_draws()
    assert set(whole.values()) == {1.0, 2.0}
    with sqlite3.connect(path) as db:
        db.execute("UPDATE trial SET best = 0.5 WHERE best = 3.0")
        db.execute("UPDATE trial SET best = 0.25 WHERE best = 1.0")
    with Store(path) as store:
        assert set(store.bests_of_draws().values()) == {4.0, 2.0}


@pytest.fixture
def three(path):
    plan = small_study().plan()
    with Store(path, write=True) as store:
        cells = store.register(plan, {})
        store.add([result(0, -1.0), result(1, -0.5)], cells)
        store.add([TrialResult(0, 2, Status.CRASH, "gone", seconds=2.0)], cells)
    return path, cells[0]


def test_trials_are_told_one_by_one_or_by_columns(three):
    path, cell = three
    with Store(path) as store:
        trials = dict(store.trials())[cell]
    rows = list(trials)
    assert [trials[i] for i in range(len(trials))] == rows
    assert list(trials[1:]) == rows[1:]
    assert trials.failed.tolist() == [False, False, True]
    np.testing.assert_array_equal(trials.numbers("best"), [-1.0, -0.5, np.nan])
    assert trials.column("repetition") == (0, 1, 2)


def test_a_best_value_is_believed_only_with_its_seal(three):
    path, _ = three
    with Store(path) as store:
        number, known = store.cells()[0].problem.id, store.bests()
    assert known[number] == -1.0
    with sqlite3.connect(path) as db:
        db.execute("UPDATE trial SET best = -1e9 WHERE repetition = 0")
    with Store(path) as store:
        assert store.bests()[number] == -0.5
