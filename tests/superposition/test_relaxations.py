"""Relaxations at several temperatures become one curve as sweeps do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import springpot
from springpot.rheology import Points
from springpot.rheology.continuum import Relaxation

MODEL = springpot.parse_model("fractional-zener")
THETA = np.array([1.0, 1000.0, 300.0, 0.5])
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
    assert lines.bent(x).real == pytest.approx((slopes[0] - slopes[1]) / (2.0 * step), rel=1e-5)


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
