"""A model in time: closed forms, reference values, limits, dualities and exact derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.special import erfc, erfcx, gamma, gammaincc, wofz

import mittag_leffler
from springpot.errors import ModelError
from springpot.registry import parse_model, plugins
from springpot.rheology import (
    Effect,
    Layer,
    Model,
    Points,
    Traced,
    arrhenius,
    basset,
    dashpot,
    mass,
    parallel,
    series,
    shift,
    spring,
    springpot,
    terms,
)
from springpot.rheology.model import Family

OF_THE_NETWORK = [each.name for each in plugins().items("effect") if not each.of_test]

REGISTERED = [
    item.build(3) if isinstance(item, Family) else item for item in plugins().items("model")
]
MODELS = {model.base: model for model in REGISTERED}
T = np.geomspace(1e-4, 1e4, 33)


def of(network, *theta: float, **options):
    return Model("test", network).in_time(np.array(theta), **{"tolerance": 1e-12, **options})


def typical(model: Model) -> np.ndarray:
    return np.array(
        [
            p.typical * (1 + 0.3 * i) if p.scale == "log" else 0.4
            for i, p in enumerate(model.parameters)
        ]
    )


@pytest.mark.soak_cases("0.7")
@pytest.mark.parametrize("alpha", mittag_leffler.ORDERS)
def test_fractional_elements_against_mittag_leffler_values(alpha: float):
    k, c = 3.0, 2.0
    x, value = mittag_leffler.table(alpha)
    t = (x * c / k) ** (1 / alpha)
    maxwell = of(series(spring(), springpot()), k, c, alpha)
    np.testing.assert_allclose(maxwell.relaxation(t).value, k * value["1"], rtol=1e-10)
    np.testing.assert_allclose(
        maxwell.creep(t).value, 1 / k + t**alpha / (c * gamma(1 + alpha)), rtol=1e-10
    )
    kelvin = of(parallel(spring(), springpot()), k, c, alpha)
    np.testing.assert_allclose(kelvin.creep(t).value, t**alpha / c * value["1+a"], rtol=1e-10)
    np.testing.assert_allclose(
        kelvin.relaxation(t).value, k + c * t**-alpha / gamma(1 - alpha), rtol=1e-10
    )
    zener = of(parallel(spring("e"), series(spring(), springpot())), 1.5, k, c, alpha)
    np.testing.assert_allclose(zener.relaxation(t).value, 1.5 + k * value["1"], rtol=1e-10)
    alone = of(springpot(), c, alpha)
    np.testing.assert_allclose(
        alone.relaxation(t).value, c * t**-alpha / gamma(1 - alpha), rtol=1e-10
    )
    np.testing.assert_allclose(alone.creep(t).value, t**alpha / (c * gamma(1 + alpha)), rtol=1e-10)


@pytest.mark.parametrize("alpha", mittag_leffler.ORDERS)
def test_the_rate_of_relaxation_against_mittag_leffler_values(alpha: float):
    # -dG/dt of spring and springpot in series is (k^2/c) t^(alpha-1) E_(alpha,alpha)(-(k/c)
    # t^alpha)
    k, c = 3.0, 2.0
    x, value = mittag_leffler.table(alpha)
    inner = (x >= 1e-3) & (x <= 1e3)
    t = ((x * c / k) ** (1 / alpha))[inner]
    band = (1 / t.max(), 1 / t.min())
    found = Model("test", series(spring(), springpot())).spectrum(
        [k, c, alpha], band, tolerance=1e-12
    )
    rate = np.exp(-np.outer(t, found.rates)) @ (found.weights * found.rates)
    np.testing.assert_allclose(rate, k**2 / c * t ** (alpha - 1) * value["a"][inner], rtol=1e-9)


def test_two_springpots_of_orders_one_half_apart():
    # E_(1/2,1-beta) has no closed form but for beta = 0 (erfcx); alpha = 1, beta = 1/2: c_b t^-1/2
    # E_(1/2,1/2)(-x)
    ca, cb = 2.0, 3.0
    x = cb / ca * np.sqrt(T)
    exact = cb / np.sqrt(T) * (1 / np.sqrt(np.pi) - x * erfcx(x))
    early = x < 1e3  # beyond, the difference is rounding
    found = of(series(dashpot(), springpot()), ca, cb, 0.5).relaxation(T).value
    np.testing.assert_allclose(found[early], exact[early], rtol=1e-9)


def test_a_startup_of_spring_and_half_springpot():
    """At rate v the force is v k t E_(1/2,2)(-x), x = (k/c) t^(1/2).

    E_(1/2,2) is the rest of an erfcx.
    """
    k, c, v = 3.0, 2.0, 0.7
    t = np.geomspace(0.01, 300.0, 40)
    x = k / c * np.sqrt(t)
    exact = v * k * t * (erfcx(x) - 1 + 2 * x / np.sqrt(np.pi)) / x**2
    clock = np.concatenate([[0.0], t])
    found = of(series(spring(), springpot()), k, c, 0.5).respond(clock, v * clock).value[1:]
    np.testing.assert_allclose(found, exact, rtol=1e-9)


def test_a_half_springpot_with_a_spring_is_an_error_function():
    t = np.array([1.0])
    found = of(series(spring(), springpot()), 1.0, 1.0, 0.5).relaxation(t).value
    assert found[0] == pytest.approx(np.e * erfc(1.0), abs=1e-12)


def test_classical_models_have_their_exponentials():
    t = np.linspace(0.0, 9.0, 10)
    maxwell = of(series(spring(), dashpot()), 2.0, 6.0)
    np.testing.assert_allclose(maxwell.relaxation(t).value, 2.0 * np.exp(-t / 3.0), rtol=1e-13)
    np.testing.assert_allclose(maxwell.creep(t).value, 0.5 + t / 6.0, rtol=1e-13)
    kelvin = of(parallel(spring(), dashpot()), 2.0, 6.0)
    np.testing.assert_allclose(kelvin.creep(t).value, 0.5 * (1 - np.exp(-t / 3.0)), atol=1e-13)
    # a dashpot holds nothing after the step, which takes an infinite force
    np.testing.assert_allclose(kelvin.relaxation(t[1:]).value, 2.0, rtol=1e-13)
    assert kelvin.relaxation(np.zeros(1)).value[0] == np.inf


def test_limits_at_the_step_itself():
    zero = np.zeros(1)
    zener = of(parallel(spring("k1"), series(spring("k2"), springpot())), 1.0, 3.0, 2.0, 0.4)
    assert zener.relaxation(zero).value[0] == pytest.approx(4.0)
    assert zener.creep(zero).value[0] == pytest.approx(0.25)
    assert of(springpot(), 2.0, 0.4).relaxation(zero).value[0] == np.inf
    assert of(springpot(), 2.0, 0.4).creep(zero).value[0] == 0.0


def both_ends() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes u, 1 - u and weights of the double exponential rule on (0, 1).

    The rule allows singularities at both ends.
    """
    x = np.arange(-4.5, 4.55, 0.05)
    y = np.pi * np.sinh(x)
    u, rest = 1 / (1 + np.exp(-y)), 1 / (1 + np.exp(y))
    return u, rest, 0.05 * np.pi * np.cosh(x) * u * rest


