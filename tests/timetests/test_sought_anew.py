"""The best effect in another minimum is sought anew before none is said to explain the tests."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from springpot.timetests import screening


def tried(left: float, misfit: bool) -> SimpleNamespace:
    """An effect by what it leaves."""
    left = SimpleNamespace(bic=left, misfit=misfit)
    return SimpleNamespace(effect="clipping", model="model", theta="theta", left=left)


@pytest.mark.parametrize(
    ("misfit", "anew", "expected"), [(True, 1.0, 1.0), (True, 9.0, 5.0), (False, 1.0, 5.0)]
)
def test_what_misses_the_tests_is_sought_as_a_first_fit_is(monkeypatch, misfit, anew, expected):
    asked = []

    def exact(*of: object, thorough: bool) -> SimpleNamespace:
        asked.append((of[3], thorough))
        return tried(anew, False)

    monkeypatch.setattr(screening, "bic_of", lambda left: left.bic)
    monkeypatch.setattr(screening, "_exact_fit", exact)
    other = tried(7.0, True)
    found = screening._sought_where_it_misses(None, [other, tried(5.0, misfit)], None)
    assert [each.left.bic for each in found] == [7.0, expected]
    assert asked == ([(["theta"], True)] if misfit else [])
