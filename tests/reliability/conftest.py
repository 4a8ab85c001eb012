"""By being here it puts this folder's modules and the readers' samples within reach."""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "plugins"))


@pytest.fixture(autouse=True)
def nobody_listens_to_the_garbage_collector() -> Iterator[None]:
    """What falls into a listener is lost, as hypothesis has one, which times the collector.

    An end of time that is lost there is told again, maybe into pytest's report of the loss, and
    that fails the test.
    """
    listening = list(gc.callbacks)
    gc.callbacks.clear()
    yield
    gc.callbacks[:] = listening