@pytest.mark.soak_cases("power-law-plateau")
@pytest.mark.parametrize("name", MODELS)
def test_creep_convolved_with_relaxation_is_time(name: str):
    """s^2 G J = 1: the integral of G(t - u) J(u) and the instant impulse of a dashpot are t."""
    model = MODELS[name]
    at = model.in_time(typical(model), tolerance=1e-10)
    u, rest, weight = both_ends()
    high = np.array([1e100, 1e101])
    steep = model.stiffness(typical(model), high).imag / high
    impulse = steep[0] if steep[1] == pytest.approx(steep[0], rel=1e-3) else 0.0
    for t in (0.03, 1.0, 40.0):
        inside = np.sum(weight * at.relaxation(t * rest).value * at.creep(t * u).value)
        found = t * inside + impulse * at.creep(np.array([t])).value[0]
        assert found == pytest.approx(t, rel=1e-6)


@given(st.floats(0.1, 5.0), st.floats(0.1, 5.0), st.floats(0.1, 0.9))
@settings(max_examples=20, deadline=None)
def test_ramps_are_exact_at_any_sampling(k: float, c: float, alpha: float):
    rng = np.random.default_rng(5)
    even = np.linspace(0.0, 3.0, 31)
    uneven = np.sort(np.append(rng.uniform(0.0, 3.0, 60), [0.0, 3.0]))
    network = parallel(spring("e"), series(spring(), springpot()))
    for t in (even, uneven):
        found = of(network, 0.7, k, c, alpha).respond(t, 2.0 * t).value
        # The force of a ramp is the integral of the relaxation function: here by a rule of its own.
        u, weight = np.polynomial.legendre.leggauss(80)
        u, weight = 0.5 * (u + 1), 0.5 * weight
        nodes = 3.0 * u**8  # graded towards t = 0
        total = np.sum(
            of(network, 0.7, k, c, alpha).relaxation(nodes).value * weight * 3.0 * 8 * u**7
        )
        assert found[-1] == pytest.approx(2.0 * total, rel=1e-9)


