"""A plugin of pytest for `mutation`: which tests run, what each of them enters, and which fail.

``SPRINGPOT_NOTES`` names the file that is written at the end. ``SPRINGPOT_ORDER`` names one with
the tests that run, in their order. Without it all run, and notes are made of the seconds that each
took, of the functions of the framework that it entered, as file from the root and name, and of
whether it started a process, which may enter anything.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter
from types import CodeType, FrameType
from typing import Any

import pytest

TESTS: dict[str, dict[str, Any]] = {}
FAILED: list[str] = []
STARTED: list[str] = []
"""Processes that the test at hand started, by how."""
STARTS = ("subprocess.Popen", "os.fork", "os.forkpty", "os.posix_spawn", "os.spawn")


def _hear(event: str, arguments: object) -> None:
    if event in STARTS:
        STARTED.append(event)


if "SPRINGPOT_ORDER" not in os.environ:
    sys.addaudithook(_hear)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The named tests alone, in their order."""
    if "SPRINGPOT_ORDER" in os.environ:
        order = json.loads(Path(os.environ["SPRINGPOT_ORDER"]).read_text(encoding="utf-8"))
        place = {name: index for index, name in enumerate(order)}
        items[:] = sorted(
            (item for item in items if item.nodeid in place), key=lambda item: place[item.nodeid]
        )


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Note what the test and its fixtures enter, up to where a test traces for itself."""
    if "SPRINGPOT_ORDER" in os.environ:
        return (yield)
    seen: set[CodeType] = set()

    def enter(frame: FrameType, event: str, argument: object) -> None:
        seen.add(frame.f_code)

    start = perf_counter()
    STARTED.clear()
    threading.settrace(enter)
    sys.settrace(enter)
    try:
        return (yield)
    finally:
        sys.settrace(None)
        threading.settrace(None)  # type: ignore[arg-type]
        root = item.config.rootpath
        places = sorted(
            {
                (os.path.relpath(code.co_filename, root), code.co_qualname)
                for code in seen
                if _ours(code)
            }
        )
        TESTS[item.nodeid] = {
            "seconds": perf_counter() - start,
            "entered": places,
            "started": bool(STARTED),
        }


def _ours(code: CodeType) -> bool:
    return f"{os.sep}framework{os.sep}" in code.co_filename


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Note what failed."""
    if report.failed:
        FAILED.append(report.nodeid)


def pytest_sessionfinish() -> None:
    """Write the notes."""
    text = json.dumps({"tests": TESTS, "failed": FAILED})
    Path(os.environ["SPRINGPOT_NOTES"]).write_text(text, encoding="utf-8")
