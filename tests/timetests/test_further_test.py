"""What to measure where tests in time do not tell two effects apart, and that it does tell them."""

from __future__ import annotations

import operator
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot import TimeTest
from springpot.diagnosis.experiment import Contest, _answer
from springpot.errors import DataError, ModelError
from springpot.misfit.residuals_of_tests import parts_of_specimen
from springpot.timetests import diagnosis as diagnosis_in_time, identify
from springpot.timetests.diagnosis import _of_one_class, planned_tests

MODEL = springpot.parse_model("fractional-zener")
THETA = MODEL.theta(k1=50.0, k2=400.0, c=60.0, alpha=0.5)
RIVALS = ["thermal-transient", "thermal-force", "force-drift"]
TIME = np.geomspace(0.01, 100.0, 80)
HEATED = springpot.parse_model("fractional-zener + thermal-transient")
CLOCK = springpot.parse_model("fractional-zener + force-drift")


def relaxed(step: float, seed: int) -> TimeTest:
    """A relaxation after a step, in which the stiffness itself grows with time."""
    exact = step * MODEL.relaxation(THETA, TIME) * (1.0 + 0.04 * np.log1p(TIME))
    noise = 0.5 * np.random.default_rng(seed).normal(size=len(TIME))
    loading = springpot.measurement.Loading.step(step)
    return TimeTest(TIME, exact + noise, loading, displacement_unit="mm", force_unit="N")


@pytest.fixture(scope="module")
def open_question() -> springpot.Diagnosis:
    """One step does not tell a force that grows from a stiffness that grows."""
    return springpot.diagnose(relaxed(1.0, 1), MODEL, effects=RIVALS)


def test_a_sample_set_aside_is_none_of_a_planned_test() -> None:
    """What is planned has samples of its own: fewer, where that one would be beyond them all."""
    test = replace(relaxed(1.0, 1), aside={78: 20.0})
    parts = parts_of_specimen([test])
    for planned in planned_tests(parts, identify([test], MODEL)):
        if planned.part.test.name == test.name and "repeats" not in planned.action:
            assert not planned.part.test.measured
            assert np.sum(~planned.part.sure) <= 1


@pytest.mark.soak
def test_a_larger_step_tells_what_grows_with_the_load(open_question) -> None:
    asked = open_question.next_experiment
    assert set(asked.separates) == {"thermal-transient", "thermal-force"}
    assert asked.action == {"factor": [3.0]}
    assert asked.expected_separation_sigma > 5.0
    assert "impose three times the step" in asked.says
    again = type(asked).from_dict(asked.to_dict())
    assert again == asked


@pytest.mark.soak
def test_once_it_is_measured_the_question_is_closed(open_question) -> None:
    both = springpot.diagnose([relaxed(1.0, 1), relaxed(3.0, 2)], MODEL, effects=RIVALS)
    odds = {each.effect: each.probability for each in both.candidates}
    assert odds["thermal-transient"] > 100.0 * odds.get("thermal-force", 0.0)
    before = {each.effect: each.probability for each in open_question.candidates}
    assert before["thermal-transient"] < 10.0 * before["thermal-force"]


@pytest.mark.parametrize(
    ("shelves", "fitted", "asked"),
    [
        ("helps helps ruled-out", "abc", ("a", "b")),
        ("ruled-out ruled-out ruled-out", "abc", None),
        ("helps ruled-out ruled-out", "abc", None),
        ("explains explains explains", "bc", None),
    ],
)
def test_no_test_is_planned_between_effects_that_nobody_believes_in(
    monkeypatch, shelves, fitted, asked
) -> None:
    """Those ruled out, and those beside a likelier one that no such test can be planned for."""
    pairs = []
    monkeypatch.setattr(diagnosis_in_time, "first_telling", lambda found, *_: pairs.extend(found))
    found = [
        SimpleNamespace(effect=name, probability=chance, alike=(), shelf=shelf)
        for name, chance, shelf in zip("abc", (0.9, 0.06, 0.04), shelves.split(), strict=True)
    ]
    answer = SimpleNamespace(
        verdict="inconclusive", candidates=found, shelf_of=operator.attrgetter("shelf")
    )
    tried = [SimpleNamespace(effect=SimpleNamespace(name=name), fit=name) for name in fitted]
    case = SimpleNamespace(diagnosis=answer, tried=tried, asked=SimpleNamespace(parts=()))
    diagnosis_in_time.next_test(case)
    assert pairs[:1] == ([asked] if asked else [])


@pytest.mark.soak
def test_nothing_is_asked_where_nothing_is_missing() -> None:
    exact = MODEL.relaxation(THETA, TIME)
    noise = 0.5 * np.random.default_rng(8).normal(size=len(TIME))
    test = TimeTest.of_relaxation(TIME, exact + noise, "kPa")
    found = springpot.diagnose(test, MODEL, effects=RIVALS)
    assert found.verdict == "adequate"
    assert found.next_experiment is None
    # All that is left is noise, though that of another story is of another size.
    assert found.error.over_floor == pytest.approx(1.0, abs=1e-9)


