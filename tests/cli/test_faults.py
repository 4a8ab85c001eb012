"""How a command ends: one line, the right exit code, no traceback unless asked for."""

import os
import subprocess
import sys

import click
import pytest

from springpot.cli.group import exit_code
from springpot.errors import DataError


def _raise(error):
    def action():
        raise error

    return action


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (DataError("bad.csv: no rows"), 2, "springpot: bad.csv: no rows\n"),
        (DataError("first\n  second"), 2, "springpot: first second\n"),
        (
            click.UsageError("No such option '--x'."),
            2,
            "springpot: no such option '--x' (see 'springpot --help')\n",
        ),
        (KeyboardInterrupt(), 130, ""),
        (click.Abort(), 130, ""),
    ],
)
def test_errors_are_one_line(capfd, error, code, said):
    assert exit_code(_raise(error)) == code
    assert capfd.readouterr() == ("", said)


def test_a_fault_names_itself_and_how_to_see_more(capfd, monkeypatch):
    monkeypatch.delenv("SPRINGPOT_TRACEBACK", raising=False)
    assert exit_code(_raise(ZeroDivisionError("division\nby zero"))) == 3
    said = capfd.readouterr().err
    assert said.count("\n") == 1
    assert "ZeroDivisionError: division by zero" in said
    assert "SPRINGPOT_TRACEBACK=1" in said


def test_a_fault_shows_its_traceback_when_asked(capfd, monkeypatch):
    monkeypatch.setenv("SPRINGPOT_TRACEBACK", "1")
    assert exit_code(_raise(ZeroDivisionError("by zero"))) == 3
    assert "Traceback" in capfd.readouterr().err


def test_the_answer_of_a_command_is_its_exit_code():
    assert exit_code(lambda: 1) == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["lst"], ["unknown command 'lst'", "did you mean list?"]),
        (["zzz"], ["unknown command 'zzz'", "identify"]),
        (["list", "foo"], ["'foo'", "'models'", "springpot list --help"]),
        (["list"], ["missing argument", "kind"]),
        (["list", "models", "--jsn"], ["no such option", "--json"]),
        (
            ["list", "models", "fractional-zenner"],
            ["unknown model 'fractional-zenner'", "fractional-zener"],
        ),
    ],
)
def test_wrong_usage_is_one_line_with_a_hint(springpot, arguments, words):
    assert springpot(*arguments).is_one_line(*words)


@pytest.mark.soak
def test_a_reader_that_goes_away_is_no_error():
    script = f"{sys.executable} -m springpot list models --json | true; echo ${{PIPESTATUS[0]}}"
    done = subprocess.run(
        ["bash", "-c", script], capture_output=True, text=True, env=os.environ, check=True
    )
    # Quiet whether or not the listing was written before the reader left.
    assert done.stderr == ""
    assert done.stdout.strip() in {"0", "141"}
