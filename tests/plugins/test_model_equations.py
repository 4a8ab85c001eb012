"""The models against their equations, typed here independently of the networks."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.special import exp1, wofz

from derivatives import sample
from springpot.registry import parse_model, plugins
from springpot.rheology import Continuum, Model, Points, Real

OMEGA = np.logspace(-2, 3, 11)
S = 1j * OMEGA
PI = np.pi
positive = st.floats(0.01, 100.0)
orders = st.floats(0.05, 1.0)


def k_of(name: str, *theta: float) -> np.ndarray:
    return parse_model(name).stiffness(np.array(theta), OMEGA)


def from_search(name: str, *x: float) -> np.ndarray:
    model = parse_model(name)
    assert model.search is not None
    return model.stiffness(model.search.to_elements(np.array(x)), OMEGA)


def eq_13_14(k0: float, kinf: float, tau: float, a: float) -> np.ndarray:
    x = tau * OMEGA
    below = 1 + 2 * x**a * np.cos(a * PI / 2) + x ** (2 * a)
    storage = (k0 + (k0 + kinf) * x**a * np.cos(a * PI / 2) + kinf * x ** (2 * a)) / below
    return storage + 1j * (kinf - k0) * x**a * np.sin(a * PI / 2) / below


def eq_22(k: float, tau: float, a: float) -> np.ndarray:
    x = tau * OMEGA
    return k * (1 + x**a * np.cos(a * PI / 2)) + 1j * k * x**a * np.sin(a * PI / 2)


def eq_23_24(k: float, tau: float, a: float) -> np.ndarray:
    x = tau * OMEGA
    below = 1 + x ** (2 * a) + 2 * x**a * np.cos(a * PI / 2)
    return (
        k * x**a * (x**a + np.cos(a * PI / 2)) / below + 1j * k * x**a * np.sin(a * PI / 2) / below
    )


@pytest.mark.parametrize("name", ["fractional-kelvin4", "fractional-zener", "oldroyd-b"])
@given(k0=positive, step=positive, tau=positive, a=orders)
def test_four_parameter_models_are_eq_13_14_and_31_32(
    name: str, k0: float, step: float, tau: float, a: float
):
    np.testing.assert_allclose(
        from_search(name, k0, k0 + step, tau, a), eq_13_14(k0, k0 + step, tau, a), rtol=1e-8
    )


@given(k=positive, tau=positive, a=orders)
def test_three_parameter_models_are_eq_22_to_24_and_29_30(k: float, tau: float, a: float):
    np.testing.assert_allclose(
        from_search("fractional-kelvin", k, tau, a), eq_22(k, tau, a), rtol=1e-11
    )
    np.testing.assert_allclose(
        from_search("fractional-maxwell", k, tau, a), eq_23_24(k, tau, a), rtol=1e-11
    )
    np.testing.assert_allclose(
        from_search("fractional-maxwell-ab", k, tau, a, a), eq_23_24(k, tau, a), rtol=1e-11
    )


@given(c=positive, a=orders)
def test_springpot_is_eq_25_26(c: float, a: float):
    stiffness = k_of("springpot", c, a)
    expected = c * OMEGA**a * np.cos(a * PI / 2) + 1j * c * OMEGA**a * np.sin(a * PI / 2)
    np.testing.assert_allclose(stiffness, expected, rtol=1e-12)
    np.testing.assert_allclose(
        stiffness.imag * np.cos(a * PI / 2), stiffness.real * np.sin(a * PI / 2), rtol=1e-9
    )


@given(k=positive, tau=positive, ratio=st.floats(0.05, 1.0), beta=orders)
def test_unequal_orders_are_eq_27(k: float, tau: float, ratio: float, beta: float):
    alpha = ratio * beta
    expected = k * (S * tau) ** beta / (1 + (S * tau) ** alpha)
    np.testing.assert_allclose(
        from_search("fractional-maxwell-ab", k, tau, alpha, beta), expected, rtol=1e-10
    )
    np.testing.assert_allclose(
        k_of("fractional-maxwell-ab", k, tau, ratio, beta), expected, rtol=1e-10
    )


def test_makris_own_parameters_give_eq_54():
    expected = 15.0 * S / (1 + 0.3 * S**0.6)
    np.testing.assert_allclose(from_search("makris", 0.3, 15.0, 0.6, 1.0), expected, rtol=1e-12)


@given(lam=positive, c0=positive, r=st.floats(0.2, 1.0), more=st.floats(0.0, 1.0))
def test_makris_is_eq_54_for_all_lawful_orders(lam: float, c0: float, r: float, more: float):
    q = r + (1 - r) * more
    np.testing.assert_allclose(
        from_search("makris", lam, c0, r, q), c0 * S**q / (1 + lam * S**r), rtol=1e-9
    )


def row(*stiffness: np.ndarray | float) -> np.ndarray:
    return 1 / sum(1 / np.asarray(k) for k in stiffness)


def mode(k: float, tau: float) -> np.ndarray:
    return k * S * tau / (1 + S * tau)


def huet(
    k: float, d: float, t: float, a: float, b: float, extra: np.ndarray | float = 0.0
) -> np.ndarray:
    return k / (1 + d * (S * t) ** -a + (S * t) ** -b + extra)


def power_law(k0: float, k1: float, tau: float, a: float) -> np.ndarray:
    """Only where closed forms exist: exponents 1 and 1/2."""
    z = S * tau
    shape = z * np.exp(z) * exp1(z) if a == 1.0 else np.sqrt(PI * z) * wofz(1j * np.sqrt(z))
    return k0 + k1 * shape


EQUATIONS: dict[str, Callable[..., np.ndarray | float]] = {
    "springpot": lambda c, a: c * S**a,
    "fractional-kelvin": lambda k, c, a: k + c * S**a,
    "fractional-maxwell": lambda k, c, a: k * c * S**a / (k + c * S**a),
    "fractional-kelvin4": lambda k1, k2, c, a: k1 * (k2 + c * S**a) / (k1 + k2 + c * S**a),
    "fractional-zener": lambda k1, k2, c, a: k1 + k2 * c * S**a / (k2 + c * S**a),
    "fractional-maxwell-ab": lambda k, t, m, b: k * (S * t) ** b / (1 + (S * t) ** (m * b)),
    "oldroyd-b": lambda k0, k1, t, a: (k0 + (k0 + k1) * (S * t) ** a) / (1 + (S * t) ** a),
    "makris": lambda c, t, m, q: c * S**q / (1 + (S * t) ** (m * q)),
    "spring": lambda k: k + 0 * S,
    "dashpot": lambda c: c * S,
    "kelvin": lambda k, c: k + c * S,
    "maxwell": lambda k, c: k * c * S / (k + c * S),
    "zener": lambda k1, k2, c: k1 + k2 * c * S / (k2 + c * S),
    "zener-kelvin": lambda k1, k2, c: k1 * (k2 + c * S) / (k1 + k2 + c * S),
    "jeffreys": lambda c1, k, c2: c1 * S + k * c2 * S / (k + c2 * S),
    "jeffreys-kelvin": lambda c1, k, c2: row(c1 * S, k + c2 * S),
    "burgers": lambda k1, c1, k2, c2: 1 / (1 / k1 + 1 / (c1 * S) + 1 / (k2 + c2 * S)),
    "zener-2": lambda k0, k1, c1, k2, c2: k0 + mode(k1, c1 / k1) + mode(k2, c2 / k2),
    "fractional-maxwell-dashpot": lambda c1, c2, a: c1 * S / (1 + c1 / c2 * S ** (1 - a)),
    "fractional-maxwell-general": lambda c1, a, c2, b: row(c1 * S**a, c2 * S**b),
    "fractional-kelvin-dashpot": lambda c1, c2, a: c1 * S + c2 * S**a,
    "fractional-kelvin-general": lambda c1, a, c2, b: c1 * S**a + c2 * S**b,
    "fractional-solid": lambda k, c1, c2, a: k + row(c1 * S, c2 * S**a),
    "fractional-jeffreys": lambda c1, c2, c3, a: c1 * S + row(c2 * S, c3 * S**a),
    "fractional-jeffreys-kelvin": lambda c1, c2, c3, a: row(c1 * S, c2 * S + c3 * S**a),
    "fractional-zener5": lambda k, c1, a, c2, b: k + row(c1 * S**a, c2 * S**b),
    "fractional-zener-general": lambda c1, a, c2, b, c3, g: c1 * S**a + row(c2 * S**b, c3 * S**g),
    "fractional-poynting-thomson-general": lambda c1, a, c2, b, c3, g: row(
        c1 * S**a, c2 * S**b + c3 * S**g
    ),
    "fractional-burgers": lambda k1, c1, a, k2, c2, b: row(k1, c1 * S**a, k2 + c2 * S**b),
    "huet": huet,
    "huet-sayegh": lambda k0, *rest: k0 + huet(*rest),
    "1s2p1d": lambda k, d, t, a, b, nu: huet(k, d, t, a, b, 1 / (S * nu * t)),
    "2s2p1d": lambda k0, k, d, t, a, b, nu: k0 + huet(k, d, t, a, b, 1 / (S * nu * t)),
    "havriliak-negami": lambda k0, k1, t, a, g: k0 + k1 - k1 / (1 + (S * t) ** a) ** g,
    "prony-N": lambda k0, k1, t1, k2, t2: k0 + mode(k1, t1) + mode(k2, t2),
    "maxwell-N": lambda k1, t1, k2, t2: mode(k1, t1) + mode(k2, t2),
    "kelvin-N": lambda k0, k1, t1, k2, t2: row(k0, k1 * (1 + S * t1), k2 * (1 + S * t2)),
}


def test_every_model_has_its_equation_here():
    builtin = plugins().shelves["model"].owners
    names = {name for name, owner in builtin.items() if owner == "builtin-models"}
    assert names == set(EQUATIONS) | {"power-law-plateau", "material"}


def test_a_material_is_a_spring_a_dashpot_and_lines():
    network = Continuum((0.5, 40.0))
    theta = np.array([3.0, 0.2, 5.0, 7.0])
    expected = 3.0 + 0.2 * S + 5.0 * S / (S + 0.5) + 7.0 * S / (S + 40.0)
    np.testing.assert_allclose(
        network.respond(theta, Points.at(S.imag)).value, expected, rtol=1e-13
    )


@pytest.mark.parametrize("name", EQUATIONS)
def test_network_is_its_equation(name: str, rng: np.random.Generator):
    model = parse_model(name.replace("-N", "-2"))
    for theta in sample(model.parameters, rng, (5,)):
        np.testing.assert_allclose(
            model.stiffness(theta, OMEGA), EQUATIONS[name](*theta), rtol=1e-11
        )


@pytest.mark.parametrize("exponent", [1.0, 0.5])
@pytest.mark.parametrize("tau", [1e-3, 1.0, 20.0])
def test_power_law_relaxation_has_its_closed_forms(exponent: float, tau: float):
    expected = power_law(2.0, 3.0, tau, exponent)
    finite = np.isfinite(expected)
    assert finite.sum() > 3
    stiffness = k_of("power-law-plateau", 2.0, 3.0, tau, exponent)
    np.testing.assert_allclose(stiffness[finite], expected[finite], rtol=1e-11)


SPECIAL_CASES: list[tuple[str, tuple[float, ...], str, tuple[float, ...]]] = [
    ("springpot", (3.0, 0.0), "spring", (3.0,)),
    ("springpot", (3.0, 1.0), "dashpot", (3.0,)),
    ("fractional-kelvin", (2.0, 3.0, 1.0), "kelvin", (2.0, 3.0)),
    ("fractional-maxwell", (2.0, 3.0, 1.0), "maxwell", (2.0, 3.0)),
    ("fractional-kelvin4", (2.0, 3.0, 4.0, 1.0), "zener-kelvin", (2.0, 3.0, 4.0)),
    ("fractional-zener", (2.0, 3.0, 4.0, 1.0), "zener", (2.0, 3.0, 4.0)),
    ("fractional-jeffreys", (2.0, 3.0, 4.0, 0.0), "jeffreys", (2.0, 4.0, 3.0)),
    ("fractional-jeffreys-kelvin", (2.0, 3.0, 4.0, 0.0), "jeffreys-kelvin", (2.0, 4.0, 3.0)),
    ("fractional-burgers", (1.0, 2.0, 1.0, 3.0, 4.0, 1.0), "burgers", (1.0, 2.0, 3.0, 4.0)),
    ("fractional-zener5", (1.0, 2.0, 0.6, 3.0, 0.0), "fractional-zener", (1.0, 3.0, 2.0, 0.6)),
    ("fractional-solid", (1.0, 2.0, 3.0, 0.0), "zener", (1.0, 3.0, 2.0)),
    ("havriliak-negami", (1.0, 2.0, 3.0, 0.6, 1.0), "oldroyd-b", (1.0, 2.0, 3.0, 0.6)),
    ("prony-2", (1.0, 2.0, 3.0, 4.0, 5.0), "zener-2", (1.0, 2.0, 6.0, 4.0, 20.0)),
    ("prony-1", (1.0, 2.0, 3.0), "zener", (1.0, 2.0, 6.0)),
    ("maxwell-1", (2.0, 3.0), "maxwell", (2.0, 6.0)),
    ("kelvin-1", (1.0, 2.0, 3.0), "zener-kelvin", (1.0, 2.0, 6.0)),
]


@pytest.mark.parametrize(("general", "theta", "special", "own"), SPECIAL_CASES)
def test_general_models_contain_the_special_ones(
    general: str, theta: tuple[float, ...], special: str, own: tuple[float, ...]
):
    np.testing.assert_allclose(k_of(general, *theta), k_of(special, *own), rtol=1e-12, atol=1e-12)


@given(ke=positive, k1=positive, c=positive, a=orders)
def test_registered_zener_and_standard_forms_are_dual(ke: float, k1: float, c: float, a: float):
    ratio = (ke + k1) / k1
    dual = k_of("fractional-kelvin4", ke + k1, ke * ratio, c * ratio**2, a)
    np.testing.assert_allclose(dual, k_of("fractional-zener", ke, k1, c, a), rtol=1e-10)


@given(c1=positive, c2=positive, c3=positive, a=orders)
def test_registered_jeffreys_forms_are_dual(c1: float, c2: float, c3: float, a: float):
    ratio = (c1 + c2) / c2
    dual = k_of("fractional-jeffreys-kelvin", c1 + c2, c1 * ratio, c3 * ratio**2, a)
    np.testing.assert_allclose(dual, k_of("fractional-jeffreys", c1, c2, c3, a), rtol=1e-9)


def terminal(model: Model, theta: Real, low: bool) -> float:
    """Slope of ln |K| over ln omega at an end of the frequency axis."""
    omega = np.exp(np.array([-60.0, -59.0]) if low else np.array([59.0, 60.0]))
    magnitude = np.log(np.abs(model.stiffness(theta, omega)))
    return float(magnitude[1] - magnitude[0])


@pytest.mark.parametrize(
    ("name", "theta", "low", "high"),
    [
        ("fractional-maxwell", (2.0, 3.0, 0.4), 0.4, 0.0),
        ("fractional-kelvin", (2.0, 3.0, 0.4), 0.0, 0.4),
        ("makris", (15.0, 0.2, 0.6, 1.0), 1.0, 0.4),
        ("fractional-maxwell-dashpot", (2.0, 3.0, 0.4), 1.0, 0.4),
        ("burgers", (1.0, 2.0, 3.0, 4.0), 1.0, 0.0),
        ("1s2p1d", (1.0, 2.0, 3.0, 0.2, 0.6, 4.0), 1.0, 0.0),
        ("huet", (1.0, 2.0, 3.0, 0.3, 0.6), 0.6, 0.0),
    ],
)
def test_terminal_slopes(name: str, theta: tuple[float, ...], low: float, high: float):
    model = parse_model(name)
    assert terminal(model, np.array(theta), low=True) == pytest.approx(low, abs=1e-3)
    assert terminal(model, np.array(theta), low=False) == pytest.approx(high, abs=1e-3)
