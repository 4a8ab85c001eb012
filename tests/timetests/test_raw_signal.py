"""What harmonics hide is seen in the record, located in the loop and named.

Noise with a memory is no misfit.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from springpot.measurement import TimeTest, noise_of
from springpot.misfit.residual_scatter import scatter_of
from springpot.misfit.where_in_time import places
from springpot.registry import parse_model, plugins
from springpot.timetests import compare, diagnose, discover, identify, recorded

MODEL = parse_model("fractional-zener")
THETA = MODEL.theta(k1=50.0, k2=400.0, c=60.0, alpha=0.55)
T = np.linspace(0.0, 15.0, 220)
X = np.sin(1.3 * T) * (1.0 + 0.3 * np.sin(0.31 * T))
TRIED = ("backlash-in-time", "asymmetric-stop", "force-clipping", "force-drift")


def library():
    return [plugins().effect(name) for name in TRIED]


def record(effect="", values=(), seed=1):
    test = TimeTest.of_history(T, X, X, "mm", "N", control="displacement")
    if effect:
        model = MODEL + plugins().effect(effect)
        force = recorded(model, np.concatenate([THETA, values]), test).value
    else:
        force = recorded(MODEL, THETA, test).value
    noise = 0.005 * np.abs(force).max() * np.random.default_rng(seed).normal(size=len(T))
    return TimeTest.of_history(T, X, force + noise, "mm", "N", control="displacement")


HIDDEN = {
    "backlash-in-time": ([0.15], "flank, displacement rising"),
    "asymmetric-stop": ([60.0, 0.7], "at the upper end"),
    "force-clipping": ([90.0], "at the upper end, displacement rising"),
}


@cache
def found(name):
    return diagnose(record(name, HIDDEN[name][0]), MODEL, library())


@pytest.mark.soak
@pytest.mark.parametrize("name", HIDDEN)
def test_what_harmonics_hide_is_named_with_its_size(name):
    answer, (values, _) = found(name), HIDDEN[name]
    assert answer.verdict == "effect-missing"
    assert answer.leading == (name,)
    first = next(iter(answer.best.parameters.values()))
    assert first.value == pytest.approx(values[0], rel=0.15)
    assert answer.best.over_floor == pytest.approx(1.0, abs=0.2)


@pytest.mark.soak
@pytest.mark.parametrize("name", HIDDEN)
def test_it_is_located_in_the_loop(name):
    [loop] = [place for place in found(name).where if place.plane == "loop"]
    assert HIDDEN[name][1] in loop.says
    assert loop.size > 1.5


def test_a_stop_on_one_side_is_missed_on_that_side_alone():
    residual = np.where(0.8 * np.abs(X).max() < X, 8.0, 0.0)
    [loop] = [place for place in places(record(), residual) if place.plane == "loop"]
    assert (loop.low, loop.high) == (0.8, 1.0)
    assert "on that side alone" in loop.says


def test_a_record_that_is_level_at_its_top_is_told():
    test = record()
    limit = 0.7 * np.abs(test.response).max()
    flat = TimeTest.of_history(
        T, X, np.clip(test.response, -limit, limit), "mm", "N", control="displacement"
    )
    residual = test.response - flat.response
    [loop] = [place for place in places(flat, residual) if place.plane == "loop"]
    assert "the record is level at its top" in loop.says
    assert not any("level" in place.says for place in places(test, residual))


@pytest.mark.soak
def test_the_answer_has_the_keys_of_one_on_a_sweep():
    path = Path(__file__).parents[2] / "docs" / "schemas" / "diagnosis.json"
    answer = found("force-clipping").to_dict()
    known = set(json.loads(path.read_text(encoding="utf-8"))["properties"])
    # Quantities are told where nothing is missing.
    assert known - set(answer) == {"quantities"}
    assert set(answer) <= known
    assert set(answer["where"][0]) == {"plane", "condition", "from", "to", "size", "says"}
    assert answer["candidates"][0]["class"] == ["force-clipping"]


@pytest.mark.soak
def test_two_effects_are_found_one_after_the_other():
    test = record("force-clipping", [90.0])
    drifting = TimeTest.of_history(T, X, test.response + 1.5 * T, "mm", "N", control="displacement")
    # The drift comes after the amplifier here, so that both are there as they are.
    found = discover([drifting], MODEL, library())
    assert found.steps[1].accepted in ("force-drift", "force-clipping")
    assert len(found.steps) >= 2
    assert found.steps[-1].over_floor < found.steps[0].over_floor


def test_models_with_and_without_a_drift_are_compared_by_name():
    t = np.geomspace(0.01, 100.0, 120)
    exact = MODEL.relaxation(THETA, t) + 0.3 * t
    noise = 0.5 * np.random.default_rng(3).normal(size=len(t))
    test = TimeTest.of_relaxation(t, exact + noise, "kPa")
    found = compare([test], ["fractional-zener", "fractional-zener + force-drift"])
    assert found.best.model.name == "fractional-zener + force-drift"
    assert found.judgements[1].delta_bic > 10.0
    assert found.best.parameters["force-drift.rate"].value == pytest.approx(0.3, rel=0.1)
    assert parse_model(found.best.model.name).names == found.best.model.names


@pytest.mark.parametrize("memory", [0.0, 0.5])
def test_noise_with_a_memory_is_no_misfit(memory):
    rng = np.random.default_rng(4)
    flagged = 0
    for _ in range(40):
        noise = np.zeros(260)
        for i in range(1, 260):
            noise[i] = memory * noise[i - 1] + np.sqrt(1.0 - memory**2) * rng.normal()
        scatter = scatter_of(noise[60:])
        flagged += scatter.misfit
        assert scatter.size == pytest.approx(1.0, abs=0.4)
    assert flagged <= 1


def test_a_slow_misfit_beneath_the_noise_is_seen():
    rng = np.random.default_rng(5)
    slow = 0.8 * np.sin(np.linspace(0.0, 12.0, 300))
    assert scatter_of(slow + rng.normal(size=300)).misfit
    bump = 4.0 * np.exp(-(((np.arange(300) - 140.0) / 5.0) ** 2))
    assert scatter_of(bump + rng.normal(size=300)).misfit


@pytest.mark.soak
def test_a_channel_at_its_limit_carries_no_noise_and_is_named():
    # What saturates last cuts the noise off too: half of such a record repeats one value.
    noisy = record()
    limit = 0.7 * np.abs(noisy.response).max()
    held = TimeTest.of_history(
        T, X, np.clip(noisy.response, -limit, limit), "mm", "N", control="displacement"
    )
    assert noise_of(held).absolute == pytest.approx(noise_of(noisy).absolute, rel=0.3)
    answer = diagnose(held, MODEL, library())
    assert answer.verdict == "effect-missing"
    assert answer.leading == ("force-clipping",)
    assert answer.best.over_floor == pytest.approx(1.0, abs=0.2)


def test_opposite_signs_are_told_and_a_mass_that_pushes_back_is_none():
    test = record()
    turned = TimeTest.of_history(T, X, -test.response, "mm", "N", control="displacement")
    assert any("had the wrong sign" in note for note in identify(turned, MODEL).notes)
    assert not any("wrong sign" in note for note in identify(test, MODEL).notes)
    heavy = parse_model("fractional-zener + inertia")
    force = heavy.respond(
        heavy.vector({**dict(zip(MODEL.names, THETA, strict=True)), "inertia.m": 1000.0}), T, X
    )
    pushes = TimeTest.of_history(T, X, force, "mm", "N", control="displacement")
    assert np.sum(X * pushes.response) < 0.0
    assert not any("wrong sign" in note for note in identify(pushes, MODEL).notes)


def test_a_limit_that_nothing_reaches_has_no_size():
    clipping = [plugins().effect("force-clipping")]
    for seed in (3, 4):
        [found] = diagnose(record(seed=seed), MODEL, clipping).candidates
        assert found.verdict == "absent"
        assert found.parameters == {}
