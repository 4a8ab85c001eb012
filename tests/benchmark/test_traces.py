"""What is kept of a run: every improvement and, on noisy data, its worth without the noise."""

import zlib
from dataclasses import replace

import numpy as np
import pytest
from benchmark_fakes import TRUTH, Walk, artificial, measurement, small_study

from springpot import parse_model, plugins
from springpot.benchmark import Store, run_study
from springpot.benchmark.schema import seal
from springpot.benchmark.trial import (
    Traces,
    TwinProblem,
    at,
    geometric_grid,
    improvements,
    pack,
    unpack,
)
from springpot.identification import Problem, Recorder, all_points, run, run_batch

NOISY = artificial(0.05, "noisy")


def rows_of(study, folder, label):
    outcome = run_study(study, engine="serial", out=folder, quiet=True)
    with Store(outcome.store) as store:
        labels = {cell.id: cell.label for cell in store.cells()}
        return [row for number, rows in store.trials() for row in rows if labels[number] == label]


@pytest.mark.parametrize("name", ["walk", "pso-paper", "native", "cma-es", "nlopt-lbfgs"])
def test_the_diary_holds_every_point_in_order(name, rng):
    problem = Problem.of(
        parse_model("fractional-kelvin"), measurement(0.02), plugins().find("objective", "paper")
    )
    optimiser = Walk() if name == "walk" else plugins().find("optimiser", name)
    optimiser = optimiser() if isinstance(optimiser, type) else optimiser
    done = run(optimiser, problem, 333, rng, diary=True)
    points, factors = all_points(done.diary, problem.dimension)
    assert points.shape == (done.evaluations, problem.dimension)
    values = problem.evaluate(points) * factors
    evaluations, kept = np.array(done.trace).T
    # Stacked and single evaluations differ in the last bits.
    lowest = np.minimum.accumulate(values)
    assert values[evaluations.astype(int) - 1] == pytest.approx(kept, rel=1e-9)
    assert lowest == pytest.approx(at(evaluations, kept, np.arange(1, len(values) + 1)), rel=1e-9)
    assert run(optimiser, problem, 50, rng).diary is None


def test_a_batch_of_runs_keeps_a_diary_for_each():
    problem = Problem.of(
        parse_model("fractional-kelvin"), measurement(0.02), plugins().find("objective", "paper")
    )
    swarm = plugins().find("optimiser", "pso-paper")()
    together = run_batch(
        swarm, problem, 250, [np.random.default_rng(i) for i in range(3)], diary=True
    )
    for i, done in enumerate(together):
        alone = run(swarm, problem, 250, np.random.default_rng(i), diary=True)
        for mine, other in zip(all_points(done.diary, 3), all_points(alone.diary, 3), strict=True):
            assert np.array_equal(mine, other)


def test_points_of_each_kind_are_counted_apart():
    problem = Problem.of(
        parse_model("fractional-kelvin"), measurement(), plugins().find("objective", "paper")
    )
    recorder = Recorder(problem, 20)
    x = 0.5 * (problem.lower + problem.upper)
    recorder(x)
    recorder.gradient(x)
    recorder.batch(np.tile(x, (5, 1)))
    recorder.residual_batch(np.tile(x, (30, 1)))
    assert (recorder.evaluations, recorder.gradients, recorder.batched) == (20, 14, 18)


def test_noisy_data_have_a_recommendation_and_an_oracle_trace(tmp_path):
    study = small_study(datasets=[NOISY], models=["own"], optimisers=[Walk()], budget=400)
    plan = study.plan()
    noisy = TwinProblem(plan.cases[0]).problem
    clean = replace(noisy, measurement=measurement())
    for row in rows_of(study, tmp_path, "walk"):
        again = run(
            Walk(),
            noisy,
            400,
            np.random.default_rng(plan.stream(plan.cells[0], row.repetition)),
            diary=True,
        )
        points, _ = all_points(again.diary, noisy.dimension)
        values = clean.evaluate(points)
        seen = list(zip(*(column.tolist() for column in row.oracle_trace()), strict=True))
        assert np.array(seen) == pytest.approx(np.array(improvements(values)))
        evaluations, recommended = row.recommendations()
        assert evaluations.tolist() == row.improvements()[0].tolist()
        assert recommended == pytest.approx(values[evaluations - 1])
        assert recommended[-1] == pytest.approx(row.oracle)
        assert seen[-1][1] <= row.oracle
        assert row.parameter_error == pytest.approx(
            max(abs(row.theta[k] / TRUTH[k] - 1) for k in TRUTH)
        )


