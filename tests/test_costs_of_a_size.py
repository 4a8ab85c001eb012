"""What a size costs that was not known beforehand, by counting where it might have been."""

import numpy as np
import pytest

from springpot.thresholds import EVIDENCE


def test_a_size_of_any_of_ten_decades_costs_their_width_over_that_of_its_likelihood():
    decades, likelihood = np.log(1e10), np.sqrt(2.0 * np.pi)
    assert pytest.approx(np.log(decades / likelihood)) == EVIDENCE.unknown_size


def test_a_sign_is_one_of_two():
    assert np.exp(-EVIDENCE.unknown_sign) == pytest.approx(0.5)
