"""The paper's search forms against its equations (6), (9), (20), (21), (34), (35)."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from derivatives import cauchy
from springpot.rheology import (
    KELVIN_FORM,
    MAXWELL_FORM,
    TIME_FORM,
    SearchForm,
    limits_form,
    order,
    relaxation_time,
    stiffness,
)

LIMITS_FORM = limits_form((stiffness("k0"), stiffness("k1"), relaxation_time(), order()))
FORMS = {"time": TIME_FORM, "maxwell": MAXWELL_FORM, "kelvin": KELVIN_FORM, "limits": LIMITS_FORM}
positive = st.floats(0.01, 100.0)
orders = st.floats(0.1, 1.0)


def lawful(form: SearchForm, rng: np.random.Generator, shape: tuple[int, ...] = ()) -> np.ndarray:
    k0 = rng.uniform(0.5, 2.0, shape)
    rest = [np.exp(rng.uniform(-1, 1, shape)), rng.uniform(0.2, 0.9, shape)]
    head = [k0] if form is TIME_FORM else [k0, k0 * rng.uniform(1.5, 4.0, shape)]
    return np.stack([*head, *rest], axis=-1)


@given(positive, positive, positive, orders)
def test_kelvin_type_limits_are_eq_6(k1: float, k2: float, c: float, alpha: float):
    k0, kinf, tau, same = KELVIN_FORM.from_elements(np.array([k1, k2, c, alpha]))
    np.testing.assert_allclose(k0, k1 * k2 / (k1 + k2))
    assert (kinf, same) == (k1, alpha)
    np.testing.assert_allclose(tau**alpha, c / (k1 + k2), rtol=1e-10)


@given(positive, positive, positive, orders)
def test_maxwell_type_limits_are_eq_9(k1: float, k2: float, c: float, alpha: float):
    k0, kinf, tau, same = MAXWELL_FORM.from_elements(np.array([k1, k2, c, alpha]))
    assert (k0, same) == (k1, alpha)
    np.testing.assert_allclose(kinf, k1 + k2)
    np.testing.assert_allclose(tau**alpha, c / k2, rtol=1e-10)


@given(positive, positive, orders)
def test_time_of_three_parameter_models(k: float, c: float, alpha: float):
    _, tau, _ = TIME_FORM.from_elements(np.array([k, c, alpha]))
    np.testing.assert_allclose(tau**alpha, c / k, rtol=1e-10)


@pytest.mark.parametrize("name", FORMS)
def test_maps_invert_each_other(name: str, rng: np.random.Generator):
    form = FORMS[name]
    x = lawful(form, rng, (4, 5))
    np.testing.assert_allclose(form.from_elements(form.to_elements(x)), x, rtol=1e-11)


@pytest.mark.parametrize("name", FORMS)
def test_jacobians_are_exact(name: str, rng: np.random.Generator):
    form = FORMS[name]
    x = lawful(form, rng, (3,))
    jacobian = form.jacobian(x)
    for one, exact in zip(x, jacobian, strict=True):
        np.testing.assert_allclose(exact, cauchy(form.to_elements, one), rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("form", [MAXWELL_FORM, KELVIN_FORM, LIMITS_FORM])
def test_a_violated_order_becomes_the_paper_s_margin(form: SearchForm):
    x = np.array([[5.0, 3.0, 1.0, 0.5], [2.0, 3.0, 1.0, 0.5]])
    mended = form.repaired(x)
    np.testing.assert_allclose(mended[0], [5.0, 5.05, 1.0, 0.5])
    np.testing.assert_array_equal(mended[1], x[1])
    assert np.all(form.to_elements(mended) > 0)
