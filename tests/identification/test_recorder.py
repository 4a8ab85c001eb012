"""The recorder: exact budgets, honest counts, the same notes in a batch as one by one."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, nan
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from paper_problems import artificial
from springpot.errors import OptionError
from springpot.identification import (
    BatchedOptimiser,
    BudgetSpent,
    Card,
    Optimiser,
    Recorder,
    RecorderGroup,
    run,
    run_batch,
)

NAMES = [
    "springpot",
    "fractional-kelvin",
    "fractional-maxwell",
    "fractional-kelvin4",
    "fractional-zener",
]


def points(problem, count, seed=0):
    """Points in and around the box."""
    rng = np.random.default_rng(seed)
    return (rng.random((count, problem.dimension)) * 1.4 - 0.2) * problem.upper


class Fixed:
    """Stands for a problem: the first coordinate is the objective."""

    def __init__(self, values):
        real = artificial("fractional-kelvin4")
        self.space, self.dimension = real.space, 4
        self.lower, self.upper = real.lower, real.upper
        self.values = list(values)

    def evaluate(self, x):
        """The next value or values, whatever the point."""
        if x.ndim == 1:
            return self.values.pop(0)
        taken, self.values = self.values[: x[..., 0].size], self.values[x[..., 0].size :]
        return np.array(taken).reshape(x.shape[:-1])


@settings(deadline=None)
@given(
    st.lists(st.floats(min_value=0.0) | st.just(nan), min_size=1, max_size=40),
    st.lists(st.integers(1, 7), min_size=1, max_size=12),
    st.integers(1, 30),
)
def test_a_batch_records_what_single_calls_record(values, sizes, budget):
    single, batched = (Recorder(Fixed(values + [1.0] * 100), budget) for _ in range(2))
    x = points(artificial("fractional-kelvin4"), sum(sizes))
    for row in x[:budget]:
        single(row)
    first = 0
    for size in sizes:
        if batched.left > 0:
            batched.batch(x[first : first + size])
        first += size
    assert batched.evaluations == single.evaluations == min(budget, sum(sizes))
    assert batched.trace == single.trace
    np.testing.assert_array_equal(batched.best_x, single.best_x)


def test_nothing_is_made_or_recorded_beyond_the_budget():
    problem = artificial("fractional-kelvin4")
    recorder = Recorder(problem, 7)
    values = recorder.batch(points(problem, 10))
    assert np.isfinite(values[:7]).all()
    assert np.isinf(values[7:]).all()
    before = (recorder.evaluations, recorder.best, list(recorder.trace))
    for call in (recorder, recorder.gradient, recorder.residuals):
        for _ in range(3):
            with pytest.raises(BudgetSpent):
                call(problem.upper)
    with pytest.raises(BudgetSpent):
        recorder.batch(points(problem, 3))
    assert (recorder.evaluations, recorder.best, recorder.trace) == before
    assert recorder.evaluations == 7
    assert recorder.gradients == 0


def test_the_end_of_the_budget_is_no_exception_that_a_library_would_swallow():
    assert not issubclass(BudgetSpent, Exception)


@pytest.mark.parametrize("bad", [nan, inf, -inf])
def test_coordinates_that_are_no_numbers_are_counted_but_leave_the_result_finite(bad):
    problem = artificial("fractional-kelvin4")
    recorder = Recorder(problem, 10)
    x = 0.5 * problem.upper
    x[2] = bad
    with np.errstate(all="ignore"):
        value = recorder(x)
        recorder.batch(x[None])
    assert recorder.evaluations == 2
    assert not np.isnan(value)
    assert np.isfinite(recorder.best_x).all()
    if np.isnan(bad):
        assert value == inf
        assert recorder.trace == []


def test_values_that_are_no_numbers_are_counted_but_never_the_best():
    recorder = Recorder(Fixed([nan, 3.0, nan, 2.0, nan, inf]), 6)
    assert recorder(np.ones(4)) == inf
    np.testing.assert_array_equal(recorder.batch(np.ones((5, 4))), [3.0, inf, 2.0, inf, inf])
    assert recorder.evaluations == 6
    assert recorder.trace == [(2, 3.0), (4, 2.0)]


def test_points_are_moved_into_the_parameters_limits_not_into_the_box():
    problem = artificial("fractional-kelvin4")
    recorder = Recorder(problem, 10)
    recorder(np.array([3000.0, 9000.0, 5.0, 1.7]))
    np.testing.assert_array_equal(recorder.best_x, [3000.0, 9000.0, 5.0, 1.0])
    recorder = Recorder(problem, 10)
    recorder(np.array([-3.0, -9.0, -5.0, -1.7]))
    assert (recorder.best_x > 0).all()
    assert (recorder.best_x < 1e-5).all()


def test_a_factor_is_in_the_values_and_in_the_record():
    problem = artificial("fractional-kelvin4")
    x = points(problem, 3)
    plain, penalised = Recorder(problem, 3).batch(x), Recorder(problem, 3)
    values = penalised.batch(x, np.array([1.0, 1e5, 10.0]))
    np.testing.assert_array_equal(values, plain * [1.0, 1e5, 10.0])
    assert penalised.best == values.min()


def test_a_derivative_is_one_evaluation_and_counted_apart():
    problem = artificial("fractional-kelvin4")
    recorder, x = Recorder(problem, 5), problem.upper * [0.1, 0.4, 0.3, 0.5]
    value, slope = recorder.gradient(x)
    residual, jacobian = recorder.residuals(x)
    assert (recorder.evaluations, recorder.gradients) == (2, 2)
    assert value == pytest.approx(residual @ residual)
    np.testing.assert_allclose(slope, 2 * residual @ jacobian, rtol=1e-10)


def test_the_target_ends_the_run():
    recorder = Recorder(Fixed([5.0, 4.0, 1.0, 3.0, 0.5]), 100, target=1.5)
    recorder.batch(np.ones((5, 4)))
    assert recorder.met
    assert recorder.trace[-1] == (5, 0.5)
    with pytest.raises(BudgetSpent):
        recorder(np.ones(4))
    assert recorder.evaluations == 5


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("runs", [1, 3, 50])
def test_a_group_gives_the_bits_of_single_recorders(name, runs):
    problem = artificial(name)
    x = points(problem, runs * 20).reshape(runs, 20, -1)
    factor = np.random.default_rng(1).choice([1.0, 1e5], (runs, 20))
    group = RecorderGroup([Recorder(problem, 50) for _ in range(runs)])
    alone = [Recorder(problem, 50) for _ in range(runs)]
    for _ in range(3):
        together = group.batch(x, factor)
        apart = [
            recorder.batch(rows, f) for recorder, rows, f in zip(alone, x, factor, strict=True)
        ]
        np.testing.assert_array_equal(together, apart)
    for one, other in zip(group.recorders, alone, strict=True):
        assert (one.evaluations, one.best, one.trace) == (
            other.evaluations,
            other.best,
            other.trace,
        )
        np.testing.assert_array_equal(one.best_x, other.best_x)
    with pytest.raises(BudgetSpent):
        group.batch(x)


def test_in_a_group_a_run_that_met_its_target_rests_while_others_go_on():
    problem = artificial("fractional-kelvin4")
    x = points(problem, 40).reshape(2, 20, -1)
    easy, hard = Recorder(problem, 100, target=inf), Recorder(problem, 100)
    group = RecorderGroup([easy, hard])
    group.batch(x)
    values = group.batch(x)
    assert np.isinf(values[0]).all()
    assert np.isfinite(values[1]).all()
    assert (easy.evaluations, hard.evaluations) == (20, 40)


def test_many_points_or_many_frequencies_are_evaluated_in_blocks_with_the_same_bits():
    problem = artificial("fractional-kelvin4")
    x = np.abs(points(problem, 2000))
    parts = np.concatenate([problem.evaluate(x[i : i + 100]) for i in range(0, 2000, 100)])
    np.testing.assert_array_equal(problem.evaluate(x), parts)
    np.testing.assert_array_equal(problem.evaluate(x.reshape(4, 500, -1)).ravel(), parts)
    residual = problem.residuals(x)
    np.testing.assert_allclose(problem.evaluate(x), np.sum(residual**2, axis=-1), rtol=1e-12)


@dataclass(frozen=True)
class Scripted(Optimiser):
    """Does what it is told."""

    deed: object

    name: ClassVar[str] = "scripted"
    card: ClassVar[Card] = Card("scripted")

    def minimise(self, problem, budget, rng):
        self.deed(problem, rng)


def fail(error):
    """An optimiser that evaluates twice and then raises."""

    def deed(problem, rng):
        problem(problem.upper * 0.3)
        problem(problem.upper * 0.4)
        raise error

    return Scripted(deed)


def spend(problem, rng):
    """Evaluate until stopped."""
    while True:
        problem(rng.random(4) * problem.upper)


def wrap(problem, rng):
    """A library that turns the end into an error of its own."""
    try:
        spend(problem, rng)
    except BaseException as error:
        raise SystemError("callback failed") from error


@pytest.mark.parametrize(
    ("optimiser", "status", "count"),
    [
        (Scripted(spend), "budget", 9),
        (Scripted(wrap), "budget", 9),
        (fail(ValueError("wrong\nsecond line")), "failed: ValueError: wrong", 2),
        (fail(SystemExit("bye")), "failed: SystemExit: bye", 2),
        (Scripted(lambda problem, rng: problem(problem.upper)), "converged", 1),
        (Scripted(lambda problem, rng: None), "failed: no finite value in 0 evaluations", 0),
    ],
)
def test_status_comes_from_the_recorder(optimiser, status, count):
    found = run(optimiser, artificial("fractional-kelvin4"), 9, np.random.default_rng(0))
    assert found.status == status
    assert found.evaluations == count
    assert found.failed == status.startswith("failed")
    assert (found.theta > 0).all() == (count > 0)


def test_an_interruption_is_not_a_status():
    with pytest.raises(KeyboardInterrupt):
        run(
            fail(KeyboardInterrupt()), artificial("fractional-kelvin4"), 9, np.random.default_rng(0)
        )


def test_target_is_a_status():
    found = run(
        Scripted(spend), artificial("fractional-kelvin4"), 99, np.random.default_rng(0), target=inf
    )
    assert (found.status, found.evaluations) == ("target", 1)


def test_a_result_has_the_thermodynamic_order_restored():
    x = np.array([500.0, 100.0, 0.1, 0.5])
    found = run(Scripted(lambda problem, rng: problem(x)), artificial("fractional-zener"), 9, None)
    assert found.best_x[1] > found.best_x[0] > 0
    assert (found.theta > 0).all()
    assert found.best == artificial("fractional-zener").evaluate(found.best_x)


@pytest.mark.parametrize("budget", [0, -3])
def test_a_budget_must_be_positive(budget):
    with pytest.raises(OptionError, match="at least 1"):
        run(Scripted(spend), artificial("fractional-kelvin4"), budget, np.random.default_rng(0))


@dataclass(frozen=True)
class Sampler(BatchedOptimiser):
    """Random points, all runs side by side."""

    name: ClassVar[str] = "sampler"
    card: ClassVar[Card] = Card("sampler", batched=True)

    def minimise_batch(self, problems, budget, rngs):
        while True:
            problems.batch(np.stack([rng.random((5, 4)) for rng in rngs]) * problems.problem.upper)


@pytest.mark.parametrize("optimiser", [Sampler(), Scripted(spend)])
def test_a_batch_of_runs_is_the_runs_one_by_one(optimiser):
    problem = artificial("fractional-kelvin4")
    seeds = range(4)
    together = run_batch(optimiser, problem, 33, [np.random.default_rng(seed) for seed in seeds])
    apart = [run(optimiser, problem, 33, np.random.default_rng(seed)) for seed in seeds]
    for one, other in zip(together, apart, strict=True):
        assert (one.status, one.evaluations, one.best, one.trace) == (
            "budget",
            33,
            other.best,
            other.trace,
        )
        np.testing.assert_array_equal(one.theta, other.theta)


def test_what_is_done_in_place_to_what_the_recorder_gives_reaches_nothing():
    problem = artificial("fractional-kelvin4")
    recorder = Recorder(problem, 9, start=problem.upper.copy())
    before = problem.lower.copy(), problem.upper.copy()
    recorder(0.5 * problem.upper)
    for array in (recorder.best_x, recorder.lower, recorder.upper, recorder.start):
        array.fill(1.0)
    recorder.trace.clear()
    np.testing.assert_array_equal((problem.lower, problem.upper), before)
    np.testing.assert_array_equal(recorder.best_x, 0.5 * problem.upper)
    np.testing.assert_array_equal(recorder.start, problem.upper)
    assert recorder.trace == [(1, recorder.best)]
