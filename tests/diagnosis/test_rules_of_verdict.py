"""The rules of a verdict and its words, each at both sides of its edge, on searches by hand."""

from __future__ import annotations

from dataclasses import fields
from types import SimpleNamespace
from zlib import crc32

import numpy as np
import pytest

from springpot.diagnosis import answer, marginal, verdict
from springpot.diagnosis.verdict import Facts
from springpot.misfit.residual_tests import OF_NEIGHBOURS
from springpot.thresholds import EVIDENCE, SEARCH, VERDICT


def test_the_rule_of_many_facts(stays):
    """Facts drawn at random, and each alone and all but each."""
    names = [each.name for each in fields(Facts) if each.name != "gain"]
    rng = np.random.default_rng(1)
    drawn = [dict(zip(names, row, strict=True)) for row in rng.random((3000, len(names))) < 0.4]
    gains = rng.choice([-1.0, 0.0, 1.0, VERDICT.clear_evidence], 3000)
    found = [
        verdict.rule_for(Facts(gain=gain, **row)).reason
        for row, gain in zip(drawn, gains, strict=True)
    ]
    stays(
        {
            "counts": {reason: found.count(reason) for reason in sorted(set(found))},
            "all": crc32("\n".join(found).encode()),
            "alone": {name: verdict.rule_for(Facts(**{name: True})).reason for name in names},
            "alarm": {
                name: verdict.rule_for(Facts(by_battery=True, **{name: True})).reason
                for name in names
                if name != "by_battery"
            },
            "verdicts": {rule.reason: rule.verdict for rule in (*verdict.QUIET, *verdict.ALARMED)},
        }
    )


@pytest.mark.parametrize(
    ("n", "m", "pairs", "chance"),
    [
        # Of 10 ways to lay 2 of 5 places, 4 are neighbours.
        (5, 2, 1, 4 / 10),
        (5, 2, 0, 1.0),
        # Of 20 ways to lay 3 of 6, 4 are one run and 12 two.
        (6, 3, 2, 4 / 20),
        (6, 3, 1, 16 / 20),
    ],
)
def test_chances_of_neighbouring_pairs_are_counted(n, m, pairs, chance):
    assert verdict._chance_of_pairs(n, m, pairs) == pytest.approx(chance)


@pytest.mark.parametrize(
    ("outside", "together"),
    [([10, 11, 12], True), ([10, 20, 30], False), ([], False), ([10, 12, 14], False)],
)
def test_neighbours_that_stand_out_are_more_than_chance(monkeypatch, outside, together):
    stands_out = np.zeros(40, dtype=bool)
    stands_out[outside] = True
    monkeypatch.setattr(verdict, "_standing_out", lambda base: stands_out)
    sweep = SimpleNamespace(rows=np.arange(40))
    monkeypatch.setattr(verdict, "sweeps_of", lambda data: [sweep])
    assert verdict._stand_out_together(SimpleNamespace(data=SimpleNamespace(mean=None))) == together


def repeated(chance, curves=0.0, drift=0.0, one_curve=True, neighbours=1.0, runs=1.0):
    """A search of repeats, and what sets them apart."""
    apart = SimpleNamespace(curves=curves, drift=drift, one_curve=one_curve)
    search = SimpleNamespace(
        repeats=SimpleNamespace(p_value=chance, parts={OF_NEIGHBOURS: neighbours}),
        structure=SimpleNamespace(parts={"runs": runs}),
        base=SimpleNamespace(data=None),
    )
    return search, apart


ALARM, SHARE = VERDICT.beyond_doubt, VERDICT.drift_share


@pytest.mark.parametrize(
    ("given", "drifts"),
    [
        ({"chance": 0.9 * ALARM, "curves": 2.0, "drift": 2.1 * SHARE}, True),
        ({"chance": ALARM, "curves": 2.0, "drift": 2.1 * SHARE}, False),
        ({"chance": 0.0, "curves": 2.0, "drift": 2.0 * SHARE}, False),
        ({"chance": 0.0, "curves": 2.0, "drift": 2.1 * SHARE, "one_curve": False}, False),
    ],
)
def test_repeats_drift_by_one_curve_that_takes_most(given, drifts, monkeypatch):
    search, apart = repeated(**given)
    monkeypatch.setattr(verdict, "sets_apart", lambda data: apart)
    assert verdict.drifted(search) == drifts


