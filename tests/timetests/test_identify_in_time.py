"""Identification from tests in time, alone and together."""

from __future__ import annotations

import numpy as np
import pytest

from springpot.errors import DataError, ModelError
from springpot.measurement import Loading, Measurement, TimeTest, Units
from springpot.registry import parse_model
from springpot.timetests import identify, predicted

ZENER = parse_model("fractional-zener")
TRUE = ZENER.theta(k1=50.0, k2=400.0, c=60.0, alpha=0.55)


def noisy(exact, share, seed):
    return exact * (1.0 + share * np.random.default_rng(seed).normal(size=len(exact)))


def relaxation(rise=0.0, share=0.01, seed=1, n=200):
    t = np.geomspace(max(0.01, 1.2 * rise), 100.0, n)
    clean = TimeTest.of_relaxation(t, np.ones(n), "kPa", rise=rise)
    exact = predicted(ZENER, TRUE, clean).value
    return TimeTest.of_relaxation(t, noisy(exact, share, seed), "kPa", rise=rise)


def creep(share=0.01, seed=2, n=200):
    t = np.geomspace(0.01, 100.0, n)
    return TimeTest.of_compliance(t, noisy(ZENER.creep(TRUE, t), share, seed), "kPa")


def sweep(share=0.01, seed=3):
    omega = np.geomspace(0.05, 50.0, 30)
    rng = np.random.default_rng(seed)
    error = 1.0 + share * (rng.normal(size=30) + 1j * rng.normal(size=30))
    return Measurement(
        omega, ZENER.stiffness(TRUE, omega) * error, units=Units("kPa", "-"), name="sweep"
    )


def history(control="displacement", seed=4, n=800):
    t = np.linspace(0.0, 20.0, n)
    imposed = np.where(t < 8.0, t / 8.0, 1.0) * (1.0 + 0.5 * np.sin(3.0 * t))
    exact = (ZENER.respond if control == "displacement" else ZENER.respond_force)(TRUE, t, imposed)
    answer = exact + 0.005 * np.abs(exact).max() * np.random.default_rng(seed).normal(size=n)
    return TimeTest(t, answer, Loading(t, imposed), control, "-", "kPa", name=f"history-{control}")


def startup(seed=5, n=200):
    t = np.linspace(0.05, 10.0, n)
    ramp = Loading(np.array([0.0, 10.0]), np.array([0.0, 0.2]))
    exact = predicted(ZENER, TRUE, TimeTest(t, np.ones(n), ramp, force_unit="kPa")).value
    return TimeTest(t, noisy(exact, 0.005, seed), ramp, force_unit="kPa", name="startup")


def recovery(seed=6, n=300):
    t = np.geomspace(0.01, 40.0, n)
    load = Loading(np.array([0.0, 0.0, 10.0, 10.0]), np.array([0.0, 2.0, 2.0, 0.0]))
    exact = predicted(ZENER, TRUE, TimeTest(t, np.ones(n), load, "force", "-", "kPa")).value
    return TimeTest(t, noisy(exact, 0.01, seed), load, "force", "-", "kPa", name="recovery")


@pytest.mark.parametrize(
    "test",
    [
        relaxation(),
        relaxation(rise=0.3),
        creep(),
        history(),
        history("force"),
        startup(),
        recovery(),
    ],
    ids=lambda test: f"{test.name}-{test.rise:.1g}",
)
def test_the_true_parameters_lie_in_their_intervals(test):
    found = identify(test, ZENER)
    low, high = found.low, found.high
    wider = 1.5  # one interval of twenty may miss; none by half its width
    middle, reach = np.sqrt(low * high), np.sqrt(high / low) ** wider
    assert np.all((middle / reach <= TRUE) & (middle * reach >= TRUE)), (found, low, high)
    assert found.converged
    # The noise is told by some hundred samples, to a tenth or so.
    assert found.tests[0].over_floor == pytest.approx(1.0, abs=0.3)


@pytest.mark.soak
def test_a_ramp_that_is_ignored_spoils_the_fit_and_one_that_is_told_does_not():
    slow = relaxation(rise=0.3, share=0.002)
    told = identify(slow, ZENER)
    taken_for_a_step = TimeTest(slow.time, slow.response, Loading.step(), force_unit="kPa")
    assert told.tests[0].over_floor < 1.2
    assert identify(taken_for_a_step, ZENER).tests[0].over_floor > 2.0


