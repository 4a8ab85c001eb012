"""Search coordinates: there and back, their slopes, their ends."""

import numpy as np
import pytest

from springpot.identification.value import LOST, Value
from springpot.rheology import PURE, STIFFNESS, VISCOSITY, Parameter, springpot
from springpot.rheology.parameters import WIDEST, Coordinates

C, ALPHA = springpot("c", "alpha").parameters
PARAMETERS = (
    Parameter("k", "k", STIFFNESS),
    C,
    ALPHA,
    Parameter("eta", "eta", VISCOSITY, typical=2.0),
    Parameter("g", "g", PURE, -3.0, 5.0, scale="linear"),
)
LOG_OMEGA = 1.7


@pytest.fixture
def coordinates():
    return Coordinates.of(PARAMETERS, LOG_OMEGA, np.array([100.0, 7.0]))


def test_natural_sizes_are_those_of_the_data(coordinates):
    time = np.exp(-LOG_OMEGA)
    wanted = [[k, C.typical * k, 1.0, 2.0 * k * time, 8.0] for k in (100.0, 7.0)]
    np.testing.assert_allclose(coordinates.size, wanted)
    np.testing.assert_allclose(
        coordinates.at_unit_stiffness().size, [[1, C.typical, 1, 2 * time, 8]]
    )
    np.testing.assert_allclose(coordinates.rows(np.array([1])).size, wanted[1:])


def test_there_and_back(coordinates, rng):
    u = rng.uniform(0.1, 0.9, (2, 5))
    theta = coordinates.theta(u, coordinates.size)
    np.testing.assert_allclose(coordinates.u(theta.copy(), coordinates.size), u)
    # A springpot's coordinate is its stiffness at the reference frequency.
    at_reference = theta[:, 1] * np.exp(LOG_OMEGA * theta[:, 2])
    np.testing.assert_allclose(np.log(at_reference / coordinates.size[:, 1]), u[:, 1])


def test_zero_is_further_down_than_any_search_goes(coordinates):
    theta = np.array([0.0, 1.0, 0.5, 1.0, 0.0])
    u = coordinates.u(theta, coordinates.size[0])
    assert u[0] == pytest.approx(-2.0 * WIDEST)
    assert u[4] == 0.0


def test_slopes_are_those_of_differences(coordinates, rng):
    u, size, step = rng.uniform(0.1, 0.9, 5), coordinates.size[0], 1e-6
    found = coordinates.slopes(coordinates.theta(u, size), size)
    for i, e in enumerate(np.eye(5)):
        ends = [coordinates.theta(u + sign * step * e, size) for sign in (1.0, -1.0)]
        np.testing.assert_allclose(found[:, i], (ends[0] - ends[1]) / (2 * step), atol=1e-7)


def test_open_ends_are_twelve_decades_off_and_ranges_are_searched_to_both(coordinates):
    low, high = coordinates.bounds
    for row in range(2):
        np.testing.assert_allclose(low[row, [0, 1, 3]], -WIDEST)
        np.testing.assert_allclose(high[row, [0, 1, 3]], WIDEST)
        size = coordinates.size[row]
        np.testing.assert_allclose([low[row, 4], high[row, 4]], [-3.0 / size[4], 5.0 / size[4]])
        np.testing.assert_allclose([low[row, 2], high[row, 2]], [ALPHA.lower, ALPHA.upper])


@pytest.mark.parametrize(
    ("low", "high", "determined"),
    [
        (1.0, 2.0, True),
        (1.0, 0.999 * LOST, True),
        (1.0, LOST, False),
        (0.0, 1.0, True),
        (-1.0, 1e9, True),
        (1.0, np.inf, False),
        (-np.inf, 1.0, False),
    ],
)
def test_an_interval_of_three_decades_says_nothing(low, high, determined):
    assert Value(1.5, low, high, "kg").determined is determined


@pytest.mark.parametrize(
    ("value", "printed"),
    [
        (Value(1.5, 1.0, 2.0, "kg"), "1.5 [1, 2] kg"),
        (Value(0.123456, 0.1, 0.2, "-"), "0.1235 [0.1, 0.2]"),
        (Value(1.5, 1.5, 1.5, "kg", fixed=True), "1.5 kg (fixed)"),
        (Value(1.5, 1.5, 1.5, "-", fixed=True), "1.5 (fixed)"),
    ],
)
def test_a_value_is_printed_with_its_interval_and_unit(value, printed):
    assert str(value) == printed
    assert Value.from_dict(value.to_dict()) == value
