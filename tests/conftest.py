"""What all tests share; being here it also puts this folder's helper modules within reach of every test."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from io import BytesIO
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from remembered import remember

# A busy machine draws slowly: that says nothing of what is tested.
settings.register_profile("any machine", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("any machine")


@pytest.fixture
def rng() -> np.random.Generator:
    """A generator with a fixed seed."""
    return np.random.default_rng(20240607)


@pytest.fixture
def asked_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """For tests of what becomes of an examination: it is not made again where another test asked for the same."""
    remember(monkeypatch)


@pytest.fixture
def unpainted(monkeypatch: pytest.MonkeyPatch) -> None:
    """For tests of the words of a page: the pictures in it, most of the work, are drawn up but not painted."""
    figure = pytest.importorskip("matplotlib.figure")
    paint = figure.Figure.savefig

    def stand_in(self: Any, file: Any, **given: Any) -> None:
        if isinstance(file, BytesIO):
            file.write(b"<svg></svg>")
        else:
            paint(self, file, **given)

    monkeypatch.setattr(figure.Figure, "savefig", stand_in)


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """For tests of what is written: figures are drawn up and kept in this list, and no file of theirs is painted."""
    figure = pytest.importorskip("matplotlib.figure")
    kept: list[Any] = []

    def stand_in(self: Any, file: Any, **given: Any) -> None:
        kept.append(self)
        file.write(b"<svg></svg>")

    monkeypatch.setattr(figure.Figure, "savefig", stand_in)
    return kept


@pytest.fixture(autouse=True, scope="session")
def hears_ctrl_c() -> Iterator[None]:
    """A shell that runs the tests in its background lets them ignore Ctrl-C, and their children after them."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
