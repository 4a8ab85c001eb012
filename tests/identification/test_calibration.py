"""What an instrument promises, as an error that all points have in common."""

import json
from dataclasses import replace

import numpy as np
import pytest

import springpot
from springpot.measurement import PROMISED
from springpot.measurement.timetest import TimeTest

MODEL = springpot.parse_model("fractional-maxwell")
TRUTH = {"k": 400.0, "c": 60.0, "alpha": 0.5}
OMEGA = np.geomspace(1.0, 300.0, 25)
T = np.geomspace(0.01, 100.0, 60)
THETA = MODEL.theta(**TRUTH)


def swept(seed, off=1.0):
    noise = 0.001 * np.random.default_rng(seed).normal(size=(2, len(OMEGA)))
    exact = MODEL.stiffness(THETA, OMEGA)
    return springpot.Measurement(
        OMEGA, off * exact * (1.0 + noise[0] + 1j * noise[1]), units=springpot.Units("kN/m")
    )


def relaxed(off=1.0):
    noise = 1.0 + 0.001 * np.random.default_rng(3).normal(size=len(T))
    return TimeTest.of_relaxation(T, off * MODEL.relaxation(THETA, T) * noise, "kN/m")


def holds(fit):
    return {name: fit[name].low <= value <= fit[name].high for name, value in TRUTH.items()}


def test_a_gain_moves_stiffness_and_no_order():
    fit = springpot.identify(swept(1), MODEL, accuracy="2%,0.001mrad")
    standard = 0.02 / 1.959964
    assert fit.budget["k"]["gain"] == pytest.approx(standard * fit["k"].value, rel=1e-3)
    assert fit.budget["c"]["gain"] == pytest.approx(standard * fit["c"].value, rel=1e-3)
    assert fit.budget["alpha"]["gain"] == pytest.approx(0.0, abs=1e-6)
    plain = springpot.identify(swept(1), MODEL)
    assert np.log(fit["k"].high / fit["k"].value) == pytest.approx(
        np.hypot(0.02, np.log(plain["k"].high / plain["k"].value)), rel=1e-2
    )
    assert fit["alpha"].high == pytest.approx(plain["alpha"].high, abs=1e-5)
    assert fit.budget["k"]["scatter"] == pytest.approx(np.sqrt(plain.covariance[0, 0]), rel=1e-9)


def test_a_turned_phase_moves_the_order():
    """Of a springpot alone: least squares of d ln c + d alpha (ln omega + i pi/2) against i phi."""
    model = springpot.parse_model("springpot")
    data = replace(swept(1), stiffness=model.stiffness(model.theta(c=60.0, alpha=0.5), OMEGA))
    fit = springpot.identify(data, model, accuracy="0.001%,3mrad")
    right = np.pi / 2.0
    expected = 0.003 / 1.959964 * right / (right**2 + np.var(np.log(OMEGA)))
    assert fit.budget["alpha"]["phase"] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("off", [1.015, 0.985 * np.exp(0.002j)])
def test_what_is_off_within_the_promise_is_held_with_it_alone(off):
    assert not all(holds(springpot.identify(swept(2, off), MODEL)).values())
    assert all(holds(springpot.identify(swept(2, off), MODEL, accuracy="2%,3mrad")).values())


@pytest.mark.soak
def test_it_covers_the_truth_in_nineteen_of_twenty():
    rng, held = np.random.default_rng(5), []
    for seed in range(40):
        gain, turn = rng.normal(size=2) / 1.96
        off = (1.0 + 0.02 * gain) * np.exp(0.005j * turn)
        held.append(holds(springpot.identify(swept(seed, off), MODEL, accuracy="2%,5mrad")))
    for name in TRUTH:
        assert np.mean([each[name] for each in held]) >= 0.85


@pytest.mark.soak
def test_tests_in_time_have_a_gain_and_no_phase():
    assert not holds(springpot.identify(relaxed(1.015), MODEL))["k"]
    fit = springpot.identify(relaxed(1.015), MODEL, accuracy="2%,3mrad")
    assert all(holds(fit).values())
    assert set(fit.budget["k"]) == {"scatter", "gain"}
    both = springpot.identify([relaxed(), swept(1)], MODEL, accuracy="2%,3mrad")
    assert both.budget["k"]["gain"] == pytest.approx(0.0102 * 400.0, rel=0.05)


@pytest.mark.soak_cases("relaxation")
@pytest.mark.parametrize("data", [swept(1), relaxed()], ids=["sweep", "relaxation"])
def test_a_kept_fit_and_its_predictions_hold_it(data, tmp_path):
    fit = springpot.identify(data, MODEL, accuracy="2%,3mrad")
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit.to_dict()), encoding="utf-8")
    again = springpot.load(path)
    assert again.to_dict() == fit.to_dict()
    plain = springpot.identify(data, MODEL)
    bands = [each.predict(frequency=[5.0]) for each in (fit, again, plain)]
    widths = [float(((band.high - band.low) / band.stiffness).real[0]) for band in bands]
    assert widths[0] == pytest.approx(widths[1], rel=1e-6)
    assert widths[0] > 0.039 > 4.0 * widths[2]


def test_any_material_and_what_a_data_set_says():
    told = replace(swept(1), provenance={PROMISED: "2%,3mrad"})
    fit = springpot.identify(told, "material")
    assert fit.budget
    assert fit.calibration.says == "2 %, 3 mrad"
    assert (
        springpot.identify(told, MODEL)["k"]
        == springpot.identify(swept(1), MODEL, accuracy="2%,3mrad")["k"]
    )


def test_what_somebody_wrote_above_a_table_is_no_promise():
    remarked = replace(swept(1), provenance={"accuracy": "class 1 of full scale"})
    assert springpot.identify(remarked, MODEL).calibration is None


def test_the_command_shows_the_budget(damper, request):
    command = request.getfixturevalue("springpot")
    told = command("identify", damper, "--model", "fractional-maxwell", "--accuracy", "2%", "-v")
    assert "accuracy    intervals hold 2 % of the instrument" in told.out
    [head] = [line for line in told.out.splitlines() if line.startswith("standard uncertainty")]
    assert head.split()[2:] == ["scatter", "gain", "phase", "together"]
    command("identify", damper, "--model", "fractional-maxwell", "--accuracy", "two").is_one_line(
        "accuracy 'two'"
    )


@pytest.mark.parametrize("data", [swept(1), relaxed()], ids=["sweep", "relaxation"])
def test_a_diagnosis_tells_the_intervals_of_the_identification(data):
    found = springpot.diagnose(data, MODEL, only=["inertia"], accuracy="2%,3mrad").parameters
    fit = springpot.identify(data, MODEL, accuracy="2%,3mrad")
    plain = springpot.identify(data, MODEL)
    for name, value in found.items():
        assert (value.low, value.high) == pytest.approx((fit[name].low, fit[name].high), rel=1e-3)
    assert found["k"].high - found["k"].low > 3.0 * (plain["k"].high - plain["k"].low)
