"""Relaxations at several temperatures become one curve as sweeps do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import springpot
from springpot import TimeTest
from springpot.rheology import Points
from springpot.rheology.elements import Compliance, Relaxation
from springpot.superposition.laws import after_steps

MODEL = springpot.parse_model("fractional-zener")
THETA = np.array([1.0, 1000.0, 300.0, 0.5])
CREEPING, FLOWING = springpot.parse_model("maxwell"), np.array([10.0, 400.0])
SHARED = Path(__file__).parents[3] / "shared" / "unseen" / "time_user_raw.csv"


def log_a(celsius):
    """WLF about 60 degC."""
    return -12.0 * np.log(10.0) * (celsius - 60.0) / (80.0 + celsius - 60.0)


def rows(temperatures, t, noise=0.0):
    rng, table = np.random.default_rng(1), []
    for celsius in temperatures:
        modulus = MODEL.relaxation(THETA, t / np.exp(log_a(celsius)))
        scatter = 1.0 + noise * rng.normal(size=len(t))
        table += [(s, g, celsius) for s, g in zip(t, modulus * scatter, strict=True)]
    return table


def file_of(path, table):
    lines = [f"{t!r},{g!r},{celsius}" for t, g, celsius in (map(float, row) for row in table)]
    path.write_text("\n".join(["time [s],relaxation [MPa],temperature [degC]", *lines]) + "\n")
    return path


def test_a_relaxation_is_that_of_the_network_with_exact_slopes():
    lines = Relaxation((0.1, 1.0, 10.0))
    theta, x = np.array([1.0, 5.0, 2.0, 3.0, 4.0]), np.log([0.02, 0.5, 3.0])
    exact = 1.0 + np.array([2.0, 3.0, 4.0]) @ np.exp(-np.outer([0.1, 1.0, 10.0], np.exp(-x)))
    answer = lines.respond(theta, Points(x), 2)
    assert answer.value.real == pytest.approx(exact)
    assert not answer.value.imag.any()
    step = 1e-5
    ends = [lines.respond(theta, Points(x + s), 2) for s in (step, -step)]
    assert answer.by_log_omega.real == pytest.approx(
        (ends[0].value - ends[1].value).real / (2.0 * step), rel=1e-6
    )
    slopes = [lines.basis(x + s, True)[1][2:].real for s in (step, -step)]
    assert lines.moved(lines.basis(x, False)[0][2:])[1].real == pytest.approx(
        (slopes[0] - slopes[1]) / (2.0 * step), rel=1e-5
    )


@pytest.mark.soak
def test_factors_of_relaxations_lie_in_their_intervals(springpot, tmp_path):
    path = file_of(tmp_path / "steps.csv", rows([55, 60, 65, 70], np.geomspace(0.1, 300, 10), 0.01))
    out = tmp_path / "curve.csv"
    words = ["--reference", "60degC", "--no-vertical", "-o", out, "--json"]
    curve = springpot("mastercurve", path, *words).json
    for level in curve["levels"]:
        assert level["a_low"] <= np.exp(log_a(level["value"])) <= level["a_high"]
        assert level["determined"]
    assert len(curve["curve"]["time"]) == len(curve["curve"]["relaxation"]) == 40
    assert {"WLF", "Arrhenius"} & {law["law"] for law in curve["laws"]}
    # The table of the curve is a test in time of its own.
    assert "1 test in time, 40 points" in springpot("inspect", out).out


def creep(temperatures, t, noise, lift=0.0, seed=2):
    """Compliances of a melt, which flows, each test with its own factor of the modulus."""
    random = np.random.default_rng(seed)
    tests = []
    for celsius in temperatures:
        b = np.exp(lift * (celsius - temperatures[-1] + 10.0))
        strain = CREEPING.creep(FLOWING, t / np.exp(log_a(celsius))) / b
        strain = strain * (1.0 + noise * random.normal(size=len(t)))
        tests.append(TimeTest.of_compliance(t, strain, unit="MPa", temperature=celsius))
    return tests


@pytest.mark.soak
@pytest.mark.parametrize("lift", [0.0, 0.02])
def test_factors_of_creep_lie_in_their_intervals(lift):
    """Those of the modulus: a compliance falls where b rises."""
    temperatures = [50.0, 60.0, 70.0]
    tests = creep(temperatures, np.geomspace(0.1, 1000, 11), 0.005, lift)
    curve = springpot.mastercurve(tests, reference=60.0)
    assert curve.columns == ("time", "compliance")
    assert curve.simplicity.error < 0.01
    for level in curve.levels:
        assert level.a_low <= np.exp(log_a(level.value)) <= level.a_high
        assert level.b_low <= np.exp(lift * (level.value - 60.0)) <= level.b_high
    line = curve.curve(1.0 / np.array([1.0, 1e4])).real
    np.testing.assert_allclose(line, CREEPING.creep(FLOWING, np.array([1.0, 1e4])), rtol=0.02)


def test_the_table_of_a_creep_curve_is_creep(springpot, tmp_path):
    rows = [
        f"{t!r},{j!r},{test.temperature}"
        for test in creep([55.0, 60.0], np.geomspace(0.1, 100, 9), 0.002)
        for t, j in zip(test.time.tolist(), test.response.tolist(), strict=True)
    ]
    path, out = tmp_path / "creep.csv", tmp_path / "curve.csv"
    path.write_text("\n".join(["time [s],compliance [1/MPa],temperature [degC]", *rows]) + "\n")
    curve = springpot("mastercurve", path, "--no-vertical", "-o", out, "--json").json["curve"]
    assert curve["unit"] == "1/MPa"
    assert len(curve["time"]) == len(curve["compliance"]) == 18
    assert "creep, 18 points" in springpot("inspect", out).out


def test_a_creep_compliance_is_that_of_its_lines_with_exact_slopes():
    lines = Compliance((0.1, 1.0, 10.0))
    theta, x = np.array([1.0, 0.5, 2.0, 3.0, 4.0]), np.log([0.02, 0.5, 3.0])
    t = np.exp(-x)
    exact = 1.0 + 0.5 * t + np.array([2.0, 3.0, 4.0]) @ -np.expm1(-np.outer([0.1, 1.0, 10.0], t))
    answer = lines.respond(theta, Points(x), 2)
    assert answer.value.real == pytest.approx(exact)
    step = 1e-5
    ends = [lines.respond(theta, Points(x + s), 2) for s in (step, -step)]
    slopes = (ends[0].value - ends[1].value).real / (2.0 * step)
    assert answer.by_log_omega.real == pytest.approx(slopes, rel=1e-6)
    slopes = [lines.basis(x + s, True)[1][2:].real for s in (step, -step)]
    assert lines.moved(lines.basis(x, False)[0][2:])[1].real == pytest.approx(
        (slopes[0] - slopes[1]) / (2.0 * step), rel=1e-5
    )


def test_samples_closer_than_twenty_a_decade_are_taken_together():
    """A logger's thousand samples of one second cost no more than their mean."""
    test = creep([60.0], np.linspace(0.1, 100.0, 2000), 0.0)[0]
    _, points = after_steps([test])
    assert len(points) <= 3 * 20 + 1
    exact = CREEPING.creep(FLOWING, 1.0 / points.omega)
    np.testing.assert_allclose(points.storage, exact, rtol=2e-3)