OWN = 0.9 * VERDICT.own_curves


@pytest.mark.parametrize(
    ("given", "on"),
    [
        ({"chance": 0.5 * ALARM, "neighbours": 0.5 * ALARM, "curves": OWN}, True),
        ({"chance": 0.5 * ALARM, "neighbours": ALARM, "curves": OWN}, False),
        ({"chance": ALARM, "neighbours": 0.5 * ALARM, "curves": OWN}, False),
        ({"chance": 0.0, "neighbours": 0.0, "curves": VERDICT.own_curves, "runs": 0.5}, False),
        ({"chance": 1.0, "neighbours": 0.01, "runs": 0.001, "curves": OWN}, True),
        ({"chance": 1.0, "neighbours": 0.5, "runs": 0.5, "curves": OWN}, False),
    ],
)
def test_an_error_goes_on_from_point_to_point(given, on, monkeypatch):
    search, apart = repeated(**given)
    search.repeats.parts[OF_NEIGHBOURS] = max(search.repeats.parts[OF_NEIGHBOURS], 1e-300)
    monkeypatch.setattr(verdict, "sets_apart", lambda data: apart)
    assert verdict._carried_on(search) == on
    search.repeats.parts = {}
    assert not verdict._carried_on(search)


def fitted(evidence=0.0, error=0.05, floor=0.01, rss=0.0, relative=None):
    """A fit of a model with an effect."""
    known = {"relative_rms": error if relative is None else relative, "rss": rss}
    return SimpleNamespace(log_evidence=evidence, error=error, floor=floor, **known)


def grown(name, evidence=0.0, physics=True, narrow=False, **more):
    effect = SimpleNamespace(name=name, narrow=narrow, needs=frozenset({"temperature"}))
    return SimpleNamespace(
        names=(name,),
        effects=(effect,),
        refit=fitted(evidence, **more),
        beyond_physics=not physics,
    )


SPARE = 20


@pytest.mark.parametrize(
    ("before", "after", "error", "physics", "explained"),
    [
        (1000.0, 0.0, 0.0, True, True),
        (1000.0, 0.0, 0.0, False, False),
        (1000.0, 0.0, 0.01 * VERDICT.small_rest, True, False),
        (1000.0, 0.99 * VERDICT.remainder * 1000.0, 0.0, True, True),
        (1e6, 0.99 * VERDICT.remainder * 1e6, 0.0, True, True),
        (1e6, 1.01 * VERDICT.remainder * 1e6, 0.0, True, False),
        (SPARE, 0.0, 0.0, True, False),
        (SPARE + 0.1, 0.0, 0.0, True, True),
        (1000.0, 1.1 * max(VERDICT.remainder * 1000.0, VERDICT.nothing_left), 0.0, True, False),
    ],
)
def test_nearly_all_is_explained_where_little_is_left(before, after, error, physics, explained):
    base = fitted(0.0, rss=before + SPARE)
    base.fit = SimpleNamespace(dof=SPARE)
    best = grown("inertia", 5.0, physics, rss=after + SPARE, relative=error)
    search = SimpleNamespace(base=base, grown=[best])
    assert verdict._all_but_explained(search) == explained


CLEAR = 0.5 * SEARCH.decisive


def confounded(*gains):
    """A search beside effects of a condition that moved, by what they gain on the best."""
    names = ("arrhenius", "wlf", "vogel", "power", "drift", "more")
    rows = [grown(name, 10.0 + gain) for name, gain in zip(names, gains, strict=False)]
    return SimpleNamespace(
        confounded=rows,
        best=SimpleNamespace(log_evidence=10.0),
        base=SimpleNamespace(fit=SimpleNamespace(measurement=None)),
    )


