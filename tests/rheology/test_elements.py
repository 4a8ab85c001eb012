"""Elements and compositions: values, exact derivatives, broadcasting."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from derivatives import cauchy, check_derivatives, sample
from springpot.errors import DataError
from springpot.rheology import (
    FixedPower,
    Node,
    Points,
    chain,
    dashpot,
    mass,
    parallel,
    power_of_s,
    series,
    shift,
    spring,
    springpot,
    viscosity,
)

OMEGA = np.logspace(-2, 3, 7)
AT = Points.at(OMEGA)
positive = st.floats(1e-3, 1e3)
orders = st.floats(0.0, 1.0)

NETWORKS = {
    "spring": spring(),
    "dashpot": dashpot(),
    "mass": mass(),
    "springpot": springpot(),
    "basset": FixedPower(viscosity("b"), 1.5),
    "parallel": parallel(spring(), springpot(), mass()),
    "series": series(spring(), springpot(), dashpot()),
    "nested": parallel(
        mass(), series(spring("k1"), parallel(springpot(), series(dashpot("c1"), spring("k2"))))
    ),
    "chain": chain(series(spring(), dashpot()), springpot("gain", "tilt")),
    "shift": shift(series(spring(), springpot()), spring("log_a")),
    "shift-in-parallel": parallel(shift(series(spring(), dashpot()), spring("log_a")), mass()),
    "prefixed": parallel(spring(), mass().with_prefix("inertia")),
}


def value(node: Node, *theta: float) -> np.ndarray:
    return node.respond(np.array(theta), AT).value


@given(positive, orders)
def test_springpot_is_its_complex_power(c: float, alpha: float):
    np.testing.assert_allclose(value(springpot(), c, alpha), c * (1j * OMEGA) ** alpha, rtol=1e-13)


@given(positive)
def test_springpot_at_the_ends_of_its_order_is_spring_and_dashpot(c: float):
    np.testing.assert_allclose(value(springpot(), c, 0.0), value(spring(), c), rtol=1e-14)
    np.testing.assert_allclose(
        value(springpot(), c, 1.0), value(dashpot(), c), rtol=1e-14, atol=1e-13 * c
    )


def test_spring_dashpot_and_mass_have_exact_phases():
    assert np.all(value(spring(), 3.0) == 3.0)
    assert np.all(value(dashpot(), 3.0).real == 0.0)
    assert np.all(value(mass(), 3.0).imag == 0.0)
    np.testing.assert_allclose(value(mass(), 3.0), -3.0 * OMEGA**2, rtol=1e-15)


def test_power_of_s_matches_the_complex_power():
    np.testing.assert_allclose(power_of_s(0.37, np.log(OMEGA)), (1j * OMEGA) ** 0.37, rtol=1e-14)


def test_parallel_adds_stiffness_series_adds_compliance_chain_multiplies():
    a, b = springpot(), spring()
    theta = (2.0, 0.4, 5.0)
    ka, kb = 2.0 * (1j * OMEGA) ** 0.4, 5.0
    np.testing.assert_allclose(value(parallel(a, b), *theta), ka + kb, rtol=1e-14)
    np.testing.assert_allclose(value(series(a, b), *theta), 1 / (1 / ka + 1 / kb), rtol=1e-14)
    np.testing.assert_allclose(value(chain(a, b), *theta), ka * kb, rtol=1e-14)


def test_shift_reads_the_first_node_at_a_multiple_of_the_frequency():
    moved = value(shift(springpot(), spring("log_a")), 2.0, 0.4, np.log(7.0))
    np.testing.assert_allclose(moved, 2.0 * (7j * OMEGA) ** 0.4, rtol=1e-14)


def test_nested_compositions_of_one_kind_are_flattened():
    nested = parallel(spring("a"), parallel(spring("b"), spring("c")))
    assert [p.name for p in nested.parameters] == ["a", "b", "c"]
    assert len(nested.children) == 3  # type: ignore[attr-defined]


def test_a_prefix_renames_parameters_and_the_order_in_their_unit():
    node = springpot().with_prefix("extra")
    assert [p.name for p in node.parameters] == ["extra.c", "extra.alpha"]
    assert node.parameters[0].unit.time == "extra.alpha"
    np.testing.assert_array_equal(value(node, 2.0, 0.3), value(springpot(), 2.0, 0.3))


@pytest.mark.parametrize("name", NETWORKS)
def test_derivatives_are_exact(name: str, rng: np.random.Generator):
    node = NETWORKS[name]
    for _ in range(3):
        check_derivatives(node, sample(node.parameters, rng), AT)


@pytest.mark.parametrize("name", NETWORKS)
def test_depth_changes_no_value(name: str, rng: np.random.Generator):
    node = NETWORKS[name]
    theta = sample(node.parameters, rng, (3,))
    plain, gradient, full = (node.respond(theta, AT, depth) for depth in range(3))
    # Where nothing but the value is wanted it is computed in a quicker order, which may round
    # differently.
    np.testing.assert_allclose(plain.value, gradient.value, rtol=1e-14)
    np.testing.assert_array_equal(gradient.value, full.value)
    np.testing.assert_array_equal(gradient.by_theta, full.by_theta)


def test_parts_in_series_keep_to_the_range_of_numbers():
    """Neither two parts of 1e200 nor two of 1e-200 may be multiplied on the way."""
    node = series(spring("k1"), spring("k2"))
    for size in (1e-200, 1e200):
        np.testing.assert_allclose(
            node.respond(np.array([size, 3.0 * size]), AT).value, 0.75 * size, rtol=1e-14
        )


@pytest.mark.parametrize("name", NETWORKS)
def test_leading_axes_equal_looping(name: str, rng: np.random.Generator):
    node = NETWORKS[name]
    theta = sample(node.parameters, rng, (2, 3))
    whole = node.respond(theta, AT, 2)
    assert whole.value.shape == (2, 3, len(OMEGA))
    assert whole.by_theta.shape == (2, 3, len(node.parameters), len(OMEGA))
    assert whole.by_log_omega.shape == (2, 3, len(OMEGA))
    for index in np.ndindex(2, 3):
        one = node.respond(theta[index], AT, 2)
        for stacked, single in zip(whole, one, strict=True):
            np.testing.assert_allclose(stacked[index], single, rtol=1e-13, atol=1e-300)


def test_the_cauchy_integral_itself_is_exact():
    derivative = cauchy(lambda x: np.exp(x[:1]) * x[1] ** 2, np.array([0.7, 3.0]))
    np.testing.assert_allclose(derivative[0], [9 * np.exp(0.7), 6 * np.exp(0.7)], rtol=1e-12)


def test_a_missing_condition_is_named():
    with pytest.raises(DataError, match="amplitude"):
        AT.need("amplitude")
