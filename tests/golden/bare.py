"""Answers golden questions where there are no threads, no processes and no optimisers' libraries.

``python bare.py NAME...`` prints each answer as a line of JSON, in the order of the cases. What is
taken away here is what Python in a browser lacks.
"""

from __future__ import annotations

import contextlib
import importlib.abc
import json
import os
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

from cases import CASES, Case

ABSENT = {"cma", "fcntl", "matplotlib", "nlopt", "resource", "starlette", "uvicorn"}
CLIMBED = ("zener hides inertia", "any material hides friction")


class Absent(importlib.abc.MetaPathFinder):
    """Finds first, and finds that what is absent is not there."""

    def find_spec(self, name: str, *_: Any) -> None:
        """Refuse what is absent; whatever else there is, others find."""
        if name.partition(".")[0] in ABSENT:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


def refused(*_: Any, **__: Any) -> NoReturn:
    """What a browser does with threads and processes."""
    raise RuntimeError("there are no threads and no processes here")


def told(case: Case, folder: Path) -> str:
    """The JSON of what Python is answered to a case's question, without times of the run."""
    import springpot

    case.write(folder)
    question, *data = case.arguments
    model = None
    if "--model" in data:
        model = data.pop()
        data.remove("--model")
    with contextlib.chdir(folder):
        answer = getattr(springpot, question)(data if len(data) > 1 else data[0], model)
    return json.dumps(without_times(answer.to_dict()))


def every() -> Iterator[Case]:
    """The golden questions, and sweeps of which more is asked than what a diagnosis tells."""
    for make in CASES.values():
        yield from make()
    for case in CASES["diagnoses"]():
        if case.name in CLIMBED:
            for question in ("discover", "invent"):
                asked = (question, *case.arguments[1:])
                yield replace(case, name=f"{question}: {case.name}", arguments=asked)


def without_times(part: Any) -> Any:
    """A document without what no two runs share."""
    if isinstance(part, dict):
        return {key: without_times(value) for key, value in part.items() if key != "seconds"}
    if isinstance(part, list):
        return [without_times(value) for value in part]
    return part


def main(names: list[str]) -> None:
    """Print the answers."""
    sys.meta_path.insert(0, Absent())
    threading.Thread.start = refused  # type: ignore[method-assign]
    subprocess.Popen.__init__ = refused  # type: ignore[method-assign,assignment]
    os.fork = os.posix_spawn = refused
    for case in every():
        if case.name in names:
            with tempfile.TemporaryDirectory() as folder:
                print(told(case, Path(folder)))


if __name__ == "__main__":
    main(sys.argv[1:])
