"""Where an effect's own parameters are tried, and how far off the data still show them."""

import numpy as np
import pytest

from springpot.identification.starts import BEYOND, DECADES, EDGE, Window, settings, shown
from springpot.measurement import Measurement
from springpot.rheology import PURE, STIFFNESS, Parameter, relaxation_time, springpot

WINDOW = Window(100.0, 0.1, 0.01, 3.0, 1.0)


def test_the_window_of_a_measurement_is_by_geometric_means():
    omega, amplitude = np.array([1.0, 10.0, 100.0]), np.array([0.1, 0.1, 10.0])
    data = Measurement(omega, [3 + 4j, 3 + 4j, 40j / 5], conditions={"amplitude": amplitude})
    found = Window.of(data)
    assert found.stiffness == pytest.approx((5 * 5 * 8) ** (1 / 3))
    assert found.time == pytest.approx(0.1)
    assert found.amplitude == pytest.approx(0.1 ** (1 / 3))
    assert (found.time_decades, found.amplitude_decades) == pytest.approx((2.0, 2.0))
    bare = Window.of(Measurement(omega, [1j] * 3))
    assert (bare.amplitude, bare.amplitude_decades) == (1.0, 0.0)


K = Parameter("k", "k", STIFFNESS, typical=2.0)
RANGE = Parameter("g", "g", PURE, -3.0, 5.0, scale="linear")
EITHER = Parameter("s", "s", PURE, -np.inf, np.inf, scale="linear")
PLAIN = Parameter("p", "p", PURE)


@pytest.mark.parametrize(
    ("parameter", "low", "high"),
    [
        (K, 200.0 * 10**-DECADES, 200.0 * 10**DECADES),
        (RANGE, -3.0, 5.0),
        (EITHER, -1.0, 1.0),
        (PLAIN, 10**-1.5, 10**1.5),
        (relaxation_time(), 0.1 * 10 ** -(1.5 + BEYOND), 0.1 * 10 ** (1.5 + BEYOND)),
    ],
)
def test_settings_fill_their_range(parameter, low, high):
    found = np.sort(settings((parameter,), WINDOW, 400)[:, 0])
    assert low <= found[0] <= found[-1] <= high
    half = len(found) // 2
    if parameter is RANGE:
        assert np.median(found) == pytest.approx(0.5 * (low + high), abs=0.05)
        np.testing.assert_allclose(found[[0, -1]], [low, high], atol=0.05)
    elif parameter is EITHER:
        assert np.count_nonzero(found < 0.0) == pytest.approx(half, abs=2)
        assert np.log10(np.abs(found)).min() == pytest.approx(-DECADES, abs=0.05)
        assert np.abs(found).max() == pytest.approx(1.0, rel=0.1)
    else:
        logs = np.log10(found)
        np.testing.assert_allclose(logs[[0, -1]], np.log10([low, high]), atol=0.05)
        assert np.median(logs) == pytest.approx(0.5 * np.log10(low * high), abs=0.05)


def test_a_constant_has_the_size_that_its_order_says():
    c, alpha = springpot("c", "alpha").parameters
    found = settings((c, alpha), WINDOW, 200)
    natural = 100.0 * c.typical * 0.1 ** found[:, 1]
    off = np.log10(found[:, 0] / natural)
    assert np.abs(off).max() <= DECADES
    assert np.ptp(off) > 1.8 * DECADES


def test_what_the_data_show():
    low, high = shown(K, WINDOW)
    assert (low, high) == pytest.approx((20.0, 2000.0))
    assert shown(RANGE, WINDOW) == pytest.approx((-3.0 + 8.0 * EDGE, 5.0 - 8.0 * EDGE))
    assert shown(relaxation_time(), WINDOW) == pytest.approx((0.1 * 10**-1.5, 0.1 * 10**1.5))
    assert shown(springpot("c", "alpha").parameters[0], WINDOW) == (np.inf, -np.inf)
