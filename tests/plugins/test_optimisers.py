"""Every built-in optimiser.

Exact budget, same seed same bits, limits kept, the optimum found, faults reported.
"""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

from paper_problems import artificial, scale, truth
from springpot.errors import OptionError
from springpot.identification import BatchedOptimiser, Problem, run, run_batch
from springpot.registry import plugins
from springpot_plugins.optimisers import evolution

OPTIMISERS = {item.name: item for item in plugins().items("optimiser")}
NAMES = sorted(OPTIMISERS)
STOCHASTIC = [name for name in NAMES if OPTIMISERS[name].card.stochastic]
BATCHED = [name for name in NAMES if OPTIMISERS[name].card.batched]
BUDGETS = [1, 2, 7, 57, 200]

# Evaluations after which the objective of the four-parameter problems is below 1e-8 of the data's
# square; what the methods that are not listed reach is too little for the paper's problem, as it is
# in other implementations.
GOOD = {
    "cma-es": 4000,
    "bipop-cma-es": 4000,
    "basin-hopping": 1000,
    "cobyqa": 3000,
    "shgo": 1000,
    "differential-evolution": 8000,
    "nlopt-crs": 8000,
    "nlopt-mlsl": 3000,
    "nlopt-bobyqa": 3000,
    "nlopt-nelder-mead": 4000,
    "nlopt-lbfgs": 1000,
    "dual-annealing": 3000,
    "least-squares": 300,
}


def generator(seed=1):
    """A new generator."""
    return np.random.default_rng(seed)


@pytest.mark.soak_cases("cobyqa-200", "bipop-cma-es-1")
@pytest.mark.soak_cases(
    "least-squares-alternating-200", *(f"{name}-{budget}" for name in NAMES for budget in (2, 57))
)
@pytest.mark.parametrize("budget", BUDGETS)
@pytest.mark.parametrize("name", NAMES)
def test_stops_exactly_at_its_budget(name, budget):
    found = run(OPTIMISERS[name](), artificial("fractional-kelvin4"), budget, generator())
    assert found.status == "budget"
    assert found.evaluations == budget
    assert 0 <= found.gradients <= budget
    assert found.trace[-1] == (found.trace[-1][0], found.best)


@pytest.mark.soak_cases("cobyqa-springpot", *(f"{name}-fractional-zener" for name in NAMES))
@pytest.mark.parametrize("model", ["springpot", "fractional-zener"])
@pytest.mark.parametrize("name", NAMES)
def test_same_seed_same_bits_whatever_ran_before(name, model):
    problem, optimiser = artificial(model), OPTIMISERS[name]()
    first = run(optimiser, problem, 150, generator(5))
    run(optimiser, artificial("fractional-maxwell"), 20, generator(6))
    # A library that draws from the process-wide generator shows here.
    np.random.seed(123)  # noqa: NPY002
    second = run(optimiser, problem, 150, generator(5))
    assert (first.status, first.best, first.trace) == (second.status, second.best, second.trace)
    np.testing.assert_array_equal(first.theta, second.theta)


@pytest.mark.parametrize("name", STOCHASTIC)
def test_different_seeds_differ(name):
    traces = [
        run(OPTIMISERS[name](), artificial("fractional-zener"), 40, generator(s)).trace
        for s in (1, 2)
    ]
    assert traces[0] != traces[1]


@pytest.mark.parametrize("name", [n for n in NAMES if n not in STOCHASTIC])
def test_deterministic_ones_do_not_depend_on_the_seed(name):
    traces = [
        run(OPTIMISERS[name](), artificial("fractional-zener"), 40, generator(s)).trace
        for s in (1, 2)
    ]
    assert traces[0] == traces[1]


@pytest.mark.soak_cases(
    "basin-hopping-fractional-kelvin4",
    "cobyqa-fractional-kelvin4",
    "least-squares-alternating-fractional-kelvin4",
    "least-squares-fractional-kelvin4",
    *(f"{name}-fractional-zener" for name in NAMES if name != "basin-hopping"),
)
@pytest.mark.parametrize("model", ["fractional-kelvin4", "fractional-zener"])
@pytest.mark.parametrize("name", NAMES)
def test_results_keep_limits_and_thermodynamic_order(name, model):
    problem = artificial(model)
    for budget in (1, 60):
        for seed in range(5):
            found = run(OPTIMISERS[name](), problem, budget, generator(seed))
            k0, kinf, tau, alpha = found.best_x
            assert kinf > k0 > 0
            assert tau > 0
            assert 0 < alpha <= 1
            assert (found.theta > 0).all()


@pytest.mark.soak_cases(
    "cobyqa-fractional-kelvin4",
    "nlopt-bobyqa-fractional-kelvin4",
    *(f"{name}-fractional-zener" for name in GOOD if name != "nlopt-bobyqa"),
)
@pytest.mark.parametrize("model", ["fractional-kelvin4", "fractional-zener"])
@pytest.mark.parametrize("name", sorted(GOOD))
def test_good_ones_find_the_artificial_optimum(name, model):
    found = run(
        OPTIMISERS[name](), artificial(model), GOOD[name], generator(2), target=1e-8 * scale(model)
    )
    assert found.status == "target"
    np.testing.assert_allclose(found.theta, truth(model), rtol=0.02)


