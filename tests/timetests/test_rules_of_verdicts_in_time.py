"""Chances, candidates and facts of a diagnosis in time, with values by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.diagnosis.evidence import unknown_odds
from springpot.thresholds import EVIDENCE, VERDICT
from springpot.timetests import verdict


def tried(name="friction", evidence=0.0, delta=0.0, helps=False, prior=1.0, fit=None, left=None):
    effect = SimpleNamespace(name=name, prior=prior, summary="what it is")
    return SimpleNamespace(
        effect=effect, evidence=evidence, delta=delta, helps=helps, fit=fit, left=left
    )


def promised(*priors):
    return {
        str(i): [SimpleNamespace(effect=SimpleNamespace(prior=prior))]
        for i, prior in enumerate(priors)
    }


def test_chances_are_priors_times_what_the_evidence_is_worth():
    each = [tried(evidence=6.0), tried(evidence=-2.0)]
    slip = 3.0
    nothing, first, second, unnamed = verdict._weights(each, promised(1.0, 2.0, 1.0), slip)
    assert nothing + first + second + unnamed == pytest.approx(1.0)
    something = 1.0 - EVIDENCE.prior_nothing
    assert first / nothing == pytest.approx(np.exp(3.0) * something / 4.0 / EVIDENCE.prior_nothing)
    assert first / second == pytest.approx(np.exp(4.0))
    assert unnamed / nothing == pytest.approx(
        np.exp(1.5) * something * EVIDENCE.outside / EVIDENCE.prior_nothing
    )


def test_what_is_unexplained_is_as_unknown_as_its_chance_of_noise_says():
    weights, chance = [0.3, 0.5, 0.2], 1e-4
    odds = unknown_odds(chance)
    assert odds / (1.0 + odds) > 0.2
    nothing, first, unknown = verdict._agreeing(weights, "unexplained", chance)
    assert unknown == pytest.approx(odds / (1.0 + odds))
    assert first / nothing == pytest.approx(5.0 / 3.0)
    assert nothing + first + unknown == pytest.approx(1.0)
    # Already as unknown as that, or not at all unexplained: as the evidence has it.
    assert verdict._agreeing([0.0, 1e-9, 1.0 - 1e-9], "unexplained", 0.9)[-1] > 0.99
    assert verdict._agreeing(weights, "cannot-tell", chance) == pytest.approx(weights)


def error(relative_rms=0.02, over_floor=1.5):
    return SimpleNamespace(relative_rms=relative_rms, over_floor=over_floor)


def test_one_effect_alone_is_missing_for_certain():
    pair = [tried("friction"), tried("inertia")]
    for says, alike, first in (
        ("effect-missing", ["friction"], "missing"),
        ("effect-missing", ["friction", "inertia"], "cannot-tell"),
        ("cannot-tell", ["friction"], "cannot-tell"),
    ):
        rows = verdict._candidates(pair, [0.7, 0.2], alike, [error(), error()], says)
        assert rows[0].verdict == first
        assert [row.probability for row in rows] == [0.7, 0.2]
    assert rows[1].verdict == "absent"
    assert rows[0].alike == ("friction",)


@pytest.mark.parametrize(
    ("delta", "told"), [(VERDICT.clear_evidence, "absent"), (50.0, "cannot-tell")]
)
def test_an_effect_for_which_something_speaks_is_not_absent(delta, told):
    assert verdict._open(tried("inertia", delta=delta), ["friction"]) == told


def test_what_was_fitted_has_parameters_and_its_error_and_else_it_is_foretold():
    values = {"k": 1.0, "friction.F": 2.0, "friction#2.F": 3.0, "inertia.m": 4.0}
    fit = SimpleNamespace(parameters=values)
    found = verdict._candidate(tried(fit=fit, delta=9.0), 0.4, ["friction"], error())
    assert found.parameters == {"F": 3.0}
    assert (found.error_after, found.over_floor, found.delta_bic) == (0.02, 1.5, 9.0)
    assert np.isnan(found.predicted_error)
    foretold = verdict._candidate(tried(), 0.4, ["friction", "inertia"], error())
    assert (foretold.predicted_error, foretold.parameters) == (0.02, {})
    assert np.isnan(foretold.error_after)
    assert foretold.alike == ("friction", "inertia")


def test_facts_are_the_gain_of_the_best_and_what_is_beyond_doubt():
    before = SimpleNamespace(misfit=True, doubtful=False)
    none = verdict.facts_of(before, [], False)
    assert (none.gain, none.something, none.ruled_out, none.by_battery) == (0.0, False, False, True)
    for missed in (True, False):
        left = SimpleNamespace(misfit=missed)
        best = tried(delta=VERDICT.clear_evidence + 1.0, helps=True, left=left)
        told = verdict.facts_of(before, [best, tried(delta=99.0)], False)
        assert told.gain == best.delta
        assert (told.something, told.ruled_out, told.named, told.left) == (True, True, True, missed)
    unknown = verdict.facts_of(before, [tried()], True)
    assert (unknown.ruled_out, unknown.named, unknown.left) == (True, False, False)
