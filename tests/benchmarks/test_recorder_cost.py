"""What measuring costs.

The recorder per evaluation, and whole libraries with and without it, side by side.

Times are those of this process's own work and the least of many turns, so that other work on the
machine hardly counts; only ratios are asserted.
"""

from __future__ import annotations

from time import perf_counter, process_time
from types import SimpleNamespace

import numpy as np
import pytest
from patience import patient

from paper_problems import artificial
from springpot import plugins
from springpot.identification import Recorder, run

MODEL = "fractional-zener"
BUSY = 1.15
"""What other work on the machine may add to a ratio before a test fails.

The goals are those without it.
"""


def least(calls, turns, clock=process_time):
    """Least duration of each call, taken in turns."""
    spent = np.empty((turns, len(calls)))
    for turn in range(turns):
        for i, call in enumerate(calls):
            began = clock()
            call(turn)
            spent[turn, i] = clock() - began
    return spent.min(axis=0)


@pytest.mark.soak
@patient
def test_the_recorder_costs_little_more_than_the_clamping_it_does(capsys):
    """At most 2 us beyond the objective on a machine that clamps a point in 0.8 us.

    A factor of 2.5.
    """
    problem = artificial(MODEL)
    x, low, high = (
        0.5 * (problem.lower + problem.upper),
        problem.space.lowest,
        problem.space.highest,
    )

    def free(_):
        return 1.0

    # With a free objective, so that no small difference of two long times has to be taken.
    box = {"lower": problem.lower, "upper": problem.upper, "space": problem.space}
    nothing = SimpleNamespace(**box, evaluate=free)
    recorders = [Recorder(one, 10**9) for one in (nothing, problem)]
    calls = [free, *recorders, lambda y: np.minimum(np.maximum(y, low), high), problem.evaluate]
    chunk = 50

    def repeated(call):
        return lambda _: [call(x) for _ in range(chunk)]

    free_alone, alone, recorded, clamping, bare = (
        1e6 / chunk * least([repeated(f) for f in calls], 150, perf_counter)
    )
    with capsys.disabled():
        print(
            f"\nrecorder {alone:.2f} us, clamping {clamping:.2f}, objective {bare:.2f}, "
            f"recorded {recorded:.2f}"
        )
    assert alone - free_alone <= 2.5 * BUSY * clamping
    assert recorded <= 1.1 * BUSY * bare


def bare_pycma(problem, budget, seed):
    import cma

    rng = np.random.default_rng(seed)
    room, done, size = (
        problem.upper - problem.lower,
        0,
        float(4 + int(3 * np.log(problem.dimension))),
    )
    while done < budget:
        options = {
            "bounds": [0.0, 1.0],
            "popsize": int(size),
            "randn": lambda *shape: rng.standard_normal(shape),
            "seed": np.nan,
            "maxiter": 10**9,
            "verbose": -9,
            "verb_log": 0,
        }
        strategy = cma.CMAEvolutionStrategy(rng.random(problem.dimension), 0.3, options)
        while done < budget and not strategy.stop():
            points = strategy.ask()
            strategy.tell(
                points, problem.evaluate(problem.lower + np.array(points) * room).tolist()
            )
            done += len(points)
        size *= 2


def bare_nlopt(problem, budget, seed):
    import nlopt

    rng = np.random.default_rng(seed)
    nlopt.srand(int(rng.integers(1, 2**31 - 1)))
    lower, room = problem.lower, problem.upper - problem.lower
    solver = nlopt.opt(nlopt.GN_CRS2_LM, problem.dimension)
    solver.set_lower_bounds(np.zeros(problem.dimension))
    solver.set_upper_bounds(np.ones(problem.dimension))
    solver.set_min_objective(lambda u, _: float(problem.evaluate(lower + u * room)))
    solver.set_maxeval(budget)
    solver.optimize(rng.random(problem.dimension))


def bare_scipy(problem, budget, seed):
    from scipy.optimize import differential_evolution

    lower, room, generation = problem.lower, problem.upper - problem.lower, 15 * problem.dimension
    differential_evolution(
        lambda u: problem.evaluate(lower + u.T * room),
        [(0.0, 1.0)] * problem.dimension,
        maxiter=budget // generation - 1,
        tol=0.0,
        polish=False,
        updating="deferred",
        vectorized=True,
        rng=np.random.default_rng(seed),
    )


LIBRARIES = {
    "pycma": (bare_pycma, "cma-es", 1500, 9),
    "nlopt": (bare_nlopt, "nlopt-crs", 1500, 9),
    "scipy": (bare_scipy, "differential-evolution", 4800, 20),
}
"""Bare call, optimiser, evaluations, turns."""


def made(name):
    found = plugins().find("optimiser", name)
    return found() if isinstance(found, type) else found


@pytest.mark.soak_cases("nlopt", "pycma", "scipy")
@pytest.mark.parametrize("library", LIBRARIES)
@patient
def test_a_library_takes_at_most_ten_percent_more_than_bare(library, capsys):
    bare, name, budget, turns = LIBRARIES[library]
    problem, optimiser = artificial(MODEL), made(name)
    done = run(optimiser, problem, budget, np.random.default_rng(0))
    assert done.evaluations == budget
    bare(problem, budget, 0)
    calls = [
        lambda turn: bare(problem, budget, turn % 3),
        lambda turn: run(optimiser, problem, budget, np.random.default_rng(turn % 3)),
    ]
    alone, ours = 1e6 / budget * least(calls, turns)
    with capsys.disabled():
        print(
            f"\n{library}: bare {alone:.2f} us per evaluation, {name} {ours:.2f} us, "
            f"ratio {ours / alone:.3f}"
        )
    assert ours <= 1.1 * BUSY * alone


@pytest.mark.soak_cases("pycma-bare", "pycma-springpot")
@pytest.mark.parametrize("who", ["bare", "springpot"])
@pytest.mark.parametrize("library", LIBRARIES)
def test_side_by_side(benchmark, library, who):
    benchmark.group = library
    bare, name, budget, _ = LIBRARIES[library]
    problem, optimiser = artificial(MODEL), made(name)
    if who == "bare":
        benchmark.pedantic(bare, (problem, budget, 0), rounds=5, warmup_rounds=1)
    else:
        benchmark.pedantic(
            lambda: run(optimiser, problem, budget, np.random.default_rng(0)),
            rounds=5,
            warmup_rounds=1,
        )
