"""A loading between its samples: its value and its rate, with jumps beside a record."""

import numpy as np

from springpot.measurement import Loading
from springpot.measurement.followed import followed


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
