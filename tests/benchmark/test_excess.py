"""The excess of a value is its share of the way from the best to the reference."""

import numpy as np
import pytest

from springpot.benchmark.comparison import _excess

VALUES = np.array([1.0, 2.0, 3.0, 5.0, np.inf])


def test_nothing_at_the_best_and_one_at_the_reference():
    np.testing.assert_array_equal(_excess(VALUES, 1.0, 3.0), [0.0, 0.5, 1.0, 2.0, np.inf])


def test_better_than_the_best_that_is_known_is_as_good():
    np.testing.assert_array_equal(_excess(VALUES, 2.0, 3.0), [0.0, 0.0, 1.0, 3.0, np.inf])


@pytest.mark.parametrize("reference", [2.0, 1.0, np.nan])
def test_where_nothing_is_worse_than_the_best_all_else_is_infinitely_worse(reference):
    np.testing.assert_array_equal(
        _excess(VALUES, 2.0, reference), [0.0, 0.0, np.inf, np.inf, np.inf]
    )
