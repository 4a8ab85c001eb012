"""Every place that shows a command to be copied is tried, and what it shows is taken.

`springpot.writing.suggested` makes all of them; a place without a scenario here fails.
"""

import ast
import importlib
import inspect
import re
import shlex
import sys
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import springpot as package
from springpot.benchmark.gate.baseline import SEPARATOR
from springpot.cli.group import commands as commands_of_springpot
from springpot.errors import SpringpotError
from springpot.measurement import Measurement
from springpot.measurement.covered import Covered
from springpot.registry import parse_model, plugins
from springpot.writing import suggested

ROOT = Path(package.__file__).parent
FILES = {
    "sweep.csv": "frequency [Hz],storage [Pa],loss [Pa]\n"
    + "".join(f"{f},{100 + f * f},{10 + f}\n" for f in (1, 2, 4, 8, 16, 32, 64)),
    "warm.csv": "frequency [Hz],storage [Pa],loss [Pa],temperature [degC]\n"
    + "".join(f"{f},{100 + f},{10 + f},{t}\n" for t in (20, 30) for f in (1, 2, 4, 8, 16)),
    "step.csv": "time [s],relaxation [Pa]\n0.1,3\n0.2,2\n0.4,1\n0.8,0.5\n1.6,0.4\n3.2,0.3\n",
    "record.csv": "time [s],displacement [mm],force [N]\n"
    + "".join(
        f"{0.01 * i:.2f},{np.sin(0.2 * i):.5f},{np.sin(0.2 * i + 0.3):.5f}\n" for i in range(400)
    ),
    "race.py": "from springpot.benchmark import Study\n"
    'study = Study("race", datasets=["artificial-springpot"], models=["own"],\n'
    '    objectives=["paper"], optimisers=["native"], repetitions=1, budget=50)\n',
}
"""Beside them, what only the user knows is what stands for it in a command."""
WORDS = {
    "EXPR": "maxwell",
    "STUDY.py": "race.py",
    "STUDY": "race.py",
    "FILE": "record.csv",
    "DATA": "warm.csv",
    "SWEEP": "sweep.csv",
    "my-model": "maxwell",
}