@pytest.mark.parametrize("alpha", [0.3, 0.5, 0.7, 0.9])
def test_a_ramp_on_a_springpot_is_a_power(alpha: float):
    t = np.linspace(0.0, 10.0, 201)
    found = of(springpot(), 2.0, alpha).respond(t, 3.0 * t).value
    np.testing.assert_allclose(found[5:], 6.0 * t[5:] ** (1 - alpha) / gamma(2 - alpha), rtol=1e-4)
    assert found[-1] == pytest.approx(6.0 * 10.0 ** (1 - alpha) / gamma(2 - alpha), rel=1e-9)


@pytest.mark.parametrize(
    "name",
    ["fractional-maxwell", "fractional-zener", "burgers", "kelvin", "huet", "zener + inertia"],
)
def test_a_sinusoid_from_rest_tends_to_the_complex_stiffness(name: str):
    model = parse_model(name)
    theta = typical(model)
    omega, periods, per = 2.0, 60, 256
    t = np.arange(periods * per + 1) * (2 * np.pi / omega / per)
    force = model.respond(theta, t, np.sin(omega * t))
    last = slice(-per - 1, -1)
    found = 2.0 / per * np.sum(force[last] * np.exp(-1j * omega * t[last])) * 1j
    exact = model.stiffness(theta, omega)[0]
    # piecewise straight displacement holds sinc^2(pi/per) of the sine: 5e-5
    assert abs(found - exact) < 3e-4 * abs(exact)
    lost = np.sum(force[last] * omega * np.cos(omega * t[last])) * t[1]
    assert lost == pytest.approx(np.pi * exact.imag, rel=3e-4)


def test_a_record_in_blocks_is_the_record_at_once():
    """Blocks and rows of the recursion leave no seam.

    One long record against the plain step by step formula.
    """
    rng = np.random.default_rng(3)
    theta = np.array([2.0, 3.0, 0.5, 4.0])
    modes = MODELS["burgers"].spectrum(theta)
    for t in (np.arange(9001) * 0.01, np.cumsum(rng.uniform(0.001, 0.02, 9001))):
        x = np.cumsum(rng.normal(size=len(t)))
        x[0] = 0.0
        found = MODELS["burgers"].respond(theta, t, x)
        q, by_hand = np.zeros(2), np.zeros(len(t))
        for k in range(1, len(t)):
            z = modes.rates * (t[k] - t[k - 1])
            q = np.exp(-z) * q - np.expm1(-z) / z * (x[k] - x[k - 1])
            by_hand[k] = modes.weights @ q
        np.testing.assert_allclose(found, by_hand, atol=1e-10 * np.abs(by_hand).max())


@pytest.mark.parametrize(
    "name", ["maxwell", "burgers", "zener", "fractional-zener", "fractional-maxwell", "springpot"]
)
def test_force_and_displacement_undo_each_other(name: str):
    model = MODELS[name]
    theta = typical(model)
    t = np.linspace(0.0, 20.0, 2001)
    force = np.sin(t) ** 2 * t
    back = model.respond(theta, t, model.respond_force(theta, t, force))
    np.testing.assert_allclose(back, force, atol=2e-3 * np.abs(force).max())


