"""The test behind the gate: it finds what got worse, is quiet about noise, and knows when it cannot tell."""

from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import mannwhitneyu, t

from springpot.benchmark.gate.difference import apart, chance, interval, smallest_chance, verdicts


def lognormal(rng, n=20, factor=1.0, spread=0.5):
    return factor * np.exp(spread * rng.standard_normal(n))


def test_noise_alone_is_hardly_ever_reported(rng):
    """Twelve cells, 50 studies without a change: with room for a factor, alarms stay far below the level."""
    alarms = sum(any(v.worse for v in verdicts([(lognormal(rng), lognormal(rng)) for _ in range(12)]))
                 for _ in range(50))  # fmt: skip
    assert alarms == 0


def test_without_the_factor_the_level_is_kept(rng):
    level = 0.05
    alarms = [any(v.worse for v in verdicts([(lognormal(rng), lognormal(rng)) for _ in range(5)], level, factor=1.0))
              for _ in range(200)]  # fmt: skip
    assert 0.01 < np.mean(alarms) < 0.1


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
    assert smallest_chance(trials, trials) > 0.001
    assert not verdict.tested
    assert verdict.p == 1.0
    # One wild value each proves nothing; where trials hardly scatter, the intervals are apart.
    assert not verdicts([(before[:1], after[:1])])[0].worse
    steady = 100.0 + 0.01 * np.arange(trials)
    assert verdicts([(steady, 3 * steady)])[0].worse == (trials > 1)


def test_more_cells_ask_for_more_trials(rng):
    pair = (lognormal(rng, 6), lognormal(rng, 6, factor=50.0, spread=0.1))
    assert verdicts([pair])[0].tested == (1 / 924 < 0.001)
    pair = (lognormal(rng, 7), lognormal(rng, 7, factor=50.0, spread=0.1))
    assert verdicts([pair])[0].tested
    assert not verdicts([pair] * 12)[0].tested


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
@given(st.lists(st.integers(1, 9), min_size=2, max_size=12), st.lists(st.integers(1, 9), min_size=2, max_size=12))
def test_the_chance_is_scipys(before, after):
    a, b = np.array(before, float), np.array(after, float)
    if np.ptp(np.concatenate([a, b])) > 0:
        assert chance(a, b) == mannwhitneyu(b, a, alternative="greater").pvalue
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
