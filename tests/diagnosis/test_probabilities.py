"""Probabilities of explanations: by Bayes' rule on a few numbers."""

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.diagnosis import evidence as e
from springpot.numerics import NEGLIGIBLE, ROUNDING
from springpot.thresholds import EVIDENCE


def test_chances_are_weights_over_their_sum():
    known, unknown = e.chances_of(np.log([1.0, 3.0]), np.log(4.0))
    np.testing.assert_allclose(known, [0.125, 0.375])
    assert unknown == pytest.approx(0.5)
    known, unknown = e.chances_of(np.log([1.0, 3.0]))
    np.testing.assert_allclose(known, [0.25, 0.75])
    assert unknown == pytest.approx(0.0)


@pytest.mark.parametrize("log", [-5000.0, 5000.0])
def test_they_sum_to_one_however_far_apart(log):
    known, unknown = e.chances_of(np.array([0.0, 1.0]), log)
    assert known.sum() + unknown == pytest.approx(1.0)
    assert unknown == pytest.approx(1.0 - ROUNDING if log > 0 else 0.0)
    np.testing.assert_allclose(known[1] / known[0], np.e)


def test_a_library_is_the_sum_of_its_priors_and_at_least_one_effect():
    assert e.size_of_library([SimpleNamespace(prior=p) for p in (1.0, 0.5, 0.1)]) == 1.6
    assert e.size_of_library([SimpleNamespace(prior=0.1)]) == 1.0
    assert e.log_prior_of_one(4.0) == pytest.approx(np.log((1 - EVIDENCE.prior_nothing) / 4))


def grown(*priors, names=None, beyond=(), evidence=0.0):
    return SimpleNamespace(
        effects=[SimpleNamespace(prior=prior) for prior in priors],
        names=names,
        key=tuple(sorted(names or ())),
        beyond_physics=beyond,
        refit=SimpleNamespace(log_evidence=evidence),
    )


def test_a_set_of_effects_has_the_shares_of_all_of_them():
    some = 1.0 - EVIDENCE.prior_nothing
    assert np.exp(e.log_prior(grown(0.5), 4.0)) == pytest.approx(some * 0.125)
    pair = some * EVIDENCE.prior_pair * 0.125 * 0.25
    assert np.exp(e.log_prior(grown(0.5, 1.0), 4.0)) == pytest.approx(pair)
    beyond = grown(0.5, 1.0, beyond=("a", "b"))
    wanted = pair * EVIDENCE.beyond_physics**2
    assert np.exp(e.log_prior(beyond, 4.0)) == pytest.approx(wanted)


@pytest.mark.parametrize("p", [1e-300, 1e-12, 1e-3, 0.2, 1 / np.e, 0.9])
def test_what_a_chance_can_speak_for_the_unknown_at_most(p):
    prior = EVIDENCE.outside / (1.0 - EVIDENCE.outside)
    within = np.clip(p, 1e-12, 1 / np.e)
    assert e.unknown_odds(p) == pytest.approx(prior / (-np.e * within * np.log(within)))
    assert e.unknown_odds(0.9) == pytest.approx(prior)


def test_the_fewest_names_that_hold_nearly_all():
    share = EVIDENCE.credible
    chances = {"c": 1.0 - share, "a": 0.6 * share, "b": 0.41 * share}
    assert e.credible(chances) == ["a", "b"]
    assert e.credible({name: 0.3 * each for name, each in chances.items()}) == ["a", "b"]
    assert e.credible(chances | {"b": 0.39 * share}) == ["a", "b", "c"]
    assert e.credible({}) == []


def test_each_name_takes_one_of_its_own_away():
    assert e.without(["a", "b", "a"], ["a", "c"]) == ["b", "a"]
    assert e.without(["a"], ["a", "a"]) == []


def test_of_each_set_the_best_whatever_the_order_of_adding():
    ab, ba, a = (
        grown(names=n, evidence=v) for n, v in ((("a", "b"), 1.0), (("b", "a"), 3.0), (("a",), 0.0))
    )
    assert e.one_for_each_set([ab, ba, a]) == [a, ba]
    # By more than rounding.
    ba.refit.log_evidence = 1.0 + 0.5 * NEGLIGIBLE
    for order in ([ab, ba], [ba, ab]):
        assert e.one_for_each_set(order) == [ab]


def test_what_may_stand_in_its_place_shares_its_probability_and_is_no_likelier():
    leader = e.Explanation(grown(evidence=0.0), 0.8)
    better, worse = grown(evidence=5.0), grown(evidence=-np.log(2.0))
    first, second, third = e._shared(leader, [worse, better])
    assert first.grown is leader.grown
    assert (second.grown, third.grown) == (better, worse)
    np.testing.assert_allclose(
        [first.probability, second.probability, third.probability], [0.32, 0.32, 0.16]
    )
