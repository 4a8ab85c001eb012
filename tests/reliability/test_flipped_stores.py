"""A store knows itself: it tells damage in one line, uses the rest; --retry-failed mends it."""

import sqlite3
import subprocess
import sys

import numpy as np
import pytest
from flipped_stores import HARMLESS, SAME, copy_of, flip, look, mended, pristine, study, verdict

from springpot.benchmark import Store, run_study
from springpot.errors import StudyError


@pytest.fixture(scope="module")
def sound(tmp_path_factory):
    return pristine(tmp_path_factory.mktemp("sound"))


@pytest.mark.suite_cases(*map(str, range(1, 9)))
@pytest.mark.parametrize("seed", range(25))
def test_a_flipped_bit_is_never_a_fault_and_never_another_number(sound, tmp_path, seed):
    path, seen = sound
    target = copy_of(path, tmp_path)
    flip(path.read_bytes(), target, np.random.default_rng(seed))
    found = verdict(target, seen)
    assert found in HARMLESS
    assert found == SAME or mended(target, seen)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            "UPDATE trial SET best = best * 0.9 WHERE cell = 2 AND repetition = 3",
            "innocent 2 on kelvin",
        ),
        (
            "UPDATE trial SET status = 'target' WHERE cell = 2 AND repetition = 3",
            "innocent 2 on kelvin",
        ),
        (
            "UPDATE trial SET status = 'nonsense' WHERE cell = 2 AND repetition = 3",
            "repetition 3 is damaged",
        ),
        (
            "UPDATE trace SET points = zeroblob(20) WHERE cell = 2 AND repetition = 3",
            "innocent 2 on kelvin",
        ),
        ("DELETE FROM trace WHERE cell = 2 AND repetition = 3", "innocent 2 on kelvin"),
        ("UPDATE trace SET seen = x'00' WHERE cell = 2 AND repetition = 3", "innocent 2 on kelvin"),
    ],
)
def test_a_damaged_trial_is_named_the_rest_is_used_and_a_run_mends_it(
    sound, tmp_path, change, told
):
    path, seen = sound
    target = copy_of(path, tmp_path)
    with sqlite3.connect(target) as db:
        assert db.execute(change).rowcount == 1
    db.close()
    found = look(target)
    assert told in found.told
    assert found.told.count("\n") == 1
    assert found.trials.keys() == seen.trials.keys() - {("innocent 2", 3)}
    assert found.trials.items() <= seen.trials.items()
    assert found.failed == 1
    outcome = run_study(
        study(), engine="serial", out=tmp_path, quiet=True, retry_failed=True, tables=False
    )
    assert outcome.ran == 1
    assert look(target) == seen


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE cell SET options = '{}' WHERE id = 1",
        "UPDATE problem SET reference = 1.0",
        "UPDATE cell SET problem = 7",
    ],
)
def test_a_damaged_cell_or_problem_is_left_out_and_written_again(sound, tmp_path, change):
    path, seen = sound
    target = copy_of(path, tmp_path)
    with sqlite3.connect(target) as db:
        db.execute(change)
    db.close()
    found = look(target)
    assert found.told.count("\n") == 1
    assert found.trials.items() < seen.trials.items()
    assert run_study(study(), engine="serial", out=tmp_path, quiet=True, tables=False).ran == 0
    assert look(target) == seen


def test_a_damaged_description_is_one_line_and_a_run_writes_it_again(sound, tmp_path):
    path, seen = sound
    target = copy_of(path, tmp_path)
    with sqlite3.connect(target) as db:
        db.execute("UPDATE fact SET value = '1e-3' WHERE name = 'target'")
    db.close()
    with pytest.raises(
        StudyError, match="description of the study is damaged: run the study again"
    ):
        look(target)
    assert run_study(study(), engine="serial", out=tmp_path, quiet=True, tables=False).ran == 0
    assert look(target) == seen


