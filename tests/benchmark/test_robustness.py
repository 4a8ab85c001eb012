"""Beside ranks: the area over the curve, what is probably equal, what hangs on one problem."""

from __future__ import annotations

import numpy as np
import pytest
from benchmark_fakes import small_study
from synthetic import synthetic_store

from springpot.benchmark import Findings, Store, run_study, statistics, store_path
from springpot.benchmark.comparison import JudgingScale, area_over_curve, races_of
from springpot.benchmark.plan import stream_of
from springpot.benchmark.robustness import WithoutSome, _moved, without_each
from springpot.benchmark.standings import RANKING, study_tables
from springpot.benchmark.statistics import ROPE, signed_rank_posterior
from springpot.benchmark.study_report import write_study_report
from springpot.benchmark.trial import Traces

SCALE = JudgingScale(1e-4, 100)


def area(*steps, scale=SCALE):
    evaluations, excess = zip(*steps, strict=True)
    traces = Traces(np.array([len(steps)]), np.array(evaluations), np.array(excess))
    return float(area_over_curve(traces, traces.values, scale)[0])


def test_the_area_is_that_over_the_curve_in_decades():
    assert area((1, 1e-4)) == 1.0
    assert area((1, 1e-9)) == 1.0
    assert area((1, 1.0)) == area((1, 50.0)) == 0.0
    # From evaluation 51 on it stands one decade of four below the reference.
    assert area((1, 3.0), (51, 0.1)) == pytest.approx(0.5 * 0.25)
    assert area((11, 0.01), (91, 1e-4)) == pytest.approx(0.8 * 0.5 + 0.1)
    assert area((100, 1e-4)) == pytest.approx(0.01)
    assert area((1, 0.1), scale=JudgingScale(2.0, 100)) == 1.0


def test_the_posterior_tells_better_equal_and_unknown_apart():
    n = 30
    rng = np.random.default_rng(3)
    gaps = np.stack(
        [
            np.full(n, 0.4),
            np.full(n, -0.4),
            np.zeros(n),
            rng.uniform(-0.9 * ROPE, 0.9 * ROPE, n),
            np.linspace(-0.5, 0.5, n),
        ]
    )
    below, equal, above = signed_rank_posterior(gaps).T
    assert above[0] > 0.999
    assert below[1] > 0.999
    assert equal[2] == 1.0
    assert equal[3] == 1.0
    # As often one as the other: neither is better, and they are not equal either.
    assert 0.3 < below[4] < 0.7
    assert equal[4] < 0.1
    np.testing.assert_allclose(below + equal + above, 1.0)


def test_the_posterior_is_that_of_the_published_example():
    """One problem against the prior: P(better) = P(w > 1/2 in the square), w of Beta(1, 1/2)."""
    [[below, _, above]] = signed_rank_posterior(np.array([[1.0]]), 0.3)
    # Means of two: 1 with w^2, 1/2 with 2 w (1 - w), 0 with (1 - w)^2: all but the last are above.
    w = np.random.default_rng(1).beta(1.0, 0.5, 200_000)
    expected = np.mean(w**2 + 2 * w * (1 - w) > (1 - w) ** 2)
    assert below == 0.0
    assert above == pytest.approx(expected, abs=0.02)


@pytest.mark.parametrize("n", [1, 2, 7, 12])
def test_the_posterior_is_that_of_all_means_of_two(n):
    # Hundredths: some are equal, and some means of two lie on an end of the region.
    gaps = np.round(np.random.default_rng(n).normal(0.02, 0.1, (20, n)), 2)
    rng = np.random.default_rng(stream_of(0, "signed rank", n))
    weights = rng.dirichlet([0.5, *[1.0] * n], 4000)
    for row, found in zip(gaps, signed_rank_posterior(gaps), strict=True):
        every = np.array([0.0, *row])
        means = 0.5 * (every[:, None] + every)
        below, above = (
            np.einsum("di,ij,dj->d", weights, beyond, weights)
            for beyond in ((means < -ROPE) * 1.0, (means > ROPE) * 1.0)
        )
        most = np.stack([below, 1.0 - below - above, above]).argmax(axis=0)
        np.testing.assert_array_equal(found, np.bincount(most, minlength=3) / 4000)


