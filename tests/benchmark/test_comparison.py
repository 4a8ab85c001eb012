"""Choices, ranks and profiles of races whose outcome is known; failures last, never numbers."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from benchmark_fakes import moody_study, small_study
from synthetic import synthetic_store

from springpot.benchmark import Findings, Store, comparison, run_study
from springpot.benchmark.comparison import (
    OVER_ALL,
    CellScores,
    JudgingScale,
    ProblemRace,
    choose,
    judged,
    profiles,
    quality,
    races_of,
    rank,
    rankings,
    scopes,
    score_cell,
)
from springpot.benchmark.plan import ProblemRow
from springpot.benchmark.standings import TABLES, rank_table, tables_of
from springpot.benchmark.statistics import expected_running_time
from springpot.benchmark.summary import CellRow
from springpot.benchmark.trial import at

INF = np.inf
SCALE = JudgingScale(1e-6, 2000)


def race(
    problem: int, values: dict[str, np.ndarray], hits: dict[str, np.ndarray] | None = None
) -> ProblemRace:
    """A race in which each entrant ends at `values` (n,) at every mark."""
    row = ProblemRow(
        problem,
        f"data-{problem}",
        "artificial",
        10,
        "N/m",
        f"model-{problem % 2}",
        "paper",
        1.0,
        0.0,
        {},
    )
    marks, grid = len(SCALE.marks), len(SCALE.grid)
    cells = []
    for i, (label, given) in enumerate(values.items()):
        n = len(given)
        reached = np.where(given <= SCALE.target, 50.0, INF) if hits is None else hits[label]
        cells.append(
            CellScores(
                CellRow(i, row, label, label, "{}", SCALE.budget),
                np.arange(n),
                reached,
                np.full(n, 2000.0),
                np.tile(given[:, None], marks),
                np.zeros(grid),
                np.zeros((3, grid)),
                None,
                3,
            )
        )
    return races_of(cells)[0]


def test_marks_end_with_the_budget():
    assert JudgingScale(1e-6, 2000).marks == (100, 500, 2000)
    assert JudgingScale(1e-6, 40_000).marks == (500, 2000, 8000, 40_000)
    assert JudgingScale(1e-6, 60).marks == (60,)
    assert set(JudgingScale(1e-6, 3000).marks) <= set(JudgingScale(1e-6, 3000).grid.tolist())
    assert JudgingScale(1e-4, 60).targets[-1] == 1e-4
    assert (np.diff(JudgingScale(1e-4, 60).targets) < 0).all()


def test_the_better_is_chosen_and_the_next_is_named(rng):
    noise = rng.random((3, 30))
    found = choose(race(0, {"a": 1 + noise[0], "b": 5 + noise[1], "c": 3 + noise[2]}), 2, SCALE)
    assert (found.label, found.alike, found.runner_up, found.chance) == ("a", (), "c", 1.0)
    assert found.success.value == 0.0
    assert found.running_time == INF
    assert found.excess == pytest.approx(np.median(1 + noise[0]), abs=0.1)
    assert found.decided


def test_of_those_that_reach_the_target_the_cheapest_is_chosen():
    zero = np.zeros(20)
    hits = {"slow": np.full(20, 900.0), "fast": np.full(20, 90.0), "late": np.full(20, 1900.0)}
    there = race(0, dict.fromkeys(hits, zero), hits)
    found = choose(there, 2, SCALE)
    assert (found.label, found.alike, found.running_time) == ("fast", ("slow", "late"), 90.0)
    assert choose(there, 0, SCALE).success.value == 1.0


def test_few_trials_decide_nothing(rng):
    found = choose(
        race(0, {"a": rng.random(3), "b": 9 + rng.random(3), "c": 9 + rng.random(3)}), 2, SCALE
    )
    assert not found.decided


def test_failures_come_last_and_are_counted():
    half = np.where(np.arange(40) % 2, 1e-9, INF)
    there = race(0, {"half": half, "all": np.full(40, 1e-9), "none": np.full(40, INF)})
    found = choose(there, 2, SCALE)
    assert (found.label, found.runner_up) == ("all", "half")
    assert found.chance == 0.75
    assert np.isinf(quality(there, 2, SCALE.target)[2]).all()
    nobody = choose(race(0, {"x": np.full(5, INF), "y": np.full(5, INF)}), 2, SCALE)
    assert nobody.label is None
    assert nobody.success.value == 0.0


def test_ranks_over_many_problems(rng):
    races = [
        race(i, {"a": rng.random(5), "b": 2 + rng.random(5), "c": 2 + rng.random(5)})
        for i in range(12)
    ]
    found = rank(OVER_ALL, races, 2, SCALE)
    assert (found.blocks, found.unit, found.decided) == (12, "problems", True)
    assert found.ranks[0].value == found.ranks[0].low == found.ranks[0].high == 1.0
    assert found.alike(0) == ()
    assert found.alike(1) == ("c",)
    assert found.p_all < 1e-3
    assert found.chances[0, 1] == 1.0
    assert found.chances[1, 2] + found.chances[2, 1] == 1.0
    assert found.means.sum() == pytest.approx(6.0)


@pytest.mark.parametrize("problems", [2, 3, 4, 5])
def test_few_problems_tell_nothing_however_many_trials_there_are(problems, rng):
    """Problems are the blocks: fifty trials of each say nothing of the next problem."""
    races = [race(i, {"a": rng.random(50), "b": 2 + rng.random(50)}) for i in range(problems)]
    found = rank(OVER_ALL, races, 2, SCALE)
    assert (found.blocks, found.unit, found.decided) == (problems, "problems", False)
    assert found.p[0, 1] == found.least == 2.0 ** (1 - problems)
    assert found.alike(0) == ("b",)
    assert found.doubt == f"{problems} problems cannot tell"
    [row, _] = rank_table("few", [found]).rows
    assert f"{problems} problems cannot tell" in row
    # What they have in common is their range: a bootstrap of five would be too sure.
    assert (found.ranks[0].low, found.ranks[0].high) == (1.0, 1.0)


def test_of_one_problem_the_trials_are_ranked_as_its_choice_is_made(rng):
    there = race(0, {"a": rng.random(20), "b": 2 + rng.random(20), "c": rng.random(20)})
    found, choice = rank(OVER_ALL, [there], 2, SCALE), choose(there, 2, SCALE)
    assert (found.blocks, found.unit, found.decided) == (20, "repetitions", True)
    assert {choice.label, *choice.alike} == {"a", *found.alike(0)} == {"a", "c"}
    few = rank(OVER_ALL, [race(0, {"a": np.zeros(2), "b": np.ones(2)})], 2, SCALE)
    assert (few.decided, few.doubt) == (False, "2 repetitions cannot tell")


def test_too_few_trials_call_nobody_worse():
    """Ties make the normal approximation surer than three trials can be."""
    found = choose(race(0, {"a": np.zeros(3), "b": np.ones(3)}), 2, SCALE)
    assert (found.decided, found.alike, found.runner_up) == (False, ("b",), None)


@pytest.mark.parametrize("trials", [515, 2000])
def test_many_repetitions_have_tables(trials, rng):
    there = race(0, {"a": rng.random(trials), "b": 2 + rng.random(trials)})
    found = choose(there, 2, SCALE)
    assert (found.label, found.decided) == ("a", True)
    assert rank(OVER_ALL, [there], 2, SCALE).told(0, 1)


def test_scopes_are_models_and_data_sets_with_several_problems():
    races = [race(i, {"a": np.zeros(3), "b": np.ones(3)}) for i in range(4)]
    assert [name for name, _ in scopes(races)] == [OVER_ALL, "model model-0", "model model-1"]
    assert {r.budget for r in rankings(races, SCALE)} == set(SCALE.marks)
    assert rankings([], SCALE) == []


def test_profiles_count_each_repetition_and_no_miss():
    hits = {"a": np.array([10.0, INF]), "b": np.array([40.0, 40.0])}
    there = race(0, {"a": np.zeros(2), "b": np.zeros(2)}, hits)
    found = profiles([there], np.array([2.5, 10.0]), np.array([1.0, 4.0]))
    assert found.data.tolist() == [[0.5, 0.5], [0.0, 1.0]]
    assert found.performance.tolist() == [[0.5, 0.5], [0.5, 1.0]]


@pytest.mark.soak
def test_scores_are_what_the_traces_say(tmp_path):
    outcome = run_study(small_study(target=1e-3), engine="serial", out=tmp_path, quiet=True)
    with Store(outcome.store) as store:
        findings = Findings.of(store)
        trials, bests = dict(store.trials()), store.bests()
    assert [s.cell for s in findings.scores] == [s.cell for s in findings.summaries]
    for scores, summary in zip(findings.scores, findings.summaries, strict=True):
        problem, rows = scores.cell.problem, trials[scores.cell.id]
        best = bests[problem.id]
        goal = best + 1e-3 * (problem.reference - best)
        first = [
            next((e for e, v in zip(*row.improvements(), strict=True) if v <= goal), INF)
            for row in rows
        ]
        assert scores.hits.tolist() == first
        assert summary.success.value == np.mean(np.isfinite(first))
        assert summary.running_time.value == expected_running_time(np.array(first), scores.spent)
        values = [at(*row.improvements(), np.array([100]))[0] for row in rows]
        assert scores.values[:, 0] == pytest.approx(
            (np.array(values) - best) / (problem.reference - best)
        )
        assert (np.diff(scores.attained) >= 0).all()
        noisy = problem.dataset == "noisy"
        assert (scores.clean is not None) == noisy
        assert scores.dimension == len(rows[0].theta)


def test_a_cell_of_failures_has_no_numbers(tmp_path):
    outcome = run_study(moody_study("throw"), engine="serial", out=tmp_path, quiet=True)
    with Store(outcome.store) as store:
        findings = Findings.of(store)
    bad = findings.scores[0]
    assert bad.cell.label.startswith("moody")
    assert np.isinf(bad.values).all()
    assert np.isinf(bad.curve).all()
    assert not bad.attained.any()
    assert all(choice.label == "walk" for choice in findings.choices)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """A store of two problems, three optimisers and a hundred repetitions."""
    return synthetic_store(tmp_path_factory.mktemp("drawn") / "drawn.sqlite", 2, 3, 100, 8)


@pytest.mark.parametrize("at_once", [1, 700, 1600])
def test_trials_scored_some_at_once_have_the_same_bits(drawn, monkeypatch, at_once):
    with Store(drawn) as store:
        whole = Findings.of(store).scores
        monkeypatch.setattr(comparison, "AT_ONCE", at_once)
        parts = Findings.of(store).scores
    for one, other in zip(whole, parts, strict=True):
        for name in ("hits", "values", "attained", "curve", "area"):
            assert np.array_equal(getattr(one, name), getattr(other, name)), name


def test_what_is_known_of_trials_is_in_a_file(drawn):
    """In memory it grew by a number or two for each trial, and by the curves of each cell."""
    with Store(drawn) as store:
        scale = JudgingScale.of(store)
        made = [score_cell(*each, scale) for each in judged(store)]
        kept = Findings.of(store).scores
    for one, other in zip(made, kept, strict=True):
        arrays = {k: value for k, value in vars(one).items() if isinstance(value, np.ndarray)}
        assert len(arrays) > 8
        assert not [value for value in vars(other).values() if isinstance(value, np.ndarray)]
        for name, array in arrays.items():
            np.testing.assert_array_equal(getattr(other, name), array)
        assert (other.cell, other.dimension, other.clean) == (one.cell, one.dimension, one.clean)


def test_trials_are_kept_once(drawn):
    with Store(drawn) as store:
        findings = Findings.of(store)
    dict(tables_of(findings, TABLES))
    kept = [vars(each) for each in (*findings.races, *findings.rankings)]
    rows = [value for fields in kept for value in fields.values() if isinstance(value, np.ndarray)]
    assert not [each.shape for each in rows if 100 in each.shape]
    # Hits, spent, area, repetition and an excess at each mark, of eight bytes; no truth.
    each = findings.scores[0]
    numbers = (each.hits, each.spent, each.area, each.repetitions, each.values)
    assert sum(array.nbytes for array in numbers) == 100 * 8 * (4 + len(findings.scale.marks))
    assert not each.oracles.size


def test_trials_of_a_problem_are_ranked_once_at_each_budget(drawn, monkeypatch):
    """Though its choice, every ranking of it, its sensitivity and its pairs ask for it."""
    with Store(drawn) as store:
        findings = Findings.of(store)
    made, count = [], comparison.Pairings.of
    monkeypatch.setattr(comparison.Pairings, "of", lambda v: made.append(1) or count(v))
    for _ in tables_of(findings, TABLES):
        pass
    assert len(findings.races) > 1
    assert len(made) == len(findings.races) * len(findings.scale.marks)


def test_a_problem_that_somebody_has_not_tried_is_left_out():
    full = race(0, {"a": np.zeros(3), "b": np.ones(3)})
    half = race(1, {"a": np.zeros(3), "b": np.ones(3)})
    assert len(races_of([*full.cells, *half.cells])) == 2
    assert [r.problem.id for r in races_of([*full.cells, half.cells[0]])] == [0]


@pytest.mark.soak
def test_only_common_repetitions_race(tmp_path):
    outcome = run_study(small_study(), engine="serial", out=tmp_path, quiet=True)
    with Store(outcome.store) as store:
        scale, cells, trials = JudgingScale.of(store), store.cells(), dict(store.trials())
        best = store.bests()[cells[0].problem.id]
    one = score_cell(cells[0], trials[cells[0].id][1:], best, scale)
    two = score_cell(cells[1], trials[cells[1].id][:3], best, scale)
    [there] = races_of([one, two])
    assert there.hits.shape == (2, 2)
    assert there.values[1].tolist() == two.values[1:].tolist()


@pytest.mark.parametrize("value", [0.0, 0.5, INF])
@pytest.mark.parametrize("entrants", [2, 3, 5])
def test_where_all_are_equal_nobody_wins_and_nobody_is_warned(value, entrants):
    equal = {f"entrant-{i}": np.full(12, value) for i in range(entrants)}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = rank(OVER_ALL, [race(i, equal) for i in range(8)], 2, SCALE)
        choice = choose(race(0, equal), 2, SCALE)
    assert found.means == pytest.approx(np.full(entrants, (entrants + 1) / 2))
    assert (found.p == 1.0).all()
    assert choice.runner_up is None
    assert len(choice.alike) == entrants - 1
