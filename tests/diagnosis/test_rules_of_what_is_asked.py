"""Rules of what a diagnosis asks for and tells, each at its edge."""

from __future__ import annotations

from math import inf
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import chi2

from springpot.diagnosis import answer, experiment, in_practice, marginal, notes, verdict
from springpot.diagnosis.result import NextExperiment
from springpot.measurement import Measurement
from springpot.thresholds import EVIDENCE


@pytest.mark.parametrize(
    ("off", "within"),
    [
        ([], True),
        ([0.9, 1.0], True),
        ([0.5, 1.01], True),
        ([1.0, 1.01], False),
        ([0.1] * 19 + [1.5], True),
        ([0.1] * 18 + [1.5, 1.5], False),
        ([0.1] * 19 + [9.0], False),
        ([0.1, np.nan], False),
    ],
)
def test_nearly_all_values_keep_a_promise(off, within):
    """One of twenty may lie beyond where 95 % are covered, if the whole stays within."""
    assert in_practice._within(np.array(off), 1.0) is within


def test_points_stand_out_at_few_frequencies_where_chance_would_choose_more():
    which = np.tile(np.arange(12), 4)
    alike = np.zeros(48, dtype=bool)
    alike[[3, 15, 27, 39]] = True
    assert verdict._at_few_frequencies(which, alike)
    apart = np.zeros(48, dtype=bool)
    apart[[3, 16, 29, 42]] = True
    assert not verdict._at_few_frequencies(which, apart)
    # A pair among ten at nine frequencies is nothing strange.
    pair = np.zeros(48, dtype=bool)
    pair[[0, 12, 1, 2, 3, 4, 5, 6, 7, 8]] = True
    assert not verdict._at_few_frequencies(which, pair)


def test_a_harmonic_is_tested_by_its_squares_over_the_noise(monkeypatch):
    monkeypatch.setattr(notes, "_growth", lambda data, share, rows: ", growing")
    harmonics = np.array([[0.01, 0.03], [0.02, 0.04j], [0.5, np.nan], [0.0, 0.06]])
    data = SimpleNamespace(harmonic=dict(enumerate(harmonics.T, 2)).get)
    relative = np.array([0.02, 0.02, 0.02, 0.04])
    [found] = notes._harmonic(data, relative, 3, "cubic")
    value = 1.5**2 + 2.0**2 + 1.5**2
    assert found.p_value == pytest.approx(chi2.sf(value, 6))
    assert found.says == "cubic nonlinearity: harmonic 3 is 4 % of the first, growing"
    [found] = notes._harmonic(data, relative, 2, "even")
    assert found.says.startswith("even nonlinearity: harmonic 2 is 1.5 % ")
    assert list(notes._harmonic(data, relative, 4, "x")) == []
    nothing = SimpleNamespace(harmonic={2: np.full(4, np.nan)}.get)
    assert list(notes._harmonic(nothing, relative, 2, "x")) == []


OF_A, OF_C = SimpleNamespace(effect="a"), SimpleNamespace(effect="c")
ASKED = {"verdict": "effect-missing", "leading": ["a"], "course": None, "outliers": ["point"]}


@pytest.mark.parametrize(
    ("state", "question"),
    [
        ({"course": SimpleNamespace(advice="wait")}, "wait"),
        ({"confounded": ["a"], "drift": OF_A}, ("confounded", ["a"])),
        ({"confounded": ["a"], "verdict": "adequate"}, "points"),
        ({"moved": {"b"}, "confounded": ["a"]}, ("confounded", ["b"])),
        ({"verdict": "adequate", "drift": OF_A}, "points"),
        ({"only_points": True, "drift": OF_A}, "points"),
        ({"drift": OF_A, "untold": OF_A}, "unknown"),
        ({"untold": OF_A}, "untold"),
        ({}, "between"),
        ({"drift": OF_C, "untold": OF_C}, "between"),
        ({"drift": OF_C, "partners": {"c": 0.5}}, "unknown"),
        ({"verdict": "unexplained", "drift": OF_C, "effects": {"c": 0.5}}, "unknown"),
        ({"verdict": "unexplained", "leading": []}, "unknown"),
        ({"verdict": "unexplained"}, "between"),
        ({"verdict": "unexplained", "leading": [], "drifted": True}, None),
        ({"verdict": "unexplained", "by_chain": True}, "unknown"),
        ({"by_chain": True}, "between"),
        ({"verdict": "inconclusive", "leading": []}, "between"),
        ({"verdict": "inconclusive", "leading": [], "named": False}, "unknown"),
    ],
)
def test_the_cheapest_question_comes_first(monkeypatch, state, question):
    state = ASKED | {"drifted": False} | state
    asked = {
        "experiment_on_confounded": lambda data, names: ("confounded", names),
        "experiment_on_points": lambda points: "points",
        "experiment_on_unknown": lambda data: "unknown",
        "experiment_on_untold": lambda untold, data: "untold",
        "_between_effects": lambda evidence: "between",
        "only_points": lambda search, points: state.get("only_points", False),
        "drifted": lambda search: state["drifted"],
        "by_chain": lambda evidence: state.get("by_chain", False),
        "prefers_effects": lambda evidence: state.get("named", True),
        "NextExperiment": lambda says, *rest: says,
    }
    for name, what in asked.items():
        monkeypatch.setattr(answer, name, what)
    data = SimpleNamespace(measurement=None)
    base = SimpleNamespace(fit=data, data=SimpleNamespace(raw=None))
    confounded = [SimpleNamespace(names=(name,)) for name in state.get("confounded", [])]
    search = SimpleNamespace(base=base, confounded=confounded)
    evidence = SimpleNamespace(
        search=search,
        moved=state.get("moved", set()),
        classes=[["a", "b"]],
        drift=state.get("drift"),
        untold=state.get("untold"),
        partners=state.get("partners", {}),
        effects=state.get("effects", {}),
    )
    found = answer._next_experiment(
        search, evidence, *(state[name] for name in ("verdict", "outliers", "leading", "course"))
    )
    assert found == question