def test_tests_below_one_another_are_told_apart_by_their_temperature(tmp_path):
    # Each falling in time, as some programs write a spectrum of times.
    table = rows([20, 30, 40], np.geomspace(10.0, 0.01, 6))
    tests = springpot.read(file_of(tmp_path / "below.csv", table))
    assert [round(test.temperature) for test in tests] == [20, 30, 40]
    assert all(np.all(np.diff(test.time) > 0.0) for test in tests)


def test_a_master_curve_of_what_is_no_relaxation_is_one_line(springpot, write, tmp_path):
    path = write("time [s],relaxation [MPa]\n1,3\n10,2\n100,1\n", "bare.csv")
    springpot("mastercurve", path).is_one_line("needs the temperature", "temperature=25[degC]")


@pytest.mark.soak
@pytest.mark.skipif(not SHARED.exists(), reason="the data stand beside the project's folder")
def test_relaxations_at_21_temperatures_of_another_laboratory():
    curve = springpot.mastercurve(SHARED, reference="25degC", vertical=False)
    assert len(curve.levels) == 21
    a = np.array([level.a for level in curve.levels])
    # Over the whole transition each hotter test relaxes sooner.
    assert np.all(np.diff(a[8:]) < 0.0)
    assert curve.simplicity.error < 0.02
