"""The table of verdicts: every line, and that no fact is forgotten."""

from __future__ import annotations

from dataclasses import fields
from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot.diagnosis.verdict import ALARMED, QUIET, Facts, _stand_out_together, rule_for
from springpot.thresholds import VERDICT

CLEAR = VERDICT.clear_evidence
SEEN = {"by_battery": True, "certain": True}


@pytest.mark.parametrize(
    ("facts", "verdict"),
    [
        ({}, "adequate"),
        (SEEN | {"exact": True, "gain": CLEAR, "named": True}, "adequate"),
        ({"few": True}, "inconclusive"),
        ({"outliers": True}, "adequate"),
        ({"outliers": True, "interference": True}, "unexplained"),
        ({"gain": CLEAR, "something": True}, "inconclusive"),
        ({"gain": CLEAR}, "adequate"),
        ({"unknown": True}, "inconclusive"),
        ({"material": True}, "unexplained"),
        ({"material": True, "gain": CLEAR, "something": True}, "unexplained"),
        ({"repeats": True}, "unexplained"),
        ({"exceeds": True}, "inconclusive"),
        ({"exceeds": True, "together": True}, "unexplained"),
        ({"exceeds": True, "unknown": True, "gain": CLEAR, "named": True}, "unexplained"),
        (SEEN | {"gain": CLEAR, "named": True}, "effect-missing"),
        (SEEN | {"gain": CLEAR, "named": True, "outliers": True}, "effect-missing"),
        (SEEN | {"gain": CLEAR, "named": True, "left": True}, "unexplained"),
        (SEEN | {"gain": CLEAR, "named": True, "left": True, "nearly_all": True}, "effect-missing"),
        (SEEN | {"gain": CLEAR, "named": True, "unknown": True}, "unexplained"),
        (
            SEEN
            | {
                "gain": CLEAR,
                "named": True,
                "unknown": True,
                "chain": True,
                "nearly_all": True,
            },
            "unexplained",
        ),
        (SEEN | {"gain": CLEAR}, "unexplained"),
        ({"by_scan": True, "gain": CLEAR}, "inconclusive"),
        ({"ruled_out": True, "gain": CLEAR, "named": True}, "effect-missing"),
        ({"ruled_out": True, "gain": CLEAR, "named": True, "unknown": True}, "unexplained"),
        (SEEN, "unexplained"),
        (SEEN | {"outliers": True}, "unexplained"),
        ({"by_scan": True, "certain": True, "gain": 0.5 * CLEAR, "named": True}, "effect-missing"),
        ({"by_scan": True, "gain": 0.5 * CLEAR, "named": True}, "inconclusive"),
        ({"by_scan": True, "outliers": True}, "unexplained"),
        ({"remembers": True}, "inconclusive"),
        ({"left": True}, "inconclusive"),
        ({"left": True, "below": True}, "adequate"),
        (SEEN | {"remembers": True}, "unexplained"),
    ],
)
def test_the_first_rule_that_holds_gives_the_verdict(facts, verdict):
    assert rule_for(Facts(**facts)).verdict == verdict


def many():
    """Combinations of facts, drawn of all that there are."""
    names = [field.name for field in fields(Facts) if field.name != "gain"]
    drawn = np.random.default_rng(1).random((20_000, len(names) + 1))
    # Few facts at once and many: the first rules would hide the last ones else.
    share = np.random.default_rng(2).random((len(drawn), 1))
    for values, size in zip((drawn[:, 1:] < share).tolist(), drawn[:, 0], strict=True):
        gain = (0.0, 0.5 * CLEAR, CLEAR)[int(3.0 * size)]
        yield Facts(**dict(zip(names, values, strict=True)), gain=gain)


def test_every_rule_is_needed_and_none_names_an_effect_without_an_alarm():
    used = set()
    for facts in many():
        rule = rule_for(facts)
        used.add(rule.reason)
        if rule.verdict == "effect-missing":
            assert facts.alarm
            assert facts.named
        if rule.verdict == "adequate":
            assert not facts.interference
        if rule.verdict == "adequate" and not facts.exact:
            assert not facts.alarm
            assert not facts.repeats
            assert not facts.unknown
    assert used == {rule.reason for rule in (*QUIET, *ALARMED)}


@pytest.mark.parametrize(
    ("rows", "together"), [([7, 18, 29], True), ([7, 18, 30], False), ([7, 19, 31], False)]
)
def test_points_of_several_sweeps_at_one_frequency_stand_out_together(monkeypatch, rows, together):
    """Three sweeps of eleven frequencies; what stands out has no neighbour."""
    outside = np.isin(np.arange(33), rows)
    monkeypatch.setattr("springpot.diagnosis.verdict._standing_out", lambda base: outside)
    omega = np.tile(np.arange(1.0, 12.0), 3)
    amplitude = np.repeat([0.1, 0.3, 1.0], 11)
    mean = springpot.Measurement(omega, omega + 1.0j, conditions={"amplitude": amplitude})
    base = SimpleNamespace(data=SimpleNamespace(mean=mean))
    assert _stand_out_together(base) is together


@pytest.mark.parametrize(("first", "together"), [(slice(0, 300), True), (slice(0, 1500, 5), False)])
def test_many_points_that_stand_out_are_counted_exactly(monkeypatch, first, together):
    """Of 1,500 points 300 can stand out in 10^324 ways, more than a floating-point number holds."""
    outside = np.zeros(1500, dtype=bool)
    outside[first] = True
    monkeypatch.setattr("springpot.diagnosis.verdict._standing_out", lambda base: outside)
    mean = springpot.Measurement(np.arange(1.0, 1501.0), np.full(1500, 1.0 + 1.0j))
    base = SimpleNamespace(data=SimpleNamespace(mean=mean))
    assert _stand_out_together(base) is together
