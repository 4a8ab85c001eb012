"""How far the furthest block of noise may be, also where few points tell their own noise."""

import numpy as np
import pytest

from springpot.misfit.regions import Blocks, MeasuredAxis, rare, scales

ALARM = 0.003


def furthest(n, dof, draws=30000):
    """Largest |mean| of any run of n points of noise in its standard deviations, by hand."""
    rng = np.random.default_rng(5)
    sums = np.concatenate(
        [np.zeros((draws, 1)), np.cumsum(rng.standard_normal((draws, n)), axis=1)], axis=1
    )
    runs = [
        np.abs(sums[:, j] - sums[:, i]) / np.sqrt(j - i)
        for i in range(n)
        for j in range(i + 1, n + 1)
    ]
    scale = 1.0 if dof == np.inf else rng.chisquare(dof, draws) / dof
    return np.max(runs, axis=0) / np.sqrt(scale)


@pytest.mark.parametrize(("n", "dof"), [(5, 3.0), (6, 5.0), (12, 15.0), (12, np.inf)])
@pytest.mark.parametrize("seed", range(3))
def test_the_threshold_has_the_chance_it_claims(n, dof, seed):
    blocks = Blocks([MeasuredAxis("frequency", np.arange(n))])
    threshold = blocks.threshold(ALARM, scales(dof), np.random.default_rng(seed))
    assert 0.1 * ALARM < np.mean(furthest(n, dof) > threshold) < 1.4 * ALARM


def test_the_scales_are_those_of_their_degrees_of_freedom():
    assert scales(np.inf) == 1.0
    values = np.asarray(scales(8.0))
    assert np.mean(values) == pytest.approx(1.0, rel=1e-2)
    assert np.var(values) == pytest.approx(2.0 / 8.0, rel=2e-2)


def test_without_doubt_of_the_scale_the_tail_is_gumbels():
    draws = np.random.default_rng(1).gumbel(3.0, 0.5, 100000)
    assert rare(draws, ALARM) == pytest.approx(3.0 - 0.5 * np.log(-np.log1p(-ALARM)), rel=1e-2)
    assert rare(draws, ALARM, np.full(7, 2.0)) == pytest.approx(rare(draws, ALARM) / 2.0)
