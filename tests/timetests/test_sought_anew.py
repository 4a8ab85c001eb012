"""The best effect in another minimum is sought anew before none is said to explain the tests."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from springpot.errors import SpringpotError
from springpot.timetests import fitting, screening


def tried(left: float, misfit: bool) -> SimpleNamespace:
    """An effect by what it leaves."""
    left = SimpleNamespace(bic=left, misfit=misfit)
    return SimpleNamespace(effect="clipping", model="model", theta="theta", left=left)


@pytest.mark.parametrize(
    ("misfit", "anew", "expected"),
    [(True, 1.0, 1.0), (True, 9.0, 5.0), (True, None, 5.0), (False, 1.0, 5.0)],
)
def test_what_misses_the_tests_is_sought_as_a_first_fit_is(monkeypatch, misfit, anew, expected):
    """A search that fails or finds no better leaves the effect, and what is told of it."""
    searched, told = [], []

    def identify(*_: object, **how: object) -> SimpleNamespace:
        searched.append((how["seeds"], how["thorough"]))
        if anew is None:
            raise SpringpotError("nothing was found")
        return tried(anew, False)

    monkeypatch.setattr(screening, "bic_of", lambda left: left.bic)
    monkeypatch.setattr(fitting, "identify", identify)
    monkeypatch.setattr(screening.Hypothesis, "exactly", lambda effects, fit, parts: fit)
    asked = SimpleNamespace(tests=(), known={}, parts=(), left_out={})
    before = [tried(7.0, True), tried(5.0, misfit)]
    found = screening._sought_where_it_misses(asked, before, told.append)
    assert [each.left.bic for each in found] == [7.0, expected]
    assert searched == ([(["theta"], True)] if misfit else [])
    assert len(told) == (expected == 1.0)
    assert asked.left_out == {}
