"""Numbers of which one is independent, and times of a range, by hand."""

from __future__ import annotations

import numpy as np
import pytest

import springpot.distributions as own
from springpot import constraints
from springpot.errors import OptionError


@pytest.mark.parametrize(
    ("residual", "count"),
    [
        ([1.0, 1.0, -1.0, -1.0, 1.0, 1.0], 1.5),
        ([1.0, -1.0, 1.0, -1.0], 1.0),
        ([0.0, 0.0, 0.0, 0.0], 1.0),
        ([2.0, 2.0, 2.0], 1.0),
        # Of 3 over 2: three products of one in the mean, whose mean square is a half.
        ([3.0, 1.0, 1.0, 1.0], (1.0 + 5.0 / 9.0) / (1.0 - 5.0 / 9.0)),
        ([0.5, 0.5, 0.5, 0.5], (1.0 + own.LIKENESS) / (1.0 - own.LIKENESS)),
        ([0.1, 0.1, -0.1, -0.1, 0.1, 0.1], 1.5),
    ],
)
def test_samples_that_are_alike_make_up_one(residual, count):
    assert own.autocorrelation_time(residual) == pytest.approx(count)


@pytest.mark.parametrize(
    ("text", "per_decade", "times"),
    [
        ("1e-2:1e1", 1, [0.01, 0.1, 1.0, 10.0]),
        ("1:10", 2, [1.0, np.sqrt(10.0), 10.0]),
        ("1:20", 1, [1.0, 20.0]),
        ("1:1", 1, None),
        ("0:1", 1, None),
        ("2:1", 1, None),
        ("1:inf", 1, None),
        ("1", 1, None),
        ("a:b", 1, None),
    ],
)
def test_times_of_a_range_are_even_over_its_decades(text, per_decade, times):
    if times is None:
        with pytest.raises(OptionError, match="is no range of times"):
            constraints.times_of(text, per_decade)
        return
    np.testing.assert_allclose(constraints.times_of(text, per_decade), times)


def test_times_are_no_more_than_a_series_has():
    most = constraints.MOST_TERMS
    assert len(constraints.times_of("1:10", most - 1)) == most
    with pytest.raises(OptionError, match=f"{most + 1} times are more than the {most} of a series"):
        constraints.times_of("1:10", most)
