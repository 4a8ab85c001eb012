"""What commands do with the shell around them: streams, Ctrl-C, a terminal; nothing is fitted."""

from __future__ import annotations

import io
import json
import os
import sys
from pathlib import Path
from threading import Event
from types import SimpleNamespace

import click
import pytest

import springpot.cli as shell
from springpot import api, loading
from springpot.cli import common, diagnose, discover, group, hints, init, invent


@pytest.mark.parametrize(("fd", "name"), [(0, "stdin"), (1, "stdout"), (2, "stderr")])
def test_a_stream_that_is_closed_goes_nowhere(fd, name, monkeypatch):
    """Whichever number the next file would get; streams that are open stay as they are."""
    given = {"stdin": io.StringIO(), "stdout": io.StringIO(), "stderr": io.StringIO(), name: None}
    opened, doubled, closed = [], [], []
    for key, stream in given.items():
        monkeypatch.setattr(sys, key, stream)
    monkeypatch.setattr(os, "open", lambda path, flags: 7)
    monkeypatch.setattr(os, "dup2", lambda *pair: doubled.append(pair))
    monkeypatch.setattr(os, "close", closed.append)
    monkeypatch.setattr(os, "fdopen", lambda *told, **more: opened.append((told, more)) or "none")
    shell._open_streams()
    found = {key: getattr(sys, key) for key in given}
    monkeypatch.undo()
    assert found == {**given, name: "none"}
    assert (doubled, closed) == ([(7, fd)], [7])
    assert opened == [((fd, "w" if fd else "r"), {"closefd": False})]


def test_a_stream_that_gets_its_own_number_is_left_open(monkeypatch):
    monkeypatch.setattr(sys, "stderr", None)
    monkeypatch.setattr(os, "open", lambda path, flags: 2)
    monkeypatch.setattr(os, "close", lambda fd: pytest.fail("it is closed"))
    monkeypatch.setattr(os, "fdopen", lambda *told, **more: "none")
    shell._open_streams()
    assert sys.stderr == "none"


@pytest.mark.parametrize("pressed", [True, False])
def test_an_import_that_fails_by_ctrl_c_ends_as_ctrl_c_does(pressed, monkeypatch):
    """A library turns the interruption into an error of its own."""
    monkeypatch.setattr(shell.CtrlC, "__init__", lambda self: setattr(self, "pressed", pressed))
    monkeypatch.setattr(shell.signal, "signal", lambda *given: None)
    monkeypatch.setitem(sys.modules, "springpot.cli.group", None)
    with pytest.raises(SystemExit if pressed else ImportError) as ended:
        shell.main([])
    assert not pressed or ended.value.code == 130


def ladder(steps):
    return SimpleNamespace(steps=list(range(steps)))


@pytest.mark.parametrize("steps", [(), (1,), (1, 3)])
def test_ctrl_c_costs_the_step_that_was_under_way_and_no_more(steps, monkeypatch, capsys):
    def interrupted(tests, model, *, reached, **more):
        for count in steps:
            reached(ladder(count))
        raise KeyboardInterrupt

    monkeypatch.setattr(api, "discover", interrupted)
    if not steps:
        with pytest.raises(KeyboardInterrupt):
            discover._climbed([], None)
        return
    found, code = discover._climbed([SimpleNamespace(name="one")], None)
    assert (len(found.steps), code) == (steps[-1], discover.INTERRUPTED)
    assert f"that of step {steps[-1] - 1}, the last one reached" in capsys.readouterr().err


def test_an_answer_that_is_whole_has_no_code(monkeypatch):
    monkeypatch.setattr(api, "discover", lambda tests, model, **more: "whole")
    assert discover._climbed([SimpleNamespace(name="one")], None) == ("whole", 0)


@pytest.mark.parametrize(
    ("name", "known", "told"),
    [("identify", None, True), (None, None, False), ("nothing", None, False), ("x", 1, False)],
)
def test_a_wrong_word_is_told_of_the_command_that_it_was_meant_for(name, known, told, monkeypatch):
    context = SimpleNamespace(invoked_subcommand=name)
    command = SimpleNamespace(name=name)
    monkeypatch.setattr(
        group.springpot,
        "get_command",
        lambda context, asked: command if asked in ("identify", "x") else None,
    )
    monkeypatch.setattr(click, "Context", lambda *given: given)
    error = click.UsageError("wrong")
    error.ctx = known
    with pytest.raises(click.UsageError), group._located(context):
        raise error
    assert error.ctx == ((command, context, name) if told else known)


class Terminal(io.StringIO):
    """A stream that may be a terminal, and says when something was written."""

    def __init__(self, tty):
        super().__init__()
        self.tty, self.written = tty, Event()

    def isatty(self):
        return self.tty

    def flush(self):
        self.written.set()