def test_a_held_displacement_goes_on_as_it_was():
    t = np.linspace(5.0, 6.0, 11)
    zener = MODELS["zener"]
    np.testing.assert_allclose(zener.respond([2.0, 3.0, 1.0], t, np.full(11, 0.5)), 1.0, rtol=1e-12)
    np.testing.assert_allclose(
        MODELS["maxwell"].respond([2.0, 3.0], t, np.full(11, 0.5)), 0.0, atol=1e-12
    )
    np.testing.assert_allclose(
        zener.respond_force([2.0, 3.0, 1.0], t, np.full(11, 0.5)), 0.25, rtol=1e-12
    )


@pytest.mark.soak
def test_an_oscillator_with_a_springpot_against_its_inverse_fourier_transform():
    m, c, alpha, k = 1.0, 0.6, 0.5, 4.0
    network = parallel(spring(), springpot(), mass())
    n, length = 2**16, 400.0
    t = np.arange(n) * (length / n)
    force = np.exp(-((t - 20.0) ** 2))
    found = Model("test", network).respond_force([k, c, alpha, m], t, force)
    omega = 2 * np.pi * np.fft.rfftfreq(n, length / n)
    stiffness = np.append(k, k + c * (1j * omega[1:]) ** alpha - m * omega[1:] ** 2)
    exact = np.fft.irfft(np.fft.rfft(force) / stiffness, n)
    early = t < 100.0
    # the transform is periodic and so begins with what is left of the record before: 1e-5 of the
    # peak
    np.testing.assert_allclose(found[early], exact[early], atol=5e-5 * np.abs(exact).max())


@pytest.mark.parametrize("m", [1e-100, 1e-200, 1e-300])
def test_a_mass_of_next_to_nothing_changes_nothing(m: float):
    model, t = parse_model("kelvin + inertia"), np.linspace(0.0, 1.0, 50)
    without = parse_model("kelvin").respond_force([5.0, 2.0], t, t)
    np.testing.assert_allclose(model.respond_force([5.0, 2.0, m], t, t), without, rtol=1e-9)


def test_bagley_torvik():
    """m y'' + c D^(3/2) y + k y = F has y = t^3 for F = 6 m t + 6 c t^(3/2)/gamma(5/2) + k t^3."""
    m, c, k = 1.0, 1.0, 1.0
    t = np.linspace(0.0, 5.0, 4001)
    force = 6 * m * t + c * 6 / gamma(2.5) * t**1.5 + k * t**3
    model = Model("plate", parallel(spring(), basset(), mass()))
    found = model.respond_force([k, c, m], t, force)
    np.testing.assert_allclose(found, t**3, atol=2e-6 * 125)
    # and the other way: 1 + t, of which a layer feels the velocity that set in at t = 0
    back = model.respond([k, c, m], t, 1 + t)
    late = t > 0.5
    np.testing.assert_allclose(
        back[late], (1 + t + c / np.sqrt(np.pi * np.maximum(t, 1e-9)))[late], rtol=1e-6
    )


def test_a_layer_of_fluid_feels_each_change_of_speed_of_a_rough_motion():
    """Of straight ways c s^(3/2) is c dv / sqrt(pi t) after each change dv of the speed.

    Whatever stands beside it: the modes that are faster than the samples nearly cancel a dashpot.
    """
    c, step = 2.0, 0.01
    t = step * np.arange(120)
    rough = np.sin(5.0 * t) + 1e-3 * np.random.default_rng(3).normal(size=len(t))
    changes = np.diff(np.diff(rough) / step, prepend=0.0)
    exact = np.array([c * np.sum(changes[:n] / np.sqrt(np.pi * t[n:0:-1])) for n in range(len(t))])
    within = 1e-5 * np.abs(exact).max()
    np.testing.assert_allclose(of(basset(), c).respond(t, rough).value, exact, atol=within)
    own = series(spring(), springpot())
    alone = of(own, 1.0, 1.0, 0.5).respond(t, rough).value
    both = of(parallel(own, basset("b")), 1.0, 1.0, 0.5, c).respond(t, rough).value
    np.testing.assert_allclose(both - alone, exact, atol=within)


