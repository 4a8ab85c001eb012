"""The relaxation spectrum of a model.

It is the model, its weights are positive, its derivatives exact.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.special import gamma

from springpot.errors import ModelError
from springpot.registry import parse_model, plugins
from springpot.rheology import (
    Model,
    Points,
    Spectrum,
    arrhenius,
    dashpot,
    mass,
    parallel,
    series,
    shift,
    spring,
    springpot,
)
from springpot.rheology.model import Family

OF_THE_NETWORK = [each.name for each in plugins().items("effect") if not each.of_test]

REGISTERED = [
    item.build(3) if isinstance(item, Family) else item for item in plugins().items("model")
]
MODELS = {model.base: model for model in REGISTERED}
CLASSICAL = [
    "spring",
    "dashpot",
    "kelvin",
    "maxwell",
    "zener",
    "zener-kelvin",
    "jeffreys",
    "jeffreys-kelvin",
    "burgers",
    "zener-2",
    "prony-3",
    "maxwell-3",
    "kelvin-3",
]
positive = st.floats(0.02, 50.0)
orders = st.floats(0.02, 0.98)


def random_theta(model: Model, rng: np.random.Generator) -> np.ndarray:
    """Over four decades; orders nearly up to both ends of their range."""
    return np.array(
        [
            np.exp(rng.uniform(-5, 5)) if p.scale == "log" else rng.uniform(0.02, 0.98)
            for p in model.parameters
        ]
    )


def of(network, *theta: float, **options) -> Spectrum:
    return Model("test", network).spectrum(np.array(theta), **options)


@pytest.mark.parametrize("name", MODELS)
def test_the_spectrum_is_the_model(name: str, rng: np.random.Generator):
    model = MODELS[name]
    for _ in range(5):
        theta = random_theta(model, rng)
        found = model.spectrum(theta)
        omega = np.geomspace(*found.band, 101)
        exact = model.stiffness(theta, omega)
        off = np.max(np.abs(found.stiffness(omega) - exact) / np.abs(exact))
        assert off < 1e-6
        assert off == pytest.approx(found.error, abs=1e-6)
        assert np.all(found.weights >= 0)
        assert min(found.equilibrium, found.viscosity, found.mass) >= 0
        assert np.all(np.diff(found.rates) > 0)


@pytest.mark.parametrize("name", CLASSICAL)
def test_springs_and_dashpots_are_found_as_poles_to_rounding(name: str, rng: np.random.Generator):
    model = MODELS[name]
    for _ in range(5):
        theta = random_theta(model, rng)
        found = model.spectrum(theta)
        assert len(found.rates) <= 3
        omega = np.geomspace(1e-9, 1e9, 61)
        exact = model.stiffness(theta, omega)
        np.testing.assert_allclose(found.stiffness(omega), exact, rtol=1e-10)


def test_every_model_is_tested_one_way_or_the_other():
    assert set(CLASSICAL) < set(MODELS)


@given(positive, positive, positive, positive)
@settings(max_examples=50)
def test_a_burgers_fluid_has_the_two_rates_of_its_quadratic(
    k1: float, c1: float, k2: float, c2: float
):
    network = series(spring("k1"), dashpot("c1"), parallel(spring("k2"), dashpot("c2")))
    found = of(network, k1, c1, k2, c2)
    # 1/K = 1/k1 + 1/(c1 s) + 1/(k2 + c2 s); the numerator of its sum vanishes at the rates.
    by_hand = np.sort(-np.roots([c1 * c2, c1 * k2 + k1 * c2 + k1 * c1, k1 * k2]).real)
    np.testing.assert_allclose(found.rates, by_hand, rtol=1e-6)
    assert found.equilibrium == 0.0
    assert found.weights.sum() == pytest.approx(k1, rel=1e-9)


@pytest.mark.parametrize("alpha", [0.1, 0.3, 0.5, 0.7, 0.9, 0.99])
def test_density_of_a_springpot(alpha: float):
    found = of(springpot(), 2.0, alpha, band=(0.1, 10.0))
    middle = (found.rates > 0.1) & (found.rates < 10.0)
    step = np.log(found.rates[middle][1] / found.rates[middle][0])
    # c s^alpha = c sin(pi alpha)/pi times the integral of r^alpha s/(s + r) dln r
    density = 2.0 * np.sin(np.pi * alpha) / np.pi * found.rates**alpha
    np.testing.assert_allclose(found.weights[middle], step * density[middle], rtol=1e-9)


def test_density_of_the_power_law_is_a_gamma_function():
    theta = np.array([1.0, 2.0, 3.0, 0.4])
    found = MODELS["power-law-plateau"].spectrum(theta, band=(1e-3, 1e3))
    step = np.log(found.rates[1] / found.rates[0])
    turn = 3.0 * found.rates
    np.testing.assert_allclose(
        found.weights, step * 2.0 * turn**0.4 * np.exp(-turn) / gamma(0.4), rtol=1e-8, atol=1e-14
    )
    # slower modes that are left out count as spring
    assert found.equilibrium + found.weights.sum() == pytest.approx(3.0, rel=1e-6)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-11])
def test_the_tolerance_is_kept_and_its_price_is_logarithmic(tolerance: float):
    found = of(
        series(spring(), springpot()), 400.0, 60.0, 0.55, band=(0.1, 100.0), tolerance=tolerance
    )
    assert found.error < tolerance
    assert len(found.rates) < 15 + 1.5 * np.log10(1 / tolerance) ** 2


@given(positive, positive, st.floats(0.9, 1.0 - 1e-6))
@settings(max_examples=30)
def test_a_peak_that_is_nearly_a_line_is_resolved(k: float, c: float, alpha: float):
    assert of(series(spring(), springpot()), k, c, alpha).error < 1e-6


@given(positive, orders, positive, orders)
@settings(max_examples=30)
def test_spectra_side_by_side_add(c1: float, a1: float, c2: float, a2: float):
    omega = np.geomspace(0.1, 10.0, 9)
    both = of(
        parallel(springpot("c1", "a1"), springpot("c2", "a2")), c1, a1, c2, a2, band=(0.1, 10.0)
    )
    apart = [
        of(springpot(), c, a, band=(0.1, 10.0)).stiffness(omega) for c, a in ((c1, a1), (c2, a2))
    ]
    np.testing.assert_allclose(both.stiffness(omega), sum(apart), rtol=3e-6)


def test_a_line_beside_a_spread_keeps_its_rate():
    network = parallel(springpot(), series(spring("k"), dashpot("d")))
    found = of(network, 1.0, 0.5, 2.0, 8.0)
    line = np.argmin(np.abs(found.rates - 0.25))
    assert found.rates[line] == pytest.approx(0.25, rel=1e-14)
    assert found.weights[line] == pytest.approx(2.0, rel=1e-14)


@pytest.mark.parametrize(
    ("name", "theta"),
    [
        ("burgers", [2.0, 3.0, 0.5, 4.0]),
        ("kelvin-3", [2.0, 1.0, 0.3, 3.0, 4.0, 0.7, 30.0]),
        ("fractional-zener", [1.0, 3.0, 2.0, 0.6]),
        ("fractional-maxwell", [4.0, 2.0, 0.97]),
        ("fractional-zener-general", [1.0, 0.3, 2.0, 0.7, 1.5, 0.4]),
        ("2s2p1d", [0.1, 5.0, 2.0, 0.3, 0.2, 0.6, 20.0]),
        ("power-law-plateau", [1.0, 2.0, 3.0, 0.4]),
        ("fractional-zener + inertia", [1.0, 3.0, 2.0, 0.6, 0.02]),
        ("fractional-zener + relaxation-mode", [1.0, 3.0, 2.0, 0.6, 2.0, 0.3]),
        ("kelvin + retardation-mode", [1.0, 3.0, 2.0, 0.6]),
    ],
)
def test_derivatives_by_the_parameters(name: str, theta: list[float]):
    model = parse_model(name)
    # A derivative has a sharper peak than K itself, and so a finer rule is needed for it.
    found = model.spectrum(np.array(theta), tolerance=1e-9)
    omega = np.geomspace(*found.band, 41)
    exact = model.jacobian(np.array(theta), omega)
    natural = np.abs(model.stiffness(np.array(theta), omega))[:, None] / np.array(theta) + np.abs(
        exact
    )
    assert np.max(np.abs(found.jacobian(omega) - exact) / natural) < 1e-5


@pytest.mark.parametrize("name", ["burgers", "zener-kelvin", "kelvin-3", "jeffreys-kelvin"])
def test_derivatives_of_rates_and_weights(name: str, rng: np.random.Generator):
    model = MODELS[name]
    theta = np.exp(rng.uniform(-1, 1, len(model.parameters)))
    slopes = model.spectrum(theta).by_theta
    for i in range(len(theta)):
        step = 1e-5 * theta[i] * np.eye(len(theta))[i]
        up, down = model.spectrum(theta + step), model.spectrum(theta - step)
        width = 2e-5 * theta[i]
        np.testing.assert_allclose(
            slopes.rates[:, i], (up.rates - down.rates) / width, rtol=1e-5, atol=1e-6
        )
        np.testing.assert_allclose(
            slopes.weights[:, i], (up.weights - down.weights) / width, rtol=1e-5, atol=1e-6
        )
        assert slopes.viscosity[i] == pytest.approx(
            (up.viscosity - down.viscosity) / width, rel=1e-5, abs=1e-7
        )
        assert slopes.equilibrium[i] == pytest.approx(
            (up.equilibrium - down.equilibrium) / width, rel=1e-5, abs=1e-7
        )


def test_a_mass_beside_the_material_is_told():
    found = of(parallel(springpot(), mass()), 2.0, 0.4, 0.03)
    assert found.mass == pytest.approx(0.03)
    assert found.error < 1e-6


def test_a_temperature_moves_the_rates():
    network = shift(series(spring(), dashpot()), arrhenius())
    hot = of(network, 2.0, 8.0, 50.0, temperature=330.0, reference_temperature=300.0)
    factor = np.exp(50.0 / 8.31446261815324e-3 * (1 / 330.0 - 1 / 300.0))
    assert hot.rates[0] == pytest.approx(0.25 / factor)
    assert of(network, 2.0, 8.0, 50.0).rates[0] == pytest.approx(0.25)


@pytest.mark.parametrize(
    "name", ["wlf-shift", "vertical-shift", "arrhenius-dashpot", "entropic-spring", "rig-drag"]
)
def test_models_with_a_temperature(name: str, rng: np.random.Generator):
    model = parse_model(f"fractional-zener + {name}")
    theta = np.array([p.typical for p in model.parameters])
    found = model.spectrum(theta, temperature=303.0, reference_temperature=293.15)
    omega = np.geomspace(*found.band, 41)
    at = Points(np.log(omega), temperature=np.full(41, 303.0))
    np.testing.assert_allclose(found.stiffness(omega), model.stiffness(theta, at), rtol=2e-6)


@pytest.mark.parametrize("effect", OF_THE_NETWORK)
def test_every_effect_has_a_spectrum_or_is_refused_by_name(effect: str):
    model = parse_model(f"fractional-zener + {effect}")
    theta = np.array([1.3, 2.0, 1.5, 0.6, *(p.typical for p in model.parameters[4:])])
    if effect in REFUSED:
        with pytest.raises(ModelError, match=f"'{effect}'") as refusal:
            model.spectrum(theta)
        assert "\n" not in str(refusal.value)
        return
    found = model.spectrum(theta)
    # The rates of diffusion follow each other ever more closely, without end; those far out count
    # as a dashpot.
    assert found.error < (1e-2 if effect == "diffusion" else 1e-6)
    assert np.all(found.weights >= 0)


REFUSED = {
    "yielding",
    *(
        "time-delay",
        "phase-error",
        "gain-error",
        "filter-mismatch",
        "fixture-resonance",
        "crosstalk",
    ),
    *(
        "frequency-error",
        "backlash",
        "hysteretic-loss",
        "basset",
        "frame-resonance",
        "self-heating",
    ),
    *(
        "smooth-hysteresis",
        "hardening-mount",
        "power-law-slip",
        "strain-softening",
        "shear-thinning",
    ),
    *(
        "friction",
        "elasto-sliding",
        "power-law-damper",
        "cubic-damping",
        "dead-zone",
        "cubic-stiffness",
        "payne",
    ),
    *("intrinsic-nonlinearity", "specimen-inertia", "specimen-inertia-fixed"),
}


def test_a_mass_in_series_is_refused():
    with pytest.raises(ModelError, match="'test'"):
        of(series(parallel(spring("k"), mass()), springpot()), 1.0, 0.5, 1.0, 0.5)


def test_a_band_upside_down_is_refused():
    with pytest.raises(ModelError, match="lower first"):
        of(springpot(), 1.0, 0.5, band=(10.0, 1.0))


def test_diffusion_is_a_row_of_lines_without_end():
    """1 - tanh(q)/q with q^2 = s tau has poles at -a^2/tau with a = pi/2, 3 pi/2, ...

    And weights 2/a^2.
    """
    diffusion = plugins().effect("diffusion")
    k, tau = 3.0, 0.2
    lines = Model("diffusion", diffusion.element).spectrum([k, tau], (1e-2, 1e5))
    a = (np.arange(50) + 0.5) * np.pi
    assert np.allclose(lines.rates[:50], a**2 / tau, rtol=1e-10)
    assert np.allclose(lines.weights[:50], 2.0 * k / a**2, rtol=1e-9)
    assert lines.error < 1e-5
    assert np.all(lines.weights > 0.0)
    # Each rate is as 1 / tau, and each weight as k.
    assert np.allclose(lines.by_theta.rates[:50, 1], -lines.rates[:50] / tau, rtol=1e-6)
    assert np.allclose(lines.by_theta.weights[:50, 0], lines.weights[:50] / k, rtol=1e-6)


def test_a_model_with_diffusion_relaxes():
    model = parse_model("zener + diffusion")
    theta = model.theta(k1=1.0, k2=2.0, c=0.5, **{"diffusion.k": 3.0, "diffusion.tau": 0.2})
    t = np.array([0.01, 0.1, 1.0])
    a = (np.arange(4000) + 0.5)[:, None] * np.pi
    slow = (
        1.0 + 2.0 * np.exp(-t / 0.25) + np.sum(2.0 * 3.0 / a**2 * np.exp(-(a**2) * t / 0.2), axis=0)
    )
    assert np.allclose(model.relaxation(theta, t), slow, rtol=1e-6)


def test_a_springpot_of_no_size_relaxes_nothing():
    """The fractional Kelvin element without its springpot is a spring."""
    lines = parse_model("fractional-kelvin").spectrum(np.array([7.0, 0.0, 0.5]))
    assert not len(lines.rates)
    assert np.allclose(lines.stiffness(np.array([0.1, 10.0])), 7.0)
