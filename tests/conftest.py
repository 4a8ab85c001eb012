"""What all tests share.

Being here it also puts this folder's helper modules within reach of every test.
"""

from __future__ import annotations

import gc
import os
import platform
import signal
from collections.abc import Iterator
from typing import Any

# Before numpy is: its linear algebra has a kernel for each kind of processor, of which the last
# digits differ, and whole answers are held to more than that.
if platform.machine() in ("x86_64", "AMD64"):
    os.environ.setdefault("OPENBLAS_CORETYPE", "Haswell")

import numpy as np
import pytest
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers

from command_line import damper, springpot, write
from remembered import remember
from unpainted import leave_unpainted
from whole_answers import stays

__all__ = ["damper", "springpot", "stays", "write"]
"""Fixtures that are made elsewhere."""

SELDOM = 100_000, 20, 20
"""After how many new objects Python looks for garbage; its own are 700, 10, 10."""

# A busy machine draws slowly: that says nothing of what is tested.
for name, examples in (("any machine", 10), ("soak", 300)):
    settings.register_profile(
        name, max_examples=examples, deadline=None, suppress_health_check=[HealthCheck.too_slow]
    )
settings.load_profile("any machine")


def pytest_configure(config: pytest.Config) -> None:
    """Hypothesis looks for constants worth trying only in the soak: it parses every module."""
    if config.getoption("--hypothesis-profile", default=None) != "soak":
        providers._get_local_constants = lambda none=providers._local_constants: none


def pytest_collection_finish() -> None:
    """Ten thousand tests stay until the end: looking through them for garbage takes time.

    Looking for it seldom saves a tenth of the time of all tests.
    """
    gc.freeze()
    gc.set_threshold(*SELDOM)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave the cases that `soak_cases` names to the soak, and all that `suite_cases` does not."""
    for item in items:
        case = item.name.partition("[")[2].removesuffix("]")
        left = [case in mark.args for mark in item.iter_markers("soak_cases")]
        left += [case not in mark.args for mark in item.iter_markers("suite_cases")]
        if any(left):
            item.add_marker(pytest.mark.soak)


@pytest.fixture
def rng() -> np.random.Generator:
    """A generator with a fixed seed."""
    return np.random.default_rng(20240607)


@pytest.fixture
def asked_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """For tests of what becomes of an examination.

    It is not made again where another test asked for the same.
    """
    remember(monkeypatch)


@pytest.fixture
def unpainted(monkeypatch: pytest.MonkeyPatch) -> None:
    """For tests of the words of a page.

    The pictures in it, most of the work, are drawn up but not painted.
    """
    leave_unpainted(monkeypatch)


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """For tests of what is written.

    Figures are drawn up and kept in this list, and no file of theirs is painted.
    """
    figure = pytest.importorskip("matplotlib.figure")
    kept: list[Any] = []

    def stand_in(self: Any, file: Any, **given: Any) -> None:
        kept.append(self)
        file.write(b"<svg></svg>")

    monkeypatch.setattr(figure.Figure, "savefig", stand_in)
    return kept


@pytest.fixture(autouse=True, scope="session")
def hears_ctrl_c() -> Iterator[None]:
    """A shell that runs the tests in its background makes them and their children ignore Ctrl-C."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
