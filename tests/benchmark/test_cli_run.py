"""``springpot run`` and ``springpot tables``: a small study, run, resumed and tabulated."""

import csv
import re
import shlex
import subprocess
import sys
from io import StringIO
from pathlib import Path

import pytest

SCRIPT = """
import numpy as np
from springpot.benchmark import Study
from springpot.measurement import Measurement, Units

omega = np.geomspace(1.0, 100.0, 12)
springpot = 60.0 * (1j * omega) ** 0.5
stiffness = 1.0 / (1.0 / 900.0 + 1.0 / springpot)
data = Measurement(omega, stiffness, units=Units("kN/m", "mm"), name="damper")
study = Study("small", [data], ["fractional-maxwell"], ["paper"], ["random-search"],
              repetitions=2, budget=50)
"""

MOODY = """
from pathlib import Path
from springpot.identification import Card, Optimiser

class Moody(Optimiser):
    name, card = "moody", Card("fails until it is cured")

    def minimise(self, problem, budget, rng):
        if not Path("cured").exists():
            raise ValueError("ill")
        while True:
            problem(problem.lower + rng.random(problem.dimension) * (problem.upper - problem.lower))
"""


@pytest.fixture
def study(write, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return write(SCRIPT, "small.py")


def test_a_study_is_run_once_and_tabulated(springpot, study):
    first = springpot("run", study, "--engine", "serial", "--quiet", "--json")
    answer = first.json
    assert first.err == ""
    assert set(answer) == {"schema", "store", "trials", "ran", "failed", "tables", "report"}
    assert answer["schema"] == "springpot.run/1"
    assert (answer["trials"], answer["ran"], answer["failed"]) == (2, 2, 0)
    assert springpot("run", study, "--engine", "serial", "-q", "--json").json["ran"] == 0

    tables = springpot("tables", "small", "--json").json
    assert set(tables) == {"schema", "study", "tables"}
    [summary] = [table for table in tables["tables"] if table["name"] == "summary"]
    assert set(summary) == {"name", "title", "columns", "rows", "note"}
    assert dict(zip(summary["columns"], summary["rows"][0], strict=True))["trials"] == 2

    printed = springpot("tables", "small", "--format", "csv", "--table", "summary").out
    [row] = list(csv.DictReader(StringIO(printed)))
    assert row["optimiser"] == "random-search"
    written = springpot("tables", "small", "--write", "--format", "html", "--json").json["files"]
    assert all(path.endswith(".html") for path in written)


def test_failed_trials_are_run_again_if_asked(springpot, write, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = write(MOODY + SCRIPT.replace('["random-search"]', "[Moody()]"), "moody.py")
    moody = ("run", path, "--engine", "serial", "--quiet", "--json")
    assert springpot(*moody).json["failed"] == 2
    (tmp_path / "cured").write_text("")
    assert springpot(*moody).json["ran"] == 0
    again = springpot(*moody, "--retry-failed").json
    assert (again["ran"], again["failed"]) == (2, 0)


def test_bad_input_is_one_line(springpot, study, write):
    assert springpot("run", study, "--engine", "serial", "--quiet").code == 0
    assert springpot("run", study, "--engine", "nonsense").is_one_line(
        "unknown engine 'nonsense'", "dask:ADDRESS"
    )
    assert springpot("run", "none.py").is_one_line("none.py")
    assert springpot("run", study, "--budget", "0").is_one_line("--budget")
    assert springpot("run", study, "--workers", "2", "--engine", "serial").is_one_line(
        "--workers or --engine"
    )
    assert springpot("run", write("1 / 0", "broken.py")).is_one_line("line 1", "ZeroDivisionError")
    assert springpot("run", write("x = 1", "empty.py")).is_one_line("declares no study")
    assert springpot("tables", "nothing").is_one_line("run the study first")
    assert springpot("tables", "nothing", "--format", "doc").is_one_line("--format", "latex")


@pytest.fixture
def race(springpot, tmp_path, monkeypatch):
    """The study that 'springpot init study' writes, made short and run; its script."""
    monkeypatch.chdir(tmp_path)
    assert springpot("init", "study").code == 0
    script = tmp_path / "race.py"
    short = (
        script.read_text("utf-8")
        .replace("repetitions=20", "repetitions=2")
        .replace("budget=2000", "budget=100")
    )
    script.write_text(short, encoding="utf-8")
    assert springpot("run", script, "--engine", "serial", "-q", "--json").json["ran"] == 6
    return script


def examples(text, command):
    """The lines of a text that start with `springpot COMMAND`, rejoined, as arguments."""
    flat = " ".join(text.split())
    found = re.findall(rf"springpot {command} race [^`]*?(?= Options:|`|$)", flat)
    return [shlex.split(line)[1:] for line in found]


def test_the_examples_of_tables_and_exports_work_on_the_race_that_init_writes(springpot, race):
    recipes = (Path(__file__).parents[2] / "docs" / "recipes.md").read_text("utf-8")
    texts = [springpot("tables", "--help").out, recipes]
    tried = [line for text in texts for line in examples(text, "tables")]
    assert len(tried) == 3, tried
    for line in tried:
        printed = springpot(*line)
        assert printed.code == 0, (line, printed.err)
        assert "tabular" in printed.out
        if "--label" in line:
            assert r"\label{tab:race}" in printed.out
            assert "fractional-zener" not in printed.out
    [exported] = examples(springpot("export", "--help").out, "export")
    assert springpot(*exported).code == 0


def test_more_repetitions_of_that_race_run_the_new_ones_only(springpot, race):
    def run_with(repetitions):
        wanted = f"repetitions={repetitions},  # {'more ' * repetitions}"
        text = re.sub(r"repetitions=.*", wanted, race.read_text("utf-8"))
        race.write_text(text, encoding="utf-8")
        del sys.modules[
            "springpot_study_race"
        ]  # a script is executed once in a process; users start another
        return springpot("run", race, "--engine", "serial", "-q", "--json").json["ran"]

    kept = springpot("tables", "race", "--table", "summary", "--json").json
    assert run_with(3) == 3
    assert run_with(2) == 0
    assert springpot("tables", "race", "--table", "summary", "--json").json == kept


@pytest.mark.soak
def test_a_script_run_by_python_tells_the_command_as_it_was_written(springpot, race):
    """The report is handed on: a path of one machine repeats nothing on another."""
    done = subprocess.run(
        [sys.executable, race.name, "--engine", "serial", "-q"],
        cwd=race.parent,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    report = race.parent.joinpath("results", "race", "report.html").read_text("utf-8")
    assert "springpot run race.py" in report
    assert str(race.parent) not in report
