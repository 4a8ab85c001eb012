"""A lead in likelihood tells two explanations apart only beyond its own scatter."""

import numpy as np
import pytest

from springpot.numerics import TWO_DEVIATIONS
from springpot.timetests.hypotheses import variance_of_sum, vuong_distinguishes

RECORDS, SAMPLES = 400, 120
PHASE = 4.0 * np.pi * np.arange(SAMPLES) / SAMPLES
NOISE = np.random.default_rng(20).normal(size=(RECORDS, SAMPLES))


def share_told_apart(one, other):
    return np.mean([vuong_distinguishes([(noise + one, noise + other)]) for noise in NOISE])


def test_the_variance_of_a_sum_counts_neighbours_that_are_alike():
    # 1, 1, -1, -1, ... : by hand, lags up to four, as 4 (120 / 100)^(2/9) is 4.2.
    terms = np.tile([1.0, 1.0, -1.0, -1.0], 30)
    lags = (1.0, -118.0, -1.0, 116.0)
    weighed = sum(2.0 * (1.0 - k / 5.0) * lag for k, lag in enumerate(lags, 1))
    assert variance_of_sum(terms) == pytest.approx(120.0 + weighed)
    # Three terms have a lag of one alone, at half the weight.
    assert variance_of_sum(np.array([2.0, 1.0, 3.0])) == pytest.approx(14.0 + 2.0 + 3.0)


def test_two_laws_that_miss_as_much_are_told_apart_as_seldom_as_chance_does():
    """Vuong's hypothesis: neither law is exact, and they are off by as much elsewhere."""
    for size in (0.3, 1.0):
        assert share_told_apart(size * np.sin(PHASE), size * np.cos(PHASE)) <= 0.05


def test_a_law_that_misses_far_more_is_told_apart():
    assert share_told_apart(0.0 * PHASE, 1.5 * np.sin(PHASE)) >= 0.99


def test_what_one_record_leaves_open_two_alike_may_tell():
    """The lead and its variance both grow with the records."""
    terms = np.cos(PHASE) + 0.3
    one = (np.full(SAMPLES, 2.0), np.sqrt(4.0 + terms))
    enough = TWO_DEVIATIONS * variance_of_sum(terms) / float(terms.sum()) ** 2
    assert enough > 1.0
    assert vuong_distinguishes([one] * int(np.ceil(enough)))
    assert not vuong_distinguishes([one] * int(enough))