def test_together_tests_tell_more_and_agree():
    alone = identify(relaxation(), ZENER)
    both = identify([relaxation(), creep(), sweep()], ZENER)
    width = [np.log(found.high / found.low) for found in (alone, both)]
    assert np.all(width[1] < width[0])
    assert [test.kind for test in both.tests] == ["relaxation", "creep", "sweep"]
    assert all(test.agrees for test in both.tests)
    assert both.theta == pytest.approx(TRUE, rel=0.03)


@pytest.mark.soak
def test_tests_of_two_specimens_do_not_agree():
    t = np.geomspace(0.01, 100.0, 200)
    other = TimeTest.of_compliance(
        t, noisy(1.3 * ZENER.creep(TRUE, t), 0.01, 7), "kPa", name="another"
    )
    found = identify([relaxation(), other], ZENER)
    assert not all(test.agrees for test in found.tests)
    assert any("does not agree" in note for note in found.notes)


@pytest.mark.soak
def test_units_of_the_second_test_are_converted():
    t = np.geomspace(0.01, 100.0, 200)
    in_pascal = TimeTest.of_compliance(t, noisy(1e-3 * ZENER.creep(TRUE, t), 0.01, 2), "Pa")
    found = identify([relaxation(), in_pascal], ZENER)
    assert found.theta == pytest.approx(TRUE, rel=0.03)
    assert found.parameters["k1"].unit == "kPa"


@pytest.mark.soak
def test_friction_beside_the_material_is_found_from_a_record():
    model = ZENER + "friction"
    theta = np.append(TRUE, 12.0)
    t = np.linspace(0.0, 20.0, 600)
    x = np.sin(t) * (1.0 + 0.3 * np.sin(0.31 * t))
    force = model.respond(theta, t, x)
    force = force + 0.003 * np.abs(force).max() * np.random.default_rng(8).normal(size=600)
    test = TimeTest.of_history(t, x, force, "mm", "N")
    assert identify(test, ZENER).tests[0].over_floor > 3.0
    found = identify(test, model)
    assert found.theta[-1] == pytest.approx(12.0, rel=0.05)
    assert found.tests[0].over_floor < 1.3


def test_the_same_data_give_the_same_bits():
    assert np.array_equal(identify(creep(), ZENER).theta, identify(creep(), ZENER).theta)


def test_what_does_not_fit_is_refused():
    with pytest.raises(ModelError, match="'payne'"):
        identify(history(), parse_model("fractional-zener + payne"))
    with pytest.raises(DataError, match="needs a temperature"):
        identify(relaxation(), parse_model("fractional-zener + wlf-shift"))
    stiffness = Measurement(np.ones(3), np.ones(3) + 1j, units=Units("kN/m", "mm"))
    with pytest.raises(DataError, match="a stiffness is no modulus"):
        identify([relaxation(), stiffness], ZENER)


def test_a_parameter_that_the_test_does_not_see_is_said_to_be_undetermined():
    found = identify(relaxation(), ZENER + "inertia")
    assert any("inertia.m is hardly determined" in note for note in found.notes)


def test_a_fit_of_tests_in_time_comes_back(tmp_path):
    """Written as JSON and loaded: the same values, intervals and predictions."""
    import json

    import springpot
    from springpot.report.text import jsonable
    from springpot.rheology import Points
    from springpot.timetests import identify, predict_test

    model = springpot.parse_model("zener")
    time = np.geomspace(0.01, 100.0, 60)
    theta = np.array([100.0, 300.0, 60.0])
    noise = 1.0 + 0.01 * np.random.default_rng(2).normal(size=60)
    test = springpot.TimeTest.of_relaxation(
        time, model.relaxation(theta, time) * noise, "Pa", name="relaxed"
    )
    found = identify([test], model)
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(jsonable(found.to_dict())))
    again = springpot.load(path)
    assert repr(again) == repr(found)
    assert again.parameters == found.parameters
    assert again["c"] == found["c"]
    assert again.relative_rms == found.relative_rms
    assert again.notes == found.notes
    assert again.tests[0].name == "relaxed"
    assert again.to_dict() == json.loads(path.read_text())
    expected = model.stiffness(found.theta, Points(np.log([2.0])))
    assert again.predict(omega=[2.0]).stiffness == pytest.approx(expected, rel=1e-12)
    later = springpot.TimeTest.of_relaxation(
        time, model.relaxation(theta, time), "Pa", name="again"
    )
    assert predict_test(again, later).says == predict_test(found, later).says
