"""What stands in a place of several effects is told with all that the data cannot tell from it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hidden_data import KELVIN, SWEEP, exact, measured

from springpot.diagnosis.discovery import _decisive
from springpot.diagnosis.evidence import Evidence
from springpot.diagnosis.search import search_from
from springpot.diagnosis.verdict import _named
from springpot.misfit.floor import fitted_to_floor
from springpot.registry import parse_model, plugins

TWINS = ("crosstalk", "friction", "hysteretic-loss", "elasto-sliding", "payne", "smooth-hysteresis")
"""At one amplitude each is, as fitted, a loss that is the same at all frequencies."""
LIBRARY = [plugins().effect(name) for name in (*TWINS, "phase-error", "backlash")]
"""The last two are one at one amplitude, too."""


def told(*sets):
    """The evidence of sets of these names and chances."""
    explained = [SimpleNamespace(names=tuple(names), probability=chance) for *names, chance in sets]
    return Evidence(SimpleNamespace(grown=[]), 0.0, 0.0, tuple(explained))


@pytest.mark.soak
def test_of_two_effects_each_is_named_with_its_twins():
    """However many looked better before anything was fitted."""
    held = replace(SWEEP, x=np.full(len(SWEEP.omega), 2.0))
    data = measured(held, (exact(KELVIN, held) + 8.0j) * np.exp(-0.05j), level=0.002)
    base = fitted_to_floor(parse_model(KELVIN.name), data)
    evidence = Evidence.of(search_from(base, LIBRARY, np.random.default_rng(0)))
    names = {frozenset(evidence.classes[0]), frozenset(evidence.classes[1])}
    assert {"phase-error", "backlash"} in names
    assert any({"friction", "hysteretic-loss"} <= group for group in names)


def grown(name, stiffness, log_likelihood=0.0, limit=False, beyond=(), contains=False):
    refit = SimpleNamespace(
        stiffness=np.array([stiffness]), log_likelihood=log_likelihood, contains=contains
    )
    return SimpleNamespace(refit=refit, beyond_physics=beyond, names=(name,), limit=limit)


@pytest.mark.parametrize(
    ("rival", "named"),
    [
        ({"stiffness": 1.1}, True),
        ({"stiffness": 2.0}, False),
        ({"stiffness": 1.1, "log_likelihood": -4.0}, False),
        ({"stiffness": 1.1, "limit": True}, False),
        ({"stiffness": 1.1, "beyond": ("b",)}, False),
        ({"stiffness": 1.1, "contains": True}, False),
    ],
)
def test_another_law_of_the_same_curve_is_named_however_dear_its_parameters(
    monkeypatch, rival, named
):
    """Unless it is the first by another name, a law at its limit."""
    monkeypatch.setattr("springpot.diagnosis.evidence.is_a_limit", lambda search, one: one.limit)
    monkeypatch.setattr("springpot.diagnosis.evidence.harmonic_evidence", lambda fit: 0.0)
    monkeypatch.setattr("springpot.diagnosis.evidence._contains", lambda fit, best: fit.contains)
    frame = SimpleNamespace(whiten=lambda k: np.array([k.real, k.imag]))
    fits = [grown("a", 1.0), grown("b", **rival)]
    explained = [SimpleNamespace(names=fit.names, probability=0.0, grown=fit) for fit in fits]
    found = Evidence(SimpleNamespace(frame=frame), 0.0, 0.0, tuple(explained))
    assert found.same_curve(("a",)) == [["b"] * named]


@pytest.mark.parametrize(("parameters", "named"), [(2, ["b", "c"]), (3, [])])
def test_several_of_one_curve_stand_in_the_place_of_one_of_as_many_parameters(
    monkeypatch, parameters, named
):
    """At one amplitude a slider is a spring and a loss."""
    monkeypatch.setattr("springpot.diagnosis.evidence.is_a_limit", lambda search, one: False)
    monkeypatch.setattr("springpot.diagnosis.evidence.harmonic_evidence", lambda fit: 0.0)
    monkeypatch.setattr("springpot.diagnosis.evidence._contains", lambda fit, best: False)
    frame = SimpleNamespace(whiten=lambda k: np.array([k.real, k.imag]))
    fits = [
        SimpleNamespace(
            refit=SimpleNamespace(stiffness=np.array([1.0]), log_likelihood=0.0, own=own),
            beyond_physics=(),
            names=names,
        )
        for names, own in ((("a",), "12"), (("b", "c"), "123"[:parameters]))
    ]
    explained = [SimpleNamespace(names=fit.names, probability=0.0, grown=fit) for fit in fits]
    found = Evidence(SimpleNamespace(frame=frame), 0.0, 0.0, tuple(explained))
    assert found.same_curve(("a",), of_any_size=True) == [named]
    assert found.same_curve(("a",)) == [[]]


def test_a_set_that_differs_in_both_places_is_told_where_each_may_stand():
    found = told(("a", "b", 0.5), ("a", "d", 0.2), ("c", "d", 0.2), ("c", "b", 0.1))
    wanted = {"a": {"a": 0.7, "c": 0.3}, "b": {"b": 0.6, "d": 0.4}}
    for names in (("a", "b"), ("b", "a")):
        for name, place in zip(names, found.stand_ins(names), strict=True):
            assert place == pytest.approx(wanted[name])


def test_it_stands_where_it_is_likelier():
    """What hardly ever stands in a place says nothing of it."""
    found = told(
        ("a", "b", 0.5), ("c", "b", 0.3), ("d", "b", 1e-9), ("a", "d", 0.1), ("d", "c", 0.05)
    )
    first, second = found.stand_ins(("a", "b"))
    assert max(second, key=second.get) == "b"
    assert np.isclose(first["c"], 0.35)
    assert np.isclose(second["d"], 0.15)


def test_two_may_stand_in_the_place_of_one_and_one_in_that_of_two():
    more = [("a", "c", "d", 0.3), ("c", 0.1), ("a", "b", "e", 0.1)]
    found = told(("a", "b", 0.4), ("a", "c", 0.1), *more)
    first, second = found.stand_ins(("a", "b"), of_any_size=True)
    assert first == pytest.approx({"a": 0.9})
    assert second == pytest.approx({"b": 0.5, "c": 0.5, "d": 0.3})
    assert found.stand_ins(("a", "b"))[1] == pytest.approx({"b": 0.4, "c": 0.1})


@pytest.mark.parametrize(
    ("second", "instead"),
    [
        (("b", "c", 0.1), ("b", "c")),
        (("b", "c", 0.05), ()),
        # With the first one, or what cannot be told from it, they are no other answer.
        (("a", "c", 0.1), ()),
        (("d", "c", 0.1), ()),
    ],
)
def test_two_in_the_place_of_one_are_named_and_none_is_accepted_unasked(
    monkeypatch, second, instead
):
    monkeypatch.setattr(Evidence, "classes", [["a", "d"]])
    monkeypatch.setattr(Evidence, "other_shape", 0.0)
    found = told(("a", 0.6), ("d", 0.3), second)
    assert found.instead == instead
    diagnosis = SimpleNamespace(verdict="effect-missing", candidates=[1], leading=[])
    case = SimpleNamespace(
        diagnosis=diagnosis,
        course=None,
        evidence=found,
        naming=SimpleNamespace(alarm=0.0, gain=np.inf, confounded=[]),
    )
    if instead:
        diagnosis.candidates = [SimpleNamespace(effect="a", error_after=0.0)]
        assert _decisive([SimpleNamespace(case=case)]) is None
        assert "or b and c together" in _named(found)