@pytest.mark.soak_cases(
    "auto",
    "basin-hopping",
    "bipop-cma-es",
    "cma-es",
    "cobyqa",
    "ipop-cma-es",
    "least-squares",
    "least-squares-alternating",
    "nlopt-lbfgs",
    "shgo",
)
@pytest.mark.parametrize("name", NAMES)
def test_every_one_beats_a_handful_of_random_points(name):
    problem = artificial("fractional-maxwell")
    bests = [run(OPTIMISERS[name](), problem, 400, generator(seed)).best for seed in range(5)]
    assert np.median(bests) < 0.05 * scale("fractional-maxwell")


def test_bipop_shares_its_evaluations_between_large_and_small_populations(monkeypatch):
    runs = []

    def evolved(cube, size, sigma, allowed, rng):
        # Ten generations of chance, so that only the schedule is left to see.
        spent = min(10 * size, allowed)
        cube.batch(rng.random((spent, cube.dimension)))
        runs.append((size, sigma, allowed, spent))

    monkeypatch.setattr(evolution, "_evolve", evolved)
    run(evolution.BipopCmaEs(), artificial("fractional-kelvin4"), 20_000, generator())
    (default, *_), rest = runs[0], runs[1:]
    assert default == 8
    large = [r for r in rest if r[2] == evolution.UNENDING]
    small = [r for r in rest if r[2] != evolution.UNENDING]
    assert [size for size, *_ in large] == [default * 2 ** (i + 1) for i in range(len(large))]
    assert len(small) >= 5
    spent, last = {True: 0, False: 0}, large[0]
    for chosen in rest:
        is_small = chosen in small
        assert is_small == (spent[True] < spent[False])
        if is_small:
            size, sigma, allowed, _ = chosen
            assert default <= size <= max(default, last[0] // 2)
            assert 0.002 <= sigma <= 0.2
            assert allowed == last[3] // 2
        else:
            last = chosen
        spent[is_small] += chosen[3]


class Broken(Problem):
    """A problem whose evaluation fails after some calls."""

    def respond_or_fail(self):
        """Count down to the fault."""
        count = self.__dict__["_count"] = self.__dict__.get("_count", 0) + 1
        if count > 12:
            raise ZeroDivisionError("the model is broken")

    def evaluate(self, x):
        self.respond_or_fail()
        return super().evaluate(x)

    def residuals_and_jacobian(self, x):
        self.respond_or_fail()
        return super().residuals_and_jacobian(x)


@pytest.mark.soak_cases("scipy-direct")
@pytest.mark.parametrize("name", NAMES)
def test_a_failing_objective_is_a_status(name):
    real = artificial("fractional-kelvin4")
    found = run(
        OPTIMISERS[name](),
        Broken(real.model, real.measurement, real.objective, real.space),
        5000,
        generator(),
    )
    assert found.status == "failed: ZeroDivisionError: the model is broken"
    assert found.evaluations < 5000


@pytest.mark.parametrize("name", BATCHED)
def test_a_batch_gives_the_bits_of_single_runs(name):
    problem, optimiser = artificial("fractional-kelvin4"), OPTIMISERS[name]()
    assert isinstance(optimiser, BatchedOptimiser)
    together = run_batch(optimiser, problem, 1030, [generator(s) for s in range(7)])
    apart = [run(optimiser, problem, 1030, generator(s)) for s in range(7)]
    for one, other in zip(together, apart, strict=True):
        assert (one.status, one.evaluations, one.trace) == (
            other.status,
            other.evaluations,
            other.trace,
        )
        np.testing.assert_array_equal(one.theta, other.theta)


@pytest.mark.parametrize("name", NAMES)
def test_options_are_frozen_documented_and_carry_a_card(name):
    optimiser = OPTIMISERS[name]()
    assert is_dataclass(optimiser)
    assert optimiser == replace(optimiser)
    assert optimiser.card.summary
    described = "".join(kind.__doc__ or "" for kind in type(optimiser).__mro__)
    for option in fields(optimiser):
        assert option.name in described
        with pytest.raises(AttributeError):
            setattr(optimiser, option.name, 1)


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("pso-paper", {"neighbourhood": 21}),
        ("pso-paper", {"particles": 0}),
        ("pso-paper", {"inertia_first": 0.1}),
        ("cma-es", {"sigma": 0.0}),
        ("cma-es", {"population": 2}),
        ("differential-evolution", {"mutation": (1.0, 0.5)}),
        ("differential-evolution", {"strategy": "none"}),
        ("dual-annealing", {"visit": 4.0}),
        ("least-squares", {"method": "newton"}),
        ("least-squares", {"tolerance": 0.0}),
        ("nlopt-mlsl", {"descent": "uphill"}),
        ("nlopt-bobyqa", {"tolerance": -1.0}),
        ("nlopt-crs", {"population": 3}),
        ("random-search", {"block": 0}),
    ],
)
def test_options_out_of_range_are_refused_by_name(name, options):
    with pytest.raises(OptionError, match=f"{name}: option {next(iter(options))} is .* must be"):
        OPTIMISERS[name](**options)


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("least-squares", {"method": "lm"}),
        ("least-squares", {"method": "dogbox"}),
        ("least-squares", {"logarithmic": False}),
        ("nlopt-mlsl", {"descent": "lbfgs"}),
        ("nlopt-mlsl", {"low_discrepancy": True}),
        ("nlopt-isres", {"population": 30}),
    ],
)
def test_other_options_work_and_stop_at_the_budget_too(name, options):
    found = run(OPTIMISERS[name](**options), artificial("fractional-zener"), 300, generator())
    assert (found.status, found.evaluations) == ("budget", 300)
