"""Statistics against scipy, printed values and cases worked by hand."""

import itertools
import warnings

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy import stats

from springpot.benchmark import statistics as s

INF = np.inf


@settings(deadline=None, max_examples=60)
@given(st.integers(1, 300).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_wilson_is_scipys(pair):
    successes, trials = pair
    interval = s.wilson(successes, trials)
    theirs = stats.binomtest(successes, trials).proportion_ci(method="wilson")
    assert interval.value == successes / trials
    assert [interval.low, interval.high] == pytest.approx([theirs.low, theirs.high], abs=1e-12)


def test_wilson_of_nothing_is_nothing():
    assert s.wilson(0, 0) is None


def drawn(rng, k, m, mean, alike):
    """Hits of k problems drawn at random, m trials each, of which a share is alike by problem."""
    scale = (1 - alike) / alike
    shares = rng.beta(mean * scale, (1 - mean) * scale, k)
    return np.where(rng.random((k, m)) < shares[:, None], 1.0, INF)


@pytest.mark.parametrize(("k", "m"), [(5, 50), (30, 2)])
@pytest.mark.parametrize("mean", [0.5, 0.97])
def test_a_share_over_problems_is_held_as_often_as_it_says(k, m, mean):
    rng, held, counted = np.random.default_rng(5), 0, 0
    for _ in range(200):
        hits = drawn(rng, k, m, mean, alike=0.9)
        ours, trials = s.wilson_over(hits), s.wilson(int(np.isfinite(hits).sum()), hits.size)
        held += ours.low <= mean <= ours.high
        counted += trials.low <= mean <= trials.high
    assert held >= 0.92 * 200
    # As if all trials were independent it would be too sure.
    assert counted < held


@pytest.mark.parametrize("count", [0, 3, 30])
def test_problems_whose_trials_end_alike_are_one_trial_each(count):
    hits = np.where(np.arange(30)[:, None] < count, np.ones(8), INF)
    ours, alone = s.wilson_over(hits), s.wilson(count, 30)
    assert ours.value == alone.value
    # Wider where the variance had to be told from the same thirty.
    assert ours.low <= alone.low + 1e-12
    assert ours.high >= alone.high - 1e-12
    assert ours.high - ours.low < 1.12 * (alone.high - alone.low)


def test_a_share_over_problems_of_which_one_is_missed_once_tells_no_more_than_of_none():
    hits = np.ones((30, 2))
    never = s.wilson_over(hits)
    hits[0, 0] = INF
    once = s.wilson_over(hits)
    assert once.low <= never.low
    assert once.high < never.high


def test_a_share_of_one_problem_counts_its_trials_and_of_none_is_nothing():
    hits = np.array([1.0, INF, 2.0])
    assert s.wilson_over([hits]) == s.wilson(2, 3)
    assert s.wilson_over([hits, np.empty(0)]) == s.wilson(2, 3)
    assert s.wilson_over([]) is None


def test_hitting_time_is_the_first_improvement_at_or_below_the_target():
    evaluations, values = np.array([1, 5, 9]), np.array([10.0, 4.0, 1.0])
    assert [s.hitting_time(evaluations, values, t) for t in (20, 10, 9.9, 4, 1, 0.5)] == [
        1,
        1,
        5,
        5,
        9,
        INF,
    ]
    assert s.hitting_time(np.empty(0, dtype=np.int64), np.empty(0), 1.0) == INF


def test_expected_running_time_charges_failures():
    hits, spent = np.array([100.0, INF, 300.0, INF]), np.full(4, 1000.0)
    assert s.expected_running_time(hits, spent) == (100 + 300 + 2000) / 2
    assert s.expected_running_time(np.full(3, INF), np.full(3, 9.0)) == INF


def test_the_bootstrap_interval_covers_the_truth_as_often_as_it_says():
    rng = np.random.default_rng(3)
    p, budget, covered = 0.6, 100.0, 0
    for _ in range(200):
        hits = np.where(rng.random(60) < p, rng.uniform(0, budget, 60), INF)
        interval = s.running_time_interval(hits, np.full(60, budget), rng, draws=400)
        assert interval.low <= interval.value <= interval.high
        covered += interval.low <= budget / 2 + budget * (1 - p) / p <= interval.high
    assert 0.88 <= covered / 200 <= 0.99


def test_the_bootstrap_knows_when_success_is_too_rare():
    hits = np.array([5.0, INF, INF])
    interval = s.running_time_interval(hits, np.full(3, 10.0), np.random.default_rng(1))
    assert interval.value == 25.0
    assert interval.high == INF
    assert s.running_time_interval(np.empty(0), np.empty(0), np.random.default_rng(1)) is None


def test_median_counts_misses_as_the_largest():
    assert s.median(np.array([INF, 3.0, 1.0])) == 3.0
    assert s.median(np.array([INF, INF, 1.0])) == INF
    assert s.median(np.array([4.0, 1.0])) == 2.5
    assert s.median(np.array([])) is None


def test_medians_of_rows_are_those_of_what_is_known_in_each(rng):
    rows = rng.random((40, 9))
    rows[rng.random(rows.shape) < 0.4] = np.nan
    rows[rng.random(rows.shape) < 0.3] = INF
    rows[0] = np.nan
    assert s.medians(rows) == [s.median(row[~np.isnan(row)]) for row in rows]
    assert s.medians(rows)[0] is None
    assert s.medians(np.empty((2, 0))) == [None, None]


def test_ecdf_never_counts_a_miss():
    times = np.array([[1.0, INF], [2.0, 3.0]])
    assert s.ecdf(times, np.array([0.5, 1, 2.5, 1e300])).tolist() == [0, 0.25, 0.5, 0.75]


def test_performance_profile_by_hand():
    costs = np.array([[1.0, 2.0], [4.0, 1.0], [INF, 5.0], [INF, INF]])
    profile = s.performance_profile(costs, np.array([1.0, 2.0, 4.0]))
    assert profile.tolist() == [[0.25, 0.25, 0.5], [0.5, 0.75, 0.75]]


def test_data_profile_by_hand():
    costs = np.array([[10.0, 30.0], [INF, 8.0]])
    profile = s.data_profile(costs, np.array([4, 3]), np.array([2.0, 6.0]))
    assert profile.tolist() == [[0.5, 0.5], [0.5, 1.0]]


def test_friedman_is_scipys_and_takes_infinite_scores(rng):
    scores = rng.random((12, 4)) + np.arange(4) * 0.2
    theirs = stats.friedmanchisquare(*scores.T)
    assert s.friedman(scores) == pytest.approx((theirs.statistic, theirs.pvalue))
    worst = np.where(scores == scores.max(axis=1, keepdims=True), INF, scores)
    assert s.friedman(worst) == pytest.approx(s.friedman(scores))
    assert s.mean_ranks(worst) == pytest.approx(s.mean_ranks(scores))


def test_friedman_where_nothing_differs_is_certain_of_nothing():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for scores in (
            np.zeros((5, 3)),
            np.full((5, 3), INF),
            np.arange(5.0)[:, None] * np.ones(3),
        ):
            assert s.friedman(scores) == (0.0, 1.0)


def test_holm_on_a_worked_example():
    assert s.holm(np.array([0.01, 0.04, 0.03, 0.005])) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert s.holm(np.array([0.9, 0.8])).tolist() == [1.0, 1.0]


def test_wilcoxon_holm_is_symmetric_and_finds_the_better(rng):
    base = rng.random(25)
    scores = np.column_stack([base, base + 0.3 + 0.1 * rng.random(25), base])
    table = s.wilcoxon_holm(scores)
    assert np.array_equal(table, table.T)
    assert table[0, 1] < 1e-3
    assert table[0, 2] == 1.0
    raw = stats.wilcoxon(scores[:, 0] - scores[:, 1], method="exact").pvalue
    assert table[0, 1] == pytest.approx(3 * raw)


def test_wilcoxon_holm_treats_two_failures_as_a_tie():
    scores = np.array([[INF, INF], [1.0, INF], [2.0, 3.0], [INF, INF], [1.0, 4.0]])
    assert 0 < s.wilcoxon_holm(scores)[0, 1] <= 1
    assert s.wilcoxon_holm(np.full((4, 2), INF))[0, 1] == 1.0


@settings(deadline=None, max_examples=60)
@given(
    st.lists(st.integers(0, 5), min_size=1, max_size=20),
    st.lists(st.integers(0, 5), min_size=1, max_size=20),
)
def test_a12_is_the_mann_whitney_statistic(a, b):
    u = stats.mannwhitneyu(b, a, method="asymptotic").statistic
    assert s.a12(np.array(a, float), np.array(b, float)) == pytest.approx(u / (len(a) * len(b)))


def test_a12_with_failures():
    assert s.a12(np.array([1.0, 2.0]), np.array([INF, INF])) == 1.0
    assert s.a12(np.array([INF]), np.array([INF])) == 0.5


def test_target_lies_a_fraction_above_the_best():
    assert s.target_value(2.0, 12.0, 0.1) == 3.0


def test_pairings_hold_every_pair(rng):
    values = np.where(rng.random((5, 30)) < 0.2, INF, rng.integers(0, 6, (5, 30)).astype(float))
    expected = [[s.a12(one, other) for other in values] for one in values]
    pairings = s.Pairings.of(values)
    assert pairings.wins / 30**2 == pytest.approx(np.array(expected))
    ranks = s.pooled_ranks(values).mean(axis=1)
    assert s.mean_ranks_of(pairings.wins, 30).tolist() == ranks.tolist()


def test_wilcoxon_of_every_pair_is_scipys(rng):
    for blocks in (rng.random((14, 5)), rng.random((80, 5)), rng.integers(0, 5, (80, 5)) / 5):
        pairs = [(i, j) for i in range(5) for j in range(i + 1, 5)]
        gaps = [blocks[:, i] - blocks[:, j] for i, j in pairs]
        method = "asymptotic" if len(blocks) > 50 else "exact"
        raw = [stats.wilcoxon(gap, zero_method="pratt", method=method).pvalue for gap in gaps]
        table = s.wilcoxon_holm(blocks)
        assert [table[pair] for pair in pairs] == pytest.approx(s.holm(np.array(raw)))


def test_mann_whitney_is_scipys_and_takes_failures(rng):
    one, other = rng.random(20), rng.random(20) + 0.3
    expected = stats.mannwhitneyu(one, other, method="asymptotic").pvalue
    assert s.mann_whitney_holm(np.stack([one, other]))[0, 1] == pytest.approx(expected)
    worst = np.where(other > 1.0, INF, other)
    assert s.mann_whitney_holm(np.stack([one, worst]))[0, 1] == pytest.approx(expected, rel=0.05)
    assert (s.mann_whitney_holm(np.full((3, 5), INF)) == 1.0).all()
    assert s.mann_whitney_holm(one[None]).tolist() == [[1.0]]
    trio = s.mann_whitney_holm(np.stack([one, other, other + 9.0]))
    assert np.array_equal(trio, trio.T)
    assert trio[0, 2] == pytest.approx(
        3 * stats.mannwhitneyu(one, other + 9.0, method="asymptotic").pvalue
    )


@pytest.mark.parametrize("blocks", [2, 5, 8, 12])
def test_signed_ranks_of_ties_are_those_of_all_signs(blocks, rng):
    """Against SciPy's enumeration of all signs; zeros keep their ranks and have no sign."""
    for _ in range(4):
        gaps = rng.integers(-2, 4, blocks).astype(float)
        every = list(itertools.product([-1.0, 1.0], repeat=blocks))
        ranks = stats.rankdata(np.abs(gaps)) * (gaps != 0)
        sums = np.abs(np.array(every) @ ranks)
        expected = np.mean(sums >= abs((np.sign(gaps) * ranks).sum()) - 1e-9)
        assert s.sign_flips(gaps[None]) == pytest.approx([expected])


def test_blocks_that_do_not_differ_take_no_certainty():
    """Twelve of one sign are as certain as they can be, however many more end alike."""
    ahead = np.where(np.arange(60) < 12, 1.0 + np.arange(60), 0.0)
    assert s.wilcoxon_holm(np.column_stack([ahead, 0 * ahead]))[0, 1] == 2.0**-11


@pytest.mark.parametrize("blocks", range(2, 9))
def test_no_p_value_is_less_than_so_few_blocks_can_give(blocks):
    """Tied differences as well: the normal approximation would be surer of them than 2 / 2**n."""
    scores = np.column_stack([np.zeros(blocks), np.ones(blocks)])
    assert s.wilcoxon_holm(scores)[0, 1] == s.least_signed_rank(blocks) == 2.0 ** (1 - blocks)
    assert s.mann_whitney_holm(scores.T)[0, 1] >= 2 * s.least_mann_whitney(blocks, blocks)
    three = np.column_stack([scores, np.full(blocks, 2.0)])
    assert s.friedman(three)[1] >= 6.0 ** (1 - blocks)


@pytest.mark.parametrize("trials", [515, 20_000])
def test_a_large_number_of_trials_has_a_least_p_value(trials):
    assert 0.0 <= s.least_mann_whitney(trials, trials) < 1e-300
    assert s.least_signed_rank(trials) < 1e-100


def test_signed_ranks_know_when_there_are_too_few_blocks():
    assert [s.least_signed_rank(blocks) for blocks in (1, 5, 6)] == [1.0, 0.0625, 0.03125]
    rng = np.random.default_rng(1)
    best = np.arange(6) + rng.random((2, 6)) * [[0.0], [0.5]] + [[0.0], [9.0]]
    assert s.wilcoxon_holm(best.T)[0, 1] == pytest.approx(2.0**-5)


def test_cliques_by_hand():
    p = np.ones((4, 4))
    p[0, 2] = p[2, 0] = p[0, 3] = p[3, 0] = p[1, 3] = p[3, 1] = 0.01
    assert s.cliques(np.array([1.0, 2.0, 3.0, 4.0]), p) == [(0, 1), (1, 2), (2, 3)]
    assert s.cliques(np.array([4.0, 3.0, 2.0, 1.0]), p[::-1, ::-1]) == [(0, 1), (1, 2), (2, 3)]
    assert s.cliques(np.array([1.0, 2.0, 3.0, 4.0]), np.ones((4, 4))) == [(0, 3)]
    assert s.cliques(np.array([1.0, 2.0, 3.0, 4.0]), np.eye(4)) == []


def test_bands_are_values_themselves():
    values = np.array([[1.0, INF], [2.0, 5.0], [3.0, INF], [INF, INF]])
    assert s.bands(values).tolist() == [[1.0, 5.0], [2.0, INF], [3.0, INF]]
    odd = np.random.default_rng(2).random((31, 4))
    assert s.bands(odd)[1] == pytest.approx(np.median(odd, axis=0))


@pytest.mark.parametrize("at_once", [1, 1500, 6000])
def test_a_mean_interval_is_the_same_of_some_draws_at_once(rng, monkeypatch, at_once):
    values = rng.exponential(size=(60, 3))
    whole = s.mean_interval(values, np.random.default_rng(1))
    monkeypatch.setattr(s, "AT_ONCE", at_once)
    parts = s.mean_interval(values, np.random.default_rng(1))
    # Not bit by bit: whether a product of fewer rows is the same is the processor's affair.
    assert np.array([(i.low, i.high) for i in parts]) == pytest.approx(
        np.array([(i.low, i.high) for i in whole]), rel=1e-12
    )


def test_mean_interval_agrees_with_scipys_bootstrap(rng):
    values = rng.exponential(size=(60, 2))
    ours = s.mean_interval(values, np.random.default_rng(1), draws=4000)
    theirs = stats.bootstrap(
        (values,),
        np.mean,
        n_resamples=4000,
        axis=0,
        method="percentile",
        rng=np.random.default_rng(2),
    ).confidence_interval
    assert [i.value for i in ours] == pytest.approx(values.mean(axis=0))
    assert [i.low for i in ours] == pytest.approx(theirs.low, rel=0.05)
    assert [i.high for i in ours] == pytest.approx(theirs.high, rel=0.05)


def test_the_running_times_interval_agrees_with_scipys_bootstrap(rng):
    hits = np.where(rng.random(80) < 0.7, rng.uniform(0, 100, 80), INF)
    spent = np.full(80, 100.0)
    ours = s.running_time_interval(hits, spent, np.random.default_rng(1), draws=4000)

    def ratio(cost, success, axis):
        return cost.sum(axis=axis) / success.sum(axis=axis)

    success = np.isfinite(hits).astype(float)
    cost = np.where(success == 1, hits, spent)
    theirs = stats.bootstrap(
        (cost, success),
        ratio,
        paired=True,
        n_resamples=4000,
        method="percentile",
        rng=np.random.default_rng(2),
    ).confidence_interval
    assert (ours.low, ours.high) == pytest.approx((theirs.low, theirs.high), rel=0.05)