@pytest.mark.parametrize(("m", "c", "k"), [(1.0, 1.0, 1.0), (1.0, 0.5, 0.5), (0.3, 2.0, 5.0)])
def test_bagley_torvik_under_a_force_that_sets_in(m: float, c: float, k: float):
    """With w = s^(1/2), 1 / (m w^4 + c w^3 + k) is a sum of A / (w - a).

    A / (s (w - a)) is a Faddeeva function: its inverse is A t^(1/2) E_(1/2,3/2)(a t^(1/2)), with
    z E_(1/2,3/2)(z) = exp(z^2) erfc(-z) - 1 (Podlubny 1999, Fractional Differential Equations,
    8.3.2, has it as a series).
    """
    t = np.geomspace(1e-3, 30.0, 60)
    a = np.roots([m, c, 0.0, 0.0, k])
    share = 1 / (4 * m * a**3 + 3 * c * a**2)
    z = np.outer(np.sqrt(t), a)
    exact = ((share / a) * (wofz(-1j * z) - 1)).sum(axis=1)
    assert np.abs(exact.imag).max() < 1e-12
    found = of(parallel(spring(), basset(), mass()), k, c, m).creep(t).value
    np.testing.assert_allclose(found, exact.real, atol=1e-9 * np.abs(exact).max())


def test_a_mass_swings_as_a_pendulum_does():
    t = np.linspace(0.0, 10.0, 101)
    found = of(parallel(spring(), mass()), 4.0, 1.0).creep(t).value
    np.testing.assert_allclose(found, 0.25 * (1 - np.cos(2 * t)), atol=1e-9)


DERIVATIVES = [
    ("fractional-zener", [1.0, 3.0, 2.0, 0.6]),
    ("burgers", [2.0, 3.0, 0.5, 4.0]),
    ("kelvin", [2.0, 3.0]),
    ("fractional-maxwell", [2.0, 3.0, 0.45]),
    ("fractional-zener + inertia", [1.0, 3.0, 2.0, 0.6, 0.05]),
    ("havriliak-negami", [1.0, 3.0, 2.0, 0.6, 0.7]),
    ("zener + relaxation-mode", [1.0, 3.0, 2.0, 1.5, 0.2]),
]


def slope_by_differences(function, theta: np.ndarray) -> np.ndarray:
    """By fourth-order central differences."""
    columns = []
    for i in range(len(theta)):
        step = 1e-3 * theta[i] * np.eye(len(theta))[i]
        values = [function(theta + factor * step) for factor in (2, 1, -1, -2)]
        columns.append(
            (-values[0] + 8 * values[1] - 8 * values[2] + values[3]) / (12e-3 * theta[i])
        )
    return np.stack(columns, axis=-1)


def check_slopes(model: Model, theta: list[float], ask) -> None:
    def value(point: np.ndarray) -> np.ndarray:
        return ask(model.in_time(point, tolerance=1e-10)).value

    found: Traced = ask(model.in_time(np.array(theta), tolerance=1e-10))
    numeric = slope_by_differences(value, np.array(theta))
    natural = np.abs(found.value).max() / np.array(theta)
    assert np.max(np.abs(found.by_theta - numeric) / natural) < 3e-8


@pytest.mark.soak_cases(
    "fractional-zener + inertia-theta4", "havriliak-negami-theta5", "zener + relaxation-mode-theta6"
)
@pytest.mark.parametrize(("name", "theta"), DERIVATIVES)
def test_derivatives_by_all_parameters(name: str, theta: list[float]):
    model = parse_model(name)
    t = np.linspace(0.0, 4.0, 81)
    wave = np.sin(t) * t
    check_slopes(model, theta, lambda at: at.relaxation(t[1:]))
    check_slopes(model, theta, lambda at: at.creep(t[1:]))
    check_slopes(model, theta, lambda at: at.respond(t, wave))
    check_slopes(model, theta, lambda at: at.respond_force(t, wave))


