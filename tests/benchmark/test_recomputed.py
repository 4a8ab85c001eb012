"""The tables of a study follow from its exported trials, as another program computes them."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest
import recomputed
from synthetic import synthetic_store
from test_whole_benchmark import filled, study

from springpot.benchmark.exporting import export
from springpot.benchmark.standings import write_tables


@pytest.fixture(scope="module", params=["seven problems", "failures, noise and two objectives"])
def folder(request, tmp_path_factory):
    """A store with its tables and its export."""
    folder = tmp_path_factory.mktemp("made")
    path = folder / "made.sqlite"
    if request.param == "seven problems":
        synthetic_store(path, 7, 4, 5)
    else:
        filled(path, study(2, 3, 6, ("paper", "log")).plan())
    write_tables(path, ["csv"])
    export(path, "csv", folder / "csv")
    return folder


@pytest.mark.soak_cases("seven problems")
def test_every_cell_is_what_numpy_makes_of_the_trials(folder):
    agree, wrong = recomputed.compared(folder / "csv", folder)
    assert wrong == []
    assert agree > 500


@pytest.mark.soak_cases("seven problems")
def test_a_cell_that_is_off_is_found(folder):
    table = folder / "pairs.csv"
    text = table.read_text(encoding="utf-8")
    table.write_text(re.sub(r",0\.(\d)", r",0.0\1", text, count=1), encoding="utf-8")
    _, wrong = recomputed.compared(folder / "csv", folder)
    table.write_text(text, encoding="utf-8")
    assert len(wrong) == 1


def test_it_knows_nothing_of_springpot():
    tree = ast.parse(Path(recomputed.__file__).read_text(encoding="utf-8"))
    names = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    names |= {a.name for node in ast.walk(tree) if isinstance(node, ast.Import) for a in node.names}
    assert names <= {"__future__", "csv", "sys", "itertools", "math", "pathlib", "numpy"}