def test_effects_of_a_condition_not_varied_alone_are_told(monkeypatch, stays):
    monkeypatch.setattr(verdict, "moved_along", lambda data: {"temperature", "time"})
    most = VERDICT.most_alike
    stays(
        [
            verdict._by_confounded(confounded(*gains))
            for gains in (
                (),
                (CLEAR,),
                (CLEAR + 0.1,),
                (CLEAR + 0.1, CLEAR, CLEAR + 0.2),
                [CLEAR + 1.0] * most,
                [CLEAR + 1.0] * (most + 1),
                [CLEAR + 1.0] * (most + 2),
            )
        ]
    )


GOOD = EVIDENCE.as_good
MOST = VERDICT.takes_most * 0.05


@pytest.mark.parametrize(
    ("rows", "gain", "named"),
    [
        ([grown("a", 9.0, relative=MOST)], SEARCH.decisive, ["a"]),
        ([grown("a", 9.0, relative=MOST)], 0.99 * SEARCH.decisive, []),
        ([grown("a", 9.0, relative=1.01 * MOST)], SEARCH.decisive, []),
        ([grown("a", 9.0, False, relative=MOST)], SEARCH.decisive, []),
        ([grown("a", 9.0, True, True, relative=MOST)], SEARCH.decisive, []),
        (
            [grown("a", 9.0, relative=MOST), grown("b", 9.1 - GOOD, relative=MOST)],
            SEARCH.decisive,
            ["a", "b"],
        ),
        (
            [grown("a", 9.0, relative=MOST), grown("b", 9.0 - GOOD, relative=MOST)],
            SEARCH.decisive,
            ["a"],
        ),
        (
            [grown("a", 9.0, relative=MOST), grown("a", 8.9, relative=1.0)],
            SEARCH.decisive,
            ["a"],
        ),
        (
            [grown(name, 9.0, relative=MOST) for name in "abcdef"[: VERDICT.most_alike]],
            SEARCH.decisive,
            list("abcdef"[: VERDICT.most_alike]),
        ),
        (
            [grown(name, 9.0, relative=MOST) for name in "abcdef"[: VERDICT.most_alike + 1]],
            SEARCH.decisive,
            [],
        ),
        ([], SEARCH.decisive, []),
    ],
)
def test_effects_that_take_most_of_the_error_are_told(rows, gain, named):
    search = SimpleNamespace(grown=rows, gain=gain, base=fitted())
    beside = SimpleNamespace(search=None)
    found = [each.names[0] for each in verdict._most_of_it(search, beside)]
    assert sorted(found) == sorted(named)


def told(**changed):
    """Evidence as a sentence needs it."""
    plain = {
        "classes": [("inertia",)], "beside": (), "imitators": set(), "drift": None, "untold": None,
        "moved": set(), "other_shape": 0.0, "leader": "inertia",
        "search": SimpleNamespace(
            base=SimpleNamespace(fit=SimpleNamespace(measurement=None)),
            confounded=[],
            best=SimpleNamespace(log_evidence=0.0, error=0.01, floor=0.01),
            left=SimpleNamespace(p_value=1.0),
        ),
        "instead": (), "rest": None,
        "explanations": [SimpleNamespace(names=("inertia",), probability=1.0)],
    }  # fmt: skip
    return SimpleNamespace(**plain | changed)


DRIFT = SimpleNamespace(effect="inertia", says="a drift of the specimen")


def test_names_of_what_is_missing(monkeypatch, stays):
    monkeypatch.setattr(verdict, "moved_along", lambda data: {"temperature", "time"})
    two = [("inertia", "mount")]
    stays(
        [
            verdict._named(told(**given))
            for given in (
                {},
                {"classes": two},
                {"classes": two, "beside": ("mount", "inertia")},
                {"beside": ("inertia",)},
                {"classes": two, "beside": ("delay",)},
                {"classes": two, "beside": ("delay", "gain")},
                {"imitators": {"inertia"}},
                {"imitators": {"delay"}},
                {"beside": ("delay",), "imitators": {"delay"}},
                {"drift": DRIFT, "moved": {"inertia"}},
                {"drift": SimpleNamespace(effect="delay", says="x"), "moved": {"inertia"}},
                {"moved": {"delay"}, "other_shape": 0.0},
                {"other_shape": VERDICT.worth_a_word},
                {"other_shape": VERDICT.worth_a_word + 0.01},
                {"other_shape": 1.0, "beside": ("delay",)},
                {"other_shape": 1.0, "classes": two},
            )
        ]
    )


