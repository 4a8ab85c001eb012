"""The paper's swarm, 50 runs side by side, against pyswarms' local-best swarm for the same evaluations."""

from __future__ import annotations

from time import perf_counter

import numpy as np
import pytest
from patience import patient

from paper_problems import artificial
from springpot.identification import run_batch
from springpot_plugins.optimisers.swarm import PaperSwarm

MODELS = ["fractional-kelvin", "fractional-maxwell", "fractional-kelvin4", "fractional-zener"]
RUNS, EVALUATIONS = 50, 8000


def ours(problem, runs=RUNS):
    """All runs in one batch."""
    return run_batch(PaperSwarm(), problem, EVALUATIONS, [np.random.default_rng(seed) for seed in range(runs)])


@pytest.fixture
def theirs(tmp_path, monkeypatch):
    """Some runs of pyswarms one after another; it writes a log into the working directory."""
    monkeypatch.chdir(tmp_path)
    single = pytest.importorskip("pyswarms.single", reason="pyswarms is in the extra 'benchmark'")

    def fly(problem, runs):
        for seed in range(runs):
            np.random.seed(seed)  # noqa: NPY002  its only source of randomness
            swarm = single.LocalBestPSO(
                n_particles=20,
                dimensions=problem.dimension,
                options={"c1": 2.0, "c2": 2.0, "w": 0.9, "k": 3, "p": 2},
                bounds=(problem.lower, problem.upper),
                oh_strategy={"w": "lin_variation"},
            )
            swarm.optimize(problem.evaluate, iters=EVALUATIONS // 20, verbose=False)

    return fly


def seconds(call):
    """Duration of a call."""
    start = perf_counter()
    call()
    return perf_counter() - start


@pytest.mark.parametrize("name", MODELS)
@patient
def test_fifty_runs_take_at_most_a_tenth_of_pyswarms(name, theirs, capsys):
    problem = artificial(name)
    ours(problem, 1), theirs(problem, 1)
    # Taken in turns, so that what else the machine does slows down both.
    pairs = [(seconds(lambda: ours(problem)) / RUNS, seconds(lambda: theirs(problem, 2)) / 2) for _ in range(3)]
    mine, other = np.median(np.array(pairs), axis=0) / EVALUATIONS * 1e6
    with capsys.disabled():
        print(f"\n{name}: {mine:.2f} us per evaluation, pyswarms {other:.2f}, ratio {mine / other:.3f}")
    assert mine <= 0.1 * other


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.benchmark(group="swarm")
def test_speed_of_fifty_runs(benchmark, name):
    runs = benchmark.pedantic(ours, args=(artificial(name),), rounds=3, warmup_rounds=1)
    assert {found.evaluations for found in runs} == {EVALUATIONS}


@pytest.mark.benchmark(group="swarm")
def test_speed_of_one_pyswarms_run(benchmark, theirs):
    benchmark.pedantic(theirs, args=(artificial("fractional-kelvin4"), 1), rounds=3, warmup_rounds=1)
