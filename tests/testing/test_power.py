"""What a baseline is said to see is what drawn samples show."""

from math import inf

import numpy as np
import pytest

from springpot.testing.difference import Successes, chance, drop
from springpot.testing.power import POWER, least_drop_seen, least_rise, smallest_seen

SHARE = 0.002


@pytest.mark.parametrize(("trials", "before"), [(20, 20), (40, 36), (60, 60)])
def test_the_least_fall_of_success_is_seen_as_often_as_is_said(trials, before, rng):
    rate = least_drop_seen(Successes(before, trials), SHARE)
    draws = rng.binomial(trials, rate, 2000)
    found = [drop(Successes(before, trials), Successes(int(k), trials)) < SHARE for k in draws]
    assert np.mean(found) == pytest.approx(POWER, abs=0.04)


@pytest.mark.parametrize("trials", [20, 50])
def test_the_least_rise_of_costs_is_seen_as_often_as_is_said(trials, rng):
    """Averaged over baselines: one sample knows its own spread only roughly."""
    found = []
    for _ in range(150):
        before, after = np.exp(0.3 * rng.standard_normal((2, trials)))
        found.append(chance(1.1 * before, after * least_rise(before, SHARE)) < SHARE)
    assert np.mean(found) == pytest.approx(POWER, abs=0.12)


def test_what_cannot_be_seen_is_said():
    assert least_drop_seen(Successes(5, 5), 1e-6) is None
    assert least_drop_seen(Successes(0, 20), SHARE) is None
    assert least_rise(np.ones(3), SHARE) == inf
    assert least_rise(np.full(20, 25.0), SHARE) == pytest.approx(1.1)
    words = smallest_seen([np.ones(3)], [Successes(3, 3)], Successes(3, 3), SHARE, 1.1)
    assert words == "costs by no factor; success 100 % by no fall on one problem"
    twenty = [Successes(20, 20)] * 2
    words = smallest_seen([np.full(20, 25.0)] * 2, twenty, Successes(40, 40), SHARE, 1.1)
    assert words == "costs x1.1; success 100 -> 58 % on one problem, 100 -> 75 % over its 2"


def test_a_baseline_that_missed_often_sees_a_rise_less(rng):
    whole = np.exp(0.3 * rng.standard_normal(20))
    half = np.where(np.arange(20) < 9, inf, whole)
    assert least_rise(half, SHARE) > least_rise(whole, SHARE)
