"""Rules of the search, of what to measure next and of what is told of it, by hand."""

from __future__ import annotations

from math import inf
from types import SimpleNamespace

import numpy as np
import pytest

from springpot.diagnosis import (
    evidence,
    experiment,
    ladder,
    marginal,
    notes,
    scan,
    search as searching,
)
from springpot.diagnosis.search import NEGLIGIBLE
from springpot.measurement import Measurement
from springpot.misfit.residuals_of_tests import SweepPart
from springpot.rheology.points import Points
from springpot.thresholds import EVIDENCE, EXPERIMENT, SEARCH, VERDICT

SETTLED = EXPERIMENT.settled


def test_what_a_contest_is_expected_to_tell_counts_each_side_by_its_chance():
    assert experiment._expected((0.25, 0.75), (2.0, 8.0)) == 6.5


@pytest.mark.parametrize(
    ("sigmas", "told"),
    [
        ((1.0, 2.0), True),
        ((2.1, 1.0), False),
        ((SETTLED, 9.0 * SETTLED), True),
        ((9.0 * SETTLED, 0.999 * SETTLED), False),
    ],
)
def test_two_are_told_apart_whoever_is_right_where_both_ways_settle_or_are_alike(sigmas, told):
    assert experiment._either_way(sigmas) is told


def test_a_question_is_as_open_as_the_odds_of_the_second_answer():
    assert experiment.openness({"a": 0.2, "b": 0.5, "c": 0.1}) == pytest.approx(0.4)
    assert experiment.openness({"a": 0.2}) == experiment.openness({"a": 0.0, "b": 0.0}) == 0.0


def test_the_effort_of_a_refit_ends_where_it_is_no_rival():
    def effort(base, *grown):
        each = [SimpleNamespace(refit=SimpleNamespace(rss=rss)) for rss in grown]
        return searching.effort_of(SimpleNamespace(base=SimpleNamespace(rss=base), grown=each))

    assert effort(1e4) == searching.Effort(NEGLIGIBLE)
    half = 1e4 - SEARCH.hopeless * (1e4 - 200.0)
    assert effort(1e4, 900.0, 200.0) == searching.Effort(NEGLIGIBLE, half)
    rival = 200.0 + 2.0 * SEARCH.decisive
    assert effort(201.0, 200.0) == searching.Effort(NEGLIGIBLE, rival)
    assert inf > rival > 200.0


@pytest.mark.parametrize(("drop", "paid"), [(4.5, False), (4.7, True), (-1.0, False)])
def test_a_second_effect_is_fitted_where_the_drop_foretold_pays_for_it(drop, paid):
    one, two = (
        SimpleNamespace(element=SimpleNamespace(parameters=(0,) * count)) for count in (1, 2)
    )
    # Of a known noise a log-likelihood is minus half of chi-square; ln 100 is the price of one.
    refit = SimpleNamespace(
        fit=SimpleNamespace(measurement=range(50)),
        noise=SimpleNamespace(log_likelihood=lambda rss, points: -0.5 * rss),
        fair=lambda rss: rss,
        log_likelihood=-40.0,
    )
    best = SimpleNamespace(refit=refit, effects=(one,))
    assert searching.pays(best, (one, one), 80.0 - drop) is paid
    assert searching.pays(best, (one, two), 80.0 - drop) is False
    # What has as many parameters need only be better.
    assert searching.pays(best, (one,), 80.0 - drop) is (drop > 0.0)


def test_effects_of_good_pairs_are_tried_alone_unless_they_were(monkeypatch):
    def of(*names):
        return SimpleNamespace(names=names, effects=names)

    grown = [of("a", "b"), of("c"), of("d", "e")]
    scores = [
        SimpleNamespace(influence=SimpleNamespace(effect=SimpleNamespace(name=name)))
        for name in "abcdx"
    ]
    search = SimpleNamespace(grown=grown, scan=SimpleNamespace(scores=scores))
    monkeypatch.setattr(searching, "clear", lambda search, made: made)
    monkeypatch.setattr(searching, "sort_by_evidence", lambda search: None)
    monkeypatch.setattr(searching, "grown_with", lambda search, score: score.influence.effect.name)
    searching._add_singles(search)
    assert search.grown[3:] == ["a", "b", "d"]


def test_two_curves_are_as_far_apart_as_their_root_mean_square_in_noise():
    frame = SimpleNamespace(whiten=lambda difference: np.r_[difference.real, difference.imag])
    first, second = (SimpleNamespace(stiffness=np.array(k)) for k in ([3.0 + 4.0j], [0.0j]))
    assert evidence.distance(frame, first, second) == pytest.approx(np.sqrt(12.5))


def test_bad_points_are_measured_again_and_close_beside():
    points = [SimpleNamespace(at=f"{hertz} Hz", frequency=hertz) for hertz in (2.0, 5.0)]
    asked = experiment.experiment_on_points(points)
    wanted = [
        2.0 * np.pi * hertz * factor for hertz in (2.0, 5.0) for factor in experiment.ACTION.beside
    ]
    assert asked.action == {"omega": pytest.approx(wanted)}
    assert asked.says.startswith("measure again at 2.0 Hz and 5.0 Hz, and close beside")


