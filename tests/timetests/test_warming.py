"""Tests during which the temperature moves: shifts follow it in reduced time."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from springpot.errors import DataError, ModelError
from springpot.measurement import Loading, TimeTest
from springpot.measurement.recording import recorded
from springpot.misfit.residuals_of_tests import parts_of_specimen
from springpot.registry import open_in_time, parse_model, plugins
from springpot.timetests import diagnose, identify, predicted
from springpot.timetests.exponentials import quick_parts
from springpot.timetests.native import TimeSearch
from springpot.timetests.score import TimeScan

DATA = (
    os.environ.get("SPRINGPOT_DATA", "").split(os.pathsep)[0]
    or Path(__file__).parents[3] / "shared" / "data"
)
UNSEEN = Path(DATA).parent / "unseen"
MODEL = parse_model("fractional-zener + arrhenius-shift")
THETA = MODEL.vector({"k1": 20.0, "k2": 300.0, "c": 50.0, "alpha": 0.6, "arrhenius-shift.Ea": 80.0})
T = np.linspace(0.0, 100.0, 401)
WARMER = 20.0 + 0.4 * T
REFERENCE = 293.15


def relaxed(temperature, kind=TimeTest.of_relaxation):
    blank = kind(T[1:], np.ones(len(T) - 1), "kPa", temperature=temperature)
    return blank, predicted(MODEL, THETA, blank, REFERENCE).value


@pytest.mark.parametrize("kind", [TimeTest.of_relaxation, TimeTest.of_compliance])
def test_a_temperature_that_stands_still_is_one_temperature(kind):
    _, one = relaxed(35.0, kind)
    _, each = relaxed(np.full(len(T) - 1, 35.0), kind)
    np.testing.assert_allclose(each, one, rtol=2e-5)


@pytest.mark.parametrize("kind", [TimeTest.of_relaxation, TimeTest.of_compliance])
def test_a_step_is_followed_in_reduced_time(kind):
    """The integral of dt / a_T by an own rule, put into the model at its reference temperature."""
    _, found = relaxed(WARMER[1:], kind)
    fine = np.linspace(0.0, 100.0, 40001)
    # Held at its first value before the first sample.
    kelvin = np.interp(fine, T[1:], WARMER[1:]) + 273.15
    pace = np.exp(-80.0 / 8.31446261815324e-3 * (1 / kelvin - 1 / REFERENCE))
    reduced = np.concatenate([[0.0], np.cumsum(0.5 * (pace[1:] + pace[:-1]) * np.diff(fine))])
    at = np.interp(T[1:], fine, reduced)
    plain = MODEL - "arrhenius-shift"
    law = plain.relaxation if kind == TimeTest.of_relaxation else plain.creep
    np.testing.assert_allclose(found, law(THETA[:4], at), rtol=1e-4)


@pytest.mark.parametrize("control", ["displacement", "force"])
def test_derivatives_while_it_warms(control):
    loading = Loading(T, np.sin(0.3 * T) * np.minimum(T / 10, 1))
    test = TimeTest(T, np.zeros(len(T)), loading, control, "-", "kPa", warmth=WARMER)

    def ask(theta):
        return predicted(MODEL, theta, test, REFERENCE, tolerance=1e-9)

    found = ask(THETA)
    for i, size in enumerate(THETA):
        step = 1e-5 * size * np.eye(len(THETA))[i]
        slope = (ask(THETA + step).value - ask(THETA - step).value) / (2e-5 * size)
        assert np.abs(found.by_theta[:, i] - slope).max() * size < 1e-6 * np.abs(found.value).max()


def test_an_activation_energy_is_found_from_one_record(tmp_path):
    """A file with a column of temperatures; one at a steady temperature would not tell it."""
    strain = 0.01 * np.sin(0.5 * T)
    blank = TimeTest.of_history(
        T, strain, 0 * T, "-", "kPa", control="displacement", temperature=WARMER
    )
    exact = predicted(MODEL, THETA, blank, REFERENCE).value
    stress = exact + 0.002 * np.abs(exact).max() * np.random.default_rng(1).normal(size=len(T))
    rows = "".join(
        ",".join(f"{each:.12g}" for each in row) + "\n"
        for row in zip(T, 100 * strain, stress, WARMER, strict=True)
    )
    path = tmp_path / "warming.csv"
    path.write_text("time [s],strain [%],stress [kPa],temperature [degC]\n" + rows)
    [test] = open_in_time(path)
    assert test.warmth is not None
    assert test.temperature == pytest.approx(40.0)
    found = identify(test, MODEL)
    row = found.parameters["arrhenius-shift.Ea"]
    assert row.low < 80.0 < row.high
    assert row.high - row.low < 10.0
    assert found.tests[0].over_floor < 1.15


@pytest.mark.soak
def test_what_the_test_did_is_followed_while_it_warms():
    """A drift and a slow ramp, each where it acts.

    Derivatives by all parameters against differences.
    """
    model = parse_model("fractional-zener + arrhenius-shift + finite-ramp + force-drift")
    blank, _ = relaxed(WARMER[1:])
    theta = np.append(THETA, [0.9, 0.2])
    assert model.names[-2:] == ("finite-ramp.rise", "force-drift.rate")

    def ask(theta):
        return recorded(model, theta, blank, REFERENCE, tolerance=1e-9)

    found = ask(theta)
    ramp = Loading(np.array([0.0, 0.9]), np.array([0.0, blank.loading.value[-1]]))
    expected = predicted(
        MODEL, THETA, replace(blank, loading=ramp), REFERENCE, tolerance=1e-9
    ).value
    np.testing.assert_allclose(found.value, expected + 0.2 * (blank.time - blank.start), rtol=1e-4)
    for i, size in enumerate(theta):
        step = 1e-5 * size * np.eye(len(theta))[i]
        slope = (ask(theta + step).value - ask(theta - step).value) / (2e-5 * size)
        # The slope by the rise has a step where the ramp ends; what a springpot answers to it is
        # steep at first.
        late = blank.time > 2.0
        assert (
            np.abs(found.by_theta[:, i] - slope)[late].max() * size
            < 1e-4 * np.abs(found.value).max()
        ), i


@pytest.mark.soak
def test_a_drift_is_told_from_a_record_that_warms():
    x = 0.01 * np.sin(0.5 * T)
    blank = TimeTest.of_history(T, x, 0 * T, "-", "kPa", control="displacement", temperature=WARMER)
    exact = predicted(MODEL, THETA, blank, REFERENCE).value + 0.004 * T
    noise = 0.002 * np.abs(exact).max() * np.random.default_rng(1).normal(size=len(T))
    found = identify(
        replace(blank, response=exact + noise), parse_model(f"{MODEL.name} + force-drift")
    )
    row = found.parameters["force-drift.rate"]
    assert row.low < 0.004 < row.high
    assert found.tests[0].over_floor < 1.15


@pytest.mark.soak
def test_what_no_exponentials_follow_is_sought_by_the_exact_answer():
    """Also where the exact answer was followed before: no start is then endless for the others."""
    x = 0.01 * np.sin(0.5 * T)
    blank = TimeTest.of_history(T, x, 0 * T, "-", "kPa", control="displacement", temperature=WARMER)
    exact = predicted(MODEL, THETA, blank, REFERENCE).value
    parts = parts_of_specimen([replace(blank, response=exact)])
    search = TimeSearch(MODEL, parts, REFERENCE, [0.8 * THETA], thorough=False)
    [start] = search.starts()
    assert np.all(np.isfinite(search.guarded(parts, start, True)[0]))
    found, _ = search.near(parts, [start])
    np.testing.assert_allclose(search.theta(found), THETA, rtol=0.02)


def test_what_cannot_follow_it_is_refused_by_name():
    blank, _ = relaxed(WARMER[1:])
    with pytest.raises(
        ModelError, match="'ageing' turns the material's clock, which the moving temperature turns"
    ):
        identify(blank, parse_model(f"{MODEL.name} + ageing"))
    loading = Loading(T, T)
    pulled = TimeTest(T, T, loading, "force", "-", "kPa", warmth=WARMER)
    with pytest.raises(ModelError, match="'inertia' is not followed"):
        identify(pulled, MODEL + "inertia")
    with pytest.raises(DataError, match="3 temperatures for 401 samples"):
        TimeTest(T, T, loading, warmth=np.ones(3))
    with pytest.raises(DataError, match="temperature of sample 2 is no number"):
        TimeTest.of_relaxation([1.0, 2.0], [1.0, 1.0], temperature=[20.0, np.nan])


@pytest.mark.soak
@pytest.mark.skipif(not UNSEEN.is_dir(), reason="the unseen files are not here")
def test_a_ramp_that_ends_at_a_sample_can_be_followed_by_a_clock_that_turns():
    [test] = open_in_time(f"{UNSEEN}/rel_lapo_1200.csv?time=s,relaxation=Pa")
    found = identify(test, parse_model("fractional-maxwell + thermal-transient + finite-ramp"))
    assert np.isfinite(found.relative_rms)


def test_a_smooth_motion_is_none_of_straight_lines_while_it_warms():
    """As at one temperature: with twelve samples a cycle these would be 2 % off."""
    steady = [np.full(2001, 35.0), 35.0, np.full(101, 35.0)]
    forces = []
    for temperature, n in zip(steady, (2001, 101, 101), strict=True):
        t = np.linspace(0.0, 100.0, n)
        x = 0.01 * np.sin(0.5 * t)
        blank = TimeTest.of_history(
            t, x, 0 * t, "-", "kPa", control="displacement", temperature=temperature
        )
        forces.append(predicted(MODEL, THETA, blank, REFERENCE).value)
    fine, one, each = forces
    np.testing.assert_allclose(each, one, atol=1e-4 * np.abs(one).max())
    inner = slice(1, -1)
    np.testing.assert_allclose(each[inner], fine[::20][inner], atol=4e-3 * np.abs(one).max())


def test_a_law_of_temperature_is_foretold_while_it_warms():
    """At the mean temperature alone it changes nothing."""
    strain = 0.01 * np.sin(0.5 * T)
    warmer = 30.0 + 0.02 * T
    blank = TimeTest.of_history(
        T, strain, 0 * T, "-", "kPa", control="displacement", temperature=warmer
    )
    exact = predicted(MODEL, THETA, blank, 304.15).value
    stress = exact + 0.002 * np.abs(exact).max() * np.random.default_rng(1).normal(size=len(T))
    test = replace(blank, response=stress)
    base = identify(test, MODEL - "arrhenius-shift")
    scan = TimeScan(base, quick_parts(parts_of_specimen([test])))
    effects = [plugins().effect(name) for name in ("arrhenius-shift", "force-drift")]
    entries = scan.entries(effects)
    [best] = entries["arrhenius-shift"]
    assert best.values[0] == pytest.approx(80.0, rel=0.15)
    assert best.drop > 10.0 * entries["force-drift"][0].drop


@pytest.mark.soak
def test_what_the_exact_response_alone_follows_is_fitted_to_all_samples():
    """A few of them, by which a search finds its way, have a bottom of their own."""
    t = np.linspace(0.0, 100.0, 601)
    strain, warmer = 0.01 * np.sin(0.5 * t), 30.0 + 0.02 * t
    blank = TimeTest.of_history(
        t, strain, 0 * t, "-", "kPa", control="displacement", temperature=warmer
    )
    exact = predicted(MODEL, THETA, blank, 304.15).value
    stress = exact + 0.02 * np.abs(exact).max() * np.random.default_rng(1).normal(size=len(t))
    parts = parts_of_specimen([replace(blank, response=stress)])
    search = TimeSearch(MODEL, quick_parts(parts), 304.15, [THETA], thorough=False)
    found, _ = search.near(parts, [search.inside(each) for each in search.starts()])
    left = parts[0].residual(MODEL, search.theta(found), 304.15).value
    best = parts[0].residual(MODEL, THETA, 304.15).value
    assert left @ left < best @ best


def test_a_specimen_that_warms_by_far_is_not_taken_for_diffusion():
    """From a model that is far off a linear step told that it cools."""
    model, t = parse_model("fractional-zener + thermal-transient"), np.geomspace(0.01, 100.0, 100)
    transient = {"thermal-transient.s": 3.3, "thermal-transient.tau": 24.0}
    theta = model.theta(k1=25.0, k2=55.0, c=34.0, alpha=0.65, **transient)
    force = recorded(model, theta, TimeTest.of_relaxation(t, t, "N/mm"), REFERENCE).value
    noise = 0.05 * np.random.default_rng(2).normal(size=len(t))
    library = [plugins().effect(name) for name in ("thermal-transient", "diffusion")]
    test = TimeTest.of_relaxation(t, force + noise, "N/mm")
    found = diagnose(test, parse_model("fractional-zener"), library)
    assert found.leading[0] == "thermal-transient"
    assert found.candidates[0].parameters["s"].value == pytest.approx(3.3, abs=0.5)