NONLINEAR = [
    ("friction", [0.3]),
    ("elasto-sliding", [2.0, 0.5]),
    ("cubic-stiffness", [0.7]),
    ("cubic-damping", [0.7]),
    ("power-law-damper", [0.6, 0.4]),
    ("dead-zone", [1.2, 0.4]),
]


@pytest.mark.parametrize(("effect", "theta"), NONLINEAR)
def test_first_and_third_harmonic_of_what_is_not_linear(effect: str, theta: list[float]):
    """The describing function is what the exact loop shows in its first harmonic."""
    model = parse_model(f"zener + {effect}")
    whole = np.array([1.0, 3.0, 2.0, *theta])
    omega, amplitude, per = 2.0, 1.3, 4000
    t = np.arange(12 * per + 1) * (2 * np.pi / omega / per)
    force = model.respond(whole, t, amplitude * np.sin(omega * t))
    last = slice(-per - 1, -1)
    at = Points(np.log([omega]), np.array([amplitude]))
    turn = np.exp(-1j * omega * t[last])
    # sin = cos(omega t - pi/2): each harmonic n is turned back by n quarter turns
    first = 2.0 / per * np.sum(force[last] * turn) * 1j / amplitude
    third = 2.0 / per * np.sum(force[last] * turn**3) * -1j / amplitude
    stiffness = model.stiffness(whole, at)[0]
    assert abs(first - stiffness) < 1e-3 * abs(stiffness)
    assert abs(third / stiffness - model.third_harmonic(whole, at)[0]) < 1e-3


@pytest.mark.parametrize(("effect", "theta"), [*NONLINEAR, ("gain-error", [0.1])])
def test_derivatives_of_what_is_not_linear(effect: str, theta: list[float]):
    t = np.linspace(0.0, 8.0, 400)
    check_slopes(
        parse_model(f"zener + {effect}"),
        [1.0, 3.0, 2.0, *theta],
        lambda at: at.respond(t, np.sin(t) * 1.1),
    )


@pytest.mark.parametrize(
    ("effect", "value"),
    [
        ("time-delay", 0.02),
        ("gain-error", 0.2),
        ("filter-mismatch", 0.1),
        ("filter-mismatch", -0.1),
    ],
)
def test_signal_effects_act_on_the_force_signal(effect: str, value: float):
    model = parse_model(f"zener + {effect}")
    theta = np.array([1.0, 3.0, 2.0, value])
    omega, per = 2.0, 2000
    t = np.arange(12 * per + 1) * (2 * np.pi / omega / per)
    found = model.in_time(theta).respond(t, np.sin(omega * t))
    last = slice(-per - 1, -1)
    turn = np.exp(-1j * omega * t[last]) * 2j / per
    at = Points(np.log([omega]), np.ones(1))
    assert np.sum(found.value[last] * turn) == pytest.approx(
        model.stiffness(theta, at)[0], rel=1e-4
    )
    np.testing.assert_allclose(turn @ found.by_theta[last], model.jacobian(theta, at)[0], atol=2e-3)


def test_friction_of_a_ramp_is_all_there():
    t = np.linspace(0.0, 1.0, 11)
    model = parse_model("spring + friction")
    np.testing.assert_allclose(model.respond([2.0, 0.3], t, t)[1:], 2.0 * t[1:] + 0.3, rtol=1e-12)


@pytest.mark.parametrize("name", ["maxwell", "fractional-zener"])
def test_a_history_of_temperatures_is_reduced_time(name: str):
    model = parse_model(f"{name} + arrhenius-shift + inertia")
    theta = np.array([*typical(MODELS[name]), 40.0, 0.01])
    t = np.linspace(0.0, 10.0, 2001)
    x = np.sin(t)
    at = {"reference_temperature": 300.0, "tolerance": 1e-9}
    steady = model.in_time(theta, temperature=310.0, **at).respond(t, x)
    same = model.in_time(theta, temperature=np.full(len(t), 310.0), **at).respond(t, x)
    np.testing.assert_allclose(same.value, steady.value, atol=1e-7 * np.abs(steady.value).max())
    np.testing.assert_allclose(
        same.by_theta, steady.by_theta, atol=3e-6 * np.abs(steady.by_theta).max()
    )
    warming = np.linspace(300.0, 330.0, len(t))
    softer = model.in_time(theta, temperature=warming, **at).respond(t, x).value
    cold = model.in_time(theta, temperature=300.0, **at).respond(t, x).value
    assert np.abs(softer[-200:]).max() < np.abs(cold[-200:]).max()
    np.testing.assert_allclose(softer[:3], cold[:3], rtol=1e-3, atol=1e-6)


