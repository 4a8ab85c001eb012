"""Algorithms of other libraries: the contract of every optimiser where they are installed."""

from __future__ import annotations

import pickle
import sys
from importlib.util import find_spec
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from paper_problems import artificial
from springpot.errors import ModelError
from springpot.identification import run
from springpot.registry import plugins
from springpot.testing import check_optimiser
from springpot_plugins.optimisers import libraries
from springpot_plugins.optimisers.cube import integer

OF = {
    **dict.fromkeys(libraries.MINION, "minionpy"),
    **dict.fromkeys(libraries.PYMOO, "pymoo"),
    **dict.fromkeys(libraries.NEVERGRAD, "nevergrad"),
}
EXTRA = {"minionpy": "race", "pymoo": "pymoo", "nevergrad": "nevergrad"}


@pytest.mark.parametrize("name", sorted(OF))
def test_it_keeps_the_contract(name):
    if find_spec(OF[name]) is None:
        pytest.skip(f"{OF[name]} is not installed: pip install 'springpot[{EXTRA[OF[name]]}]'")
    kind = plugins().find("optimiser", name)
    assert check_optimiser(kind) == []
    assert type(pickle.loads(pickle.dumps(kind()))) is kind


@pytest.mark.parametrize(
    ("prefix", "extra"),
    [
        ("minion-", "race"),
        ("pymoo-", "pymoo"),
        ("minuit-", "race"),
        ("dfo-", "race"),
        ("nevergrad-", "nevergrad"),
        ("bayesian-", "surrogate"),
        ("lipo-", "lipo"),
    ],
)
def test_a_library_that_is_absent_says_how_to_get_it(monkeypatch, prefix, extra):
    monkeypatch.setattr(libraries, "find_spec", lambda _: None)
    family = next(each for each in libraries.FAMILIES if each.prefix == prefix)
    with pytest.raises(ModelError, match=rf"optimisers {prefix}.*springpot\[{extra}\]"):
        family.members()


class Unread:
    """An iminuit that cannot read what its descent came to, as beside minionpy."""

    LEAST_SQUARES = 1.0

    def __init__(self, value, start):
        self.value, self.start = value, start

    def migrad(self, ncall):
        for step in range(10):
            self.value(np.clip(self.start + 0.01 * step, 0.0, 1.0))
        raise RuntimeError


def test_a_descent_that_minuit_cannot_read_is_over_and_no_failure(monkeypatch):
    library = ModuleType("iminuit")
    library.Minuit = Unread
    monkeypatch.setitem(sys.modules, "iminuit", library)
    done = run(libraries.Migrad(), artificial("fractional-kelvin"), 35, np.random.default_rng(1))
    assert (done.evaluations, done.failed) == (35, False)


@pytest.mark.parametrize(("name", "told"), [("jso", 5), ("nl-shade-rsp", 120), ("lsrtde", 120)])
def test_minionpy_is_told_of_enough_evaluations_where_fewer_end_the_process(
    monkeypatch, name, told
):
    """The recorder ends the run at its budget, whatever the library would go on with."""
    asked = []

    class Minimizer:
        def __init__(self, function, box, x0, algorithm, budget, *more):
            asked.append(budget)
            self.function, self.points = function, np.full((budget, len(box)), 0.3)

        def optimize(self):
            self.function(self.points)

    monkeypatch.setitem(sys.modules, "minionpy", SimpleNamespace(Minimizer=Minimizer))
    kind = libraries.MINION[f"minion-{name}"]
    found = run(kind(), artificial("springpot"), 5, np.random.default_rng(1))
    assert asked == [told]
    assert found.evaluations == 5


class Candidates:
    """What the adapter asks of lipo, as its source has it, where the library is not installed."""

    def __init__(self, lower_bounds, upper_bounds, log_args, maximize, random_state):
        assert (log_args, maximize) == ([], False)
        self.low, self.high = lower_bounds, upper_bounds
        self.rng, self.known = np.random.default_rng(random_state), []

    def get_candidate(self):
        x = {name: self.rng.uniform(low, self.high[name]) for name, low in self.low.items()}
        return SimpleNamespace(x=x, set=lambda y: self.known.append((x, y)))


def test_lipo_is_told_each_value_at_its_own_candidate_in_any_order(monkeypatch):
    module = ModuleType("lipo")
    module.GlobalOptimizer = Candidates
    monkeypatch.setitem(sys.modules, "lipo", module)
    enquiry = libraries.MaxLipo().enquiry(3, 10, np.random.default_rng(1))
    points = [enquiry.ask() for _ in range(3)]
    for i, value in ((2, 5.0), (0, 7.0), (1, np.inf)):
        enquiry.tell(points[i], value)
    told = [(list(x.values()), y) for x, y in enquiry._search.known]
    assert told == [(points[2].tolist(), 5.0), (points[0].tolist(), 7.0)]


FUNCTIONS = {
    "a bowl": lambda x, y: (x - 0.3) ** 2 + (y - 0.7) ** 2,
    "waves": lambda x, y: np.sin(9.0 * x) + np.cos(11.0 * y) + x,
}


@pytest.mark.parametrize("function", FUNCTIONS.values(), ids=FUNCTIONS)
def test_lipo_evaluates_what_its_library_does_alone(function):
    library = pytest.importorskip("lipo", reason="pip install 'springpot[lipo]', which builds dlib")
    alone, through = [], []

    def noted(x, y):
        alone.append((x, y, function(x, y)))
        return alone[-1][-1]

    search = library.GlobalOptimizer(
        noted,
        lower_bounds={"x": 0.0, "y": 0.0},
        upper_bounds={"x": 1.0, "y": 1.0},
        log_args=[],
        maximize=False,
        random_state=integer(np.random.default_rng(3)),
    )
    search.run(60)
    enquiry = libraries.MaxLipo().enquiry(2, 60, np.random.default_rng(3))
    for _ in range(60):
        u = enquiry.ask()
        through.append((*u, function(*u)))
        enquiry.tell(u, through[-1][-1])
    assert through == alone
