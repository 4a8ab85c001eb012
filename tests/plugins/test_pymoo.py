"""Algorithms of pymoo as optimisers: the contract of every optimiser, where it is installed."""

from __future__ import annotations

import pickle
from importlib.util import find_spec

import pytest

from springpot.errors import ModelError
from springpot.registry import plugins
from springpot.testing import check_optimiser
from springpot_plugins.optimisers import pymoo_library

needs_pymoo = pytest.mark.skipif(
    find_spec("pymoo") is None,
    reason="pymoo is not installed: pip install 'springpot[pymoo]'",
)


@needs_pymoo
@pytest.mark.parametrize("name", sorted(pymoo_library.MEMBERS))
def test_it_keeps_the_contract(name):
    kind = plugins().find("optimiser", name)
    assert check_optimiser(kind) == []
    assert type(pickle.loads(pickle.dumps(kind()))) is kind


def test_without_the_library_its_names_say_how_to_get_it(monkeypatch):
    monkeypatch.setattr(pymoo_library, "find_spec", lambda _: None)
    with pytest.raises(ModelError, match=r"springpot\[pymoo\]"):
        pymoo_library.members()
