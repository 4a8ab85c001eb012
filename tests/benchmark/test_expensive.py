"""Races of expensive evaluations: workers, their clock, and a search that is asked for points."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.util import find_spec
from threading import Barrier
from types import ModuleType
from typing import ClassVar

import numpy as np
import pytest

from springpot.benchmark.expensive import OnThreads, Site, asked, expensive_table, paced_run
from springpot.benchmark.traits import Formless, Ripples
from springpot.errors import StudyError
from springpot.identification import AskingOptimiser, Card, Enquiry, Optimiser, run
from springpot_plugins.optimisers import libraries

ALIKE = Site(workers=4, seconds=0.05, spread=0.0)


class Halving(Enquiry):
    """Draws around the best point told, nearer each time."""

    def __init__(self, dimension, rng):
        self.rng, self.best, self.value = rng, np.full(dimension, 0.5), np.inf
        self.out, self.most, self.told = 0, 0, []

    def ask(self):
        self.out += 1
        self.most = max(self.most, self.out)
        away = self.rng.normal(size=len(self.best)) * 0.5 ** (1 + len(self.told) / 10)
        return np.clip(self.best + away, 0.0, 1.0)

    def tell(self, u, value):
        self.out -= 1
        self.told.append(value)
        if value < self.value:
            self.best, self.value = u, value


@dataclass(frozen=True)
class Asked(AskingOptimiser):
    name: ClassVar[str] = "asked"
    card: ClassVar[Card] = Card("draws around the best")

    def enquiry(self, dimension, budget, rng):
        return Halving(dimension, rng)


@dataclass(frozen=True)
class Blocks(Optimiser):
    """So many points at once."""

    size: int = 1
    name: ClassVar[str] = "blocks"
    card: ClassVar[Card] = Card("blocks")

    def minimise(self, problem, budget, rng):
        while True:
            x = rng.random((self.size, problem.dimension))
            if self.size == 1:
                problem(x[0])
            else:
                problem.batch(x)


class Bowl(Formless):
    """Smooth, and anywhere near zero."""

    def evaluate(self, x):
        return np.asarray(np.sum((np.asarray(x) - 0.3) ** 2, axis=-1))


def problem():
    return Ripples(np.array([0.3, 0.6]))


@pytest.mark.parametrize(("size", "seconds"), [(1, 1.0), (2, 0.5), (4, 0.25), (20, 0.25)])
def test_points_given_together_take_the_time_of_one_round_of_the_workers(size, seconds):
    course = paced_run(Blocks(size), problem(), 20, ALIKE, 1)
    assert len(course.values) == 20
    assert course.ended[-1] == pytest.approx(seconds)


def test_who_can_be_asked_keeps_all_workers_busy_whatever_a_point_takes():
    uneven = Site(workers=4, seconds=0.05, spread=0.8)
    asked_for, batch = (
        paced_run(optimiser, problem(), 40, uneven, 1) for optimiser in (Asked(), Blocks(4))
    )
    # A batch waits for its slowest; who is asked does not wait: all but the last round are full.
    assert asked_for.ended[-1] < 0.8 * batch.ended[-1]
    assert (np.diff(asked_for.ended) >= 0).all()
    assert asked_for.by(asked_for.ended[9]) == asked_for.after(10)


def test_one_worker_searches_as_a_study_does():
    rng = np.random.default_rng(7)
    alone, enquiry = Site(workers=1, spread=0.0), Halving(2, np.random.default_rng(7))

    class Same(Asked):
        def enquiry(self, dimension, budget, rng):
            return enquiry

    course = paced_run(Same(), problem(), 30, alone, 1)
    assert course.after(30) == run(Asked(), problem(), 30, rng).best
    assert enquiry.most == 1


def test_threads_evaluate_at_the_same_time_and_all_is_told():
    together = Barrier(3, timeout=10)

    def objective(u):
        # Passed only when three points are out at once.
        together.wait()
        return float(u.sum())

    enquiry = Halving(2, np.random.default_rng(1))
    with ThreadPoolExecutor(3) as executor:
        asked(enquiry, OnThreads(executor, objective, 3), 12)
    assert (enquiry.most, enquiry.out, len(enquiry.told)) == (3, 0, 12)


def test_the_table_ranks_by_evaluations_and_by_time():
    courses = {
        name: [[paced_run(optimiser, problem(), 20, ALIKE, 1, i)] for i in range(2)]
        for name, optimiser in {"asked": Asked(), "one by one": Blocks(1)}.items()
    }
    table = expensive_table(courses, ALIKE, marks=(10, 20))
    assert [row[0] for row in table.rows] == ["asked", "one by one"]
    assert [row[-2] for row in table.rows] == [1.0, 2.0]


def test_a_site_without_workers_is_refused():
    with pytest.raises(StudyError, match="at least one worker"):
        Site(workers=0)


class Library:
    """What the surrogate asks of bayesian-optimization, as its documentation has it."""

    def __init__(self, f, pbounds, acquisition_function, random_state, **_):
        assert f is None
        self.bounds, self.known = pbounds, []
        self.rng = np.random.default_rng(random_state)

    def suggest(self):
        return {key: self.rng.uniform(*limits) for key, limits in self.bounds.items()}

    def register(self, params, target):
        self.known.append((params, target))


def test_the_surrogate_tells_heights_of_the_logarithm_and_none_that_is_infinite(monkeypatch):
    module, acquisition = ModuleType("bayes_opt"), ModuleType("bayes_opt.acquisition")
    acquisition.ConstantLiar = lambda base, strategy: base
    acquisition.ExpectedImprovement = lambda xi: xi
    module.BayesianOptimization, module.acquisition = Library, acquisition
    monkeypatch.setitem(sys.modules, "bayes_opt", module)
    monkeypatch.setitem(sys.modules, "bayes_opt.acquisition", acquisition)
    enquiry = libraries.ExpectedImprovement(initial=2).enquiry(3, 20, np.random.default_rng(1))
    for value in (100.0, np.inf, 1e-3, 0.0):
        enquiry.tell(enquiry.ask(), value)
    assert [target for _, target in enquiry._search.known] == [-2.0, 3.0, 12.0]


@pytest.mark.skipif(find_spec("bayes_opt") is None, reason="pip install 'springpot[surrogate]'")
def test_the_surrogate_draws_from_its_generator_only_and_beats_blind_search():
    kind, before = libraries.ExpectedImprovement(), np.random.get_state()[1].copy()  # noqa: NPY002
    found, again = (paced_run(kind, Bowl(2), 30, ALIKE, 1) for _ in range(2))
    np.testing.assert_array_equal(found.values, again.values)
    np.testing.assert_array_equal(np.random.get_state()[1], before)  # noqa: NPY002
    assert found.after(30) < 0.1 * paced_run(Blocks(4), Bowl(2), 30, ALIKE, 1).after(30)