def own(error=0.05, floor=0.01, scan=0.0, structure=0.0, alarm=0.0, gain=0.0, rows=()):
    """A search of the user's model."""
    base = fitted(error=error, floor=floor)
    units = SimpleNamespace(magnitude="|K|")
    base.fit = SimpleNamespace(measurement=SimpleNamespace(units=units))
    return SimpleNamespace(
        base=base, grown=list(rows), gain=gain, alarm=alarm, confounded=[],
        scan=SimpleNamespace(p_value=scan), structure=SimpleNamespace(p_value=structure),
        best=SimpleNamespace(log_evidence=0.0),
    )  # fmt: skip


def test_a_verdict_in_words(monkeypatch, stays):
    exact = [False]
    doubts = [""]
    monkeypatch.setattr(verdict, "is_arithmetic", lambda base: exact[0])
    monkeypatch.setattr(
        verdict, "beyond_floor", lambda base: base.error > VERDICT.misfit * base.floor
    )
    monkeypatch.setattr(verdict, "_of_repeats", lambda search: doubts[0])
    monkeypatch.setattr(verdict, "EqualRows", SimpleNamespace)
    level, noisy, little = VERDICT.structure_alarm, VERDICT.noisy, VERDICT.certified
    one, two = [object()], [object(), object()]

    class Behind:
        headline = "it goes with the current"

    def says(kind, search, outliers=(), behind=None, evidence=None):
        return verdict.sentence(search, evidence or told(), kind, outliers, behind)

    taking = [grown("inertia", 9.0, error=0.02, relative=0.0)]
    nearly = [grown("inertia", 9.0, error=0.99 * noisy * 0.01, relative=0.0)]
    strong = own(gain=SEARCH.decisive, rows=taking)
    weak = own(gain=SEARCH.decisive, rows=nearly)
    answer = {
        "adequate": says("adequate", own()),
        "adequate but for a point": says("adequate", own(), one),
        "adequate but for two": says("adequate", own(), two),
        "effect": says("effect-missing", own()),
        "open": says("inconclusive", own()),
        "open at the floor": says("inconclusive", own(error=0.01)),
        "one point": says("unexplained", own(scan=1.0, structure=1.0), one),
        "two points": says("unexplained", own(scan=1.0, structure=1.0), two),
        "a point and more": says("unexplained", own(scan=level, structure=1.0), one),
        "unexplained": says("unexplained", own()),
        "near the noise": says("unexplained", own(error=0.99 * noisy * 0.01)),
        "beyond the noise": says("unexplained", own(error=noisy * 0.01)),
        "little": says("unexplained", own(error=0.99 * little, floor=0.001)),
        "not little": says("unexplained", own(error=little, floor=0.001)),
        "most taken": says("unexplained", strong, evidence=told(search=strong)),
        "taken to the noise": says("unexplained", weak, evidence=told(search=weak)),
        "or a drift": says("unexplained", weak, evidence=told(search=weak, drift=DRIFT)),
        "or a drift elsewhere": says("unexplained", weak, evidence=told(drift=DRIFT)),
        "a drift and more": says("unexplained", strong, evidence=told(search=strong, drift=DRIFT)),
        "equal rows": says("unexplained", own(), behind=SimpleNamespace(headline="equal rows")),
        "a column": says("unexplained", own(), behind=Behind()),
    }
    doubts[0] = "repeats drift"
    answer["doubt"] = says("unexplained", own(alarm=1.01 * level))
    answer["alarm before doubt"] = says("unexplained", own(alarm=level))
    exact[0] = True
    answer["arithmetic"] = says("adequate", own())
    stays(answer)
    names = verdict.leading_names
    assert names(own(), told(classes=[("mount", "inertia")]), "effect-missing") == [
        "inertia",
        "mount",
    ]
    assert names(strong, told(), "unexplained") == ["inertia"]
    assert names(strong, told(), "inconclusive") == []
    moved = told()
    moved.search.confounded = [1]
    assert names(strong, moved, "unexplained") == []


