"""The parts that need no numpy run in Pyodide, which brings its own and cannot be fetched here."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import pluggy
import pytest

import springpot

ROOT = Path(__file__).parents[2]
PYODIDE = ROOT / ".venv" / "node" / "node_modules" / "pyodide"
NODE = shutil.which("node")
OLDEST = 20
"""Version of Node from which Pyodide runs in it."""


def runs() -> bool:
    """Whether there is a Node that is new enough, and Pyodide."""
    if NODE is None or not PYODIDE.is_dir():
        return False
    told = subprocess.run([NODE, "--version"], capture_output=True, text=True).stdout
    return int(told.lstrip("v").partition(".")[0] or 0) >= OLDEST


pytestmark = pytest.mark.skipif(
    not runs(),
    reason="there is no Pyodide here: 'make pyodide'",
)
DISTRIBUTED = {"numpy", "scipy"}
"""What Pyodide brings along."""
APART = {"anywidget", "h11", "pytest", "resource", "starlette", "uvicorn"}
"""What guests need: the server, the notebook, contract tests, races."""


@pytest.mark.soak
def test_nothing_but_numpy_is_missing_where_python_runs_in_a_browser():
    site = Path(pluggy.__file__).parents[1]
    sources = Path(springpot.__file__).parents[1]
    script = Path(__file__).with_name("in_node.mjs")
    ran = subprocess.run(
        [str(NODE), str(script), str(PYODIDE), str(sources), str(site)],
        check=True,
        capture_output=True,
        text=True,
        timeout=120,
    )
    told = json.loads(ran.stdout)
    lacks = told["lacks"]
    assert set(lacks.values()) <= {None} | DISTRIBUTED | APART
    assert lacks["springpot.api"] == "numpy"
    pure = [name for name, missing in lacks.items() if missing is None]
    assert {"springpot.cli.diagnose", "springpot.errors", "springpot.plain_data"} <= set(pure)
    assert "springpot COMMAND --help" in told["help"]
