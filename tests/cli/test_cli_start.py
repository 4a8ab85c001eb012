"""What helps to begin: files to start from, and what the shell offers behind TAB."""

from importlib import import_module
from pathlib import Path

import pytest

from springpot.testing import check_effect, check_model


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
