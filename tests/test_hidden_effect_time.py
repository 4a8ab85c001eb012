"""A few hidden effects of tests in time, computed outside springpot, are seen and named."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

STUDIES = Path(__file__).resolve().parents[1] / "studies"
sys.path.insert(0, str(STUDIES))

from hidden_effects_time.cases import OUTSIDE, Setting, drawn_case  # noqa: E402
from hidden_effects_time.judge import DETECTED, NAMED, judged, library  # noqa: E402
from hidden_effects_time.physics import creep, inverse, relaxation, to_history  # noqa: E402
from hidden_effects_time.tables import figures, write_tables  # noqa: E402
from springpot.registry import parse_model  # noqa: E402

SEED = 33
CASES = (0, 1, 2, 3, 4, 5, 8)
"""Five with something of the library hidden, one with something of none, and one with nothing."""


@pytest.fixture(scope="module")
def verdicts():
    effects = library()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return [judged(drawn_case(SEED, index), index, effects) for index in CASES]


@pytest.mark.soak
def test_what_is_plainly_missing_is_seen_and_named(verdicts):
    inside = [each for each in verdicts if each.hidden and not each.outside]
    seen = [each for each in inside if each.visible >= DETECTED]
    plain = [each for each in inside if each.visible >= NAMED]
    assert len(plain) >= 4
    assert all(each.flagged for each in seen)
    assert sum(each.right for each in plain) >= len(plain) - 1


@pytest.mark.soak
def test_nothing_is_flagged_where_nothing_is_missing(verdicts):
    clean = [each for each in verdicts if not each.hidden]
    assert clean
    assert not any(each.flagged for each in clean)


@pytest.mark.soak
def test_what_no_library_has_is_not_given_a_name(verdicts):
    unknown = [each for each in verdicts if each.outside and each.visible >= NAMED]
    assert unknown
    assert all(each.verdict == "unexplained" for each in unknown)


@pytest.mark.soak
def test_the_tables_count_all_cases(verdicts, tmp_path):
    write_tables(verdicts, tmp_path, SEED)
    text = (tmp_path / "README.md").read_text(encoding="utf-8")
    assert f"{len(CASES)} tests drawn anew" in text
    assert all(name in text for name, _, _ in figures(verdicts))


@pytest.mark.soak_cases(
    "fractional-kelvin", "fractional-maxwell", "fractional-zener", "maxwell", "zener"
)
@pytest.mark.parametrize(
    "name", ["maxwell", "zener", "fractional-maxwell", "fractional-zener", "fractional-kelvin"]
)
def test_the_inversion_agrees_with_the_exact_response(name):
    theta = {"k": 50.0, "k1": 50.0, "k2": 400.0, "c": 60.0, "alpha": 0.55}
    model = parse_model(name)
    t, even = np.geomspace(0.05, 20.0, 30), np.linspace(0.0, 15.0, 200)
    at = Setting(
        "history", name, {key: theta[key] for key in model.names}, even, np.sin(even), None
    )
    values = model.vector(at.theta)
    assert relaxation(at.stiffness, t) == pytest.approx(
        model.relaxation(values, t), rel=1e-5, abs=1e-6
    )
    assert creep(at.stiffness, t) == pytest.approx(model.creep(values, t), rel=1e-6)
    force = model.respond(values, even, at.x)
    assert to_history(at.stiffness, even, at.x)[1:] == pytest.approx(
        force[1:], abs=1e-5 * np.abs(force).max()
    )


def test_the_inversion_follows_a_mass_that_rings_a_hundred_times():
    time, slow, omega = np.geomspace(1e-3, 60.0, 200), 0.02, 10.0
    rung = inverse(lambda s: 1.0 / s - (s + slow) / ((s + slow) ** 2 + omega**2), time)
    assert rung == pytest.approx(1.0 - np.exp(-slow * time) * np.cos(omega * time), abs=1e-8)


@pytest.mark.soak
def test_a_case_is_the_same_every_time():
    first, again = drawn_case(5, 7), drawn_case(5, 7)
    assert np.array_equal(first.test.response, again.test.response)
    assert first.hidden == again.hidden
    assert set(OUTSIDE) == {"hum", "slip", "bump", "frozen", "wander"}
