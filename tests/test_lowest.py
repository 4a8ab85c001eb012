"""The lowest versions that are declared are those that 'make lowest' tries."""

from __future__ import annotations

import re
import tomllib
from itertools import chain
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
USED = ("figures", "instruments", "download", "data", "workbench")
"""Extras whose lowest versions are tried, as in the Makefile."""
TESTERS = ("pytest", "pytest-benchmark", "hypothesis", "jsonschema", "xlwt")


def declared() -> dict[str, set[str]]:
    """The lowest versions of each library that pyproject.toml asks for, wherever it does."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    wanted = [*project["dependencies"], *chain.from_iterable(extras[name] for name in USED)]
    wanted += [line for line in extras["dev"] if line.partition(">=")[0] in TESTERS]
    lowest: dict[str, set[str]] = {}
    for line in wanted:
        name, _, version = line.partition(">=")
        lowest.setdefault(name, set()).add(version)
    return lowest


def test_what_is_tried_is_what_is_declared():
    lines = (ROOT / "constraints-lowest.txt").read_text(encoding="utf-8").splitlines()
    pinned = dict(line.split("==") for line in lines if not line.startswith("#"))
    assert {name: {version} for name, version in pinned.items()} == declared()


def test_the_makefile_installs_these():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert f"USED := {','.join(USED)}" in makefile
    assert f"TESTERS := {' '.join(TESTERS)}" in makefile


def test_one_library_has_one_lowest_version():
    """An extra and the tests ask for the same."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lowest: dict[str, set[str]] = {}
    for line in chain(project["dependencies"], *project["optional-dependencies"].values()):
        found = re.fullmatch(r"([\w-]+)(?:\[[\w,]+\])?>=([\d.]+)", line)
        if found:
            lowest.setdefault(found[1], set()).add(found[2])
    assert {name for name, versions in lowest.items() if len(versions) > 1} == set()
