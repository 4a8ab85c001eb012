"""Effects that are missing together are found as a set, and what stays is the likeliest set."""

from types import SimpleNamespace

import numpy as np
import pytest
from hidden_data import KELVIN, SWEEP, exact, measured

from springpot.diagnosis import discovery
from springpot.diagnosis.discovery import EffectSet, complete_set, likeliest_set, searched_sets
from springpot.diagnosis.evidence import Evidence
from springpot.diagnosis.search import search_from
from springpot.misfit.floor import fitted_to_floor
from springpot.misfit.refit import refit
from springpot.registry import parse_model, plugins

OMEGA = SWEEP.omega
DELAYED = (exact(KELVIN, SWEEP) - 2e-4 * OMEGA**2) * np.exp(-5e-4j * OMEGA)
THREE = (exact(KELVIN, SWEEP) - 2e-4 * OMEGA**2 + 15.0j) * np.exp(-5e-4j * OMEGA)
"""A mass, a delay, and a hysteretic loss of 15 kN/m."""
LIBRARY = [
    plugins().effect(name)
    for name in ("inertia", "time-delay", "hysteretic-loss", "series-spring", "parallel-dashpot")
]


def searched(stiffness):
    """What single effects and pairs explain."""
    base = fitted_to_floor(parse_model(KELVIN.name), measured(SWEEP, stiffness, level=0.002))
    return search_from(base, LIBRARY, np.random.default_rng(0))


def case_of(search):
    """An examination, as far as sets are concerned."""
    return SimpleNamespace(search=search, naming=search, course=None)


def with_effects(search, *names):
    """The fit of the search's base with some effects."""
    model = search.base.model
    for name in names:
        model = model + name
    return refit(model, search.base.data, search.base.noise)


@pytest.fixture(scope="module")
def three():
    return searched(THREE)


@pytest.fixture(scope="module")
def delayed():
    return searched(DELAYED)


@pytest.mark.soak
def test_three_effects_of_which_no_two_explain_the_data_are_found_together(three):
    assert max(len(grown.effects) for grown in three.grown) == 2
    found = complete_set(case_of(three), np.random.default_rng(0))
    assert sorted(each.name for each in found.effects) == [
        "hysteretic-loss",
        "inertia",
        "time-delay",
    ]
    # What a rung begins with fits as the set was fitted, whatever came first.
    model = parse_model(KELVIN.name) + "hysteretic-loss" + "time-delay" + "inertia"
    assert found.makes(model)
    off = measured(SWEEP, THREE, level=0.002).stiffness / model.stiffness(
        found.start(model), three.base.fit.measurement.points
    )
    assert np.sqrt(np.mean(np.abs(off - 1.0) ** 2)) < 1.2 * three.base.floor


def test_where_a_pair_explains_the_data_no_further_set_is_sought(delayed):
    assert complete_set(case_of(delayed), np.random.default_rng(0)) is None


def test_one_rung_is_exchanged_for_the_effect_that_belongs_there(delayed):
    """A mount took the place of the mass beside a delay."""
    last = with_effects(delayed, "series-spring", "time-delay")
    cases = [case_of(delayed), case_of(SimpleNamespace(base=last, scan=delayed.scan))]
    found = likeliest_set(cases, ["series-spring", "time-delay"], LIBRARY)
    # What stays keeps its rung and comes first.
    assert [effect.name for effect in found.effects] == ["time-delay", "inertia"]
    assert found.refit.rss < last.rss - 20.0


@pytest.mark.soak
def test_one_rung_is_exchanged_for_two_only_if_the_evidence_says_so(three, delayed):
    for search, wanted in ((three, ["hysteretic-loss", "time-delay"]), (delayed, ["time-delay"])):
        last = with_effects(search, "inertia", "parallel-dashpot")
        cases = [case_of(search), case_of(SimpleNamespace(base=last, scan=search.scan))]
        found = likeliest_set(cases, ["inertia", "parallel-dashpot"], LIBRARY)
        assert found.effects[0].name == "inertia"
        assert sorted(effect.name for effect in found.effects[1:]) == wanted


def test_rivals_that_the_first_rung_has_seen_are_weighed_too(delayed, monkeypatch):
    """They may differ from what was accepted in every place."""
    begun = []
    searched = discovery.searched_sets
    monkeypatch.setattr(
        discovery,
        "searched_sets",
        lambda search, effects: begun.extend(search.grown) or searched(search, []),
    )
    last = with_effects(delayed, "series-spring", "hysteretic-loss")
    cases = [case_of(delayed), case_of(SimpleNamespace(base=last, scan=delayed.scan))]
    found = likeliest_set(cases, ["series-spring", "hysteretic-loss"], LIBRARY)
    assert ("inertia", "time-delay") in {grown.key for grown in begun}
    assert {effect.name for effect in found.effects} == {"inertia", "time-delay"}


def test_a_single_rung_is_what_the_diagnosis_says():
    assert likeliest_set([], ["inertia"], LIBRARY) is None


def test_sets_that_differ_in_two_places_are_told_place_by_place(monkeypatch):
    def told(chance, *names):
        return SimpleNamespace(names=names, probability=chance)

    sets = [
        told(0.4, "a", "b"),
        told(0.3, "c", "d"),
        told(0.2, "c", "b"),
        told(0.1, "a", "b", "e"),
    ]
    effects = tuple(SimpleNamespace(name=name) for name in "ba")
    found = EffectSet(effects, None, Evidence(None, 0.0, 0.0, tuple(sets)))
    # Beside what is likely, what has the same curve, however unlikely.
    monkeypatch.setattr(Evidence, "same_curve", lambda self, names, of_any_size: [["d", "f"], []])
    assert found.places() == {"b": ("b", "d", "f"), "a": ("a", "c")}


def test_the_best_set_is_minimal(three):
    """Without any of its effects the evidence is less, beyond doubt."""
    found = searched_sets(three, LIBRARY)
    best = Evidence.of(found).explanations[0].grown
    for i in range(len(best.effects)):
        rest = tuple(sorted(name for j, name in enumerate(best.names) if j != i))
        (without, *_) = [one for one in found.grown if one.key == rest]
        assert without.refit.log_evidence < best.refit.log_evidence - 5.0
