"""The test behind the gate.

It finds what got worse, is quiet about noise, and knows when it cannot tell.
"""

from math import inf

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.stats import boschloo_exact, fisher_exact, mannwhitneyu, t

from springpot.benchmark.gate.baseline import (
    LEVEL,
    Successes,
    apart,
    chance,
    drop,
    interval,
    least_drop,
    verdicts,
)
from springpot.benchmark.statistics import least_mann_whitney


def lognormal(rng, n=20, factor=1.0, spread=0.5):
    return factor * np.exp(spread * rng.standard_normal(n))


@pytest.mark.soak
def test_noise_alone_is_hardly_ever_reported(rng):
    """Twelve cells, 50 studies without a change.

    With room for a factor, alarms stay far below the level.
    """
    alarms = sum(
        any(v.worse for v in verdicts([(lognormal(rng), lognormal(rng)) for _ in range(12)]))
        for _ in range(50)
    )
    assert alarms == 0


@pytest.mark.soak
def test_without_the_factor_the_level_is_kept(rng):
    level = 0.05

    def cells():
        return [(lognormal(rng), lognormal(rng)) for _ in range(5)]

    alarms = [any(v.worse for v in verdicts(cells(), level, factor=1.0)) for _ in range(200)]
    assert 0.01 < np.mean(alarms) < 0.1


@pytest.mark.soak
def test_three_times_the_cost_is_found_and_named_alone(rng):
    found = 0
    for _ in range(20):
        pairs = [(lognormal(rng), lognormal(rng)) for _ in range(12)]
        pairs[7] = (lognormal(rng), lognormal(rng, factor=3.0))
        result = verdicts(pairs)
        assert not any(v.worse for i, v in enumerate(result) if i != 7)
        found += result[7].worse
    assert found >= 18


@pytest.mark.parametrize("trials", [1, 2, 3, 4])
def test_it_knows_when_the_sample_is_too_small(trials, rng):
    before, after = lognormal(rng, trials), lognormal(rng, trials, factor=100.0)
    [verdict] = verdicts([(before, after)])
    assert least_mann_whitney(trials, trials) > LEVEL or trials == 4
    assert not verdict.tested
    assert verdict.p == 1.0
    # One wild value each proves nothing; where trials hardly scatter, the intervals are apart.
    assert not verdicts([(before[:1], after[:1])])[0].worse
    steady = 100.0 + 0.01 * np.arange(trials)
    assert verdicts([(steady, 3 * steady)])[0].worse == (trials > 1)


def test_more_cells_ask_for_more_trials(rng):
    pair = (lognormal(rng, 6), lognormal(rng, 6, factor=50.0, spread=0.1))
    assert not verdicts([pair], 0.001)[0].tested
    assert 1 / 924 > 0.001
    pair = (lognormal(rng, 7), lognormal(rng, 7, factor=50.0, spread=0.1))
    assert verdicts([pair], 0.001)[0].tested
    assert not verdicts([pair] * 12, 0.001)[0].tested
    # Counts take their places too, and have theirs.
    full = (Successes(7, 7), Successes(7, 7))
    assert not verdicts([pair], 0.001, counts=[full] * 11)[0].tested


def test_lost_reliability_is_seen_where_costs_show_nothing(rng):
    """Half of the trials of one cell of six give up; in the others' times nothing changed."""
    found = 0
    for _ in range(20):
        times = [
            (lognormal(rng, 20, spread=0.25), lognormal(rng, 20, spread=0.25)) for _ in range(6)
        ]
        counts = [(Successes(20, 20), Successes(20, 20)) for _ in range(6)]
        lost = rng.random(20) < 0.6
        times[2] = (times[2][0], np.where(lost, inf, times[2][1]))
        counts[2] = (counts[2][0], Successes(20 - int(lost.sum()), 20))
        result = verdicts(times, counts=counts)
        assert not any(verdict.worse for i, verdict in enumerate(result) if i not in (2, 8))
        found += result[8].worse
    assert found >= 18


@pytest.mark.parametrize(("low", "high", "trials"), [(16, 20, 20), (3, 9, 10), (33, 40, 40)])
def test_counts_are_judged_by_boschloo(low, high, trials):
    table = [[low, high], [trials - low, trials - high]]
    before, after = Successes(high, trials), Successes(low, trials)
    assert drop(before, after) == boschloo_exact(table, alternative="less").pvalue
    assert drop(before, after) <= fisher_exact(table, alternative="less")[1]
    assert drop(after, before) == drop(before, before) == 1.0
    [verdict] = verdicts([], 0.2, counts=[(after, before)])
    assert verdict.better
    assert not verdict.worse


def test_large_counts_are_judged_without_delay():
    assert drop(Successes(1250, 1250), Successes(1240, 1250)) == pytest.approx(
        fisher_exact([[1240, 1250], [10, 0]], alternative="less")[1]
    )


@pytest.mark.parametrize(("n", "m"), [(1, 1), (3, 5), (20, 20)])
def test_the_least_drop_is_all_before_and_none_after(n, m):
    assert least_drop(n, m) == pytest.approx(drop(Successes(n, n), Successes(0, m)), rel=0.01)
    assert least_drop(0, 5) == 1.0


def test_missed_targets_count(rng):
    before = lognormal(rng)
    missed = np.where(np.arange(20) < 16, inf, before)
    assert verdicts([(before, missed)])[0].worse
    assert verdicts([(missed, before)])[0].better
    assert not verdicts([(np.full(20, inf), np.full(20, inf))])[0].worse
    assert verdicts([(np.full(3, 5.0), np.full(3, inf))])[0].worse


def test_a_small_but_certain_rise_is_no_regression():
    before = np.full(20, 1000.0)
    assert not verdicts([(before, before + 5)])[0].worse
    assert verdicts([(before, 1.2 * before)])[0].worse
    assert verdicts([(1.2 * before, before)])[0].better


@settings(deadline=None, max_examples=50)
@given(
    st.lists(st.integers(1, 9), min_size=2, max_size=12),
    st.lists(st.integers(1, 9), min_size=2, max_size=12),
)
def test_the_chance_is_scipys(before, after):
    a, b = np.array(before, float), np.array(after, float)
    if np.ptp(np.concatenate([a, b])) > 0:
        least = least_mann_whitney(len(a), len(b))
        assert chance(a, b) == max(mannwhitneyu(b, a, alternative="greater").pvalue, least)
    else:
        assert chance(a, b) == 1.0


def test_the_interval_is_students(rng):
    values = lognormal(rng, 5)
    logs = np.log(values)
    expected = t.interval(0.99, 4, logs.mean(), logs.std(ddof=1) / np.sqrt(5))
    assert np.log(interval(values, 0.01)) == pytest.approx(expected)
    assert interval(np.array([3.0]), 0.01) == (0.0, inf)
    assert interval(np.array([inf, inf]), 0.01) == (inf, inf)
    assert interval(np.array([2.0, 2.0, inf]), 0.01) == (2.0, inf)
    assert not apart(np.array([1.0]), np.array([inf]), 0.01)