def nodes_of_files_with(word):
    """Files of the framework that hold a word, with their syntax."""
    for path in sorted(ROOT.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if word in text:
            yield path, list(ast.walk(ast.parse(text)))


def places():
    """Each function that calls `suggested`, with its file."""
    for path, nodes in nodes_of_files_with("suggested("):
        for node in nodes:
            if isinstance(node, ast.FunctionDef) and any(
                isinstance(call, ast.Call) and ast.unparse(call.func) == "suggested"
                for call in ast.walk(node)
            ):
                yield f"{path.relative_to(ROOT).as_posix()}:{node.name}"


def called(name):
    """A function of a module of springpot, also one of its own."""
    module, _, function = name.partition(":")
    words = module.removesuffix(".py").replace("/", ".")
    return getattr(importlib.import_module(f"springpot.{words}"), function)


def unknown_condition(_):
    covered = Covered((1.0, 10.0), {"temperature": (20.0, 20.0)})
    called("identification/prediction.py:require_known")(
        parse_model("maxwell"), covered, "temperature", np.array([90.0])
    )


def another_budget(_):
    store = SimpleNamespace(facts=lambda: {"budget": 1, "target": 1})
    before = SimpleNamespace(settings={"budget": 2, "target": 1})
    called("benchmark/gate/regression.py:compare")(before, store, Path("baseline.json"))


def new_cell(monkeypatch):
    module = sys.modules[called("benchmark/gate/regression.py:compare").__module__]
    samples = {SEPARATOR.join(["data", "model", "paper", "mine"]): ()}
    monkeypatch.setattr(module, "baseline_of", lambda _: SimpleNamespace(samples=samples))
    module._notes(SimpleNamespace(samples={}), [], None)


def too_large(_):
    def greedy():
        raise MemoryError

    called("files.py:within_budget")(Path("record.csv"), greedy)


def by_column(_):
    conditions = {"water": np.repeat([1.0, 2.0], 8)}
    omega = np.tile(np.geomspace(1.0, 100.0, 8), 2)
    data = Measurement(omega, omega + 1j, conditions=conditions)
    column = SimpleNamespace(name="water")
    assert list(
        called("diagnosis/notes.py:_by_column")(data, column, tuple(plugins().items("effect")))
    )


UNFIT = SimpleNamespace(sweep=None, standing=SimpleNamespace(good_enough=False))
ANSWER = SimpleNamespace(
    one_test="",
    offered="inertia",
    onward="next",
    verdict="adequate",
    leading=("inertia",),
    left_out={},
    best=SimpleNamespace(effect="inertia", model=parse_model("kelvin"), fails=True, unclear=False),
    turns=[],
)


def printing(name, *given):
    """A function that prints an answer, whose words are not looked at, and what follows it."""

    def action(monkeypatch):
        monkeypatch.setattr("springpot.report.told.told", lambda *_, **__: "")
        called(name)(*given)

    return action


def of_each_kind(name, *given, changes):
    """The same for answers that go on in another way."""

    def action(_):
        for change in changes:
            called(name)(SimpleNamespace(**{**vars(ANSWER), **change}), *given)

    return action


def after_discovery(_):
    ladder = {"steps": [], "model": parse_model("kelvin + inertia")}
    for change in ({}, {"one_test": "temperature=20"}, {"leading": (), "best": None}):
        diagnosis = SimpleNamespace(**{**vars(ANSWER), **change})
        called("cli/discover.py:_next")(
            SimpleNamespace(**ladder, diagnosis=diagnosis), ["warm.csv"], "kelvin", []
        )


def of_command(*words):
    return lambda _: words


def of_call(name, *given):
    return lambda _: called(name)(*given)


SCENARIOS = {
    "benchmark/coco_suite.py:postprocess": of_call(
        "benchmark/coco_suite.py:postprocess", Path(), Path("report")
    ),
    "benchmark/gate/baseline.py:read_baseline": of_call(
        "benchmark/gate/baseline.py:read_baseline", Path("none.json")
    ),
    "benchmark/gate/regression.py:_notes": new_cell,
    "benchmark/gate/regression.py:compare": another_budget,
    "benchmark/gate/regression.py:known_scripts": of_call(
        "benchmark/gate/regression.py:known_scripts", Path("none")
    ),
    "benchmark/store.py:_tell": lambda _: called("benchmark/store.py:Store")._tell(
        SimpleNamespace(_told=False, path=Path("race.sqlite")), "it is damaged"
    ),
    "cli/compare.py:_next_command": of_each_kind(
        "cli/compare.py:_next_command",
        "warm.csv",
        ["kelvin"],
        changes=({}, {"one_test": "temperature=20"}),
    ),
    "cli/diagnose.py:_next_command": of_each_kind(
        "cli/diagnose.py:_next_command",
        ["warm.csv"],
        None,
        ["warm.csv"],
        changes=(
            {},
            {"one_test": "temperature=20"},
            {"offered": ""},
            {"left_out": {"inertia": "another material could have done the same"}},
        ),
    ),
    "cli/discover.py:_next": after_discovery,
    "cli/identify.py:_show": printing(
        "cli/identify.py:_show", UNFIT, ("sweep.csv",), "maxwell", None, False
    ),
    "cli/init.py:_next": of_command("init", "study", "--folder", "my race"),
    "cli/signals.py:_show": of_command("signals", "record.csv", "-o", "sweep of it.csv"),
    "diagnosis/result.py:accepting": of_call("diagnosis/result.py:accepting", "inertia", True, 0.1),
    "diagnosis/result.py:leaving_out": of_call("diagnosis/result.py:leaving_out", [3, 5], 0.1),
    "diagnosis/result.py:leaving_out_the_beginning": of_call(
        "diagnosis/result.py:leaving_out_the_beginning", 0.3, 4
    ),
    "diagnosis/result.py:splitting": of_call("diagnosis/result.py:splitting", "temperature", 0.1),
    "diagnosis/result.py:turning": of_call("diagnosis/result.py:turning", "sweep.csv"),
    "diagnosis/notes.py:_by_column": by_column,
    "identification/prediction.py:require_known": unknown_condition,
    "loading.py:no_fit": of_call("loading.py:no_fit", "sweep.csv"),
    "files.py:within_budget": too_large,
    "measurement/opening.py:_named": of_command("inspect", "none"),
    "measurement/opening.py:_signals_by": of_command("signals", "sweep.csv"),
    "measurement/opening.py:problem": of_command("list", "suites", "springpot-60/zzz"),
    "registry.py:_proposal": of_command("identify", "sweep.csv", "--model", "zzz"),
    "report/inspection.py:in_time_text": of_command("inspect", "record.csv"),
    "report/inspection.py:next_step": of_command("inspect", "warm.csv"),
    "report/plugin_cards.py:optimiser": of_command("list", "optimisers"),
    "web/folders.py:_store_of": of_call("web/folders.py:_store_of", "none"),
    "web/tasks.py:dataset": of_call("web/tasks.py:dataset", None, "none"),
}
"""What makes each place show its command: a command line, or a call."""


class Reached(Exception):
    """The command is understood; what it computes is tested elsewhere."""


@pytest.fixture
def shown(monkeypatch):
    """Commands that were made, each with the place that made it."""
    made = []
    # All of them are there before: one that came later would keep what is put in its place.
    for place in SCENARIOS:
        called(place.partition(":")[0] + ":__name__")

    def recorded(*words):
        command = suggested(*words)
        frame = inspect.currentframe().f_back
        # What adds the options of the command that runs is not what suggests.
        while frame.f_code.co_name.startswith("<") or "hints" in frame.f_code.co_filename:
            frame = frame.f_back
        place = Path(frame.f_code.co_filename).relative_to(ROOT).as_posix()
        made.append((f"{place}:{frame.f_code.co_name}", command))
        return command

    monkeypatch.setattr("springpot.writing.suggested", recorded)
    for module in list(sys.modules.values()):
        if getattr(module, "suggested", None) is suggested and module.__name__ != __name__:
            monkeypatch.setattr(module, "suggested", recorded)
    return made


def test_every_place_that_suggests_has_a_scenario():
    assert set(places()) == set(SCENARIOS)


def test_no_command_is_written_out_anywhere_else():
    """But in help, whose examples are run by its own tests, and in prose of docstrings."""
    commands = "|".join(sorted(commands_of_springpot(), key=len, reverse=True))
    written = re.compile(rf"springpot (?:{commands})\b(?! needs)")
    found = []
    for path, nodes in nodes_of_files_with("springpot "):
        for node in nodes:
            if isinstance(node, ast.JoinedStr):
                parts = [getattr(part, "value", "") for part in node.values]
                if written.search("".join(part for part in parts if isinstance(part, str))):
                    found.append(f"{path.relative_to(ROOT)}: {ast.unparse(node)[:70]}")
    # What the page says first: the address is that of the workbench itself.
    assert [each for each in found if "springpot workbench: " not in each] == []


@pytest.mark.parametrize("place", SCENARIOS)
def test_what_is_suggested_is_taken(springpot, shown, monkeypatch, tmp_path, place):
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    with monkeypatch.context() as only_here, suppress(SpringpotError):
        asked = SCENARIOS[place](only_here)
        if isinstance(asked, tuple):
            springpot(*asked)
    commands = [command for where, command in shown if where == place]
    assert commands, shown

    def stop(*_, **__):
        raise Reached

    if place == "cli/init.py:_next":
        monkeypatch.chdir(tmp_path / "my race")
    for name in ("api.mastercurve", "benchmark.runner.run_study", "benchmark.exporting.export"):
        monkeypatch.setattr(f"springpot.{name}", stop)
    monkeypatch.setattr("springpot.benchmark.gate.regression.update", stop)
    for name in ("compare", "diagnose", "discover", "identify"):
        monkeypatch.setattr(f"springpot.api.{name}", stop)
        monkeypatch.setattr(f"springpot.timetests.{name}", stop)
    for command in dict.fromkeys(commands):
        _, *words = shlex.split(command)
        answer = springpot(*(WORDS.get(word, word) for word in words))
        taken = answer.code == 0 or "Reached" in answer.err or "pip install" in answer.err
        assert taken, f"{command}\n{answer.err}"


def test_commands_that_the_page_shows_are_there():
    """Its scripts hold them as text."""
    page = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "web/page").glob("*.js"))
    shown = set(re.findall(r"springpot ([a-z-]+) (?:[A-Z]{4,}\.\w+)", page))
    assert {"run", "workbench"} <= shown <= set(commands_of_springpot())