@pytest.mark.parametrize(("scale", "size"), [(1.0, 1.0), (0.0, 4.0)])
def test_further_points_are_as_noisy_as_the_median_and_quieter_by_repeats(scale, size, monkeypatch):
    made = SweepPart(
        Measurement([1.0, 2.0, 3.0], [3.0, 4.0j, 5.0]),
        noise=np.array([0.3, 0.8, 1.5, 0.6, 0.4, 2.0]),
    )
    action = experiment.Action("", Points(np.zeros(1)), scale=scale, repeats=4)
    shown = {3: np.array([3.0, 0.0, 5.0, 0.0, 4.0, 0.0]), 1: np.array([0.6, 0.8])}
    answer = SimpleNamespace(theta=None)
    monkeypatch.setattr(
        experiment, "_answer", lambda fit, part, _: SimpleNamespace(value=shown[part.count() // 2])
    )
    plan = experiment.planned_sweep(action, made, answer)
    # Of 0.1, 0.2, 0.3 the median, and of 0.2, 0.1, 0.4; the mean of four repeats.
    assert plan.sd == pytest.approx(0.5 * size * np.array([0.2, 0.2]))


@pytest.mark.parametrize(
    ("verdict", "then", "taken"),
    [
        ("effect-missing", "adequate", True),
        ("effect-missing", "effect-missing", True),
        ("effect-missing", "unexplained", False),
        ("adequate", "effect-missing", False),
    ],
)
def test_a_set_replaces_rungs_where_it_leads_to_no_worse_verdict(monkeypatch, verdict, then, taken):
    def step(name, verdict):
        return SimpleNamespace(
            model=SimpleNamespace(name=name),
            diagnosis=SimpleNamespace(verdict=verdict),
            accepted=name[1:],
            alike=(),
        )

    class Base(str):
        """A model that grows by a letter."""

        @property
        def name(self):
            return str(self)

        def __add__(self, effect):
            return Base(str.__add__(self, effect.name))

    first, made = step("k", "unexplained"), step("ka", then)
    first.model = Base("k")
    steps = [first, step("kb", verdict)]
    monkeypatch.setattr(ladder, "rung_of", lambda case, before, name: made)
    monkeypatch.setattr(ladder, "replace", lambda step, alike: (step, alike))
    rungs = SimpleNamespace(examined=lambda *given: None)
    found = ladder.FoundSet((SimpleNamespace(name="a"),), None, lambda names: {"a": ("a", "c")})
    now = ladder.replaced_by(rungs, steps, found, None)
    assert now == ([(first, ()), (made, ("a", "c"))] if taken else steps)


def test_what_the_best_model_leaves_is_told_in_multiples_of_its_noise(monkeypatch):
    monkeypatch.setattr(notes, "discrepancy", lambda frame, shift: [])
    monkeypatch.setattr(notes, "log_shift_of", lambda refit: None)

    class Best:
        """A fit that leaves five times its noise."""

        error, floor, model = 0.1, 0.02, "kelvin + slip"

        def frame(self):
            return None

    best = Best()
    [says] = notes._of_rest(SimpleNamespace(best=best, base=None))
    assert (
        says == "the best model found, kelvin + slip, still leaves structure (5 x the noise floor)"
    )
    assert list(notes._of_rest(SimpleNamespace(best=best, base=best))) == []


def test_the_largest_score_of_noise_is_a_square_and_none_is_negative():
    """Noise of one number that points the other way scores nothing."""
    drawn = np.linspace(-2.0, 2.0, scan.DRAWS)
    parts = iter(np.array_split(drawn, 4))
    frame = SimpleNamespace(size=1, draws=lambda count, rng: next(parts)[:, None])
    tried = [SimpleNamespace(unit=np.ones((1, 1)))]
    found = scan._simulated_maxima(frame, tried, None)
    np.testing.assert_allclose(found, np.maximum(drawn, 0.0) ** 2, rtol=1e-5)


def test_a_draw_that_is_as_likely_with_the_other_sign_serves_twice():
    drawn = np.linspace(-2.0, 3.0, scan.DRAWS // 2)
    parts = iter(np.array_split(drawn, 2))
    frame = SimpleNamespace(size=1, draws=lambda count, rng: next(parts)[:, None])
    tried = [SimpleNamespace(unit=np.ones((1, 1)))]
    found = scan._simulated_maxima(frame, tried, None, scan.DRAWS, mirrored=True)
    np.testing.assert_allclose(np.sort(found)[-1], 9.0, rtol=1e-5)
    assert len(found) == scan.DRAWS
    assert np.sum(found > 0.0) == len(drawn), "each lies to one of the two sides"


def harmonic(measured, predicted, radius):
    """A fit with one row of noise 0.03 + 0.04 i beside a size of 5, and its third harmonic."""
    data = SimpleNamespace(
        harmonic={3: np.array(measured, dtype=complex)}.get,
        magnitude=np.full(len(measured), 5.0),
        points=None,
    )
    model = SimpleNamespace(
        third_harmonic_range=lambda theta, points: (np.array(predicted), np.array(radius))
    )
    noise = SimpleNamespace(sd=np.full(len(measured), 0.03 + 0.04j))
    return SimpleNamespace(data=SimpleNamespace(mean=data), model=model, theta=None, noise=noise)


def test_a_third_harmonic_counts_by_what_is_known_of_it(monkeypatch):
    monkeypatch.setattr(marginal, "_open_harmonic", lambda refit, predicted: 0.0)
    sd = 0.01 + EVIDENCE.least_harmonic
    known = np.hypot(sd, EVIDENCE.harmonic_tolerance * 0.5)
    found = marginal.harmonic_evidence(harmonic([0.5], [0.3], [0.0]))
    assert found == pytest.approx(-0.5 * (0.2 / known) ** 2)
    found = marginal.harmonic_evidence(harmonic([0.5, np.nan], [0.5, 0.1], [0.0, 0.0]))
    assert found == 0.0
    many = [0.5] * (int(EVIDENCE.most_harmonic_rows) + 9)
    found = marginal.harmonic_evidence(harmonic(many, [0.3] * len(many), [0.0] * len(many)))
    assert found == pytest.approx(-0.5 * (0.2 / known) ** 2 * EVIDENCE.most_harmonic_rows)
    assert marginal.harmonic_evidence(harmonic([np.nan], [0.3], [0.0])) == 0.0
    nothing = marginal.harmonic_evidence(harmonic([0.5], [0.3], [inf]))
    assert nothing == EVIDENCE.unpredicted_harmonic


@pytest.mark.parametrize(("beyond", "asked"), [(1.0, False), (1.001, True)])
def test_a_law_is_opened_where_the_harmonic_lies_beyond_its_noise(monkeypatch, beyond, asked):
    opened = []
    monkeypatch.setattr(
        marginal, "_open_harmonic", lambda refit, predicted: opened.append(1) or 1.0
    )
    sd = np.hypot(0.03, 0.04) / 5.0 + EVIDENCE.least_harmonic
    marginal.harmonic_evidence(harmonic([beyond * sd], [0.0], [0.0]))
    assert bool(opened) is asked


def test_a_bound_costs_what_its_room_holds_and_no_more_than_to_know_nothing():
    price = marginal._price_of_a_bound
    assert price(np.array([0.5]), np.array([0.0])) == 0.0
    wanted = 2.0 * np.log(2.0) + np.log(1.0 + np.log(3.0))
    assert price(np.array([2.0]), np.array([3.0])) == pytest.approx(wanted)
    both = price(np.array([2.0, 0.5]), np.array([3.0, 1.0]))
    assert both == pytest.approx(0.5 * wanted)
    assert price(np.array([1e9]), np.array([1e9])) == -EVIDENCE.unpredicted_harmonic


def test_structure_in_general_is_none_where_sweeps_differ_beyond_doubt(monkeypatch):
    kinds = [SimpleNamespace(says=says) for says in ("", "a gain", "")]
    monkeypatch.setattr(marginal, "unknowns", lambda frame: iter(kinds))

    def left(share):
        repeats = SimpleNamespace(p_value=share * VERDICT.beyond_doubt)
        return marginal._kinds(SimpleNamespace(frame=None, repeats=repeats))

    assert left(1.0) == kinds
    assert left(0.9) == [kinds[0], kinds[2]]


@pytest.mark.parametrize(
    ("misfit", "drop", "p_value", "told"),
    [
        (100.0, 95.0, 0.0, True),
        (100.0, 20.0, 0.0, False),
        (100.0, 95.0, VERDICT.structure_alarm, False),
    ],
)
def test_a_kind_explains_where_it_takes_most_of_a_misfit_that_is_none_of_noise(
    monkeypatch, misfit, drop, p_value, told
):
    kind = SimpleNamespace(drop=drop)
    monkeypatch.setattr(marginal, "likeliest_unknown", lambda search: kind)
    frame = SimpleNamespace(size=10, absorbed=np.zeros((10, 4)), rest=np.array([misfit**0.5]))
    structure = SimpleNamespace(p_value=p_value)
    search = SimpleNamespace(structure=structure, frame=frame)
    assert marginal.explaining_unknown(search) is (kind if told else None)


def test_what_a_parameter_costs_is_how_sharp_it_is_beside_all_others():
    """Columns that are half alike leave three quarters of a square."""
    slopes = np.array([[2.0, 0.5], [0.0, np.sqrt(0.75)], [0.0, 0.0]])
    refit = SimpleNamespace(fit=SimpleNamespace(jacobian_u=slopes))
    free = np.zeros(2, dtype=int)
    assert marginal._sharpness(refit, np.array([0]), free) == pytest.approx([3.0])
    assert marginal._sharpness(refit, np.array([1]), free) == pytest.approx([0.75])
    held = np.array([0, 1])
    assert marginal._sharpness(refit, np.array([0]), held) == pytest.approx([4.0])
    assert marginal._sharpness(refit, np.array([1]), held) == pytest.approx([0.0])
