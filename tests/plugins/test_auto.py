"""The optimiser ``auto`` looks first, for its share of the budget, and says why it goes on so."""

from __future__ import annotations

import contextlib

import numpy as np
import pytest

import springpot
from springpot.errors import ModelError, OptionError
from springpot.identification.problem import Problem
from springpot.identification.recorder import BudgetSpent, Recorder
from springpot.identification.runs import run
from springpot.registry import plugins
from springpot_plugins.optimisers import auto

BUDGET = 600
SEEN = auto.Seen(5, 4, 1.0, 0.0, 3.0, 2.0, 0.0)


def problem(name: str) -> Problem:
    card = plugins().problem(f"springpot-60/{name}")
    objective = plugins().find("objective", card.objective)
    return Problem.of(springpot.parse_model(card.model), card.open(), objective)


def leaves(node):
    if "feature" not in node:
        return [node["optimisers"]]
    return leaves(node["below"]) + leaves(node["above"])


@pytest.mark.soak
def test_what_it_looks_at_are_the_descents_of_its_rules():
    limit = int(auto.Auto().share * BUDGET)
    whole = run(auto.Auto(), problem("mass-and-delay"), BUDGET, np.random.default_rng(3)).trace
    descents = Recorder(problem("mass-and-delay"), limit)
    with contextlib.suppress(BudgetSpent):
        auto.descents(descents, limit, np.random.default_rng(3))
    assert [step for step in whole if step[0] <= limit] == descents.trace
    assert descents.trace


def test_a_descent_is_cut_short_and_the_next_one_is_of_another_kind(monkeypatch):
    known = {"longest": 4, "descents": [{"method": "trf", "logarithmic": True}, {"method": "lm"}]}
    monkeypatch.setattr(auto, "rules", lambda: known)
    kinds, made = auto.kinds(), Recorder(problem("mass-and-delay"), BUDGET)
    for methods in ("trf", "lm", "trf"):
        kind, before = next(kinds), made.evaluations
        assert kind.method == methods
        assert auto.descended(made, kind, np.random.default_rng(1), BUDGET).cut
        assert made.evaluations == before + 4


@pytest.mark.soak
def test_it_says_which_optimiser_it_goes_on_with_and_why():
    done = run(auto.Auto(), problem("mass-and-delay"), BUDGET, np.random.default_rng(3))
    (remark,) = done.remarks
    name = remark.partition(" was chosen to take turns")[0]
    assert name in {name for leaf in leaves(auto.rules()["tree"]) for name in leaf}
    assert "descents were looked at" in remark
    assert done.evaluations == BUDGET


def test_the_remark_is_a_note_of_the_identification():
    data = springpot.read("springpot-60/kelvin-noisy")
    found = springpot.identify(data, "fractional-kelvin", optimiser="auto", budget=300)
    assert any("was chosen" in note for note in found.notes)


def test_the_tree_is_followed_down_to_an_optimiser_that_is_installed(monkeypatch):
    tree = {
        "feature": "agreement",
        "limit": 0.5,
        "below": {"optimisers": ["no-such-optimiser", "cma-es"]},
        "above": {"optimisers": ["least-squares"]},
    }
    monkeypatch.setattr(auto, "rules", lambda: {"tree": tree})
    name, why = auto.chosen(SEEN)
    assert name == "least-squares"
    assert why.startswith("agreement 1 is not below 0.5")
    lonely = auto.Seen(5, 4, 0.25, 3.0, 3.0, 2.0, 0.0)
    assert auto.chosen(lonely)[0] == "cma-es"
    monkeypatch.setattr(auto, "rules", lambda: {"tree": {"optimisers": ["no-such-optimiser"]}})
    with pytest.raises(ModelError, match="no-such-optimiser"):
        auto.chosen(SEEN)


def test_every_leaf_has_an_optimiser_that_comes_with_springpot():
    extra = ("minion-", "dfo-", "minuit-", "pymoo-", "optimagic-")
    for names in leaves(auto.rules()["tree"]):
        assert any(not name.startswith(extra) for name in names), names


def test_its_share_is_a_share():
    with pytest.raises(OptionError, match="share"):
        auto.Auto(share=1.5)
