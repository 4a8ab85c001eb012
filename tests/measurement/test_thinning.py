"""Points diagnosed out of very many: every sweep over its whole range, with its repeats."""

import numpy as np
import pytest

from springpot.measurement import Measurement, average_repeats, thinned
from springpot.measurement.replicates import THINNED


def data(f, **given):
    return Measurement(2 * np.pi * np.asarray(f), np.arange(1, len(f) + 1) * (1 + 1j), **given)


def test_few_points_are_all_kept():
    small = data(np.geomspace(0.1, 100.0, THINNED.points))
    assert thinned(small) is small


@pytest.mark.parametrize("shuffled", [False, True])
def test_rows_that_alternate_between_temperatures_keep_both_over_the_whole_range(shuffled):
    f, t = np.repeat(np.geomspace(0.1, 100.0, 1500), 2), np.tile([20.0, 60.0], 1500)
    order = np.random.default_rng(0).permutation(3000) if shuffled else np.arange(3000)
    kept = thinned(data(f[order], conditions={"temperature": t[order]}))
    assert len(kept) == THINNED.points
    assert np.all(np.diff(kept.storage) > 0)  # the order of the rows
    for level in (20.0, 60.0):
        x = np.sort(np.log(kept.frequency[kept.conditions["temperature"] == level]))
        assert len(x) == THINNED.points // 2
        assert np.exp(x[[0, -1]]) == pytest.approx([0.1, 100.0])
        assert np.ptp(np.diff(x)) < 1.01 * np.log(1000.0) / 1499


def test_repeats_stay_together():
    f = np.repeat(np.geomspace(0.1, 100.0, 1500), 2)
    kept = thinned(data(f, repeat=np.tile([1, 2], 1500)))
    assert len(kept) == THINNED.points
    assert average_repeats(kept).scatter.dof.sum() == pytest.approx(THINNED.points // 2, rel=0.01)


def test_a_dense_sweep_does_not_crowd_out_a_short_one():
    f = np.concatenate([np.geomspace(0.1, 100.0, 5000), np.geomspace(0.1, 100.0, 10)])
    kept = thinned(data(f, conditions={"temperature": np.repeat([20.0, 40.0], [5000, 10])}))
    assert len(kept) == THINNED.points
    assert np.sum(kept.conditions["temperature"] == 40.0) == 10


@pytest.mark.parametrize(
    ("sweeps", "points", "repeats"), [(900, 5, 1), (4, 3, 900), (1, 1, 4000), (1, 5, 1000)]
)
def test_never_too_many_and_never_one_end_only(sweeps, points, repeats):
    f, t, k = (
        c.ravel()
        for c in np.meshgrid(
            np.geomspace(1.0, 10.0, points),
            5.0 * np.arange(sweeps),
            np.arange(repeats),
            indexing="ij",
        )
    )
    given = {"repeat": k} if repeats > 1 else {}
    kept = thinned(data(f, conditions={"temperature": t}, **given))
    assert 0.9 * THINNED.points <= len(kept) <= THINNED.points
    for column, whole in ((kept.frequency, f), (kept.conditions["temperature"], t)):
        assert [column.min(), column.max()] == pytest.approx([whole.min(), whole.max()])


def test_a_ramp_of_the_temperature_keeps_all_its_frequencies():
    t, f = (
        c.ravel()
        for c in np.meshgrid(np.linspace(-20.0, 60.0, 800), [1.0, 3.0, 10.0, 30.0], indexing="ij")
    )
    kept = thinned(data(f, conditions={"temperature": t}))
    for each in (1.0, 3.0, 10.0, 30.0):
        at = np.isclose(kept.frequency, each)
        assert np.sum(at) == pytest.approx(THINNED.points / 4, abs=2)
        assert np.ptp(kept.conditions["temperature"][at]) > 79.0
