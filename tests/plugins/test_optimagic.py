"""Algorithms of optimagic as optimisers.

Its contract, its options, and that nobody waits for it who does not ask.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
from importlib.util import find_spec

import numpy as np
import pytest

from paper_problems import artificial
from soaked import soaked
from springpot.benchmark import Store, Study, run_study
from springpot.constraints import optimiser_of
from springpot.errors import ModelError
from springpot.identification import run
from springpot.registry import plugins
from springpot.testing import check_optimiser

needs_optimagic = pytest.mark.skipif(
    find_spec("optimagic") is None,
    reason="optimagic is not installed: pip install 'springpot[optimagic]'",
)
UNBOUNDED = {"optimagic-scipy-bfgs", "optimagic-scipy-ls-lm"}
"""They leave the box; the recorder moves their points into the parameters' own limits."""


@needs_optimagic
@pytest.mark.parametrize(
    "name",
    [
        "optimagic-scipy-ls-trf",
        "optimagic-scipy-differential-evolution",
        "optimagic-nlopt-crs2-lm",
        "optimagic-scipy-bfgs",
        *map(soaked, ("optimagic-scipy-lbfgsb", "optimagic-nlopt-esch", "optimagic-scipy-ls-lm")),
    ],
)
def test_it_keeps_the_contract(name):
    kind = plugins().find("optimiser", name)
    assert check_optimiser(kind, skip=("box",) if name in UNBOUNDED else ()) == []


@needs_optimagic
def test_a_worker_can_have_it_and_its_options():
    optimiser = optimiser_of(
        "optimagic-scipy-lbfgsb:convergence_ftol_rel=1e-3,limited_memory_storage_length=4"
    )
    assert optimiser.convergence_ftol_rel == 1e-3
    again = pickle.loads(pickle.dumps(optimiser))
    assert (type(again), again) == (type(optimiser), optimiser)
    traces = [
        run(each, artificial("springpot"), 60, np.random.default_rng(3)).trace
        for each in (optimiser, again)
    ]
    assert traces[0] == traces[1]


@needs_optimagic
def test_a_slip_is_answered_with_the_nearest_names():
    with pytest.raises(ModelError, match="did you mean optimagic-scipy-lbfgsb"):
        plugins().find("optimiser", "optimagic-scipy-lbfgs")
    assert (
        "optimagic-bhhh" not in next(plugins().items("optimiser family")).members()
    )  # for likelihoods only


@needs_optimagic
def test_it_races(tmp_path):
    study = Study(
        "through-optimagic",
        datasets=["artificial-springpot"],
        models=["own"],
        objectives=["paper"],
        optimisers=["optimagic-scipy-ls-trf", "native"],
        repetitions=2,
        budget=120,
    )
    outcome = run_study(study, workers=1, out=tmp_path, quiet=True)
    assert (outcome.ran, outcome.failed) == (4, 0)
    with Store(outcome.store) as store:
        assert "optimagic" in store.facts()


@pytest.mark.soak
def test_nobody_waits_for_it_who_does_not_ask():
    """Listing all optimisers names it without importing it; nor does the start import it."""
    code = (
        "import sys; from springpot.cli.group import run; run(['list', 'optimisers']); "
        "print('optimagic' in sys.modules)"
    )
    said = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout
    assert "springpot list optimisers optimagic-NAME" in said
    assert said.splitlines()[-1] == "False"


def test_where_it_is_absent_one_line_says_how_to_get_it(monkeypatch):
    from springpot_plugins.optimisers import unified

    monkeypatch.setitem(sys.modules, "optimagic.algorithms", None)
    unified.members.cache_clear()
    with pytest.raises(ModelError, match=r"need optimagic: pip install 'springpot\[optimagic\]'"):
        plugins().find("optimiser", "optimagic-scipy-lbfgsb")
    monkeypatch.undo()
    unified.members.cache_clear()
