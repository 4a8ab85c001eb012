"""Answers stay what they were: `python tests/golden` tells what moved, `--update` accepts it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from bare import every, told
from cases import CASES

from answers import asked, cases_of, gist, kept, moved, same

ONE_IN = 10
"""The suite asks each tenth question, the soak all of them."""
WITHIN = 0.02
"""Relative difference that another machine's rounding may make of a fit's error or a noise floor.
"""


def questions():
    for kind in CASES:
        for number, case in enumerate(cases_of(kind)):
            marks = [pytest.mark.soak] if number % ONE_IN else []
            yield pytest.param(kind, case, id=case.name.replace(" ", "-"), marks=marks)


@pytest.mark.soak_cases(
    "artificial-fractional-zener-noise2-by-springpot",
    "fractional-zener-hides-time-delay",
    "fractional-maxwell-hides-inertia",
    "any-material-hides-time-delay",
    "artificial-fractional-kelvin4-noise1-as-springpot",
    "sweep-hides-inertia-beside-a-relaxation",
)
@pytest.mark.parametrize(("kind", "case"), list(questions()))
def test_verdict_named_class_and_errors_are_the_committed_ones(kind, case, tmp_path):
    before, after = gist(kept(kind)[case.name]), gist(asked(case, tmp_path))
    assert {key for key in before if not same(before[key], after[key], WITHIN)} == set(), (
        before,
        after,
    )


FEW = (
    "fractional-kelvin hides inertia",
    "artificial-springpot-noise2 by springpot",
    "relaxation of nothing hidden",
)


def tens():
    """All questions, ten at a time: the suite asks the few of them."""
    names = [case.name for case in every()]
    for number in range(0, len(names), 10):
        yield pytest.param(names[number : number + 10], marks=pytest.mark.soak)


@pytest.mark.soak_cases("names0")
@pytest.mark.parametrize("names", [FEW, *tens()])
def test_answers_need_no_threads_no_processes_and_no_library_of_optimisers(names, tmp_path):
    """Bit for bit: what runs where a browser runs Python."""
    cases = [case for case in every() if case.name in names]
    bare = subprocess.run(
        [sys.executable, str(Path(__file__).with_name("bare.py")), *(case.name for case in cases)],
        check=True,
        capture_output=True,
        text=True,
    )
    assert bare.stdout.splitlines() == [told(case, tmp_path) for case in cases]


def test_each_question_has_a_committed_answer_and_each_answer_its_question():
    for kind in CASES:
        assert [case.name for case in cases_of(kind)] == list(kept(kind))


def test_there_are_sixty_diagnoses_thirty_fits_and_twenty_tests_in_time():
    assert [len(cases_of(kind)) for kind in CASES] == [60, 30, 20]


def test_what_moved_is_told_by_its_place():
    before = {"verdict": "adequate", "candidates": [{"effect": "inertia", "score": 2.0}]}
    after = {
        "verdict": "adequate",
        "candidates": [{"effect": "inertia", "score": 3.0}],
        "split": "",
    }
    assert list(moved(before, after)) == [
        "candidates[inertia].score: 2.0 -> 3.0",
        "split: None -> ''",
    ]
    assert list(moved(before, before)) == []
