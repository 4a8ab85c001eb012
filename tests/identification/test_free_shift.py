"""Free factors are found again, with any model, from what the data say alone."""

from dataclasses import replace

import numpy as np
import pytest

import springpot
from springpot.identification import fit
from springpot.identification.known_factors import Allowed
from springpot.identification.material_fit import aligned
from springpot.registry import parse_model

TEMPERATURES = np.array([0.0, 15.0, 30.0, 45.0, 60.0])
LOG_A = -np.log(10.0) * 8.0 * (TEMPERATURES - 30.0) / (120.0 + TEMPERATURES - 30.0)
LOG_B = np.log((TEMPERATURES + 273.15) / 303.15)


def superposable(noise=0.0, base="fractional-zener", theta=(1.0, 30.0, 2.0, 0.6), seed=0):
    """Sweeps over two decades at five temperatures, each with its own factors."""
    omega = np.geomspace(0.1, 10.0, 11)
    model, theta = parse_model(base), np.array(theta)
    parts = [
        np.exp(b) * model.stiffness(theta, omega * np.exp(a))
        for a, b in zip(LOG_A, LOG_B, strict=True)
    ]
    stiffness = np.concatenate(parts)
    random = np.random.default_rng(seed)
    error = random.normal(size=len(stiffness)) + 1j * random.normal(size=len(stiffness))
    temperature = np.repeat(TEMPERATURES, len(omega)) + random.uniform(-0.2, 0.2, len(stiffness))
    return springpot.Measurement(
        np.tile(omega, 5),
        stiffness * (1.0 + noise * error),
        conditions={"temperature": temperature},
    )


def factors(found, prefix):
    values = dict(zip(found.model.names, found.theta, strict=True))
    return np.array([value for name, value in values.items() if name.startswith(prefix)])


@pytest.mark.soak_cases("material")
@pytest.mark.parametrize("base", ["material", "fractional-zener"])
def test_exact_data_give_their_factors_back(base):
    found = fit(parse_model(f"{base} + free-shift + free-vertical-shift"), superposable())
    free = [0, 1, 3, 4]
    np.testing.assert_allclose(np.log(factors(found, "free-shift")), LOG_A[free], atol=2e-3)
    np.testing.assert_allclose(np.log(factors(found, "free-vertical")), LOG_B[free], atol=2e-3)


def test_the_first_guess_is_near():
    data = superposable(0.01)
    model = parse_model("material + free-shift + free-vertical-shift").bound_to(data.points)
    guesses = aligned(model, data)
    found = np.log([value for name, value in guesses.items() if name.startswith("free-shift")])
    np.testing.assert_allclose(found, LOG_A[[0, 1, 3, 4]], atol=1.0)


@pytest.mark.soak
def test_the_order_of_rows_changes_nothing():
    data = superposable(0.01)
    order = np.random.default_rng(3).permutation(len(data))
    model = parse_model("material + free-shift")
    one, other = (fit(model, each) for each in (data, data.subset(order, "shuffled")))
    np.testing.assert_allclose(factors(one, "free"), factors(other, "free"), rtol=1e-6)


def test_another_column_than_temperature():
    data = superposable()
    water = np.repeat([0.0, 1.0, 2.0, 5.0, 10.0], 11)
    moist = replace(
        data, conditions={"water": water}, stiffness=data.stiffness / np.exp(np.repeat(LOG_B, 11))
    )
    found = fit(parse_model("material + free-shift:water"), moist)
    np.testing.assert_allclose(
        np.log(factors(found, "free-shift:water")), LOG_A[[0, 1, 3, 4]], atol=2e-3
    )


@pytest.mark.soak
def test_two_columns_at_once():
    """Temperature and water on a grid with a corner missing; their shifts add up."""
    omega, model, theta = (
        np.geomspace(0.1, 10.0, 9),
        parse_model("fractional-zener"),
        np.array([1.0, 30.0, 2.0, 0.6]),
    )
    rows = [(i, j) for i in range(3) for j in range(3) if (i, j) != (2, 2)]
    log_t, log_w = np.array([1.7, 0.0, -1.2]), np.array([0.9, 0.0, -0.8])
    parts = [model.stiffness(theta, omega * np.exp(log_t[i] + log_w[j])) for i, j in rows]
    conditions = {
        "temperature": np.repeat([10.0 + 10.0 * i for i, _ in rows], 9),
        "water": np.repeat([1.0 + j for _, j in rows], 9),
    }
    data = springpot.Measurement(np.tile(omega, 8), np.concatenate(parts), conditions=conditions)
    data = replace(data, reference=293.15)
    found = fit(parse_model("material + free-shift + free-shift:water"), data)
    np.testing.assert_allclose(np.log(factors(found, "free-shift.")), log_t[[0, 2]], atol=2e-3)
    np.testing.assert_allclose(
        np.log(factors(found, "free-shift:water.")), log_w[[0, 2]], atol=2e-3
    )


def test_the_reference_is_told():
    notes = springpot.identify(superposable(0.01), "material + free-shift").notes
    assert any("factor is 1 at temperature 30" in note for note in notes)


def test_an_optimiser_takes_the_levels_too():
    found = springpot.identify(
        superposable(0.01), "fractional-zener + free-shift", optimiser="least-squares", budget=50
    )
    assert sum(name.startswith("free-shift") for name in found.model.names) == 4


def test_how_far_a_shift_sets_two_sweeps_apart_is_told_in_decades():
    """Their shifts lie on one side of the reference: the difference counts, not the sum."""
    decades = np.log(10.0) * np.array([0.0, 2.0, 5.0])
    ends = np.zeros(3), np.full(3, np.log(100.0))
    levels = np.array([20.0, 10.0, 0.0])
    known = Allowed("temperature", levels, *ends, np.ones((3, 3), dtype=bool))
    assert "10 degC and 0 degC apart by 3 decades" in known.broken_by(decades)


def test_an_activation_energy_near_the_glass_transition_is_within_bounds():
    draw, energy, celsius = np.random.default_rng(1), 1300.0, (88.0, 90.0, 92.0, 94.0, 96.0)
    omega, temperature = np.tile(np.geomspace(0.1, 100.0, 16), 5), np.repeat(celsius, 16)
    moved = energy / 0.00831446 * (1.0 / (temperature + 273.15) - 1.0 / 365.15)
    root = np.sqrt(1j * omega * np.exp(moved))
    noise = 0.01 * (draw.normal(size=80) + 1j * draw.normal(size=80))
    modulus = (1.0 + 1e3 * root / (1.0 + root)) * (1.0 + noise)
    data = springpot.Measurement(omega, modulus, conditions={"temperature": temperature})
    fit = springpot.identify(data, "material + arrhenius-shift")
    value = fit.parameters["arrhenius-shift.Ea"]
    assert value.low < energy < value.high
    assert value.value == pytest.approx(energy, rel=0.03)
