"""The material floor is a floor.

No linear passive model with the same effects is nearer to the same rows.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import springpot
from springpot import Measurement, parse_model
from springpot.identification import fit, least_error
from springpot.misfit import any_material
from springpot.misfit.floor import fitted_to_floor
from springpot.misfit.material import material_floor

NETWORKS = (
    "springpot",
    "fractional-zener",
    "burgers",
    "zener",
    "maxwell-2",
    "maxwell-3",
    "maxwell-5",
    "makris",
)
ROUNDING = 2e-5
"""Error of a free spectrum that follows computed data."""


def measured(name, seed, noise, with_sd=False):
    """A random passive network, its parameters, and its own data with noise."""
    rng = np.random.default_rng(seed)
    model = parse_model(name)
    orders = np.array([p.scale != "log" for p in model.parameters])
    theta = np.where(
        orders, rng.uniform(0.2, 0.8, len(orders)), 10.0 ** rng.uniform(-1.0, 1.0, len(orders))
    )
    count = int(rng.choice([6, 12, 30, 60]))
    omega = np.geomspace(0.01, 100.0, count)
    exact = model.stiffness(theta, omega)
    scatter = noise * np.abs(exact) * (rng.normal(size=count) + 1j * rng.normal(size=count))
    sd = None
    if with_sd:
        # Weights unlike those of the printed error: that of the fit is then not the least.
        sd = np.abs(exact) * 10.0 ** rng.uniform(-3.0, 0.0, count) * (1.0 + 1.0j)
    return model, theta, exact, Measurement(omega, exact + scatter, sd=sd)


def error_of(stiffness, data):
    return float(np.sqrt(np.mean(np.abs(stiffness / data.stiffness - 1.0) ** 2)))


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.sampled_from(NETWORKS), st.integers(0, 10**6), st.sampled_from([0.0, 1e-4, 1e-2, 0.1]))
def test_no_network_is_nearer_to_its_own_data_than_any_material(name, seed, noise):
    _, _, exact, data = measured(name, seed, noise)
    lowest = least_error(any_material(), data, [np.zeros(0)])
    assert lowest <= 1.005 * error_of(exact, data) + ROUNDING


@pytest.mark.soak
@settings(max_examples=8, deadline=None, derandomize=True)
@given(
    st.sampled_from(NETWORKS), st.integers(0, 10**6), st.sampled_from([1e-4, 1e-2]), st.booleans()
)
def test_the_floor_is_of_the_norm_in_which_the_error_is_told_and_not_of_the_fit(
    name, seed, noise, with_sd
):
    model, theta, _, data = measured(name, seed, noise, with_sd)
    if 2 * len(data) <= len(theta):
        return
    base = fitted_to_floor(model, data, [theta])
    floor = material_floor(base, np.random.default_rng(seed))
    plain = Measurement(data.omega, data.stiffness)
    nearest = fit(model, plain, seeds_theta=[theta])
    assert floor.relative_rms <= base.relative_rms
    assert (
        floor.relative_rms
        <= 1.01 * error_of(model.stiffness(nearest.theta, data.omega), plain) + ROUNDING
    )


@pytest.mark.soak_cases("inertia", "series-spring")
@pytest.mark.parametrize("effect", ["inertia", "series-spring"])
def test_the_floor_lies_below_a_model_with_effects(effect):
    rng = np.random.default_rng(7)
    model = parse_model(f"maxwell-3 + {effect}")
    omega = np.geomspace(0.1, 100.0, 30)
    theta = np.array([10.0, 0.1, 5.0, 1.0, 2.0, 10.0, 0.001])
    noise = 0.02 * (rng.normal(size=30) + 1j * rng.normal(size=30))
    data = Measurement(omega, model.stiffness(theta, omega) * (1.0 + noise))
    found = springpot.identify(data, model)
    assert found.standing.material_floor <= found.relative_rms
    compared = springpot.compare(data, ["zener", f"zener + {effect}", f"maxwell-3 + {effect}"])
    for judged in compared.judgements:
        assert judged.error.material_floor <= judged.error.relative_rms


@pytest.mark.soak
def test_the_floor_is_over_all_rows_that_the_error_is_over():
    """Of many rows a comparison looks at some."""
    rng = np.random.default_rng(5)
    omega = np.geomspace(0.01, 100.0, 1600)
    model = parse_model("zener")
    noise = 0.02 * (rng.normal(size=1600) + 1j * rng.normal(size=1600))
    data = Measurement(omega, model.stiffness(np.array([1.0, 3.0, 2.0]), omega) * (1.0 + noise))
    found = springpot.identify(data, model)
    assert found.standing.material_floor <= found.relative_rms
