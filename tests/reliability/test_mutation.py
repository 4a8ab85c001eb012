"""The tool that tests the tests: what it changes, and what it leaves alone."""

import ast
import re

import mutation
import numpy as np
import pytest
import soak_mutants
from mutation import (
    AMISS,
    PACKAGE,
    ROOT,
    Change,
    Copy,
    Mutant,
    changes_of,
    drawn,
    examples,
    in_order,
    own_tests,
    room_of,
)


@pytest.mark.parametrize(
    ("line", "after"),
    [
        ("a < b", "a <= b"),
        ("a + b", "(a - b)"),
        ("a and b", "(a or b)"),
        ("not a", "bool(a)"),
        ("x = 3", "6"),
        ("x = 0", "1"),
        ("x = True", "False"),
        ("def f(damping: float = 0.0): ...", "1.0"),
    ],
)
def test_a_change_is_one_that_a_tired_hand_could_make(line, after):
    assert after in [change.after for change in changes_of(line + "\n")]


@pytest.mark.parametrize(
    "text",
    [
        '"""Says 3 < 4."""',
        "def f(a: int | None = None) -> int | str: ...",
        'raise ValueError(f"{3 < 4}")',
        '"a" + "b"',
        "LEVEL = 0.05",
        "LEVEL = -0.05",
        "def f(draws: int = 1000): ...",
        "x = max(y, 1e-300)",
        "for a, b in zip(x, y, strict=True): ...",
    ],
)
def test_texts_annotations_and_settings_are_left_alone(text):
    assert changes_of(text + "\n") == []


@pytest.mark.parametrize(
    ("line", "after"), [("x or 1.0", "(x and 1.0)"), ("x < 1e-6", "x <= 1e-06")]
)
def test_a_guard_and_a_tolerance_keep_their_numbers(line, after):
    assert [change.after for change in changes_of(line + "\n")] == [after]


def test_examples_in_a_file_are_tests_of_its_room():
    [named] = examples(PACKAGE / "rheology" / "points.py")
    assert named == "tests/test_docstrings.py::test_examples_run[springpot.rheology.points]"
    assert examples(PACKAGE / "__main__.py") == []


@pytest.fixture(scope="module")
def forty():
    return list(drawn(np.random.default_rng(1), 40))


@pytest.mark.soak
def test_each_change_is_one_line_that_python_reads_and_that_differs(forty):
    for mutant in forty:
        text = (ROOT / mutant.path).read_text()
        changed = mutant.change.made(text)
        ast.parse(changed)
        assert (
            sum(a != b for a, b in zip(text.splitlines(), changed.splitlines(), strict=True)) == 1
        )


@pytest.mark.soak
def test_changes_are_spread_over_the_rooms(forty):
    rooms = {room_of(mutant.path) for mutant in forty}
    assert len(rooms) >= 10


@pytest.mark.soak
def test_the_same_seed_draws_the_same_changes():
    first, second = (list(drawn(np.random.default_rng(5), 5)) for _ in range(2))
    assert first == second


def test_every_room_has_tests_of_its_own():
    rooms = {room_of(path.relative_to(ROOT)) for path in (ROOT / PACKAGE).rglob("*.py")}
    assert [room for room in sorted(rooms) if not own_tests(room)] == []