@pytest.mark.soak_cases("fractional-zener-own0")
@pytest.mark.parametrize(
    ("name", "own"),
    [
        ("fractional-zener", [1.0, 3.0, 2.0, 0.6]),
        ("kelvin", [1.0, 3.0]),
        ("burgers", [1.0, 3.0, 2.0, 0.6]),
    ],
)
def test_derivatives_with_a_history_of_temperatures(name: str, own: list[float]):
    model = parse_model(f"{name} + wlf-shift")
    t = np.linspace(0.0, 4.0, 81)
    warming = np.linspace(295.0, 310.0, len(t))
    theta = np.array([*own, 8.0, 90.0])

    def ask(point: np.ndarray) -> Traced:
        options = {"temperature": warming, "reference_temperature": 300.0, "tolerance": 1e-10}
        return model.in_time(point, **options).respond(t, np.sin(t) * t)

    found, numeric = ask(theta), slope_by_differences(lambda point: ask(point).value, theta)
    assert np.max(np.abs(found.by_theta - numeric) * theta) < 1e-7 * np.abs(found.value).max()


def test_a_ramp_of_temperature_has_the_reduced_time_of_its_integral():
    """A Maxwell element held while it warms.

    ln of its force falls with the integral of dt / (a_T tau).
    """
    network = shift(series(spring(), dashpot()), arrhenius())
    model = Model("test", network)
    heated = Model(
        "test",
        series(spring(), dashpot()),
        effects=(Effect("warm", shift, arrhenius(), "w", Layer.TEMPERATURE),),
    )
    t = np.concatenate([[0.0, 1e-6], np.linspace(0.01, 5.0, 2000)])
    x = np.minimum(t / 1e-6, 1.0)
    warm = 300.0 + 4.0 * t
    found = (
        heated.in_time([2.0, 8.0, 50.0], temperature=warm, reference_temperature=300.0)
        .respond(t, x)
        .value
    )
    inverse = np.exp(-50.0 / 8.31446261815324e-3 * (1 / warm - 1 / 300.0))
    reduced = np.concatenate([[0.0], np.cumsum(np.diff(t) * 0.5 * (inverse[1:] + inverse[:-1]))])
    np.testing.assert_allclose(found[2:], 2.0 * np.exp(-reduced[2:] / 4.0), rtol=1e-5)
    assert model.name == "test"


@pytest.mark.parametrize("effect", OF_THE_NETWORK)
def test_every_effect_answers_in_time_or_is_refused_by_name(effect: str):
    model = parse_model(f"fractional-zener + {effect}")
    theta = np.array([1.3, 2.0, 1.5, 0.6, *(p.typical for p in model.parameters[4:])])
    t = np.linspace(0.0, 2.0, 50)
    if effect in NO_LAW:
        with pytest.raises(ModelError, match=f"'{effect}'"):
            model.respond(theta, t, np.sin(t))
    else:
        assert np.all(np.isfinite(model.respond(theta, t, np.sin(t))))


NO_LAW = {
    *(
        "phase-error",
        "fixture-resonance",
        "crosstalk",
        "frequency-error",
        "backlash",
        "hysteretic-loss",
    ),
    *(
        "hardening-mount",
        "power-law-slip",
        "strain-softening",
        "shear-thinning",
    ),
    *("frame-resonance", "self-heating", "payne", "intrinsic-nonlinearity", "specimen-inertia"),
    "specimen-inertia-fixed",
}


@pytest.mark.parametrize("what", ["relaxation", "creep", "respond_force"])
def test_what_is_not_linear_has_no_relaxation_function(what: str):
    model = parse_model("zener + friction")
    t = np.linspace(1.0, 2.0, 5)
    with pytest.raises(ModelError, match="'friction'"):
        getattr(model, what)([1.0, 2.0, 3.0, 0.1], t, *([t] if what == "respond_force" else []))


