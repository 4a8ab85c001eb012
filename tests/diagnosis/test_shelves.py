"""Three shelves: an effect explains the misfit, or helps, or is ruled out as its cause."""

from dataclasses import replace

import pytest

import springpot
from springpot.diagnosis.result import AsTold
from springpot.report.answers import ranked
from springpot.report.told import told

pytestmark = pytest.mark.usefixtures("asked_once")


@pytest.fixture
def found(asked_once):
    return springpot.diagnose("artificial-hidden", "fractional-maxwell")


def names(found, shelf):
    return [row.effect for row in found.on_shelf(shelf)]


def test_each_effect_stands_on_one_shelf(found):
    shelved = [each for shelf in ("explains", "helps", "ruled-out") for each in names(found, shelf)]
    assert sorted(shelved) == sorted(row.effect for row in found.candidates)


def test_rivals_for_the_place_beside_the_leading_effect_explain_too(found):
    """The headline named one of them while its row said that the error stays."""
    assert names(found, "explains") == ["inertia", "time-delay", "fixture-resonance"]
    beside = found.on_shelf("explains")[2]
    assert beside.error_beside < 0.05 * beside.error_after
    assert set(found.next_experiment.separates) <= set(names(found, "explains"))


def test_the_parameters_beside_the_leading_effect_are_those_of_the_model_with_both(found):
    """They were those of the model with that effect alone, where a delay is of another size."""
    delay = found.on_shelf("explains")[1]
    both = springpot.identify("artificial-hidden", "fractional-maxwell + inertia + time-delay")
    told, fitted = delay.parameters["tau"], both.parameters["time-delay.tau"]
    assert told.value == pytest.approx(fitted.value, rel=1e-3)
    assert told.low < fitted.value < told.high


def test_what_helps_takes_a_tenth_of_the_error_and_the_most_stands_first(found):
    after = [row.after for row in found.on_shelf("helps")]
    assert after == sorted(after)
    assert all(each < 0.9 * found.error.relative_rms for each in after)
    assert names(found, "helps")[0] == "frame-resonance"


def test_what_helps_only_beside_another_effect_is_not_offered_before_it(found):
    """Accepted alone it left the error where it was."""
    rows = [replace(row, beside=AsTold()) for row in found.candidates]
    least = min(row.after for row in rows)
    pair = next(i for i, row in enumerate(rows) if row.effect == "fixture-resonance")
    rows[pair] = replace(rows[pair], beside=AsTold(0.5 * least))
    nameless = replace(found, verdict="unexplained", leading=(), candidates=tuple(rows))
    assert names(nameless, "helps")[-1] == "fixture-resonance"
    assert nameless.offered != "fixture-resonance"


def test_what_is_ruled_out_is_one_line(found):
    text = " ".join(told(found).split())
    assert "ruled out, as the error stays: filter-mismatch, parallel-dashpot, " in text
    assert "helps too: frame-resonance, specimen-inertia, " in text
    assert "cannot-tell" not in text
    assert not set(names(found, "ruled-out")) & {row.effect for row in ranked(found)}


def test_without_a_name_the_best_help_is_offered_and_said_to_be_no_proof(found):
    nameless = replace(found, verdict="unexplained", leading=())
    assert names(nameless, "explains") == []
    assert nameless.offered == names(nameless, "helps")[0]
    assert nameless.onward == "helps, but is no proof"


def test_of_what_may_be_chance_the_likeliest_is_offered_though_another_leaves_less(found):
    """A headline named one effect, and the command below it accepted another."""
    nameless = replace(found, verdict="unexplained", leading=())
    likeliest = next(row for row in found.candidates if row.effect == names(nameless, "helps")[1])
    rest = tuple(row for row in found.candidates if row is not likeliest)
    open_ended = replace(nameless, verdict="inconclusive", candidates=(likeliest, *rest))
    assert open_ended.offered == names(open_ended, "helps")[0] == likeliest.effect


def test_an_effect_that_leaves_the_error_is_never_offered(found):
    stays = tuple(
        replace(row, alone=AsTold(found.error.relative_rms), beside=AsTold())
        for row in found.candidates
    )
    bare = replace(found, verdict="unexplained", leading=("inertia",), candidates=stays)
    assert bare.offered == ""


def test_programs_read_the_shelf_and_get_the_same_answer_back(found):
    answer = found.to_dict()
    shelves = {row["effect"]: row["shelf"] for row in answer["candidates"]}
    assert shelves["inertia"] == "explains"
    assert shelves["frame-resonance"] == "helps"
    assert shelves["gain-error"] == "ruled-out"
    assert type(found).from_dict(answer).to_dict() == answer
