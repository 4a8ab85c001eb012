"""Networks that no linear measurement tells apart, under exact maps between their parameters."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from springpot.rheology import Node, Points, dashpot, parallel, series, spring, springpot

OMEGA = np.logspace(-3, 3, 13)
AT = Points.at(OMEGA)
positive = st.floats(0.05, 20.0)
orders = st.floats(0.05, 1.0)

zener = parallel(spring("ke"), series(spring("k1"), springpot()))
standard = series(spring("k0"), parallel(spring("k2"), springpot()))


def value(node: Node, *theta: float) -> np.ndarray:
    return node.respond(np.array(theta), AT).value


def standard_of_zener(
    ke: float, k1: float, v: float, a: float
) -> tuple[float, float, float, float]:
    return ke + k1, ke * (ke + k1) / k1, v * ((ke + k1) / k1) ** 2, a


def zener_of_standard(
    k0: float, k2: float, v: float, a: float
) -> tuple[float, float, float, float]:
    ke, k1 = k0 * k2 / (k0 + k2), k0**2 / (k0 + k2)
    return ke, k1, v * (k1 / (ke + k1)) ** 2, a


@given(positive, positive, positive, orders)
def test_zener_and_standard_form_are_one_model(ke: float, k1: float, v: float, a: float):
    other = standard_of_zener(ke, k1, v, a)
    np.testing.assert_allclose(value(standard, *other), value(zener, ke, k1, v, a), rtol=1e-12)
    np.testing.assert_allclose(zener_of_standard(*other), (ke, k1, v, a), rtol=1e-12)


@pytest.mark.soak
@given(positive, positive, positive, orders)
def test_jeffreys_forms_are_one_model(c0: float, c1: float, v: float, a: float):
    solvent = parallel(dashpot("c0"), series(dashpot("c1"), springpot()))
    film = series(dashpot("cs"), parallel(dashpot("cp"), springpot()))
    other = (c0 + c1, c0 * (c0 + c1) / c1, v * ((c0 + c1) / c1) ** 2, a)
    np.testing.assert_allclose(value(film, *other), value(solvent, c0, c1, v, a), rtol=1e-11)


@given(positive, positive, positive, orders, positive)
def test_an_instantaneous_spring_absorbs_mounting_compliance(
    ke: float, k1: float, v: float, a: float, km: float
):
    k0, k2, c, _ = standard_of_zener(ke, k1, v, a)
    absorbed = zener_of_standard(k0 * km / (k0 + km), k2, c, a)
    mounted = value(series(spring("km"), zener), km, ke, k1, v, a)
    np.testing.assert_allclose(value(zener, *absorbed), mounted, rtol=1e-11)


def kelvin_chain_of_prony(
    k0: float, k: np.ndarray, tau: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:
    """Partial fractions of 1/K: the zeros of K are the retardation rates."""
    poles = np.poly(-1 / tau)
    stiff = (k0 + k.sum()) * poles
    for i in range(len(k)):
        others = np.poly(np.delete(-1 / tau, i))
        stiff = np.polysub(stiff, np.polymul([k[i] / tau[i]], others))
    zeros = np.roots(stiff).real
    amounts = np.polyval(poles, zeros) / np.polyval(np.polyder(stiff), zeros)
    return k0 + float(k.sum()), -zeros / amounts, -1 / zeros


@given(positive, positive, positive, positive, st.floats(2.0, 50.0))
def test_two_maxwell_elements_beside_a_spring_are_a_kelvin_chain(
    k0: float, k1: float, k2: float, tau1: float, spread: float
):
    k, tau = np.array([k1, k2]), np.array([tau1, tau1 * spread])
    side = parallel(spring("k0"), *(series(spring(f"k{i}"), dashpot(f"c{i}")) for i in (1, 2)))
    row = series(spring("k0"), *(parallel(spring(f"k{i}"), dashpot(f"c{i}")) for i in (1, 2)))
    g, stiffs, times = kelvin_chain_of_prony(k0, k, tau)
    prony = value(side, k0, k[0], k[0] * tau[0], k[1], k[1] * tau[1])
    kelvin = value(row, g, stiffs[0], stiffs[0] * times[0], stiffs[1], stiffs[1] * times[1])
    np.testing.assert_allclose(kelvin, prony, rtol=1e-9)


def test_bearing_drag_and_solvent_dashpot_are_one():
    base = series(spring(), springpot())
    one = value(parallel(base, dashpot("bearing")), 2.0, 3.0, 0.4, 0.7)
    other = value(parallel(dashpot("solvent"), base), 0.7, 2.0, 3.0, 0.4)
    np.testing.assert_allclose(one, other, rtol=1e-15)
