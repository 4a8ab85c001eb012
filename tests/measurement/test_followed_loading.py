"""A loading between its samples: its value and its rate, with jumps beside a record."""

import gc
import weakref

import numpy as np
import pytest

from springpot import TimeTest
from springpot.measurement import Loading, Record
from springpot.measurement.recording import followed


def test_between_samples_a_loading_goes_straight_and_at_rest_it_has_no_rate():
    loading = Loading(np.array([0.0, 1.0, 3.0]), np.array([0.0, 2.0, -2.0]))
    value, rate = followed(loading, np.array([-1.0, 0.25, 1.0, 2.0, 4.0]))
    np.testing.assert_allclose(value, [0.0, 0.5, 2.0, 0.0, -2.0], atol=1e-12)
    # At a knot the mean of both sides.
    np.testing.assert_allclose(rate, [0.0, 2.0, 0.0, -2.0, 0.0], atol=1e-12)


def test_a_jump_adds_to_what_goes_on_beside_it_and_has_no_rate_of_its_own():
    loading = Loading(np.array([0.0, 1.0, 1.0, 2.0]), np.array([0.0, 1.0, 5.0, 6.0]))
    value, rate = followed(loading, np.array([0.5, 1.0, 1.5]))
    np.testing.assert_allclose(value, [0.5, 5.0, 5.5], atol=1e-12)
    np.testing.assert_allclose(rate, [1.0, 1.0, 1.0], atol=1e-12)


def test_a_cycle_goes_there_and_back_once_on_one_side_as_on_both():
    time = np.linspace(0.0, 4.0, 401)
    both = np.sin(2.0 * np.pi * time)
    for displacement in (both, 1.0 - np.cos(2.0 * np.pi * time), 3.0 + both):
        test = TimeTest.of_history(time, displacement, displacement, "mm", "N")
        np.testing.assert_allclose(Record.of(test).cycles[-1], 4.0, rtol=1e-3)


@pytest.mark.parametrize("jumped", [0.0, 1.0])
def test_a_loading_is_freed_without_the_garbage_collector(jumped):
    """One that kept itself held gigabytes of what a diagnosis had worked out of a long record."""
    loading = Loading([0.0, 0.0, 1.0, 2.0], [0.0, jumped, 1.0 + jumped, 0.5 + jumped])
    assert loading.smooth is not None
    np.testing.assert_allclose(loading.smooth.value[-1], 0.5)
    kept = weakref.ref(loading)
    gc.disable()
    try:
        del loading
        assert kept() is None
    finally:
        gc.enable()
