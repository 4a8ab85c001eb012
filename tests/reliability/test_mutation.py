"""The tool that tests the tests: what it changes, and what it leaves alone."""

import ast

import numpy as np
import pytest
from mutation import ROOT, changes_of, drawn, room_of


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
    ],
)
def test_texts_and_annotations_are_left_alone(text):
    assert changes_of(text + "\n") == []


def test_each_change_is_one_line_that_python_reads_and_that_differs():
    for mutant in drawn(np.random.default_rng(1), 40):
        text = (ROOT / mutant.path).read_text()
        changed = mutant.change.made(text)
        ast.parse(changed)
        assert (
            sum(a != b for a, b in zip(text.splitlines(), changed.splitlines(), strict=True)) == 1
        )


def test_changes_are_spread_over_the_rooms():
    rooms = {room_of(mutant.path) for mutant in drawn(np.random.default_rng(1), 40)}
    assert len(rooms) >= 10


def test_the_same_seed_draws_the_same_changes():
    first, second = (list(drawn(np.random.default_rng(5), 5)) for _ in range(2))
    assert first == second
