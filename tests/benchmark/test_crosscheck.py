"""Statistics against a second public package; they are in the extra ``crosscheck``."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from springpot.benchmark import statistics as s

WHY = "pip install 'springpot[crosscheck]'"


@pytest.fixture
def posthocs():
    pytest.importorskip("pandas", reason=WHY)
    return pytest.importorskip("scikit_posthocs", reason=WHY)


@pytest.fixture
def scores(rng):
    return rng.random((24, 5)) + 0.12 * np.arange(5)


@pytest.mark.soak
def test_wilcoxon_holm_is_that_of_scikit_posthocs(posthocs, scores):
    theirs = posthocs.posthoc_wilcoxon(
        list(scores.T), p_adjust="holm", zero_method="zsplit"
    ).to_numpy()
    assert s.wilcoxon_holm(scores) == pytest.approx(theirs, abs=1e-12)


@pytest.mark.soak
def test_mann_whitney_holm_is_that_of_scikit_posthocs(posthocs, scores):
    groups = scores.T[:2]
    theirs = posthocs.posthoc_mannwhitney(list(groups), p_adjust="holm").to_numpy()[0, 1]
    exact = stats.mannwhitneyu(*groups).pvalue
    assert theirs == pytest.approx(exact)
    assert s.mann_whitney_holm(groups[0], groups[1:])[0] == pytest.approx(theirs, rel=0.1)


def test_wilson_and_holm_are_those_of_statsmodels(rng):
    proportion = pytest.importorskip("statsmodels.stats.proportion", reason=WHY)
    multitest = pytest.importorskip("statsmodels.stats.multitest", reason=WHY)
    for successes, trials in ((0, 7), (3, 11), (50, 50), (17, 400)):
        ours = s.wilson(successes, trials)
        theirs = proportion.proportion_confint(successes, trials, method="wilson")
        assert (ours.low, ours.high) == pytest.approx(theirs, abs=1e-12)
    p = rng.random(30) ** 3
    assert s.holm(p) == pytest.approx(multitest.multipletests(p, method="holm")[1])


def test_mean_ranks_and_effects_are_those_of_autorank(scores):
    autorank = pytest.importorskip("autorank", reason=WHY)
    pandas = pytest.importorskip("pandas", reason=WHY)
    frame = pandas.DataFrame(scores, columns=list("abcde"))
    result = autorank.autorank(
        frame, alpha=0.05, verbose=False, order="ascending", force_mode="nonparametric"
    )
    theirs = result.rankdf.meanrank
    assert s.mean_ranks(scores) == pytest.approx([theirs[name] for name in "abcde"])
    assert result.pvalue == pytest.approx(s.friedman(scores)[1])
