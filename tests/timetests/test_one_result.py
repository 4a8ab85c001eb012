"""A fit of tests in time is told, judged, kept and asked as one of a sweep."""

from __future__ import annotations

import json

import numpy as np
import pytest

import springpot

MODEL = springpot.parse_model("zener")
THETA = np.array([100.0, 300.0, 60.0])
TIME = np.geomspace(0.01, 100.0, 60)


@pytest.fixture(scope="module")
def relaxed():
    noise = 1.0 + 0.01 * np.random.default_rng(2).normal(size=60)
    exact = MODEL.relaxation(THETA, TIME)
    return springpot.TimeTest.of_relaxation(TIME, exact * noise, "Pa", name="relaxed")


@pytest.fixture(scope="module")
def fit(relaxed):
    return springpot.identify(relaxed, MODEL)


def test_its_error_stands_beside_the_noise_and_any_material(fit):
    error = fit.to_dict()["error"]
    assert error["good_enough"]
    assert error["material_floor"] <= error["relative_rms"]
    assert error["noise_floor"] == pytest.approx(error["relative_rms"], rel=0.1)
    assert "verdict     good enough" in str(fit)


def test_a_model_that_misses_its_test_is_not_good_enough(relaxed):
    poor = springpot.identify(relaxed, "maxwell")
    assert not poor.standing.good_enough
    assert poor.standing.material_floor < 0.2 * poor.relative_rms


def test_its_floors_come_back_from_a_file(fit, tmp_path):
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit.to_dict()))
    assert springpot.load(path).standing == fit.standing


def test_it_may_be_asked_at_rest(fit):
    still = fit.predict(frequency=[0.0])
    assert still.storage[0] == pytest.approx(fit["k1"].value, rel=1e-6)
    assert still.loss[0] == 0.0
    assert still.low.real[0] == pytest.approx(fit["k1"].low, rel=0.01)


@pytest.fixture(scope="module")
def diagnosis(relaxed):
    return springpot.diagnose(relaxed, "maxwell", only=["parallel-spring", "force-drift"])


def test_in_one_answer_a_test_has_one_noise_floor(fit, diagnosis):
    told = diagnosis.error
    assert diagnosis.tests[0].noise_floor == told.noise_floor
    assert diagnosis.tests[0].over_floor == pytest.approx(told.over_floor, rel=1e-12)
    assert fit.tests[0].noise_floor == fit.noise_floor
    compared = springpot.compare(fit.data, [MODEL, "maxwell"])
    for judged in compared.judgements:
        assert judged.by_test[0].noise_floor == judged.error.noise_floor


def test_its_chances_hold_nothing_and_something_unknown(diagnosis):
    chances = [each.probability for each in diagnosis.candidates]
    assert sum(chances) + sum(diagnosis.evidence.values()) == pytest.approx(1.0)
    assert diagnosis.evidence["nothing"] < 1e-6
