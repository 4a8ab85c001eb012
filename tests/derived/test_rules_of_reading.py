"""What is read off a curve of points: places, limits and their errors against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from springpot.identification import measured_quantities
from springpot.identification.measured_quantities import CURVE, FALL
from springpot.measurement import Measurement, Units
from springpot.numerics import FEWEST

X = np.linspace(-2.0, 3.0, 21)


def test_a_parabola_is_read_with_its_errors():
    """Numbers and covariance as by `numpy.polyfit` of the nine points around the place."""
    y = np.sin(X) + 0.01 * np.random.default_rng(1).normal(size=21)
    found = measured_quantities.read(X, y, 0.4)
    near = np.sort(np.argsort(np.abs(X - 0.4), kind="stable")[:9])
    wanted, covariance = np.polyfit(X[near] - 0.4, y[near], 2, cov=True)
    assert (found.bend, found.slope, found.value) == pytest.approx(tuple(wanted))
    np.testing.assert_allclose(found.covariance, covariance[::-1, ::-1], rtol=1e-9)
    assert found.dof == 6
    assert found.reach == pytest.approx(2.4469 * np.sqrt(covariance[2, 2]), rel=1e-4)


def test_a_curve_crosses_nothing_once_at_each_place():
    y = (X - 0.63) * (X + 1.11) * 0.5
    places = [place for place, _ in measured_quantities.crossings(X, y)]
    assert places == pytest.approx([-1.11, 0.63])
    # Scatter about zero crosses it again and again at what is one place.
    rough = 0.2 * (X - 0.5) + 0.05 * (-1.0) ** np.arange(21)
    assert np.sum(np.diff(np.sign(rough)) != 0) > 1
    assert len(list(measured_quantities.crossings(X, rough))) == 1
    assert list(measured_quantities.crossings(X, y + 10.0)) == []
    # Also at a sample itself, as of rounded numbers that are equal there.
    assert [place for place, _ in measured_quantities.crossings(X, X - X[7])] == pytest.approx(
        [X[7]]
    )
    assert list(measured_quantities.crossings(X, (X - X[7]) ** 2)) == []


def swept(count, **conditions):
    omega = np.tile(np.geomspace(1.0, 100.0, count), 2)
    return Measurement(omega, 3.0 + 1.0j * omega, units=Units("kPa", "-"), conditions=conditions)


@pytest.mark.parametrize("count", [CURVE, CURVE - 1])
def test_a_curve_has_as_many_points_as_it_takes_to_read_it(count):
    level = np.repeat([20.0, 30.0], count)
    found = list(measured_quantities.curves(swept(count, temperature=level), "frequency"))
    assert len(found) == (2 if count == CURVE else 0)
    for sweep, temperature in zip(found, (20.0, 30.0), strict=False):
        assert sweep.at == {"temperature": temperature}
        np.testing.assert_allclose(np.exp(sweep.x), np.geomspace(1.0, 100.0, count) / (2 * np.pi))
        np.testing.assert_allclose(np.exp(sweep.loss), np.geomspace(1.0, 100.0, count))


def test_what_was_measured_beside_a_curve_parts_it_not():
    """A column of as many values as rows; one of few levels parts it, if each leaves a curve."""
    beside = np.linspace(1.0, 2.0, 12)
    (whole,) = measured_quantities.curves(swept(6, force=beside), "frequency")
    assert whole.at == {}
    few = np.repeat([1.0, 2.0], 6)
    assert [each.at for each in measured_quantities.curves(swept(6, current=few), "frequency")] == [
        {"current": 1.0},
        {"current": 2.0},
    ]
    assert list(measured_quantities.curves(swept(6), "amplitude")) == []


def test_what_is_not_positive_has_no_logarithm_and_no_place_on_a_curve():
    data = swept(8)
    stiffness = data.stiffness.copy()
    stiffness[2], stiffness[5] = -1.0 + 1.0j, 1.0 - 1.0j
    (found,) = measured_quantities.curves(Measurement(data.omega, stiffness), "frequency")
    assert len(found.x) == 14
    # Half of what others are is still positive.
    stiffness[2], stiffness[5] = 0.5 + 0.5j, 1e-9 + 1e-9j
    (found,) = measured_quantities.curves(Measurement(data.omega, stiffness), "frequency")
    assert len(found.x) == 16


@pytest.mark.soak_cases("3.0", "1.5")
@pytest.mark.parametrize("power", [1.5, 3.0])
def test_a_linear_limit_is_where_storage_has_fallen_by_a_twentieth(power):
    """ln G' = level + ln(0.95) (amplitude / limit)^power, in its own form and with its error."""
    x = np.linspace(np.log(0.01), np.log(0.5), 30)
    exact = 7.0 + np.log(1.0 - FALL) * np.exp(power * (x - np.log(0.1)))
    place, error, dof = measured_quantities.linear_limit(x, exact)
    assert (np.exp(place), error) == pytest.approx((0.1, 0.0), abs=1e-6)
    assert dof < 30 - 3
    rng, found = np.random.default_rng(2), []
    for _ in range(60):
        found.append(measured_quantities.linear_limit(x, exact + 0.002 * rng.normal(size=30))[:2])
    places, errors = np.transpose(found)
    assert np.std(places) == pytest.approx(np.mean(errors), rel=0.25)
    assert measured_quantities.linear_limit(x, np.full(30, 7.0) + 1e-4 * np.sin(x)) is None


@pytest.mark.parametrize(
    ("last", "says"),
    [
        (7.0, "storage falls by less than 5 % up to 0.5 mm: no limit"),
        (7.0 + 0.99 * np.log(0.95), "storage falls by less than 5 % up to 0.5 mm: no limit"),
        (7.0 + 1.01 * np.log(0.95), "storage falls from 0.01 mm on: the linear limit lies below"),
    ],
)
def test_a_limit_that_is_not_there_lies_above_or_below(last, says):
    x, storage = np.linspace(np.log(0.01), np.log(0.5), 12), np.full(12, 7.0)
    storage[-FEWEST:] = last
    # The median of three: one point that is off says nothing.
    storage[0], storage[-1] = 2.0, 20.0
    sweep = measured_quantities.OneSweep(x, storage, storage, {})
    assert measured_quantities._no_limit(sweep, "mm").startswith(says)
