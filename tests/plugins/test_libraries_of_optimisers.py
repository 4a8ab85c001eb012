"""Algorithms of other libraries: the contract of every optimiser where they are installed."""

from __future__ import annotations

import pickle
from importlib.util import find_spec

import pytest

from springpot.errors import ModelError
from springpot.registry import plugins
from springpot.testing import check_optimiser
from springpot_plugins.optimisers import (
    dfo,
    families,
    minion,
    minuit,
    nevergrad_library,
    pymoo_library,
    surrogate,
)

OF = {
    **dict.fromkeys(minion.MEMBERS, "minionpy"),
    **dict.fromkeys(pymoo_library.MEMBERS, "pymoo"),
    **dict.fromkeys(nevergrad_library.MEMBERS, "nevergrad"),
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
    ("of", "prefix", "extra"),
    [
        (minion, "minion-", "race"),
        (pymoo_library, "pymoo-", "pymoo"),
        (minuit, "minuit-", "race"),
        (dfo, "dfo-", "race"),
        (nevergrad_library, "nevergrad-", "nevergrad"),
        (surrogate, "bayesian-", "surrogate"),
    ],
)
def test_a_library_that_is_absent_says_how_to_get_it(monkeypatch, of, prefix, extra):
    for module in (families, dfo):
        monkeypatch.setattr(module, "find_spec", lambda _: None)
    with pytest.raises(ModelError, match=rf"optimisers {prefix}.*springpot\[{extra}\]"):
        of.FAMILY.members()