@pytest.mark.parametrize(
    ("left", "ratio"),
    [(25.0, 4.0), (200.0, 1.0), (0.0, 1e24), (-1e-9, 1e24), (1e-30, 1e24)],
)
def test_exact_data_leave_rounding_and_never_less(left, ratio):
    """Less than nothing would make the chance of the unknown no number."""
    noise = SimpleNamespace(source="estimated", dof=9.0)
    search = SimpleNamespace(base=SimpleNamespace(fair_rss=100.0, noise=noise))
    assert marginal._ratio(search, left) == pytest.approx(ratio)


def test_repeats_add_what_they_tell_of_the_noise():
    noise = SimpleNamespace(source="repeats", dof=20.0)
    search = SimpleNamespace(base=SimpleNamespace(fair_rss=100.0, noise=noise))
    assert marginal._ratio(search, 20.0) == pytest.approx(3.0)


def test_what_an_effect_does_is_told_beside_the_fit_before(monkeypatch):
    """Of one that was not fitted only what is foretold."""
    monkeypatch.setattr(answer, "parameters_of", lambda known, believed: {"m": believed})
    before = SimpleNamespace(error=0.08, rss=400.0, floor=0.01, log_evidence=-50.0)
    effect = SimpleNamespace(name="inertia", summary="a mass that moves along", own_of=dict)
    influence = SimpleNamespace(effect=effect)
    score = SimpleNamespace(influence=influence, score=9.0, predicted=100.0, bound=0.002)
    row = answer._candidate(before, score, None, True)
    assert (row.probability, row.delta_bic, row.verdict) == (0.0, -np.inf, "cannot-tell")
    assert (row.score, row.bound, row.says) == (9.0, 0.002, "a mass that moves along")
    # A quarter of the squares is half of the error.
    assert row.predicted_error == pytest.approx(0.04)
    assert np.isnan([row.error_after, row.over_floor]).all()
    assert answer._predicted(before, -1.0) == 0.0
    refit = SimpleNamespace(error=0.02, log_evidence=-20.0, known=None)
    grown_ = SimpleNamespace(refit=refit, predicted=25.0)
    row = answer._candidate(before, score, grown_, True)
    assert (row.delta_bic, row.error_after) == (60.0, 0.02)
    assert row.over_floor == pytest.approx(2.0)
    assert row.predicted_error == pytest.approx(0.02)
    assert row.parameters == {"m": True}
    refit = SimpleNamespace(error=0.0123, log_evidence=-12.0, known=None)
    pair = SimpleNamespace(refit=refit, predicted=9.0)
    beside = answer._beside(before, row, pair, "delay", None)
    assert (beside.delta_bic, beside.error_beside) == (60.0, 0.0123)
    assert beside.predicted_error == pytest.approx(0.012)
    assert beside.says == "beside delay: a mass that moves along; 1.23 % is left with both"
    assert beside.parameters == {"m": False}
    alone = SimpleNamespace(refit=SimpleNamespace(log_evidence=-15.0))
    assert answer._beside(before, row, pair, "delay", alone).delta_bic == pytest.approx(6.0)


@pytest.mark.parametrize(
    ("fitted", "score", "word"),
    [(True, 50.0, "absent"), (False, 50.0, "cannot-tell"), (False, 1.0, "absent")],
)
def test_what_follows_the_misfit_is_not_absent_because_others_were_fitted(fitted, score, word):
    """Only the likeliest are fitted: of the others the scan has the last word."""
    base = SimpleNamespace(log_evidence=3.0)
    search = SimpleNamespace(base=base, scan=SimpleNamespace(threshold=12.0))
    seen = SimpleNamespace(score=score, bound=0.01)
    best = SimpleNamespace(log_evidence=2.0) if fitted else None
    assert answer._effect_verdict(search, seen, best, False) == word
