"""Tests of one specimen with something hidden in one or in all, computed outside springpot."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

STUDIES = Path(__file__).resolve().parents[1] / "studies"
sys.path.insert(0, str(STUDIES))

from hidden_effects_time.joint import GROUPS, HIDDEN, drawn_case, drawn_specimen  # noqa: E402
from hidden_effects_time.joint_report import JointVerdict, judged, write_joint  # noqa: E402
from hidden_effects_time.judge import NAMED, library  # noqa: E402
from springpot.measurement import Measurement  # noqa: E402
from springpot.registry import parse_model  # noqa: E402

SEED = 1
CASES = (0, 1, 6)
"""What yields in the rig of a sweep, a slow mode of the material in two tests, and nothing.
"""


@pytest.fixture(scope="module")
def verdicts():
    effects = library()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return [judged(drawn_case(SEED, index), index, effects) for index in CASES]


def test_what_several_tests_miss_is_named_and_nothing_else(verdicts):
    plain = [each for each in verdicts if each.hidden]
    assert all(each.visible >= NAMED and each.right for each in plain)
    clean = [each for each in verdicts if not each.hidden]
    assert len(clean) == 1
    assert not any(each.flagged for each in clean)


def test_the_joint_tables_count_all_cases(verdicts, tmp_path):
    write_joint(verdicts, tmp_path, SEED)
    text = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert f"--joint --cases {len(CASES)} --seed {SEED}" in text
    assert "| confidently wrong | 0.0 % | 3 |" in text
    again = [JointVerdict.from_dict(each.to_dict()) for each in verdicts]
    assert again == verdicts


@pytest.mark.parametrize("index", range(3))
def test_what_several_tests_show_agrees_with_the_models_own_answer(index):
    specimen = drawn_specimen(np.random.default_rng([7, index]))
    model = parse_model(specimen.base)
    theta = model.vector(specimen.theta)
    own = {"sweep": model.stiffness, "relaxation": model.relaxation, "creep": model.creep}
    for test, shown in specimen.answers({}).items():
        assert np.allclose(shown, own[test](theta, specimen.at[test]), rtol=1e-5)


@pytest.mark.parametrize("group", list(GROUPS))
def test_something_hidden_is_visible_and_nothing_is_not(group):
    rng = np.random.default_rng(3)
    specimen = drawn_specimen(rng)
    found = HIDDEN[group](specimen, rng)
    ideal = specimen.answers({})
    changed = {
        test for test in specimen.tests if not np.array_equal(found.exact[test], ideal[test])
    }
    assert changed == set(found.where)


def test_a_joint_case_is_the_same_every_time():
    first, again = drawn_case(5, 2), drawn_case(5, 2)
    assert first.found.name == again.found.name
    assert first.visible == again.visible
    for one, other in zip(first.tests, again.tests, strict=True):
        name = "stiffness" if isinstance(one, Measurement) else "response"
        assert np.array_equal(getattr(one, name), getattr(other, name))


@pytest.mark.soak
def test_a_gain_of_one_of_two_tests_is_one_of_the_other_just_as_well():
    cases = [drawn_case(5, index) for index in range(40)]
    gains = [case for case in cases if case.group == "calibration"]
    assert gains
    for case in gains:
        assert len(case.truth) == (2 if len(case.specimen.tests) == 2 else 1)
