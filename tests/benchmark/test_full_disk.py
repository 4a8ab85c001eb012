"""A full disk costs what was not yet acknowledged.

The same command goes on with every finished trial.
"""

import shutil
import sqlite3
from contextlib import suppress

import pytest
from benchmark_fakes import Walk, small_study
from full_disk import Disk, filling, system
from test_store import result

from soaked import soaked
from springpot.benchmark import Store
from springpot.errors import StudyError

pytestmark = pytest.mark.skipif(
    system() is None, reason="SQLite's table of system calls is out of reach here"
)
ROUNDS, EACH = 2, 10


@pytest.fixture(scope="module")
def plan():
    return small_study(repetitions=ROUNDS * EACH, optimisers=[Walk()]).plan()


def work(path, plan, acknowledged):
    """What a run does to its store; trials are entered in `acknowledged` once they are kept."""
    with Store(path, write=True) as store:
        cells = store.register(plan, {})
        assert acknowledged <= {(cell, r) for cell in cells for r in store.finished(cells[cell])}
        for first in range(0, ROUNDS * EACH, EACH):
            wanted = [
                (c, r)
                for c in cells
                for r in range(first, first + EACH)
                if r not in store.finished(cells[c])
            ]
            store.add([result(r, cell=c) for c, r in wanted], cells)
            acknowledged |= set(wanted)


def failing(action, *given):
    """What it says where it fails."""
    try:
        action(*given)
    except StudyError as error:
        return str(error)
    return ""


def states(path):
    with Store(path) as store:
        return [
            (row.repetition, row.status, row.best) for _, rows in store.trials() for row in rows
        ]


def writes_of(action):
    disk = Disk(float("inf"))
    with filling(disk):
        action()
    return disk.writes


@pytest.fixture(scope="module")
def undisturbed(plan, tmp_path_factory):
    """Where a run keeps what it does, and the number of its writes."""
    path = tmp_path_factory.mktemp("undisturbed") / "small.sqlite"
    return path, writes_of(lambda: work(path, plan, set()))


@pytest.mark.soak_cases("True")
@pytest.mark.parametrize("lasting", [True, soaked(False)])
def test_whichever_write_finds_the_disk_full_the_same_command_goes_on(
    plan, undisturbed, tmp_path, capfd, lasting
):
    whole, writes = undisturbed
    assert writes > 50
    for room in range(writes):
        path, kept = tmp_path / str(room) / "small.sqlite", set()
        with filling(Disk(room, lasting)):
            told = failing(work, path, plan, kept)
        assert "damaged" not in told
        work(path, plan, kept)
        assert states(path) == states(whole)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("step", [9, soaked(1)])
def test_whichever_write_finds_the_disk_full_while_a_store_is_mended_no_trial_is_lost(
    undisturbed, tmp_path, step
):
    whole, _ = undisturbed
    damaged = shutil.copy(whole, tmp_path / "damaged.sqlite")
    with sqlite3.connect(damaged) as db:
        (page,) = db.execute(
            "SELECT rootpage FROM sqlite_master WHERE name = 'sqlite_autoindex_cell_1'"
        ).fetchone()
        (size,) = db.execute("PRAGMA page_size").fetchone()
    db.close()
    with damaged.open("r+b") as file:
        file.seek((page - 1) * size)
        file.write(bytes(size))
    mended = tmp_path / "mended.sqlite"
    shutil.copy(damaged, mended)
    for room in range(0, writes_of(lambda: Store(mended, write=True, mend=True).close()), step):
        path = tmp_path / f"{room}.sqlite"
        shutil.copy(damaged, path)
        with filling(Disk(room)), suppress(StudyError):
            Store(path, write=True, mend=True).close()
        Store(path, write=True, mend=True).close()
        assert states(path) == states(whole)
