"""Shapes along sweeps and in time: what they span, where they are zero, what energy they take."""

import numpy as np
import pytest
from scipy import stats

from springpot.measurement import Measurement
from springpot.misfit.drift_search import _at_each, _roughness, _slow, beyond
from springpot.misfit.frame import (
    DRIFT_DEGREE,
    SMOOTH_DEGREE,
    chance_of_squares,
    drift_curves,
    drift_shapes,
    orthonormal,
    relative_to,
    slow_shapes,
    spectrum,
    waves,
)


def swept(count, temperatures=(20.0, 40.0)):
    omega = np.tile(np.geomspace(1.0, 50.0, count), len(temperatures))
    t = np.repeat(temperatures, count)
    return Measurement(omega, np.full(len(omega), 1j), conditions={"temperature": t})


def test_slow_shapes_are_polynomials_along_each_sweep_alone():
    data = swept(12)
    shapes, each = slow_shapes(data), 4
    assert shapes.shape == (2 * each, 24)
    assert each == min(SMOOTH_DEGREE, 12 // 3 - 1) + 1
    wanted = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, 12), each - 1).T
    for sweep, rows in enumerate((slice(0, 12), slice(12, 24))):
        own = shapes[sweep * each : (sweep + 1) * each]
        np.testing.assert_allclose(own[:, rows], wanted, atol=1e-12)
        assert np.count_nonzero(np.delete(own, np.arange(24)[rows], axis=1)) == 0


@pytest.mark.parametrize(("count", "degree"), [(2, 0), (5, 0), (6, 1), (9, 2)])
def test_three_points_for_each_polynomial(count, degree):
    assert len(slow_shapes(swept(count, (20.0,)))) == min(SMOOTH_DEGREE, degree) + 1


def test_waves_have_their_period_along_each_sweep():
    shapes = waves(swept(8), 4.0)
    cosine, sine = [1, 0, -1, 0] * 2, [0, 1, 0, -1] * 2
    nothing = [0] * 8
    wanted = [[*cosine, *nothing], [*sine, *nothing], [*nothing, *cosine], [*nothing, *sine]]
    np.testing.assert_allclose(shapes, wanted, atol=1e-12)


def test_the_spectrum_is_the_energy_along_waves_by_least_squares(rng):
    data = swept(7)
    sample = rng.normal(size=(3, 28))
    found = spectrum(data, sample)
    assert found.shape == (3, 8)
    for k in range(8):
        wanted = np.zeros(3)
        phase = np.pi * k / 7 * np.arange(7)
        columns = np.stack([np.cos(phase), np.sin(phase)], axis=1)
        for start in (0, 7, 14, 21):
            part = sample[:, start : start + 7].T
            wanted += np.sum((columns @ np.linalg.pinv(columns, rcond=1e-6) @ part) ** 2, axis=0)
        np.testing.assert_allclose(found[:, k], wanted)


def test_drift_curves_are_polynomials_with_and_without_their_constant():
    curves = drift_curves(9)
    assert curves.shape == (9, DRIFT_DEGREE + 1)
    x = np.linspace(-1.0, 1.0, 9)
    np.testing.assert_allclose(curves[:, :3], np.stack([x**0, x, 1.5 * x**2 - 0.5], axis=1))
    np.testing.assert_array_equal(drift_shapes(9), curves.T[1:])


def test_an_orthonormal_basis_spans_the_columns_whatever_their_units(rng):
    columns = rng.normal(size=(9, 3))
    many = np.column_stack([1e-8 * columns, 1e8 * columns[:, :1], columns @ [1, 2, 3], np.zeros(9)])
    basis = orthonormal(many)
    assert basis.shape == (9, 3)
    np.testing.assert_allclose(basis.T @ basis, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(basis @ (basis.T @ columns), columns)
    assert orthonormal(np.zeros((9, 2))).shape == (9, 0)
    left = beyond(np.column_stack([columns[:, 0], rng.normal(size=9)]), basis)
    assert left.shape == (9, 1)
    np.testing.assert_allclose(basis.T @ left, 0.0, atol=1e-12)


def test_deviations_are_relative_to_the_model_unless_it_has_none():
    data = Measurement([1.0, 2.0], [5.0 + 1j, 7.0 + 1j])
    np.testing.assert_array_equal(relative_to(np.array([2.0j, 0.0]), data), [2.0j, 7.0 + 1j])


def test_chances_of_squares_are_those_of_chi_square_and_of_f():
    assert chance_of_squares(9.0, 4.0, np.inf) == pytest.approx(stats.chi2.sf(9.0, 4))
    assert chance_of_squares(9.0, 4.0, 12.0) == pytest.approx(stats.f.sf(9.0 / 4.0, 4, 12))
    assert chance_of_squares(9.0, 4.0, 0.2) == pytest.approx(stats.f.sf(9.0 / 4.0, 4, 1))


def test_slow_curves_go_by_the_order_and_slope_along_the_frequency(rng):
    values = np.array([0.0, 1.0, 1.0, 10.0, 100.0, *np.geomspace(200.0, 1e6, 60)])
    slopes = rng.normal(size=65)
    found = _slow(values, slopes)
    half = len(found) // 2
    rank = np.array([0, 1, 1, *range(2, 64)])
    np.testing.assert_allclose(found[0], 1.0)
    np.testing.assert_allclose(found[1], 2.0 * rank / 63 - 1.0)
    np.testing.assert_allclose(found[half:], found[:half] * slopes)
    assert len(_slow(np.zeros(5), np.zeros(5))) == 2


def test_each_value_has_a_shape_of_its_own():
    np.testing.assert_array_equal(
        _at_each(np.array([0, 2, 1, 2])), [[1, 0, 0, 0], [0, 0, 1, 0], [0, 1, 0, 1]]
    )


def test_roughness_is_how_far_values_lie_off_their_neighbours():
    assert _roughness(np.arange(9.0)) == 0.0
    assert _roughness(np.array([0.0, 1.0, 0.0, 1.0, 0.0])) == 2.0
