"""Evaluations to a target under pytest-benchmark: its timer counts evaluations instead of seconds.

With ``--benchmark-enable --benchmark-autosave`` and later ``--benchmark-compare
--benchmark-compare-fail=median:10%`` accuracy is gated by the plugin's own means; what it prints as
seconds are evaluations. A round is a run with its own seed, so two runs of the same code give the
same figures to the last digit.
"""

from __future__ import annotations

import numpy as np
import pytest

from paper_problems import artificial
from springpot import plugins
from springpot.identification import run

ROUNDS, BUDGET, TARGET = 15, 8000, 1e-6


class Counter:
    """A clock that advances by one for each evaluation."""

    def __init__(self):
        self.now = 0.0

    def __call__(self):
        return self.now


COUNTER = Counter()


def to_target(optimiser, problem, target, seed):
    """One run; the clock goes on by the evaluations that it took."""
    done = run(optimiser, problem, BUDGET, np.random.default_rng(seed), target)
    COUNTER.now += next((number for number, value in done.trace if value <= target), BUDGET)


def prepared(name, model):
    """An optimiser, a problem and the objective to reach."""
    found = plugins().find("optimiser", name)
    problem = artificial(model)
    centre = float(problem.evaluate(0.5 * (problem.lower + problem.upper)))
    return (found() if isinstance(found, type) else found), problem, TARGET * centre


@pytest.mark.soak_cases("cma-es-fractional-maxwell", "cma-es-fractional-zener")
@pytest.mark.parametrize("model", ["fractional-maxwell", "fractional-zener"])
@pytest.mark.parametrize("name", ["pso-paper", "cma-es", "nlopt-crs", "native"])
@pytest.mark.benchmark(timer=COUNTER, group="evaluations to target")
def test_evaluations_to_target(benchmark, name, model):
    optimiser, problem, target = prepared(name, model)
    seeds = iter(range(10**6))
    benchmark.extra_info["unit"] = "evaluations"
    benchmark.pedantic(
        to_target,
        setup=lambda: ((optimiser, problem, target, next(seeds)), {}),
        rounds=ROUNDS,
        iterations=1,
    )
    if benchmark.enabled:
        counts = np.array(benchmark.stats.stats.data)
        assert len(counts) == ROUNDS
        assert np.all(counts == np.round(counts))
        assert 1 <= counts.min() <= counts.max() <= BUDGET


def test_the_counter_counts_and_repeats():
    optimiser, problem, target = prepared("cma-es", "fractional-maxwell")
    counts = []
    for seed in (0, 1, 0):
        before = COUNTER()
        to_target(optimiser, problem, target, seed)
        counts.append(COUNTER() - before)
    assert counts[0] == counts[2] != counts[1]
    assert all(count == int(count) and 1 < count < BUDGET for count in counts)
