"""What no effect of the library makes is weighed beside those that it holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from springpot.errors import ModelError
from springpot.measurement import Measurement, TimeTest
from springpot.measurement.timenoise import strays
from springpot.misfit.residual_scatter import (
    ResidualScatter,
    scatter_of,
    scatter_of_sweep,
)
from springpot.misfit.residuals_of_tests import InTimePart, parts_of_specimen
from springpot.registry import parse_model, plugins
from springpot.timetests import diagnose, identify
from springpot.timetests.disturbances import Slip, likeliest_jump, slip_beside
from springpot.timetests.hypotheses import FitResiduals, delta_bic

TIME = np.geomspace(0.01, 100.0, 80)
OMEGA = np.geomspace(0.1, 100.0, 17)
ZENER = parse_model("zener")
THETA = ZENER.theta(k1=400.0, k2=300.0, c=60.0)
LIKE_A_SLIP = ("force-drift", "thermal-force", "ageing", "finite-ramp")


def library(*names):
    return [plugins().effect(name) for name in names]


def relaxation(model, theta, jump=0.0, seed=1):
    exact = model.relaxation(theta, TIME)
    noise = 0.01 * exact.max() * np.random.default_rng(seed).normal(size=len(TIME))
    return TimeTest.of_relaxation(TIME, exact + jump * (np.arange(80) >= 45) + noise, name="relax")


JUMP = f"a jump in relax at {TIME[45]:.3g} s"


@pytest.mark.soak
@pytest.mark.parametrize("height", [-40.0, -100.0])
def test_a_slip_is_no_effect_of_the_library(height):
    found = diagnose(relaxation(ZENER, THETA, height), ZENER, library(*LIKE_A_SLIP))
    assert found.verdict == "unexplained"
    assert found.leading == ()
    assert f"{JUMP}, as of what slips or lets go, explains more" in found.says
    assert found.evidence["unknown"] > 0.9


@pytest.mark.soak
def test_a_slip_is_seen_though_a_power_law_has_bent_to_it():
    time, model = np.linspace(1.0, 500.0, 300), parse_model("fractional-zener")
    exact = model.relaxation(model.theta(k1=200.0, k2=500.0, c=40.0, alpha=0.5), time)
    noise = 1.7 * np.random.default_rng(3).normal(size=300)
    slipped = exact * np.where(time > 170.0, 0.95, 1.0) + noise
    found = diagnose(
        TimeTest.of_relaxation(time, slipped, name="relax"), model, library(*LIKE_A_SLIP)
    )
    assert found.verdict == "unexplained"
    assert "a jump in relax at 171 s" in found.says


@pytest.mark.soak
def test_a_large_slip_is_no_noise_with_a_memory():
    found = diagnose(relaxation(ZENER, THETA, -200.0), ZENER, library(*LIKE_A_SLIP))
    assert found.verdict == "unexplained"
    assert found.error.over_floor > 2.0


def test_where_a_model_cannot_be_followed_nothing_is_sought(monkeypatch):
    test, followed = relaxation(ZENER, THETA, -200.0), InTimePart.residual
    fit, parts = identify(test, ZENER), parts_of_specimen([test])
    before = FitResiduals.of(fit, parts)
    assert before.misfit

    def near(part, model, theta, reference, coarse=False):
        if not np.allclose(theta, fit.theta):
            raise ModelError("no sum of relaxations")
        return followed(part, model, theta, reference, coarse)

    monkeypatch.setattr(InTimePart, "residual", near)
    assert JUMP in slip_beside(parts, fit, before).says


@pytest.mark.soak
def test_what_drifts_is_no_jump():
    drifting = parse_model("zener + force-drift")
    exact = relaxation(ZENER, THETA).response + 2.0 * TIME
    found = diagnose(
        TimeTest.of_relaxation(TIME, exact, name="relax"), ZENER, library(*LIKE_A_SLIP)
    )
    assert found.verdict == "effect-missing"
    assert found.leading[0] == drifting.effects[0].name
    assert found.evidence["unknown"] < 0.01


def test_a_jump_is_found_where_it_is_and_taken_out():
    rng, white = np.random.default_rng(3), ResidualScatter(1.0, 0.0, 0.0, 1.0)
    noise, slopes = rng.normal(size=100), np.column_stack([np.ones(100), np.arange(100.0)])
    jumped = noise + 5.0 * (np.arange(100) >= 60)
    found = likeliest_jump([(jumped, slopes)], [np.ones(100)], [white])
    assert found.row == 60
    assert np.std(found.left[0]) == pytest.approx(np.std(noise), rel=0.05)


@pytest.mark.soak
def test_a_jump_pays_for_its_place():
    """Of a test without one nothing speaks for one."""
    found = [diagnose(relaxation(ZENER, THETA, 0.0, seed), ZENER, []) for seed in range(20)]
    assert {each.verdict for each in found} == {"adequate"}
    assert max(each.evidence["unknown"] for each in found) < 0.9


@pytest.mark.soak
def test_a_ripple_of_a_sweep_that_tells_its_noise_itself_is_no_noise():
    """Of four points a period, as rough as noise to neighbours."""
    exact = ZENER.stiffness(THETA, OMEGA)
    rng = np.random.default_rng(2)
    noise = 0.005 * (rng.normal(size=17) + 1j * rng.normal(size=17))
    ripple = 0.08 * np.sin(2.0 * np.pi * 4.4 * np.arange(17) / 17.0)
    sweep = Measurement(OMEGA, exact * (1.0 + noise + ripple), name="sweep")
    tests = [sweep, relaxation(ZENER, THETA)]
    assert diagnose(tests, ZENER, library("series-spring", "inertia")).verdict == "unexplained"


def test_white_noise_holds_no_ripple():
    rng = np.random.default_rng(4)
    chances = [scatter_of_sweep(rng.normal(size=40), known=False).local for _ in range(300)]
    assert np.mean(np.array(chances) < 0.01) < 0.02


@pytest.mark.soak
def test_a_springpot_of_order_one_has_the_name_of_a_dashpot_too():
    """From a model that misses creep by far a linear step leads past the dashpot."""
    solvent = parse_model("zener + parallel-dashpot")
    theta = solvent.theta(k1=367.0, k2=778.0, c=1612.0, **{"parallel-dashpot.c": 311.0})
    rng, tests = np.random.default_rng(5), []
    exact = solvent.stiffness(theta, OMEGA)
    noise = rng.normal(size=17) + 1j * rng.normal(size=17)
    tests.append(Measurement(OMEGA, exact * (1.0 + 0.003 * noise), name="sweep"))
    crept = solvent.creep(theta, TIME)
    noise = 0.003 * np.abs(crept).max() * rng.normal(size=80)
    tests.append(TimeTest.of_compliance(TIME, crept + noise, name="creep"))
    found = diagnose(tests, ZENER, plugins().items("effect"))
    assert found.verdict == "effect-missing"
    assert found.leading[0] == "parallel-dashpot"


def test_what_only_bends_is_no_jump():
    """Rubber pulled far and let go: from where on a straight line misses it, nothing lets go."""
    stretch = 1.0 + np.interp(np.arange(60.0), [0.0, 30.0, 59.0], [0.0, 2.0, 0.0])
    stress = 80.0 * (stretch - stretch**-2.0)
    test = TimeTest.of_history(0.1 * np.arange(60), stretch - 1.0, stress, "-", "kPa", name="pull")
    found = diagnose(test, parse_model("material"), library("asymmetric-stiffness", "inertia"))
    assert "a jump in" not in found.says
    assert "asymmetric-stiffness" in found.says


@pytest.mark.parametrize(("count", "row", "when"), [(70, -1, "30"), (25, 12, "0.5477")])
def test_a_sample_that_is_off_beside_the_model_is_set_aside_and_told(count, row, when):
    """Few neighbours tell less of it than the model does; an effect would follow it alone."""
    time, rng = np.geomspace(0.01, 30.0, count), np.random.default_rng(7)
    exact = ZENER.creep(np.array([30.0, 60.0, 18.0]), time)
    noise = 0.005 * exact.max() * rng.normal(size=count)
    noise[row] += 12.0 * 0.005 * exact.max()
    test = TimeTest.of_compliance(time, exact + noise, name="creep")
    assert row not in strays(test)
    found = diagnose(test, ZENER, [])
    assert found.verdict == "adequate"
    assert any(f"creep: the sample at {when} s is off by" in note for note in found.notes)


def left_of(value, count):
    scatter = scatter_of(value)
    return FitResiduals(
        count, (value,), (scatter,), (np.zeros((0, len(value))),), (np.zeros(len(value)),)
    )


@pytest.mark.parametrize(("seed", "late"), [(1, 1.0), (6, 1.0), (7, 1.0), (5, 3.0)])
def test_a_jump_is_no_likelier_where_noise_may_be_uneven(seed, late):
    noise = np.random.default_rng(seed).normal(size=200)
    noise *= np.r_[np.linspace(0.8, 1.2, 150), late * np.ones(50)]
    after, white = left_of(noise, 5), ResidualScatter(1.0, 0.0, 0.0, 1.0)
    before = left_of(noise + 4.0 * (np.arange(200) >= 100), 2)
    of_even_noise = delta_bic(before, replace(after, count=3), [white]) - 2.0 * np.log(200.0)
    assert Slip("", after, 200).delta(before, [white]) <= of_even_noise