def test_no_means_of_two_are_asked_where_one_region_has_nearly_all(monkeypatch):
    """Of 190 pairs of a thousand problems they take most of the time of a study's tables."""
    asked, chance = [], statistics._chance_above
    monkeypatch.setattr(statistics, "_chance_above", lambda *a: asked.append(1) or chance(*a))
    clear = np.where(np.arange(100) < 3, 0.0, 0.4)
    found = signed_rank_posterior(np.stack([clear, -clear, 0.01 * clear]))
    assert found.tolist() == [[0, 0, 1], [1, 0, 0], [0, 1, 0]]
    assert not asked
    signed_rank_posterior(np.linspace(-0.5, 0.5, 100)[None])
    assert asked


def test_few_problems_make_no_certainty():
    found = signed_rank_posterior(np.full((1, 1), 0.4))[0]
    assert 0.5 < found[2] < 0.9
    assert signed_rank_posterior(np.full((1, 12), 0.4))[0, 2] > 0.99


@pytest.fixture(scope="module")
def findings(tmp_path_factory):
    path = synthetic_store(tmp_path_factory.mktemp("made") / "made.sqlite", 7, 4, 5)
    with Store(path) as store:
        return Findings.of(store)


def test_a_table_of_places_without_each_problem(findings):
    whole, *others = without_each(findings.races, findings.scale)
    # All problems have one model: without it nothing would be left.
    assert [each.without for each in others] == [
        f"fractional-kelvin on mock-{i}, paper" for i in range(7)
    ]
    total = sum(each.ranks for each in others)
    np.testing.assert_allclose(total / 7, whole.ranks)
    without = races_of([s for s in findings.scores if s.cell.problem.dataset != "mock-3"])
    np.testing.assert_allclose(next(without_each(without, findings.scale)).ranks, others[3].ranks)


def test_equals_share_a_place():
    places = WithoutSome("", np.array([2.0, 1.0, 2.0 + 1e-15, 4.0])).places
    assert places.tolist() == [2, 1, 2, 4]


def test_tables_hold_the_measures(findings):
    from springpot.benchmark.standings import COMPARING

    anytime = COMPARING["anytime"](findings)
    # The faster its objective falls, the larger the area: as the entrants were made.
    assert [row[0] for row in anytime.rows] == ["mock-3", "mock-2", "mock-1", "mock-0"]
    assert all(row[1].low < row[1].value < row[1].high for row in anytime.rows)
    pairs = COMPARING["pairs"](findings)
    probable = np.array([row[-3:] for row in pairs.rows], dtype=float)
    np.testing.assert_allclose(probable.sum(axis=1), 1.0)
    sensitivity = COMPARING["sensitivity"](findings)
    assert all(row[3] <= row[2] <= row[4] for row in sensitivity.rows)


def test_where_no_place_moves_no_problem_is_named():
    assert _moved(np.array([2, 2]), 2, ["a", "b"]) == (2, 2, None)
    assert _moved(np.array([2, 4]), 2, ["a", "b"]) == (2, 4, "b")


def test_no_ranking_holds_native_without_saying_what_it_knows(tmp_path):
    for optimisers, told in ((["native", "random-search"], True), (["random-search"], False)):
        folder = tmp_path / optimisers[0]
        study = small_study(optimisers=[*optimisers, "nlopt-bobyqa"], repetitions=2, budget=40)
        run_study(study, 1, "serial", out=folder, quiet=True, tables=False)
        with Store(store_path(study, folder)) as store:
            notes = {name: table.note for name, table in study_tables(store, sorted(RANKING))}
        words = "native knows how the model is built"
        assert {words in note for note in notes.values()} == {told}
        page = write_study_report(store_path(study, folder)).read_text(encoding="utf-8")
        assert (words in page.partition("Which optimiser should I use?")[0]) == told