def test_files_of_tests_that_name_what_was_changed_run_first():
    path = PACKAGE / "structure" / "frame.py"
    lines = (ROOT / path).read_text().splitlines()
    within = next(i for i, line in enumerate(lines, 1) if "def modes_of(" in line) + 20
    found = in_order(own_tests("structure"), Mutant(path, Change(within, 0, 0, "", "")))
    assert sorted(found) == own_tests("structure")
    texts = [(ROOT / file).read_text() for file in found]
    named = [sum(bool(re.search(rf"\b{w}\b", t)) for w in ("frame", "modes_of")) for t in texts]
    assert named[0] > named[-1]
    assert named == sorted(named, reverse=True)


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """A room with one test that sees a function, and one that always fails."""
    package, tests = tmp_path / PACKAGE / "room", tmp_path / "tests" / "room"
    for folder in (package, tests):
        folder.mkdir(parents=True)
    (package.parent / "__init__.py").write_text("")
    (package / "sums.py").write_text("def twice(x):\n    return x + x\n")
    head = "from springpot.room.sums import twice\n\n\ndef test_it():\n    assert "
    (tests / "test_a.py").write_text(f"{head}0\n")
    (tests / "test_b.py").write_text(f"{head}twice(2) == 4\n")
    monkeypatch.setattr(mutation, "ROOT", tmp_path)
    return Copy(tmp_path / "folder")


SUMS = PACKAGE / "room" / "sums.py"
TURNED = Mutant(SUMS, Change(2, 11, 16, "x + x", "x - x"))
FIRST, SECOND = (f"tests/room/test_{name}.py::test_it" for name in "ab")


@pytest.mark.soak
def test_the_first_failing_test_is_told_of_those_that_can_pass(copy):
    copy.failing.add(FIRST)
    assert copy._run(*own_tests("room")) == ""
    with copy._made(TURNED):
        assert copy._run(*own_tests("room")) == SECOND
    assert (copy.folder / SUMS).read_text() == (mutation.ROOT / SUMS).read_text()


@pytest.mark.parametrize(
    ("runs", "by", "failing"),
    [
        ([""], "", set()),
        ([SECOND, ""], SECOND, set()),
        # It fails without the change, too: the others are asked anew.
        ([FIRST, FIRST, SECOND, ""], SECOND, {FIRST}),
        ([FIRST, FIRST, ""], "", {FIRST}),
        ([AMISS], AMISS, set()),
    ],
)
def test_a_change_is_noticed_by_a_test_that_fails_with_it_alone(
    copy, monkeypatch, runs, by, failing
):
    monkeypatch.setattr(copy, "_run", lambda *options: runs.pop(0))
    assert copy.notices(TURNED) == by
    assert (copy.failing, runs) == (failing, [])


def test_a_file_of_tests_that_cannot_be_read_is_left_out(copy, monkeypatch):
    """Whatever is deselected in it, it would fail again and again."""
    unread, asked = FIRST.partition("::")[0], []
    runs = [unread, unread, ""]
    monkeypatch.setattr(copy, "_run", lambda *options: asked.append(options) or runs.pop(0))
    assert copy.notices(TURNED) == ""
    assert copy.failing == {unread}
    assert [unread in options for options in asked] == [True, True, False]
    assert SECOND.partition("::")[0] in asked[-1]


def test_changes_that_change_nothing_are_told_of_and_not_counted(monkeypatch, copy):
    monkeypatch.setattr(soak_mutants, "ROOT", mutation.ROOT)
    lost = [TURNED] * 3
    row = soak_mutants.counted(20, lost, {FIRST})
    assert row.held == 1
    assert row.measured.startswith("17 of 20, of all but ")
    assert row.measured.count("room/sums.py:2 `x + x` to `x - x`") == 3
    assert FIRST in row.measured
    assert soak_mutants.counted(20, [TURNED] * 4, ()).held == 0
    known = {("room/sums.py", "return x + x", "x - x"): "no sum matters"}
    monkeypatch.setattr(soak_mutants, "HARMLESS", known)
    row = soak_mutants.counted(20, [TURNED] * 4, ())
    assert row.held == 1
    assert "not noticed: none; not noticed either" in row.measured
    assert "`x - x` (no sum matters)" in row.measured


def test_a_change_that_is_called_harmless_is_of_a_line_that_stands_there():
    gone = [
        (place, line)
        for place, line, _ in soak_mutants.HARMLESS
        if "".join(line.split()) not in "".join((ROOT / PACKAGE / place).read_text("utf-8").split())
    ]
    assert gone == []
