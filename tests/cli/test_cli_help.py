"""Help: it is there, it has an example, and it loads nothing heavy."""

import subprocess
import sys

import pytest

from springpot import __version__
from springpot.cli.group import commands

LISTS_MODULES = """
import sys
from springpot.cli import main
try:
    main(["--help"])
finally:
    print("\\n".join(sys.modules), file=sys.stderr)
"""


def test_help_loads_no_library_and_no_room():
    done = subprocess.run(
        [sys.executable, "-c", LISTS_MODULES], capture_output=True, text=True, check=True
    )
    loaded = set(done.stderr.split())
    assert "identify" in done.stdout
    assert {"springpot.cli.group", "click"} <= loaded
    heavy = {"numpy", "scipy", "pluggy", "rich", "matplotlib"}
    assert not heavy & loaded
    own = {name for name in loaded if name.startswith("springpot.")}
    tables = {name for name in own if name.endswith(".commands")}
    assert own - tables - {name.removesuffix(".commands") for name in tables} == {
        f"springpot.{name}" for name in ("cli", "cli.group", "errors", "lazy", "limits")
    }


@pytest.mark.parametrize("name", commands())
def test_every_command_has_an_example_and_json(springpot, name):
    answer = springpot(name, "--help")
    assert answer.code == 0
    assert f"Example: springpot {name}" in answer.out
    assert "--json" in answer.out


@pytest.mark.parametrize("name", commands())
def test_a_command_is_called_what_the_table_says(name):
    from springpot.cli.group import springpot as group

    assert group.get_command(None, name).name == name


def test_without_arguments_help_is_shown(springpot):
    answer = springpot()
    assert answer.code == 0
    assert answer.out == springpot("--help").out
    assert answer.out.startswith("Usage: springpot")


def test_version(springpot):
    assert springpot("--version").out == f"springpot {__version__}\n"
