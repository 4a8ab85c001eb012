"""The tool that tests the tests: what it changes, and what it leaves alone."""

import ast

import numpy as np
import pytest
from mutation import (
    PACKAGE,
    ROOT,
    Change,
    Mutant,
    Room,
    changes_of,
    drawn,
    kept,
    own_tests,
    room_of,
    state_of,
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


def test_the_number_that_stands_in_for_nothing_is_a_guard():
    assert [change.after for change in changes_of("x or 1.0\n")] == ["(x and 1.0)"]


@pytest.fixture(scope="module")
def forty():
    return list(drawn(np.random.default_rng(1), 40))


def test_each_change_is_one_line_that_python_reads_and_that_differs(forty):
    for mutant in forty:
        text = (ROOT / mutant.path).read_text()
        changed = mutant.change.made(text)
        ast.parse(changed)
        assert (
            sum(a != b for a, b in zip(text.splitlines(), changed.splitlines(), strict=True)) == 1
        )


def test_changes_are_spread_over_the_rooms(forty):
    rooms = {room_of(mutant.path) for mutant in forty}
    assert len(rooms) >= 10


def test_the_same_seed_draws_the_same_changes():
    first, second = (list(drawn(np.random.default_rng(5), 5)) for _ in range(2))
    assert first == second


def test_every_room_has_tests_of_its_own():
    rooms = {room_of(path.relative_to(ROOT)) for path in (ROOT / PACKAGE).rglob("*.py")}
    assert [room for room in sorted(rooms) if not own_tests(room)] == []


def test_tests_that_enter_the_changed_function_or_start_a_process_run_the_shortest_first():
    path = PACKAGE / "rheology" / "points.py"
    tree = ast.parse((ROOT / path).read_text())
    holder = next(node for node in tree.body if isinstance(node, ast.ClassDef))
    function = next(node for node in holder.body if isinstance(node, ast.FunctionDef))
    here, beside = [str(path), f"{holder.name}.{function.name}"], [str(path), "other"]
    entered = {
        "long": {"seconds": 2.0, "entered": [beside, here], "started": False},
        "beside": {"seconds": 0.1, "entered": [beside], "started": False},
        "short": {"seconds": 1.0, "entered": [here], "started": True},
        "outside": {"seconds": 0.2, "entered": [], "started": True},
    }
    entered["fails anyway"] = entered["short"]
    entered["neither"] = {"seconds": 0.3, "entered": [beside], "started": False}
    room = Room(entered, ["fails anyway"])
    inside = Mutant(path, Change(function.body[-1].lineno, 0, 0, "", ""))
    assert room.asked(inside) == ["short", "long", "outside"]
    # What a module sets as it is loaded may be of use anywhere; where it is entered comes first.
    of_module = room.asked(Mutant(path, Change(1, 0, 0, "", "")))
    assert of_module == ["beside", "neither", "short", "long", "outside"]


def test_what_a_file_of_tests_enters_stays_known_until_it_or_what_it_shares_is_changed(tmp_path):
    own, other, shared = (tmp_path / "tests" / "room" / f"{name}.py" for name in
                          ("test_it", "test_other", "known"))  # fmt: skip
    own.parent.mkdir(parents=True)
    for path in (own, other, shared):
        path.write_text("1\n")
    made = []

    def room(seconds):
        def make():
            made.append(seconds)
            return {"seconds": seconds}

        state = state_of(tmp_path, "tests/room/test_it.py")
        return kept(tmp_path / "kept" / "test_it.json", state, make)["seconds"]

    assert room(1.0) == 1.0
    other.write_text("2\n")
    assert room(2.0) == 1.0
    own.write_text("2\n")
    assert room(3.0) == 3.0
    shared.write_text("2\n")
    assert room(4.0) == 4.0
    assert made == [1.0, 3.0, 4.0]