@pytest.mark.parametrize("mode", ["delete", "wal"])
def test_a_database_of_another_program_is_refused_untouched(tmp_path, mode):
    path = tmp_path / "flips" / "flips.sqlite"
    path.parent.mkdir()
    with sqlite3.connect(path) as db:
        db.execute(f"PRAGMA journal_mode = {mode}")
        db.execute("CREATE TABLE bookmark (address TEXT)")
        db.execute("INSERT INTO bookmark VALUES ('https://example.org')")
    db.close()
    before = path.read_bytes()
    for write in (True, False):
        with pytest.raises(StudyError, match="no study store: move it away"):
            Store(path, write=write)
    assert path.read_bytes() == before
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize("version", [0, 1, 3])
def test_so_is_one_whose_tables_are_still_in_its_log(tmp_path, version):
    """As of a program that has just begun, and runs meanwhile."""
    path = tmp_path / "theirs.sqlite"
    theirs = sqlite3.connect(path, isolation_level=None)
    theirs.execute("PRAGMA journal_mode = wal")
    theirs.execute(f"PRAGMA user_version = {version}")
    theirs.execute("CREATE TABLE bookmark (address TEXT)")
    theirs.execute("INSERT INTO bookmark VALUES ('https://example.org')")
    before = path.read_bytes(), path.with_name("theirs.sqlite-wal").read_bytes()
    for mend in (False, True):
        with pytest.raises(StudyError, match="no study store: move it away"):
            Store(path, write=True, mend=mend)
    assert (path.read_bytes(), path.with_name("theirs.sqlite-wal").read_bytes()) == before
    assert theirs.execute("SELECT * FROM bookmark").fetchall() == [("https://example.org",)]
    theirs.close()


def test_a_store_in_which_nothing_is_yet_is_one_line(tmp_path):
    """As a run leaves it that is killed in its first moment."""
    path = tmp_path / "flips" / "flips.sqlite"
    Store(path, write=True).close()
    with pytest.raises(StudyError, match=r"there are no results at .* yet: run the study first"):
        look(path)


@pytest.mark.suite_cases("2")
@pytest.mark.parametrize("seed", range(6))
def test_a_flipped_bit_in_the_log_of_a_killed_run_costs_trials_and_never_changes_one(
    tmp_path, sound, seed
):
    target = tmp_path / "flips" / "flips.sqlite"
    # Whoever has it open keeps the log from being folded into the file, as does who kills the run.
    with Store(target, write=True):
        run_study(study(), engine="serial", out=tmp_path, quiet=True, tables=False)
        parts = {
            name: target.with_name(name).read_bytes()
            for name in ("flips.sqlite", "flips.sqlite-wal")
        }
    assert len(parts["flips.sqlite-wal"]) > 10 * len(parts["flips.sqlite"])
    for name, content in parts.items():
        target.with_name(name).write_bytes(content)
    log = target.with_name("flips.sqlite-wal")
    flip(parts[log.name], log, np.random.default_rng(seed))
    found, told = {}, ""
    try:
        found = look(target).trials
    except StudyError as error:
        told = str(error)
    assert "\n" not in told
    assert found.items() <= sound[1].trials.items()
    run_study(study(), engine="serial", out=tmp_path, quiet=True, tables=False)
    assert look(target).trials == sound[1].trials


@pytest.mark.soak
def test_the_command_tells_of_damage_in_one_line(sound, tmp_path):
    path, _ = sound
    target = copy_of(path, tmp_path)
    with sqlite3.connect(target) as db:
        db.execute("UPDATE trial SET evaluations = 1 WHERE cell = 1 AND repetition = 0")
    db.close()
    command = [
        sys.executable,
        "-m",
        "springpot",
        "tables",
        str(target),
        "--table",
        "failures",
        "--json",
    ]
    done = subprocess.run(command, text=True, capture_output=True)
    assert done.returncode == 0
    assert done.stderr.count("\n") == 1
    assert (
        "the trial innocent 1 on kelvin, fractional-kelvin, repetition 0 is damaged" in done.stderr
    )
    assert "--retry-failed runs it again" in done.stdout
