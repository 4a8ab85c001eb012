"""Two effects that hide each other in a record are found together, and no more than these."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from springpot.diagnosis.grown import go_on_to_neighbours
from springpot.measurement import TimeTest
from springpot.registry import parse_model, plugins
from springpot.rheology.effect import SWEEPS
from springpot.thresholds import VERDICT
from springpot.timetests import discover, recorded
from springpot.timetests.discovery import TimeRungs, TimeSets, places

NAMES = ("force-drift", "thermal-force", "cubic-stiffness", "friction", "asymmetric-stiffness")


def record(model, **values):
    """A force on a maxwell element and what is beside it, with noise of 0.3 N."""
    grown, t = parse_model(model), np.linspace(0.0, 12.0, 160)
    x = np.sin(1.3 * t) * (1.0 + 0.3 * np.sin(0.4 * t))
    plan = TimeTest.of_history(t, x, np.ones(160), "m", "N", control="displacement")
    force = recorded(grown, grown.vector({"k": 100.0, "c": 150.0} | values), plan).value
    noise = 0.3 * np.random.default_rng(5).normal(size=160)
    return TimeTest.of_history(t, x, force + noise, "m", "N", control="displacement")


@pytest.mark.soak
def test_two_effects_of_which_neither_explains_much_are_accepted_together():
    values = {"asymmetric-stiffness.k2": 20.0, "force-drift.rate": 3.0}
    test = record("maxwell + asymmetric-stiffness + force-drift", **values)
    found = discover([test], "maxwell", [plugins().effect(name) for name in NAMES])
    # Alone each explains next to nothing, and no single one is beyond doubt.
    assert found.steps[0].diagnosis.verdict == "unexplained"
    assert len(found.steps[0].diagnosis.leading) != 1
    accepted = {step.accepted for step in found.steps[1:]}
    assert accepted == {"asymmetric-stiffness", "force-drift"}
    assert found.verdict == "adequate"
    for name, size in values.items():
        assert found.steps[-1].parameters[name].value == pytest.approx(size, rel=0.1)


def test_a_pair_is_no_worse_for_the_exponentials_by_which_it_was_found(monkeypatch):
    def of(names, cost, fit=None):
        effects = tuple(SimpleNamespace(name=name) for name in names)
        return SimpleNamespace(key=tuple(names), effects=effects, cost=cost, fit=fit)

    def fit_exactly(sets, one):
        exact = 26.0 if one.key == ("a", "b") else one.cost
        sets.fitted[one.key] = of(one.key, exact, fit="exact")

    def left_there(sets, best, effect):
        return of("".join(key for key in best.key if key != effect.name), np.inf)

    monkeypatch.setattr(TimeSets, "_fit_exactly", fit_exactly)
    monkeypatch.setattr(TimeSets, "_left_there", left_there)
    sets = TimeSets(None, None)
    for names, cost in (("a", 270.0), ("b", 1700.0), ("c", 900.0), ("ab", 166.0), ("bcd", 77.0)):
        sets.add(of(names, cost))
    for names in ("bc", "bd", "cd"):
        sets.add(of(names, 500.0, fit="exact"))
    assert sets.settle().key == ("a", "b")


@dataclass(frozen=True)
class Toy:
    """A set of letters."""

    key: tuple[str, ...]


class Toys:
    """Sets that are the better the more they share with a hidden one, and the smaller."""

    def __init__(self, hidden, begun):
        self.hidden, self.known = set(hidden), {tuple(begun)}

    def likeliest(self):
        def misses(key):
            return len(self.hidden ^ set(key)), key

        return [Toy(key) for key in sorted(self.known, key=misses)]

    def open(self, near):
        self.known |= {tuple(sorted({*one.key, new})) for one in near for new in "abd"}

    def extend(self, near):
        self.open(near)

    def exchange(self, best):
        for old in best.key:
            self.known |= {tuple(sorted({*best.key, new} - {old})) for new in "abcd"}


def test_a_search_ends_where_neither_more_nor_others_help():
    toys = Toys("cd", "b")
    go_on_to_neighbours(toys)
    assert toys.likeliest()[0].key == ("c", "d")


class Imitated(Toys):
    """Sets of which all with an imitator are better than any other, but for the hidden one."""

    def likeliest(self):
        def misses(key):
            return {*key} != self.hidden, "m" not in key, len(self.hidden ^ {*key}), key

        return [Toy(key) for key in sorted(self.known, key=misses)]

    def open(self, near):
        self.known |= {tuple(sorted({*one.key, new})) for one in near for new in "abcdefgm"}

    def exchange(self, best):
        pass


def test_what_one_effect_imitates_is_asked_though_it_is_in_all_of_the_likeliest():
    toys = Imitated("abc", "m")
    toys.known |= {("a",), ("b",)}
    go_on_to_neighbours(toys)
    assert toys.likeliest()[0].key == ("a", "b", "c")


class Behind(Toys):
    """Sets of one letter, each beside the next alone: the last is hidden, the first next best."""

    def likeliest(self):
        return [Toy(key) for key in sorted(self.known, key=lambda key: (key != ("d",), key))]

    def open(self, near):
        self.known |= {(chr(ord(one.key[0]) + 1),) for one in near}

    def extend(self, near):
        pass

    def exchange(self, best):
        pass


def test_what_lies_behind_worse_neighbours_is_found():
    toys = Behind("d", "a")
    go_on_to_neighbours(toys)
    assert toys.likeliest()[0].key == ("d",)


def test_what_may_stand_in_a_place_stands_beside_the_same_others():
    rivals = (
        ("cubic-stiffness", "force-drift"),
        ("cubic-stiffness", "thermal-force"),
        ("asymmetric-stiffness", "thermal-force"),
    )
    assert places(rivals, ["force-drift", "cubic-stiffness"]) == {
        "force-drift": ("force-drift", "thermal-force"),
        "cubic-stiffness": ("cubic-stiffness",),
    }


@pytest.mark.parametrize(
    ("alike", "probability", "leading", "taken"),
    [
        (("inertia",), 0.1, True, True),
        (("inertia", "mounting"), VERDICT.likely, True, True),
        (("inertia", "mounting"), VERDICT.likely - 1e-6, True, False),
        (("inertia",), 1.0, False, False),
    ],
)
def test_what_goes_in_is_the_very_effect_that_was_tried(alike, probability, leading, taken):
    """A mass of the rig of the sweeps alone went in as one of all rigs."""
    mass = plugins().effect("inertia").at(SWEEPS)
    first = SimpleNamespace(effect="inertia", physics=mass, alike=alike, probability=probability)
    told = SimpleNamespace(candidates=[first], leading=alike if leading else ())
    rungs = TimeRungs(tests=[], effects=[plugins().effect("inertia")])
    assert (rungs.decisive([SimpleNamespace(diagnosis=told)]) is mass) is taken
