"""What helps to begin: files to start from, and what the shell offers behind TAB."""

import re
import subprocess
from importlib import import_module
from pathlib import Path

import pytest

import springpot as springpot_itself
from springpot.cli import init
from springpot.testing import check_effect, check_model, check_optimiser


@pytest.mark.parametrize("kind", ["study", "plugin", "ci"])
def test_files_are_written_once_and_never_replaced(springpot, tmp_path, kind):
    first = springpot("init", kind, "--folder", tmp_path / "new")
    assert first.code == 0, first.err
    assert first.out.splitlines()[-1].startswith("next: ")
    for path in (tmp_path / "new").rglob("*.py"):
        compile(path.read_text(), path, "exec")
    assert springpot("init", kind, "--folder", tmp_path / "new").is_one_line("exists already")


def test_the_study_to_start_from_is_one(springpot, tmp_path):
    from springpot.benchmark.summary import load_study

    springpot("init", "study", "--folder", tmp_path)
    study = load_study(tmp_path / "race.py")
    assert study.plan().cells


def test_the_plugin_to_start_from_keeps_the_contract(springpot, tmp_path, monkeypatch):
    springpot("init", "plugin", "--folder", tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    mine = import_module("springpot_mine")
    assert check_model(*mine.springpot_models()) == []
    assert check_effect(*mine.springpot_effects()) == []
    assert check_optimiser(*mine.springpot_optimisers()) == []


def test_the_gate_to_start_from_installs_the_users_package_and_says_what_got_worse(
    springpot, tmp_path
):
    springpot("init", "plugin", "--folder", tmp_path)
    springpot("init", "ci", "--folder", tmp_path)
    workflow = (tmp_path / ".github" / "workflows" / "accuracy.yml").read_text()
    assert re.search(r"python -m pip install (\S.* )?\.(  #.*)?\n", workflow)
    assert "cache-dependency-path: .github/workflows/accuracy.yml\n" in workflow
    script = re.findall(r"^ +sed -n '(.*)' gate.txt$", workflow, re.M)
    told = "seen: cma-es\nworse: mine on x got worse: 3\n"
    done = subprocess.run(["sed", "-n", *script], input=told, capture_output=True, text=True)
    assert done.stdout == "::error title=accuracy::mine on x got worse: 3\n"
    assert "GITHUB_STEP_SUMMARY" in workflow


def test_without_a_package_the_gate_installs_springpot_itself(springpot, tmp_path):
    springpot("init", "ci", "--folder", tmp_path)
    workflow = (tmp_path / ".github" / "workflows" / "accuracy.yml").read_text()
    assert "python -m pip install springpot" in workflow


def test_the_gate_races_the_study_that_is_there(springpot, tmp_path):
    (tmp_path / "race.py").write_text("mine")
    told = springpot("init", "ci", "--folder", tmp_path).out.splitlines()
    assert told[1] == f"kept:    {tmp_path / 'race.py'}, which was there"
    assert (tmp_path / "race.py").read_text() == "mine"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("identify", ".", "--model", "zener"), "this is a folder"),
        (("identify", "nist-srm2491", "-m", "zener", "--budget", "9"), "ends by itself"),
        (("identify", "nist-srm2491", "-m", "zener", "--optimiser", "pso"), "pso-paper"),
        (("diagnose", "nist-srm2491", "-m", "zener", "--effects", "bananas"), "list effects"),
        (("run", "X.zip"), "Give --optimiser NAME"),
        (("run", "race.py", "--optimiser", "native"), "a study names its own"),
    ],
)
def test_what_a_newcomer_types_is_answered_in_one_line(springpot, tmp_path, arguments, says):
    for name in ("X.zip", "race.py"):
        (tmp_path / name).write_text("anything")
    given = [tmp_path / each if "." in each[1:] else each for each in arguments]
    assert springpot(*given).is_one_line(says)


FROM_GIT = {"url": "https://x.org/s.git", "vcs_info": {"vcs": "git", "commit_id": "ab12"}}


@pytest.mark.parametrize(
    ("origin", "package", "installed"),
    [
        ({}, "", "springpot"),
        ({}, ".", "."),
        (FROM_GIT, "", '"springpot @ git+https://x.org/s.git@ab12"'),
        (FROM_GIT, ".", '"springpot @ git+https://x.org/s.git@ab12" .'),
        (
            {"url": "https://x.org/s-1.0.whl", "archive_info": {}},
            "",
            '"springpot @ https://x.org/s-1.0.whl"',
        ),
        (
            {"url": "file:///mine/s", "dir_info": {"editable": True}},
            ".",
            "springpot .  # springpot is from a folder here: write where it is to be found",
        ),
    ],
)
def test_the_gate_installs_springpot_from_where_it_came(origin, package, installed):
    assert init._addresses(origin, package) == installed


def test_a_study_to_start_from_races_the_users_own_optimisers(monkeypatch):
    registry = springpot_itself.plugins()
    monkeypatch.setitem(registry.shelves["optimiser"].items, "mine", object)
    monkeypatch.setattr(registry, "owner_of", lambda _, name: "my plugin" if name == "mine" else "")
    assert init._entrants() == '"mine", "pso-paper", "cma-es", "native"'


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        (("identify", "damper.csv", "--model", "fractional-z"), "fractional-zener"),
        (("diagnose", "damper.csv", "--model", "zener + iner"), "zener + inertia"),
        (("identify", "nist"), "nist-srm2491"),
        (("discover", "x", "--accept", "time-d"), "time-delay"),
        (("identify", "x", "--optimiser", "cma"), "cma-es"),
    ],
)
def test_the_shell_is_offered_names(words, offered):
    from click.shell_completion import ShellComplete

    from springpot.cli.group import springpot as group

    *before, incomplete = words
    found = ShellComplete(group, {}, "springpot", "_SPRINGPOT_COMPLETE").get_completions(
        before, incomplete
    )
    assert offered in [item.value for item in found]


def test_templates_are_installed():
    from importlib.resources import files

    from springpot.cli.init import KINDS

    for name in {template for kind in KINDS.values() for template in kind}:
        assert (files("springpot.cli") / "templates" / f"{name}.txt").is_file()
    assert '"cli/templates/*.txt"' in (Path(__file__).parents[2] / "pyproject.toml").read_text()
