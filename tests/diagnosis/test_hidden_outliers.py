"""Bad points that what is missing hides from the base model."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from springpot.diagnosis import examination


@pytest.mark.parametrize("seen", [True, False])
def test_the_best_model_shows_what_the_base_does_not(monkeypatch, seen):
    rows = {"base": np.array([], dtype=int), "best": np.array([3, 38] if seen else [], dtype=int)}
    best = SimpleNamespace(frame=lambda: "best")
    search = SimpleNamespace(frame="base", base=None, best=best, grown=[best])
    told = SimpleNamespace(frame_of=lambda _: "best without them")
    reduced = SimpleNamespace(base=None, best=told, grown=[], alarm=1.0, gain=0.0)
    monkeypatch.setattr(examination, "outlying", rows.__getitem__)
    monkeypatch.setattr(examination, "are_outliers", lambda *_: True)
    monkeypatch.setattr(examination, "described", lambda frame, found: (frame, found.tolist()))
    found = examination._without_outliers(search, None, lambda _: reduced)
    assert found == ((reduced, ("best without them", [3, 38])) if seen else None)
