"""No linear passive model follows relaxation, creep or both better than any material does."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import springpot
from springpot import Measurement, TimeTest, parse_model
from springpot.timetests import identify
from springpot.timetests.material import relaxation_of
from springpot.timetests.residuals_of_tests import parts_of_specimen

DATA = (
    os.environ.get("SPRINGPOT_DATA", "").split(os.pathsep)[0]
    or Path(__file__).parents[3] / "shared" / "data"
)
UNSEEN = Path(DATA).parent / "unseen"
MATERIAL = parse_model("material")
NETWORKS = (
    "maxwell",
    "jeffreys",
    "burgers",
    "zener",
    "maxwell-3",
    "fractional-zener",
    "fractional-maxwell",
)
T = np.geomspace(0.01, 100.0, 60)


def made(name, seed):
    """A random passive network, its parameters and a generator of noise."""
    rng = np.random.default_rng(seed)
    model = parse_model(name)
    orders = np.array([p.scale != "log" for p in model.parameters])
    theta = np.where(
        orders, rng.uniform(0.2, 0.8, len(orders)), 10.0 ** rng.uniform(-1.0, 1.0, len(orders))
    )
    return model, theta, rng


def noisy(exact, share, rng):
    # Of one size: what is proportional would leave the end of a relaxation without any.
    return exact + share * np.abs(exact).max() * rng.normal(size=exact.shape)


def measured_in(kind, model, theta, share, rng):
    relaxed = TimeTest.of_relaxation(T, noisy(model.relaxation(theta, T), share, rng), "kPa")
    if kind == "relaxation":
        return [relaxed]
    crept = TimeTest.of_compliance(T, noisy(model.creep(theta, T), share, rng), "kPa")
    if kind == "creep":
        return [crept]
    omega = np.geomspace(0.01, 100.0, 25)
    exact = model.stiffness(theta, omega)
    swept = Measurement(
        omega, exact * (1.0 + share * (rng.normal(size=25) + 1j * rng.normal(size=25)))
    )
    return [TimeTest.of_compliance(T, crept.response, "Pa"), swept]


def squares(tests, model, theta):
    parts = parts_of_specimen(tests)
    return sum(float(np.sum(part.residual(model, theta, 293.15).value ** 2)) for part in parts)


@pytest.mark.parametrize("kind", ["relaxation", "creep"])
@settings(max_examples=8, deadline=None, derandomize=True)
@given(st.sampled_from(NETWORKS), st.integers(0, 10**6), st.sampled_from([1e-3, 1e-2, 0.1]))
def test_no_network_is_nearer_to_its_own_test_than_any_material(kind, name, seed, share):
    model, theta, rng = made(name, seed)
    tests = measured_in(kind, model, theta, share, rng)
    found = identify(tests, MATERIAL)
    assert squares(tests, found.model, found.theta) <= 1.02 * squares(tests, model, theta)


def test_nor_to_a_creep_and_a_sweep_together():
    for name in ("burgers", "fractional-zener"):
        model, theta, rng = made(name, 3)
        tests = measured_in("both", model, theta, 0.01, rng)
        found = identify(tests, MATERIAL)
        assert squares(tests, found.model, found.theta) <= 1.05 * squares(tests, model, theta)


@pytest.mark.parametrize(("glass", "fluidity"), [(0.5, 0.0), (0.5, 0.1), (0.0, 0.1), (0.0, 0.0)])
def test_a_retardation_is_turned_into_its_relaxation(glass, fluidity):
    times, weights = np.array([0.01, 1.0, 3.0, 1000.0]), np.array([0.1, 2.0, 0.3, 5.0])
    found = relaxation_of(glass, fluidity, times, weights)
    s = 1j * np.geomspace(1e-5, 1e5, 80)
    compliance = glass + fluidity / s + (weights / (1.0 + s[:, None] * times)).sum(axis=1)
    lines = (found.weights * s[:, None] / (s[:, None] + found.rates)).sum(axis=1)
    stiffness = found.equilibrium + found.viscosity * s + lines
    assert min(found.equilibrium, found.viscosity, found.weights.min()) >= 0.0
    np.testing.assert_allclose(stiffness * compliance, 1.0, rtol=1e-9)


@pytest.mark.skipif(not UNSEEN.is_dir(), reason="the unseen files are not here")
def test_a_melt_that_creeps_is_a_material():
    [test] = springpot.open_in_time(UNSEEN / "CM3_Creep.creep")
    found = identify(test, MATERIAL)
    assert found.relative_rms < 0.0015
    # 1/eta of the steady flow in 1/s, which had been taken for a drift.
    rates = np.array(found.model.material.rates)
    viscosity = found.theta[1] + float(np.sum(found.theta[2:] / rates))
    assert 10.0 / viscosity == pytest.approx(2.16e-4, rel=0.05)