@pytest.mark.parametrize(("telling", "found"), [({"b", "c"}, "b"), ({"c"}, "c"), (set(), "b")])
def test_the_leader_is_told_from_the_next_rival_that_can_be_told_from_it(
    monkeypatch, telling, found
):
    chances = {"c": 0.2, "a": 0.5, "b": 0.29, "d": 1e-5}
    pairs = experiment.worth_telling_apart(chances)
    assert pairs == [("a", "b"), ("a", "c")]

    def asked(plans, fits, parts, names, shares):
        assert (fits, shares) == (names, (chances["a"], chances[names[1]]))
        return NextExperiment("", names, 1.0, {"omega": [1.0]} if names[1] in telling else {})

    monkeypatch.setattr(experiment, "most_telling", asked)
    known = {name: name for name in chances}, chances, (), None
    assert experiment.first_telling(pairs, *known).separates == ("a", found)
    assert experiment.first_telling([], *known) is None


@pytest.mark.parametrize(("left", "explained"), [(60.0, 40.0), (100.0, 0.0), (130.0, 0.0)])
def test_evidence_is_half_of_what_is_explained_less_what_it_costs(left, explained):
    """Of known noise: three parameters, each as the logarithm of one and what is explained."""
    noise = SimpleNamespace(dof=inf, source="given", worth=1.0)
    base = SimpleNamespace(noise=noise, log_likelihood=-50.0, fair_rss=100.0)
    found = marginal._discounted(SimpleNamespace(base=base), left, 3, 2)
    price = 2.0 * EVIDENCE.unknown_size
    wanted = -50.0 + 0.5 * (explained - 3.0 * np.log1p(explained)) - price
    assert found == pytest.approx(wanted)


def test_evidence_of_unknown_noise_counts_what_parameters_leave_free():
    """Twelve numbers less four are eight; a half is left by three: g is 5 of ratio 2."""
    noise = SimpleNamespace(dof=8, source="estimated", worth=1.0)
    base = SimpleNamespace(
        noise=noise,
        log_likelihood=-50.0,
        fair_rss=100.0,
        own=range(3),
        lines=1,
        fit=SimpleNamespace(measurement=range(6)),
    )
    search = SimpleNamespace(base=base)
    assert marginal._freedom(search) == 8
    assert marginal._drop(search, 50.0, 3) == pytest.approx(5.0)
    found = marginal._discounted(search, 50.0, 3, 1)
    wanted = 0.5 * (5.0 * np.log(6.0) - 8.0 * np.log(3.5)) - EVIDENCE.unknown_size - 50.0
    assert found == pytest.approx(wanted)
    assert marginal._drop(search, 50.0, 9) == 0.0


@pytest.mark.parametrize(("count", "steps"), [(3, 0), (4, 1), (5, 2)])
def test_a_step_of_gain_has_two_frequencies_on_each_side(monkeypatch, count, steps):
    """Between the second and the third, the last place explaining most."""
    tried = []

    def each_alone(frame, curves):
        tried.append(curves.real)
        return np.arange(len(curves), dtype=float)

    monkeypatch.setattr(marginal, "_each_alone", each_alone)
    hertz = 2.0 ** np.arange(count)
    data = Measurement(2.0 * np.pi * np.repeat(hertz, 2), np.full(2 * count, 1.0 + 1.0j))
    found = list(marginal._step(SimpleNamespace(measurement=data)))
    assert len(found) == min(steps, 1)
    if not steps:
        return
    wanted = [np.repeat(hertz, 2) > hertz[i] for i in range(1, steps + 1)]
    np.testing.assert_array_equal(tried, [wanted])
    place = np.sqrt(hertz[steps] * hertz[steps + 1])
    assert found[0].says == f"a gain that steps at {data.units.at(place)}"
    assert found[0].shapes == 1


@pytest.mark.parametrize(
    ("temperature", "stand"),
    [
        ([20, 20, 40, 60], True),
        ([60, 40, 40, 20], True),
        ([20, 40, 20, 60], False),
        ([20, 20, 20, 20], False),
    ],
)
def test_rows_stand_by_a_condition_whose_levels_follow_one_another(temperature, stand):
    omega = np.tile([1.0, 2.0, 3.0], 4)
    column = np.repeat(np.array(temperature, dtype=float), 3)
    data = Measurement(omega, np.full(12, 1.0 + 1.0j), conditions={"temperature": column})
    assert marginal._stand_by_a_condition(SimpleNamespace(measurement=data)) is stand


def test_slow_curves_are_polynomials_over_the_whole_without_a_constant():
    along = np.array([3.0, 4.0, 7.0])
    x = np.array([-1.0, -0.5, 1.0])
    curves = marginal._creep(along)
    assert len(curves) == marginal.DRIFT_DEGREE
    np.testing.assert_allclose(curves[0], x)
    np.testing.assert_allclose(curves[1], 1.5 * x**2 - 0.5)
