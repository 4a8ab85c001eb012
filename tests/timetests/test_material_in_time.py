"""Any linear passive material from tests in time: no model is named, and the spectrum is found."""

from __future__ import annotations

import json

import numpy as np
import pytest

import springpot
from springpot.measurement import TimeTest
from springpot.registry import parse_model
from springpot.timetests import identify, predict_test

MODEL = parse_model("fractional-zener")
THETA = np.array([1.0, 3.0, 2.0, 0.6])
T = np.geomspace(0.01, 1000.0, 200)


def scattered(values, seed):
    return values * (1.0 + 0.01 * np.random.default_rng(seed).normal(size=len(values)))


RELAXED = TimeTest.of_relaxation(T, scattered(MODEL.relaxation(THETA, T), 1), "kPa")
CREPT = TimeTest.of_compliance(T, scattered(MODEL.creep(THETA, T), 2), "kPa")


@pytest.fixture(scope="module")
def fit():
    return identify(RELAXED, parse_model("material"))


def test_its_spectrum_follows_a_relaxation_to_the_noise(fit):
    [test] = fit.tests
    assert 0.85 < test.ratio < 1.1
    assert np.all(fit.theta >= 0.0)
    assert fit.parameters["K_e"]["value"] == pytest.approx(1.0, rel=0.1)
    assert set(fit.parameters) == {"K_e", "c"}


def test_what_it_says_of_another_test_and_of_frequencies(fit, tmp_path):
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit.to_dict()))
    known = springpot.load(path)
    assert predict_test(known, CREPT).error < 0.02
    omega = np.geomspace(3e-3, 30.0, 20)
    exact = MODEL.stiffness(THETA, omega)
    assert np.abs(known.predict(omega=omega).stiffness / exact - 1.0).max() < 0.01


def test_relaxation_and_creep_together_though_a_creep_is_not_linear():
    both = identify([RELAXED, CREPT], parse_model("material"))
    assert all(0.8 < test.ratio < 1.15 and test.agrees for test in both.tests)


def test_a_mass_around_it_is_found_from_a_record():
    model = parse_model("fractional-zener + inertia")
    t = np.linspace(0.0, 12.0, 600)
    x = np.sin(t**1.5)
    force = model.respond(np.append(THETA, 0.3), t, x)
    noise = 0.005 * np.abs(force).max() * np.random.default_rng(3).normal(size=len(t))
    found = identify(TimeTest.of_history(t, x, force + noise, "m", "N"), parse_model("material + inertia"))
    assert found.tests[0].ratio < 1.1
    assert found.parameters["inertia.m"]["value"] == pytest.approx(0.3, rel=0.05)