@pytest.mark.soak
def test_luck_with_the_noise_is_not_scored(tmp_path):
    """On noisy data the best value seen is not what the recommended point is worth."""
    study = small_study(
        datasets=[NOISY], models=["own"], optimisers=[Walk()], repetitions=8, budget=2000
    )
    rows = rows_of(study, tmp_path, "walk")
    assert any(np.any(np.diff(row.recommendations()[1]) > 0) for row in rows)
    assert any(row.oracle_trace()[1][-1] < row.oracle for row in rows)


def test_exact_data_are_their_own_oracle_and_measured_ones_have_none(tmp_path):
    exact = small_study(datasets=[artificial()], models=["own"], optimisers=[Walk()])
    for row in rows_of(exact, tmp_path / "exact", "walk"):
        assert row.recommended == row.seen == b""
        assert (
            row.oracle_trace()[1].tolist()
            == row.recommendations()[1].tolist()
            == row.improvements()[1].tolist()
        )
    measured = small_study(datasets=[measurement(0.01)], models=["springpot"], optimisers=[Walk()])
    for row in rows_of(measured, tmp_path / "measured", "walk"):
        assert row.oracle_trace() is row.recommendations() is None


def test_a_grid_is_geometric_and_ends_at_the_last_evaluation():
    grid = geometric_grid(8000)
    assert grid[0] == 1
    assert grid[-1] == 8000
    assert {10, 100, 1000} <= set(grid.tolist())
    assert np.all(np.diff(grid) > 0)
    assert len(grid) < 90
    assert geometric_grid(1).tolist() == [1]
    evaluations, values = np.array([2, 7]), np.array([5.0, 1.0])
    assert at(evaluations, values, np.array([1, 2, 6, 7, 100])).tolist() == [np.inf, 5, 5, 1, 1]


def test_a_seal_is_the_same_in_every_python():
    """A store is read by a later Python than that which wrote it."""
    values = (1, 1.0, "1", "\u00b5 \ud800", None, b"1", -(2**40), 1e-300)
    assert seal(values).hex() == "d4ac87129c6f742c"
    assert len({seal((value,)) for value in (1, 1.0, "1", b"1", None)}) == 5
    # Equal texts are one object in one row, and two in another.
    text = "".join(["a", "b"])
    assert seal((text, text)) == seal(("ab", "".join(["a", "b"])))


@pytest.mark.parametrize("count", [1, 150, 8191, 8192, 20_000])
def test_traces_are_streams_of_zlib_as_those_of_older_stores(rng, count):
    # More than 65,535 bytes of values take several blocks, and 8,191 values all but fill one.
    steps, values = rng.integers(1, 9, count), np.sort(rng.random(count))[::-1]
    numbers = np.cumsum(steps)
    older = zlib.compress(steps.astype("<u4").tobytes() + values.astype("<f8").tobytes(), 6)
    blob = pack(list(zip(numbers.tolist(), values.tolist(), strict=True)))
    for each in (older, blob):
        found = Traces.of([each, b"", each])
        assert found.counts.tolist() == [count, 0, count]
        assert np.array_equal(found.evaluations, np.tile(numbers, 2))
        assert np.array_equal(found.values, np.tile(values, 2))
        assert np.array_equal(unpack(each), (numbers, values))


def test_traces_are_seen_alike_on_a_short_and_on_a_long_grid(rng):
    """On a grid that is no longer than a table of its places they are counted without a search."""
    found = Traces.of([pack(improvements(rng.random(900))), b"", pack([(7, 2.0), (500, 1.0)])])
    for last in (500, 1000, 2_000_000):
        grid = geometric_grid(last)
        seen = found.at(found.values, grid)
        first = 0
        for own, count in zip(seen, found.counts.tolist(), strict=True):
            those = slice(first, first + count)
            assert own.tolist() == at(found.evaluations[those], found.values[those], grid).tolist()
            first += count
