"""Intervals and objectives of tests in time are those of sweeps."""

from __future__ import annotations

import numpy as np
import pytest

import springpot
from springpot.identification.fitting import start_at
from springpot.timetests import fitting

MODEL = springpot.parse_model("fractional-maxwell")
THETA = MODEL.theta(k=400.0, c=60.0, alpha=0.5)
T = np.geomspace(0.02, 50.0, 60)


def relaxed(noise):
    exact = MODEL.relaxation(THETA, T)
    return springpot.TimeTest.of_relaxation(T, exact + noise, "kPa")


@pytest.mark.soak
@pytest.mark.parametrize("kind", ["profile", "bootstrap"])
def test_intervals_by_profiles_and_by_simulation_are_those_of_the_slopes(kind):
    scatter = 0.01 * np.random.default_rng(0).normal(size=len(T)) * MODEL.relaxation(THETA, T)
    plain = springpot.identify(relaxed(scatter), MODEL).parameters
    other = springpot.identify(relaxed(scatter), MODEL, intervals=kind, seed=1).parameters
    for name, value in plain.items():
        assert other[name].value == value.value
        # Of so little noise the objective is a parabola: all three agree.
        for end in ("low", "high"):
            apart = getattr(other[name], end) - getattr(value, end)
            assert abs(apart) < 0.1 * (value.high - value.low)
            assert apart != 0.0


@pytest.mark.soak
def test_a_profile_ends_at_the_bound_of_a_user():
    scatter = 0.01 * np.random.default_rng(0).normal(size=len(T)) * MODEL.relaxation(THETA, T)
    fit = springpot.identify(
        relaxed(scatter), MODEL, intervals="profile", bounds={"k": (396.0, 1000.0)}
    )
    assert fit["k"].low == pytest.approx(396.0)


@pytest.mark.soak
def test_an_objective_weighs_samples_among_each_other():
    # One plain fault where the response is small: relative differences feel it, plain ones do not.
    fault = np.where(T > 20.0, 0.2, 0.0) * MODEL.relaxation(THETA, T)
    off = {}
    for name in ("paper", "relative", "log"):
        fit = springpot.identify(relaxed(fault), MODEL, objective=name)
        assert fit.to_dict()["objective"]["name"] == name
        off[name] = abs(fit["alpha"].value - 0.5)
    assert off["paper"] < 0.2 * off["relative"]
    assert off["log"] == pytest.approx(off["relative"], rel=0.05)
    assert springpot.identify(relaxed(fault), MODEL).to_dict()["objective"]["name"] == "noise"


def test_the_search_begins_at_simpler_models_too(monkeypatch):
    begun = []

    def noted(model, start, fitted):
        begun.append(dict(start))
        return start_at(model, start, fitted)

    monkeypatch.setattr(fitting, "start_at", noted)
    whole = springpot.parse_model("fractional-zener")
    exact = whole.relaxation(whole.theta(k1=20.0, k2=60.0, c=40.0, alpha=0.7), T)
    test = springpot.TimeTest.of_relaxation(T, exact, "kPa")
    found = springpot.identify(test, whole, simpler=["zener", "fractional-maxwell"])
    assert [sorted(start) for start in begun] == [["c", "k1", "k2"], ["alpha", "c"]]
    assert found.theta == pytest.approx([20.0, 60.0, 40.0, 0.7], rel=1e-4)