@pytest.mark.parametrize("tty", [True, False])
def test_a_stage_is_shown_in_place_on_a_terminal_and_gone_at_the_end(tty, monkeypatch):
    monkeypatch.setattr(hints, "PATIENCE", 0.005)
    monkeypatch.setattr(sys, "stderr", Terminal(tty))
    with hints.Waiting() as shown:
        shown.told("fitting a model")
        assert sys.stderr.written.wait(5.0)
    shown.told("what nobody waits for")
    text = sys.stderr.getvalue()
    lines = text.split("\r")
    if not tty:
        assert text == "fitting a model\n"
        return
    assert lines[1] == f"{'fitting a model, 0 s':{hints.window()}}"
    assert lines[-2:] == [" " * hints.window(), ""]


def test_nothing_is_written_over_where_nothing_was_shown(monkeypatch):
    monkeypatch.setattr(sys, "stderr", Terminal(True))
    with hints.Waiting() as shown:
        shown.told("fitting a model")
    assert sys.stderr.getvalue() == ""


@pytest.mark.parametrize("best", [None, SimpleNamespace(text="parallel: k*X")])
def test_a_law_is_taken_up_by_the_next_command_where_one_was_found(best):
    following = invent._next(SimpleNamespace(best=best), "a b.csv", "kelvin")
    if best is None:
        assert following == ""
    else:
        assert following.startswith("discover 'a b.csv' --model kelvin --accept ")


def test_what_cannot_be_written_is_told_before_a_law_is_looked_for(
    springpot, tmp_path, monkeypatch
):
    monkeypatch.setattr(api, "invent", lambda *given, **more: pytest.fail("it is looked for"))
    for words in (("-o", tmp_path / "no" / "law.json"), ("--figure", tmp_path / "law.doc")):
        assert springpot("invent", "artificial-hidden", *words).code == 2


def test_a_plugin_of_a_law_holds_it_as_it_was_found(monkeypatch):
    law = SimpleNamespace(expression="(law-1 = series: X^(-n)*k)")
    monkeypatch.setattr(loading, "law_of", lambda source, name: law)
    text = init.plugin_of(Path('a "law".json'))
    assert "'series: X^(-n)*k'" in text
    assert "a law.json" in text
    assert repr(init.LAW) in text
    compile(text, "plugin", "exec")


def test_only_a_plugin_is_made_of_a_law_and_no_file_is_replaced(springpot, tmp_path, monkeypatch):
    monkeypatch.setattr(init, "plugin_of", lambda source: "TEXT")
    law = tmp_path / "law.json"
    law.write_text("{}")
    for kind, code in (("plugin", 0), ("study", 2)):
        folder = tmp_path / kind
        answer = springpot("init", kind, "--from", law, "--folder", folder, "--json")
        assert answer.code == code, answer.err
    files = json.loads(springpot("init", "study", "--folder", tmp_path / "new", "--json").out)[
        "files"
    ]
    assert all(Path(name).exists() for name in files)
    assert springpot("init", "study", "--folder", tmp_path / "new").is_one_line("is not replaced")


def test_one_answer_is_spread_over_lines_and_of_several_each_is_one(capsys):
    for given, lines in (((), 3), ((False,), 3), ((True,), 1)):
        with click.Context(group.springpot):
            common.emit({"a": 1}, True, print, *given)
        assert len(capsys.readouterr().out.splitlines()) == lines
    with click.Context(group.springpot):
        common.emit({"a": 1}, False, lambda: print("words"), True)
    assert capsys.readouterr().out == "words\n"


@pytest.mark.soak_cases("1-command1", "2-command1", "3-command1")
@pytest.mark.parametrize("command", [("inspect",), ("identify", "-m", "kelvin")])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_answers_of_several_files_are_lines_for_programs_and_parted_for_people(
    command, count, springpot, damper, tmp_path
):
    """Of one the answer is spread over lines, and nothing stands before it."""
    data = [tmp_path / f"{i}.csv" for i in range(count)]
    for each in data:
        each.write_text(Path(damper).read_text())
    lines = springpot(command[0], *data, *command[1:], "--json").out.splitlines()
    assert (len(lines) == count) is (count > 1)
    for each in lines if count > 1 else ["".join(lines)]:
        assert isinstance(json.loads(each), dict)
    if command == ("inspect",):
        parts = springpot(*command, *data).out.split(": 15 points, 1 sweep\n")
        assert len(parts) == count + 1
        assert parts[0] == "0"
        assert [part.rpartition("\n\n")[2] for part in parts[1:-1]] == ["1", "2"][: count - 1]


@pytest.mark.parametrize(("named", "text"), [("aba", "a\n\nb\na\n"), ("a", "a\n")])
def test_a_blank_line_parts_answers_of_a_diagnosis(named, text, monkeypatch, capsys):
    monkeypatch.setattr(diagnose, "opened", lambda name, geometry: name)
    monkeypatch.setattr(diagnose.timetests, "named_tests", lambda data, geometry: None)
    inconclusive = SimpleNamespace(verdict="inconclusive")
    monkeypatch.setattr(diagnose, "_answer", lambda data, *_: print(*data) or inconclusive)
    group.run(["diagnose", *named, "-m", "kelvin"])
    assert capsys.readouterr().out == text
