"""What is missing is found in the raw signal of a record, and nothing where nothing is."""

from __future__ import annotations

import numpy as np
import pytest

from springpot.measurement import TimeTest
from springpot.registry import parse_model, plugins
from springpot.timetests import diagnose

MODEL = parse_model("fractional-zener")
TRUE = MODEL.theta(k1=50.0, k2=400.0, c=60.0, alpha=0.55)
T = np.linspace(0.0, 15.0, 140)
X = np.sin(1.3 * T) * (1.0 + 0.3 * np.sin(0.31 * T))
TRIED = ("friction", "inertia", "dead-zone", "cubic-stiffness", "phase-error")


def library():
    return [plugins().effect(name) for name in TRIED]


def record(effect=None, values=(), seed=1):
    model = MODEL if effect is None else MODEL + effect
    force = model.respond(np.append(TRUE, values), T, X)
    noise = 0.005 * np.abs(force).max() * np.random.default_rng(seed).normal(size=len(T))
    return TimeTest.of_history(T, X, force + noise, "mm", "N")


def test_nothing_is_missing_where_nothing_is():
    found = diagnose(record(), MODEL, library())
    assert found.verdict == "adequate"
    assert found.leading == ()
    assert {each.verdict for each in found.candidates} <= {"absent"}
    # It has no law in time.
    assert "phase-error" not in {each.effect for each in found.candidates}


@pytest.mark.soak_cases("dead-zone-values2", "cubic-stiffness-values3", "inertia-values1")
@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("friction", [12.0]),
        ("inertia", [30.0]),
        ("dead-zone", [40.0, 0.3]),
        ("cubic-stiffness", [40.0]),
    ],
)
def test_what_is_missing_is_named_with_its_size(effect, values):
    found = diagnose(record(effect, values), MODEL, library())
    assert found.verdict == "effect-missing"
    assert found.leading == (effect,)
    best = found.candidates[0]
    assert best.over_floor < 1.25
    [first, *_] = best.parameters.values()
    if effect == "cubic-stiffness":
        assert any("where the motion turns" in place.says for place in found.where)
    # N/mm s^2 are 1,000 kg.
    assert first.value == pytest.approx(values[0] * (1e3 if first.unit == "kg" else 1.0), rel=0.1)


@pytest.mark.soak
def test_what_no_effect_explains_is_called_unexplained():
    odd = record()
    bump = 40.0 * np.exp(-(((T - 11.0) / 0.4) ** 2))
    test = TimeTest.of_history(T, X, odd.response + bump, "mm", "N")
    found = diagnose(test, MODEL, library())
    assert found.verdict == "unexplained"
    assert any("missed most from 10" in place.says for place in found.where)


def no_evidence_is_called_absent(found):
    for each in found.candidates:
        assert each.verdict != "absent" or each.delta_bic < 6.0, each


@pytest.mark.soak
def test_of_two_missing_effects_neither_is_called_absent_nor_one_of_them_all():
    model = MODEL + "friction" + "inertia"
    force = model.respond(np.append(TRUE, [12.0, 30.0]), T, X)
    noise = 0.002 * np.abs(force).max() * np.random.default_rng(1).normal(size=len(T))
    found = diagnose(TimeTest.of_history(T, X, force + noise, "mm", "N"), MODEL, library())
    assert found.verdict == "unexplained"
    said = {each.effect: each.verdict for each in found.candidates}
    assert said["friction"] == said["inertia"] == "cannot-tell"
    assert "missing" not in said.values()
    no_evidence_is_called_absent(found)


@pytest.mark.soak
def test_a_drift_in_a_relaxation_leaves_no_rival_absent_and_makes_no_fit_worse_than_none():
    t = np.geomspace(0.01, 100.0, 80)
    model = parse_model("fractional-maxwell")
    exact = model.relaxation(model.theta(k=400.0, c=60.0, alpha=0.5), t) + 0.5 * t
    test = TimeTest.of_relaxation(
        t, exact + 0.3 * np.random.default_rng(3).normal(size=len(t)), "kPa"
    )
    names = ("force-drift", "finite-ramp")
    effects = [each for each in plugins().items("effect") if each.name in names]
    found = diagnose(test, model, [*effects, plugins().effect("parallel-spring")])
    assert found.leading == ("force-drift",)
    assert {each.effect: each.verdict for each in found.candidates}[
        "parallel-spring"
    ] == "cannot-tell"
    no_evidence_is_called_absent(found)
    # A ramp that took no time changes nothing: it costs its parameter, and no more.
    ramp = next(each for each in found.candidates if each.effect == "finite-ramp")
    assert ramp.delta_bic > -2.0 * np.log(len(t))
    assert ramp.over_floor <= 1.001 * found.error.over_floor
