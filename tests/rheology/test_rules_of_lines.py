"""Rules of lines, planes, powers and rates, by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.registry import parse_model, plugins
from springpot.rheology import grammar, hysteresis, named, nodes, poles
from springpot.rheology.elements import Compliance, Continuum, KnownMass, Relaxation
from springpot.rheology.nodes import FULL, GRADIENT, Response
from springpot.rheology.points import HALF_PI, Points


def slope_of(function, x, step=1e-6):
    """The derivative of a function by its argument, from both sides."""
    return (function(x + step) - function(x - step)) / (2.0 * step)


@pytest.mark.parametrize("kind", [Continuum, Relaxation, Compliance])
def test_lines_of_a_spectrum_have_the_slopes_of_their_curves(kind):
    node, x = kind((0.3, 2.0, 50.0)), np.array([-3.0, 0.2, 2.0])
    basis, slopes = node.basis(x, True)
    np.testing.assert_allclose(
        slopes, slope_of(lambda u: node.basis(u, False)[0], x), rtol=1e-6, atol=1e-9
    )
    first, second = node.moved(basis[2:])
    np.testing.assert_allclose(first, slopes[2:], rtol=1e-9, atol=1e-12)
    bends = slope_of(lambda u: node.basis(u, True)[1], x)[2:]
    np.testing.assert_allclose(second, bends, rtol=1e-5, atol=1e-8)


def test_lines_of_a_spectrum_are_those_of_maxwell_elements():
    """At real and at complex frequencies."""
    rates, x = np.array([0.3, 2.0]), np.array([-1.0, 0.7])
    node = Continuum(tuple(rates))
    for log_omega in (x, x + 0.1j):
        s = 1j * np.exp(log_omega)
        found = node.basis(log_omega, False)[0]
        np.testing.assert_allclose(found[1], s, rtol=1e-12)
        np.testing.assert_allclose(found[2:], s / (s + rates[:, None]), rtol=1e-12)


def test_poles_that_rounding_moves_on_are_found_once_steps_no_longer_shrink():
    """Poles at all whole numbers, of a curve that is known to 3e-12 of its places."""
    asked = []

    def respond(where, depth):
        asked.append(depth)
        u = where - HALF_PI + 3e-12 * np.random.default_rng(len(asked)).normal(size=len(where))
        return Response(np.pi / np.tan(np.pi * u) + 0j, None, -((np.pi / np.sin(np.pi * u)) ** 2))

    branch = SimpleNamespace(respond=respond)
    edge = poles.edge_of(branch, 0.6, 40.4)
    np.testing.assert_allclose(poles._poles(branch, edge), np.arange(1, 41), rtol=0.0, atol=1e-10)
    assert len(asked) < 30


@pytest.mark.parametrize(
    ("plane", "missing"),
    [
        (nodes.Parallel, lambda k: 2.0 + 1.0j),
        (nodes.Series, lambda k: 1.0 / (k + 2.0 + 1.0j) - 1.0 / k),
        (nodes.Chain, lambda k: np.log((k + 2.0 + 1.0j) / k)),
        (nodes.Shift, lambda k: (2.0 + 1.0j) / (0.5 * k)),
    ],
)
def test_what_is_missing_is_told_in_the_plane_of_a_composition(plane, missing):
    k = np.array([3.0 + 1.0j, 5.0 + 4.0j])
    modelled = SimpleNamespace(value=k, by_log_omega=0.5 * k)
    np.testing.assert_allclose(plane.residual(k + 2.0 + 1.0j, modelled), missing(k), rtol=1e-12)
    assert plane.label("N/m").startswith(plane.symbol)


def test_a_known_mass_goes_with_the_square_of_the_frequency():
    at = Points.at([0.1, 2.0])
    mass, theta = KnownMass(3.0), np.zeros(0)
    found = mass.respond(theta, at, FULL)
    np.testing.assert_allclose(found.value, [-0.03, -12.0])
    np.testing.assert_allclose(found.by_log_omega, 2.0 * found.value)
    assert mass.respond(theta, at, GRADIENT).by_theta.shape == (0, 2)


def test_two_effects_of_one_size_are_one_where_they_move_k_in_one_direction():
    known = {
        "inertia": True,
        "time-delay": True,
        "friction": True,
        "mounting-compliance": True,
        "gain-error": True,
        "free-shift": True,
        "relaxation-mode": False,
        "filter-mismatch": False,
        "wlf-shift": False,
    }
    effects = {effect.name: effect for effect in plugins().items("effect")}
    told = {name: named.same_twice(effects[name]) for name in known if name in effects}
    assert len(told) > 6
    assert told == {name: known[name] for name in told}


@pytest.mark.parametrize(
    ("lower", "upper", "value"),
    [(2.0, 4.0, 2.5), (3.0, np.inf, 3.25), (-3.0, np.inf, 0.25), (-np.inf, -2.0, -2.25),
     (-np.inf, 2.0, -0.25)],
)  # fmt: skip
def test_a_value_within_bounds_lies_away_from_the_end_that_there_is(lower, upper, value):
    assert named._inside(SimpleNamespace(lower=lower, upper=upper), 0.25) == value


@pytest.mark.parametrize(
    ("text", "shares"),
    [
        ("2", {"": 2.0}),
        ("n", {"n": 1.0}),
        ("2*n - 1", {"n": 2.0, "": -1.0}),
        ("n*2 + n", {"n": 3.0}),
        ("n/4", {"n": 0.25}),
        ("1 - n + n", {"": 1.0}),
        ("n*m", None),
        ("n/m", None),
        ("2/n", None),
        ("sqrt(n)", None),
        ("sqrt(n) + 1", None),
    ],
)
def test_a_power_is_a_sum_of_multiples_of_parameters_or_none(text, shares):
    assert grammar._linear(grammar.parsed(text)) == shares


@pytest.mark.parametrize("z", [-2.0, -0.5, 0.7, 3.0])
def test_a_force_flows_by_its_power_the_way_that_it_pulls(z):
    speed, slope, bend = hysteresis._flow(z, 1.5, 3.0)
    assert speed == pytest.approx(np.sign(z) * (abs(z) / 1.5) ** 3.0)
    assert slope == pytest.approx(slope_of(lambda u: hysteresis._flow(u, 1.5, 3.0)[0], z), rel=1e-6)
    by_power = slope_of(lambda power: hysteresis._flow(z, 1.5, power)[0], 3.0)
    assert bend == pytest.approx(by_power, rel=1e-6)
    assert hysteresis._flow(0.0, 1.5, 3.0) == (0.0, 0.0, 0.0)
    share = 0.3
    found = hysteresis._flowed(z, share, 1.5, 3.0)
    assert found + share * hysteresis._flow(found, 1.5, 3.0)[0] == pytest.approx(z)


@pytest.mark.parametrize("name", ["fractional-zener", "fractional-maxwell", "maxwell"])
def test_rates_after_a_step_are_slopes_of_the_answer(name):
    model = parse_model(name)
    followed = model.in_time(model.theta(**dict.fromkeys(model.names, 0.6)))
    t = np.array([0.05, 1.0, 20.0])
    for control, answer in (("displacement", followed.relaxation), ("force", followed.creep)):
        numeric = slope_of(lambda at, f=answer: f(np.sort(at)).value, t, 1e-4)
        np.testing.assert_allclose(followed.step_rate(t, control), numeric, rtol=1e-4, atol=1e-7)