@pytest.fixture(scope="module")
def fits() -> list:
    test = TimeTest.of_relaxation(TIME, MODEL.relaxation(THETA, TIME) + 0.2 * TIME, "kPa")
    return [test, identify([test], HEATED), identify([test], CLOCK)]


@pytest.mark.soak
def test_an_explanation_follows_itself_whatever_is_measured(fits) -> None:
    test, heated, _ = fits
    parts = parts_of_specimen([test])
    for planned in planned_tests(parts, heated):
        contest = Contest(heated, heated, (*parts, planned.part))
        assert contest.linear < 1e-6


@pytest.mark.soak
def test_what_an_explanation_cannot_say_is_no_promise(fits) -> None:
    test, heated, clock = fits
    endless = replace(clock, theta=np.full(len(clock.theta), 1e300))
    for pair in ((heated, endless), (endless, heated)):
        contest = Contest(*pair, parts_of_specimen([test]))
        assert contest.linear == contest.fitted() == 0.0


@pytest.mark.soak
def test_a_clock_without_a_time_to_begin_from_is_no_promise(fits) -> None:
    test, heated, _ = fits
    aged = springpot.parse_model("fractional-zener + ageing")
    names = [parameter.name for parameter in aged.parameters]
    theta = np.append(
        heated.theta[:4], np.where(["waited" in name for name in names[4:]], 0.0, 1.0)
    )
    contest = Contest(heated, replace(heated, model=aged, theta=theta), parts_of_specimen([test]))
    assert contest.linear == contest.fitted() == 0.0


@pytest.mark.soak
def test_slopes_are_those_of_the_differences(fits) -> None:
    test, heated, clock = fits
    parts = parts_of_specimen([test])
    for planned in planned_tests(parts, heated):
        contest = Contest(heated, clock, (*parts, planned.part))
        slopes = contest.seen(clock.theta)[1]
        for i, value in enumerate(clock.theta):
            step = np.zeros(len(clock.theta))
            step[i] = 1e-5 * max(abs(value), 1e-3)
            ahead, back = (contest.seen(clock.theta + sign * step)[0] for sign in (1.0, -1.0))
            central = (back - ahead) / (2.0 * step[i])
            size = np.abs(slopes[i]).max()
            assert central == pytest.approx(slopes[i], abs=2e-4 * size), planned.says


def test_what_was_imposed_can_be_let_go(fits) -> None:
    test, heated, _ = fits
    plans = {
        next(iter(each.action)): each for each in planned_tests(parts_of_specimen([test]), heated)
    }
    assert set(plans) == {"repeats", "factor", "time", "release", "omega"}
    assert plans["release"].part.test.kind == "recovery"
    assert plans["omega"].part.test.omega[0] == pytest.approx(1.0 / 100.0, rel=0.01)


@pytest.mark.parametrize("fault", [ModelError, DataError])
def test_a_rival_that_went_beyond_all_numbers_follows_nothing(fault) -> None:
    def answer(*_: object) -> None:
        raise fault("log_omega is the natural logarithm of omega")

    part, fit = SimpleNamespace(answer=answer, thin=np.arange(3)), SimpleNamespace()
    fit.model = fit.reference = None
    told = _answer(fit, part, np.ones(2))
    assert np.isnan(told.value).all()
    assert told.by_theta.shape == (3, 2)


def test_of_a_class_the_first_and_each_other_are_told_apart_however_unlike_their_chances() -> None:
    alike = ("thermal-transient", "thermal-growth", "fading-network", "thermal-force")
    first = SimpleNamespace(effect="thermal-transient", alike=alike, probability=0.5)
    fitted = {"thermal-force", "fading-network", "thermal-transient"}
    assert _of_one_class([first], fitted) == [
        ("thermal-transient", "fading-network"),
        ("thermal-transient", "thermal-force"),
    ]
    alone = SimpleNamespace(
        effect="thermal-transient", alike=("thermal-transient",), probability=1.0
    )
    assert _of_one_class([alone, first], fitted) == []
    assert _of_one_class([], fitted) == []
    first.probability = 0.0
    assert _of_one_class([first], fitted) == []


def test_of_each_kind_of_test_a_further_one_is_offered(fits) -> None:
    """A larger step of the creep alone tells its rig's spring from a zero that is off."""
    test, heated, _ = fits
    creep = TimeTest.of_compliance(TIME, MODEL.creep(THETA, TIME), "kPa", name="creep")
    parts = parts_of_specimen([test, creep, replace(test, name="second")])
    says = [each.says for each in planned_tests(parts, heated)]
    assert "impose three times the step of creep" in says
    assert f"impose three times the step of {test.name}" in says
    assert not any("second" in each for each in says)
