"""Fit one test, predict another: the band, and whether it holds."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import springpot
from springpot.errors import DataError, ModelError
from springpot.identification import Identification
from springpot.measurement import Measurement, TimeTest, Units
from springpot.registry import parse_model, plugins
from springpot.timetests import identify, predict_test

MODEL = parse_model("fractional-zener")
TRUE = MODEL.theta(k1=50.0, k2=400.0, c=60.0, alpha=0.55)
T = np.geomspace(0.01, 100.0, 150)


def scatter(seed, n=150):
    return 1.0 + 0.01 * np.random.default_rng(seed).normal(size=n)


def relaxed(seed=1):
    return TimeTest.of_relaxation(T, MODEL.relaxation(TRUE, T) * scatter(seed), "kPa")


def crept(factor=1.0, seed=2):
    return TimeTest.of_compliance(T, factor * MODEL.creep(TRUE, T) * scatter(seed), "kPa")


def swept(unit="kPa", size=1.0):
    omega = np.geomspace(0.03, 30.0, 25)
    return Measurement(
        omega,
        size * MODEL.stiffness(TRUE, omega) * scatter(3, 25),
        units=Units(unit, "-"),
        name="sweep",
    )


@pytest.fixture(scope="module")
def fit():
    return identify(relaxed(), MODEL)


def test_another_test_of_the_specimen_holds(fit):
    for test in (crept(), swept(), swept("Pa", 1e3)):
        found = predict_test(fit, test)
        assert found.holds, found.says
        assert "holds" in found.says
        assert found.error < 0.03


def test_another_specimen_does_not_hold_and_it_is_told_which_way(fit):
    found = predict_test(fit, crept(1.3))
    assert found.verdict == "fails"
    assert found.bias == pytest.approx(1 / 1.3 - 1.0, abs=0.05)
    assert "too little on average" in found.says


def test_a_sweep_predicts_a_test_in_time():
    found = predict_test(springpot.identify(swept(), MODEL), relaxed())
    assert found.error < 0.05
    assert found.verdict == "holds"
    assert found.inside < 1.0
    assert "beyond what the fitted tests saw" in found.says


@pytest.mark.soak
def test_the_band_holds_the_truth(fit):
    """At 95 % the true curve is within 1.5 times the band everywhere, for several noises."""
    outside = 0
    for seed in range(5, 15):
        found = predict_test(identify(relaxed(seed), MODEL), crept())
        exact = MODEL.creep(TRUE, T)
        middle, wide = 0.5 * (found.high + found.low), 0.5 * (found.high - found.low)
        outside += bool(np.any(np.abs(exact - middle) > 1.5 * wide))
    assert outside <= 2


def test_a_fit_that_does_not_determine_the_test_says_so():
    early = T < 0.02
    few = TimeTest.of_relaxation(T[early][:8], relaxed().response[early][:8], "kPa")
    assert predict_test(identify(few, MODEL), crept()).verdict == "vague"


def test_what_a_model_answers_to_noise_of_the_motion_is_expected():
    """The specimen never felt it: a mass makes 12 N of 2 µm at 2 kHz, and the prediction holds."""
    model, t = parse_model("kelvin + inertia"), np.arange(1000) / 2000.0
    theta = model.theta(k=200.0, c=0.5, **{"inertia.m": 6e-4})
    swept = np.geomspace(5.0, 500.0, 30)
    known = springpot.identify(
        Measurement(swept, model.stiffness(theta, swept) * scatter(4, 30), units=Units("kN/m")),
        model,
    )
    # With corners, or the motion would be taken without that noise.
    moved = 2.0 * np.abs(np.sin(40.0 * np.pi * t)) * (0.5 + t)
    force = 1e-3 * model.respond(theta, t, moved) + 0.1 * (scatter(5, 1000) - 1.0)
    read = moved + 0.2 * (scatter(6, 1000) - 1.0)
    found = predict_test(known, TimeTest.of_history(t, read, force, "mm", "kN"))
    assert found.verdict == "holds"
    assert found.error > 0.02
    assert "filter both channels alike first" in found.notes[0]
    quiet = predict_test(known, TimeTest.of_history(t, moved, force, "mm", "kN"))
    assert quiet.expected < 0.02
    assert not quiet.notes


def test_a_planned_test_is_predicted_and_not_judged(fit):
    t, fine = np.linspace(0.0, 5.0, 200), np.linspace(0.0, 5.0, 199 * 30 + 1)
    found = predict_test(fit, TimeTest.planned(t, 2.0 * np.sin(t), "%"))
    assert found.verdict == "not-judged"
    assert found.unit == "Pa"
    assert found.value == pytest.approx(
        1e3 * MODEL.respond(fit.theta, fine, 0.02 * np.sin(fine))[::30], rel=1e-3, abs=1e-2
    )
    assert found.to_dict()["error"] is None


def test_what_was_written_predicts_the_same(fit, tmp_path):
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit.to_dict()))
    again = springpot.load(path)
    assert isinstance(again, Identification)
    assert np.array_equal(predict_test(again, crept()).high, predict_test(fit, crept()).high)
    predicted = again.predict(omega=[1.0])
    assert predicted.stiffness[0] == pytest.approx(MODEL.stiffness(fit.theta, np.ones(1))[0])
    assert predicted.low.real[0] < predicted.storage[0] < predicted.high.real[0]


def test_a_covariance_belongs_to_the_numbers_that_are_printed(fit):
    """A mass in Mg, as kN/m have it, is printed in kg."""
    heavy = replace(fit, model=MODEL + plugins().effect("inertia"), units=Units("kN/m", "mm"))
    plain = np.eye(len(heavy.model.names))
    heavy = replace(heavy, slopes=plain, spread=plain)
    assert heavy.covariance.diagonal().tolist() == [1.0, 1.0, 1.0, 1.0, 1e6]


def test_what_was_held_is_told_and_held_again(tmp_path):
    fit = identify(relaxed(), MODEL.holding({"alpha": 0.5}, {"k1": (1.0, 60.0)}))
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit.to_dict()))
    again = springpot.load(path)
    assert again.parameters == fit.parameters
    assert str(again["alpha"]) == "0.5 (fixed)"
    assert again.model.parameters == fit.model.parameters
    assert np.array_equal(predict_test(again, crept()).high, predict_test(fit, crept()).high)


def test_a_stiffness_is_no_modulus(fit):
    omega = np.ones(3)
    with pytest.raises(DataError, match="a stiffness is no modulus"):
        predict_test(fit, Measurement(omega, omega + 1j, units=Units("kN/m", "mm")))


@pytest.mark.parametrize("effect", ["friction", "power-law-damper"])
def test_a_test_in_another_unit_of_length_is_brought_to_the_fit(effect):
    """F |v|^a with v in mm/s is 1000^a times another F with v in m/s: no whole length power."""
    model = parse_model(f"kelvin + {effect}")
    omega = np.tile(np.geomspace(1.0, 30.0, 8), 2)
    amplitude = np.repeat([1.0, 3.0], 8)
    at = springpot.rheology.Points(np.log(omega), amplitude=amplitude)
    stiffness = model.stiffness(np.array([100.0, 5.0, 20.0, 0.5][: len(model.names)]), at)
    noise = 1.0 + 0.002 * np.random.default_rng(3).normal(size=16)
    data = Measurement(
        omega, stiffness * noise, conditions={"amplitude": amplitude}, units=Units("N/mm", "mm")
    )
    found = springpot.identify(data, model)
    units = Units("N/m", "m")
    there = Measurement(
        omega, 1e3 * stiffness, conditions={"amplitude": 1e-3 * amplitude}, units=units
    )
    foretold = predict_test(found, there)
    assert foretold.holds
    assert (foretold.unit, foretold.measured[0]) == ("N/m", pytest.approx(1e3 * stiffness[0].real))


def warm(test, celsius: float):
    if isinstance(test, TimeTest):
        return replace(test, temperature=celsius)
    return replace(test, conditions={"temperature": np.full(len(test), celsius)})


@pytest.mark.soak
def test_a_joint_fit_knows_what_its_tests_measured_and_keeps_it(tmp_path):
    """Times count as one over them; temperatures of all tests together."""
    early = T < 3.0
    relaxed_early = TimeTest.of_relaxation(T[early], relaxed().response[early], "kPa")
    joint = identify([warm(relaxed_early, 20.0), warm(swept(), 25.0)], MODEL)
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(joint.to_dict()))
    again = springpot.load(path)
    for known in (joint.of_specimen, again.of_specimen):
        assert known.covered.rate == pytest.approx((0.03, 1.0 / T[0]), rel=1e-6)
        assert known.covered.conditions["temperature"] == (20.0, 25.0)
        asked = np.array([1e-4, 1.0, 1e9])
        found = known.predict(omega=asked, temperature=22.0)
        assert found.outside.tolist() == [True, False, True]
        assert len(found.notes) == 1
        with pytest.raises(ModelError, match="does not know temperature"):
            known.predict(omega=asked, temperature=80.0)
        late = predict_test(known, warm(crept(), 22.0))
        assert np.array_equal(late.outside, T > 2.0 / 0.03)
        assert late.outside.any()
        assert "beyond the measured" in " ".join(late.notes)
        cold = predict_test(known, warm(crept(), -40.0))
        assert cold.outside.all()
        assert cold.inside == 0.0
        assert "temperature of 20 to 25 [degC]" in cold.notes[0]
        assert all(point["outside_measured"] for point in cold.to_dict()["points"])


def test_a_fit_of_one_modulus_is_no_prediction_of_another():
    shear = replace(relaxed(), letter="G")
    fit = identify(shear, MODEL)
    assert fit.of_specimen.units.modulus == "G"
    assert Units(**fit.to_dict()["kept"]["units"]).modulus == "G"
    with pytest.raises(DataError, match="is a shear modulus and the test a Young's modulus"):
        predict_test(fit, replace(crept(), letter="E"))
    with pytest.raises(DataError, match="by Poisson's ratio"):
        identify([shear, replace(crept(), letter="E")], MODEL)
    tension = replace(swept(), units=Units("kPa", "-", letter="E"))
    with pytest.raises(DataError, match="by Poisson's ratio"):
        springpot.measurement.joined(
            [tension, replace(tension, units=Units("kPa", "-", letter="G"))]
        )
