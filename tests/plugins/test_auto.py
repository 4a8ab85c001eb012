"""The optimiser ``auto`` looks first, for its share of the budget, and says why it goes on so."""

from __future__ import annotations

import contextlib
from types import SimpleNamespace

import numpy as np
import pytest

import springpot
from springpot.errors import ModelError, OptionError
from springpot.identification.problem import Problem
from springpot.identification.recorder import BudgetSpent, Recorder
from springpot.identification.runs import run
from springpot.registry import plugins
from springpot_plugins.optimisers import descents
from springpot_plugins.optimisers.descents import LeastSquares, Misfit

BUDGET = 600


def problem(name: str) -> Problem:
    card = plugins().problem(f"springpot-60/{name}")
    objective = plugins().find("objective", card.objective)
    return Problem.of(springpot.parse_model(card.model), card.open(), objective)


@pytest.mark.soak
def test_what_it_looks_at_are_the_descents_of_its_rules():
    limit = int(descents.Auto().share * BUDGET)
    whole = run(descents.Auto(), problem("mass-and-delay"), BUDGET, np.random.default_rng(3)).trace
    seen = Recorder(problem("mass-and-delay"), limit)
    with contextlib.suppress(BudgetSpent):
        descents.descents(seen, limit, np.random.default_rng(3))
    assert [step for step in whole if step[0] <= limit] == seen.trace
    assert seen.trace


def ruled(monkeypatch, **changes):
    known = dict(descents.rules()) | changes
    monkeypatch.setattr(descents, "rules", lambda: known)


def test_a_descent_is_cut_short_and_the_next_one_is_of_another_kind(monkeypatch):
    kinds = [
        {"begins": "parameters", "method": "trf", "logarithmic": True},
        {"begins": "logarithms", "method": "lm", "logarithmic": True},
    ]
    ruled(monkeypatch, longest=4, descents=kinds)
    kinds, made = descents.kinds(), Recorder(problem("mass-and-delay"), BUDGET)
    for methods in ("trf", "lm", "trf"):
        way, before = next(kinds), made.evaluations
        assert (way.kind.method, way.sized) == (methods, methods == "lm")
        descents.descended(made, way, np.random.default_rng(1), BUDGET)
        assert made.evaluations == before + 4


def test_a_descent_that_leads_no_further_is_given_up(monkeypatch):
    # Nobody falls by nine tenths at every evaluation.
    ruled(monkeypatch, patience=3, progress=1e-9)
    made = Recorder(problem("mass-and-delay"), BUDGET)
    descents.descended(made, next(descents.kinds()), np.random.default_rng(1), BUDGET)
    assert made.evaluations == 4


def test_starts_that_are_drawn_by_logarithms_have_sizes_of_any_order(monkeypatch):
    ruled(monkeypatch, longest=1)
    diary = []
    made, way = Recorder(problem("mass-and-delay"), BUDGET, diary=diary), LeastSquares()
    rng = np.random.default_rng(1)
    for _ in range(100):
        descents.descended(made, descents.Way(way, sized=True), rng, BUDGET)
    points, sized = np.array([point for point, _ in diary]), Misfit(made).logarithmic
    share = (points - made.lower) / (made.upper - made.lower)
    # The lower end is a billionth of the upper one: half of the orders are below its root.
    assert 0.3 < np.mean(share[:, sized] < 1e-4) < 0.7
    assert 0.3 < np.mean(share[:, ~sized] < 0.5) < 0.7


@pytest.mark.soak
def test_it_says_which_optimiser_it_goes_on_with_and_why():
    done = run(descents.Auto(), problem("mass-and-delay"), BUDGET, np.random.default_rng(3))
    (remark,) = done.remarks
    name = remark.partition(" was chosen to take turns")[0]
    assert name in descents.rules()["optimisers"]
    assert "descents ended as low as the best" in remark
    assert done.evaluations == BUDGET


def test_the_remark_is_a_note_of_the_identification():
    data = springpot.read("springpot-60/kelvin-noisy")
    found = springpot.identify(data, "fractional-kelvin", optimiser="auto", budget=300)
    assert any("was chosen" in note for note in found.notes)


@pytest.mark.parametrize(
    ("ends", "alike"), [([1e-24, 3e-27, 0.5], 2), ([0.2, 0.2 + 1e-8, 0.21], 2), ([np.inf], 1)]
)
def test_descents_that_end_in_rounding_are_alike(ends, alike):
    seen = [SimpleNamespace(least=end, begun=7.0) for end in ends]
    assert descents.told(seen).startswith(f"{alike} of {len(ends)} descents")


def test_the_first_that_is_installed_takes_turns(monkeypatch):
    ruled(monkeypatch, optimisers=["no-such-optimiser", "cma-es"])
    assert descents.chosen() == "cma-es"
    ruled(monkeypatch, optimisers=["no-such-optimiser"])
    with pytest.raises(ModelError, match="no-such-optimiser"):
        descents.chosen()


def test_one_of_them_comes_with_springpot():
    extra = ("minion-", "dfo-", "minuit-", "pymoo-", "optimagic-")
    assert any(not name.startswith(extra) for name in descents.rules()["optimisers"])


def test_its_share_is_a_share():
    with pytest.raises(OptionError, match="share"):
        descents.Auto(share=1.5)
