"""An isotropic solid from one measured modulus.

The conversions of linear viscoelasticity, and back.
"""

from __future__ import annotations

import numpy as np
import pytest

from springpot.errors import ModelError
from springpot.solvers import Prony, solid_of, young_of

OMEGA = np.geomspace(1e-4, 1e6, 200)
SERIES = Prony(
    1.5,
    0.0,
    np.array([900.0, 31.25, 4.125e-3, 7.0]),
    np.array([1e-5, 1.2e-3, 0.25, 70.0]),
    (1.0, 300.0),
    0.0,
)
"""Fastest first, weights over five decades."""


@pytest.mark.parametrize("poisson", [-0.3, 0.0, 0.3, 0.49, 0.49999])
@pytest.mark.parametrize("measured", ["G", "E"])
def test_with_a_constant_bulk_modulus_one_over_e_is_one_over_3g_and_one_over_9k(
    measured: str, poisson: float
):
    solid = solid_of(SERIES, measured, poisson, "constant")
    shear, bulk = solid.shear.stiffness(OMEGA), solid.bulk.stiffness(OMEGA)
    young = young_of(solid).stiffness(OMEGA)
    assert np.ptp(bulk.real) == 0.0
    assert np.all(bulk.imag == 0.0)
    np.testing.assert_allclose(1.0 / young, 1.0 / (3.0 * shear) + 1.0 / (9.0 * bulk), rtol=1e-9)
    given = {"G": shear, "E": young}[measured]
    np.testing.assert_allclose(given, SERIES.stiffness(OMEGA), rtol=1e-9)
    for series in (solid.shear, young_of(solid)):
        assert np.all(series.weights > 0.0)
        assert np.all(np.diff(series.times) > 0.0)
        assert len(series.times) == len(SERIES.times)


@pytest.mark.parametrize(("measured", "share"), [("G", 1.0), ("E", 1 / 2.6), ("K", 0.6 / 1.3)])
def test_with_a_constant_poisson_ratio_all_moduli_are_in_proportion(measured: str, share: float):
    solid = solid_of(SERIES, measured, 0.3, "relaxing")
    shear = solid.shear.stiffness(OMEGA)
    np.testing.assert_allclose(shear, share * SERIES.stiffness(OMEGA), rtol=1e-12)
    np.testing.assert_allclose(young_of(solid).stiffness(OMEGA), 2.6 * shear, rtol=1e-12)
    np.testing.assert_allclose(solid.bulk.stiffness(OMEGA), 2.6 / 1.2 * shear, rtol=1e-12)


def test_the_shear_modulus_at_each_frequency_is_that_of_the_series():
    for poisson, bulk in ((0.3, "relaxing"), (0.49, "constant")):
        solid = solid_of(SERIES, "E", poisson, bulk)
        at = solid.shear_of(SERIES.stiffness(OMEGA))
        np.testing.assert_allclose(at, solid.shear.stiffness(OMEGA), rtol=1e-9)


def test_the_bulk_modulus_is_constant_by_default_where_it_is_that_of_a_rubber():
    assert solid_of(SERIES, "G", 0.49).constant
    assert not solid_of(SERIES, "G", 0.4).constant
    assert not solid_of(SERIES, "K", 0.49).constant
    with pytest.raises(ModelError, match="--bulk relaxing"):
        solid_of(SERIES, "K", 0.49, "constant")


def test_poisson_ratio_rises_towards_rest_where_the_bulk_modulus_is_constant():
    solid = solid_of(SERIES, "G", 0.3, "constant")
    assert solid.poisson_beside(solid.shear.instantaneous) == pytest.approx(0.3)
    at_rest = solid.poisson_beside(solid.shear.equilibrium)
    assert 0.499 < at_rest < 0.5