def test_a_nonlinear_force_inside_a_mounting_is_refused():
    with pytest.raises(ModelError, match=r"'cubic-stiffness'.*'series-spring'"):
        parse_model("zener + cubic-stiffness + series-spring").respond(
            np.ones(5), [0.0, 1.0], [0.0, 1.0]
        )


@pytest.mark.parametrize(
    ("t", "x", "says"),
    [
        ([0.0, 1.0, 1.0], [0.0, 1.0, 2.0], "does not rise after sample 2"),
        ([0.0, 1.0], [0.0], "same length"),
        ([0.0], [0.0], "two samples"),
        ([0.0, 1.0], [0.0, np.nan], "sample 2 is no number"),
    ],
)
def test_bad_histories_are_told_in_one_line(t: list[float], x: list[float], says: str):
    with pytest.raises(ModelError, match=says) as told:
        MODELS["zener"].respond([1.0, 2.0, 3.0], t, x)
    assert "\n" not in str(told.value)


def test_times_before_the_step_are_refused():
    with pytest.raises(ModelError, match="nothing before"):
        MODELS["zener"].relaxation([1.0, 2.0, 3.0], [-1.0, 1.0])


def test_a_fluid_is_put_under_force_with_the_first_sample():
    """Before it would have flowed without end."""
    model = MODELS["maxwell"]
    found = model.respond_force([1.0, 2.0], [3.0, 4.0], [1.0, 1.0])
    assert found == pytest.approx([1.0, 1.5])
    inside = model.in_time(np.array([1.0, 2.0]))
    with pytest.raises(ModelError, match="begin at 0"):
        inside.by_clock(np.array([3.0, 4.0]), np.ones(2), "force", np.ones((2, 1)))


@pytest.mark.parametrize("turned", [1.0, 1.0 + 0.3j])
def test_even_samples_are_driven_as_uneven_ones(rng: np.random.Generator, turned: complex):
    n, m = 5000, 40
    rates = np.geomspace(1e-4, 1e5, m) * turned
    changes, mix = rng.normal(size=n), rng.normal(size=(m, 3))
    rate_mix = rng.normal(size=(m, 3)) / np.abs(rates)[:, None]
    even = np.full(n, 0.01)
    # One sample that comes late by little more than scatter: the same history, the other way.
    late = even.copy()
    late[-1] *= 1.0 + 1e-8
    found = terms.driven(rates, even, changes, mix, rate_mix)
    expected = terms.driven(rates, late, changes, mix, rate_mix)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-8 * np.abs(expected).max())
    earlier = slice(None, -1)
    np.testing.assert_allclose(
        found[earlier], expected[earlier], rtol=0.0, atol=1e-12 * np.abs(expected).max()
    )


@pytest.mark.parametrize("alpha", [0.1, 0.5, 0.9])
def test_a_springpot_has_no_force_yet_as_a_ramp_begins(alpha: float):
    t = np.linspace(0.0, 10.0, 101)
    traced = of(springpot(), 2.0, alpha).respond(t, 3.0 * t)
    exact = 6.0 * t ** (1.0 - alpha) / gamma(2.0 - alpha)
    np.testing.assert_allclose(traced.value, exact, rtol=1e-6, atol=1e-12)
    assert np.all(traced.by_theta[0] == pytest.approx(0.0, abs=1e-12))
    # A dashpot has its force at once.
    assert of(dashpot(), 2.0).respond(t, 3.0 * t).value[0] == pytest.approx(6.0)


@pytest.mark.parametrize("order", [0.3, 0.6, 0.9])
def test_davidson_and_cole_relax_as_an_incomplete_gamma_function(order):
    """The spectrum of (1 + s tau)^-gamma has an infinite edge at 1/tau."""
    t = np.geomspace(0.01, 20.0, 40)
    theta = np.array([1.0, 3.0, 2.0, 1.0, order])
    model = parse_model("havriliak-negami")
    exact = 1.0 + 3.0 * gammaincc(order, t / 2.0)
    assert model.relaxation(theta, t) == pytest.approx(exact, rel=5e-4)
