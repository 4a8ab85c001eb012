"""What strangers write never commands the terminal.

Not by file names, JSON, manifests, labels or errors.
"""

import io
import json
import os
import re
import subprocess
import sys
from time import sleep

import numpy as np
import pytest

from springpot.cli import hints
from springpot.cli.group import exit_code, run
from springpot.errors import DataError, PlainStream, below, plain, plain_json, plain_streams
from springpot.measurement import Measurement
from springpot.report.text import to_json

EVIL = "\x1b]0;owned\x07\x1b[2J\x9b31m\u202eevil\x7f"
IN_TEXT = "\x9d0;owned\x9c\x9b31m\u202eevil"
COMMANDS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
HEAD = "omega [rad/s],storage [Pa],loss [Pa]"
ROWS = "".join(f"{w},100,{2 * w}{{more}}\n" for w in range(1, 13))
"""A Kelvin element, in which there is nothing to be found.

What is told is looked at, not how it was come by.
"""


def file_with_evil_name(folder):
    path = folder / f"{EVIL}.csv".replace("/", "")
    path.write_text(f"{HEAD}\n{ROWS.format(more='')}")
    return path


def labels(folder):
    """Commands that a text file may hold: one with ESC is no text."""
    path = folder / "labels.csv"
    rows = ROWS.format(more=f",{IN_TEXT}")
    path.write_text(
        f"# {IN_TEXT}: {IN_TEXT}\n# operator: {IN_TEXT}\n{HEAD},sample {IN_TEXT}\n{rows}", "utf-8"
    )
    return path


def trios_json(folder):
    columns = [("Angular frequency", "rad/s"), ("Storage modulus", "Pa"), ("Loss modulus", "Pa")]
    headers = {
        str(i): {"DisplayName": name, "Unit": {"Name": unit}}
        for i, (name, unit) in enumerate(columns)
    }
    rows = [{"0": w, "1": 100.0, "2": 2.0 * w} for w in range(1, 13)]
    table = {"ColumnHeaders": headers, "Rows": rows, "Properties": {"Name": EVIL}}
    root = {
        "Sample": {"Name": EVIL},
        "StartTime": EVIL,
        "Results": [{"DataSet": table}, {"DataSet": table}],
    }
    path = folder / "trios.json"
    path.write_text(json.dumps({"TRIOSJSONExportSchema": EVIL, "Experiment": root}))
    return path


def unknown_columns(folder):
    path = folder / "unknown.csv"
    path.write_text(f"{EVIL},b {EVIL}\n1,2\n3,4\n")
    return path


FILES = (file_with_evil_name, labels, trios_json, unknown_columns)
COMMAND_LINES = (
    ["inspect"],
    ["inspect", "--json"],
    ["identify", "-m", "kelvin"],
    ["identify", "-m", "kelvin", "--json"],
    ["diagnose", "-m", "kelvin"],
    ["signals"],
)


@pytest.mark.soak_cases(
    "diagnose -m kelvin-file_with_evil_name",
    "diagnose -m kelvin-labels",
    "diagnose -m kelvin-trios_json",
)
@pytest.mark.parametrize("make", FILES, ids=lambda make: make.__name__)
@pytest.mark.parametrize("words", COMMAND_LINES, ids=" ".join)
def test_no_command_reaches_the_terminal(make, words, tmp_path, capsys):
    path = make(tmp_path)
    code = exit_code(lambda: run([words[0], str(path), *words[1:]]))
    said = capsys.readouterr()
    assert code in (0, 2), said
    assert not COMMANDS.search(said.out + said.err)
    assert said.out or said.err
    if code == 0 and "--json" in words:
        assert json.loads(said.out)


def test_a_manifest_and_its_folder_do_not_either(tmp_path, capsys, monkeypatch):
    from springpot_plugins.datasets import folders

    monkeypatch.setenv(folders.VARIABLE, str(tmp_path))
    escaped = "".join(f"\\u{ord(sign):04x}" for sign in EVIL)
    manifest = (
        f'file = "a.csv"\nsummary = "{escaped}"\nlicence = "{escaped}"\n'
        f'physics = ["{escaped}"]\n[columns]\n'
    )
    for name, text in (
        ("good", f'{manifest}"{escaped}" = "x"'),
        (f"broken {EVIL}", "= "),
        ("other", f"'{EVIL}"),
    ):
        (tmp_path / name).mkdir()
        (tmp_path / name / "dataset.toml").write_text(text)
    sets = folders.datasets()
    assert any("\x1b" in dataset.summary for dataset in sets), (
        "what is told apart is what was written"
    )
    from springpot.report import plugin_cards as cards

    kind = cards.KINDS["datasets"]

    def listing():
        for dataset in sets:
            print(cards.card(kind.describe(dataset)))
            print(to_json(kind.describe(dataset)))
        raise DataError(str(sets[0].name))

    assert exit_code(listing) == 2
    said = capsys.readouterr()
    assert "broken" in said.out
    assert not COMMANDS.search(said.out + said.err)


def test_errors_are_plain_without_the_command_line_too():
    error = DataError(f"{EVIL}: no")
    assert not COMMANDS.search(str(error))
    assert "\\x1b]0;owned" in str(error)
    assert not COMMANDS.search(repr(Measurement([1.0], [1 + 1j], name=EVIL)))


def test_json_means_the_same_and_every_program_can_read_it():
    value = {EVIL: [EVIL, "ω, °C, 温度", "\udc80"]}
    text = to_json(value)
    assert not COMMANDS.search(text.replace("\n", ""))
    assert json.loads(text) == value
    assert "ω, °C, 温度" in text
    text.encode()
    assert plain_json('"\\u001b"') == '"\\u001b"'


def test_ordinary_text_stays_as_it_is():
    for text in ("ω = 3 rad/s\t°C\n", "G'' ≥ 温度 ── é", ""):
        assert plain(text) == text
    assert plain("a\rb\x00") == "a\\rb\\x00"


def test_the_stream_is_still_a_stream(tmp_path):
    with (tmp_path / "out").open("w+") as stream:
        wrapped = PlainStream(stream)
        print("a\x1b[1mb", "c", file=wrapped, flush=True)
        wrapped.writelines(["\x9b", "d\n"])
        assert wrapped.fileno() == stream.fileno()
        assert wrapped.isatty() is False
        assert below(wrapped) is stream
        assert below(stream) is stream
    assert (tmp_path / "out").read_text() == "a\\x1b[1mb c\n\\x9bd\n"


class Terminal(io.StringIO):
    """Where people wait."""

    def isatty(self):
        return True


def test_progress_is_written_over_itself_and_still_plain(monkeypatch):
    """The return to the beginning of the line is ours; what stands in it may be a stranger's."""
    monkeypatch.setattr(hints, "PATIENCE", 0.01)
    shown = Terminal()
    monkeypatch.setattr(sys, "stderr", shown)
    with plain_streams(), hints.Waiting() as told:
        told.told(f"fitting {EVIL}")
        while "fitting" not in shown.getvalue():
            sleep(0.01)
    first, *lines = shown.getvalue().split("\r")
    assert first == ""
    assert not any(COMMANDS.search(line) for line in lines)
    assert "\\r" not in shown.getvalue()
    assert lines[-2:] == [" " * hints.window(), ""]


@pytest.mark.soak
@pytest.mark.skipif(not hasattr(os, "openpty"), reason="no terminals here")
def test_on_a_real_terminal_tables_are_ruled_and_still_plain(tmp_path):
    """What rich draws with is sent, what the file says is not.

    On a terminal the cells go another way.
    """
    path = labels(tmp_path)
    main, side = os.openpty()
    command = [sys.executable, "-c", "from springpot.cli import main; main()", "inspect", str(path)]
    with subprocess.Popen(
        command, stdout=side, stderr=side, env={**os.environ, "TERM": "xterm"}
    ) as process:
        os.close(side)
        said = b""
        while True:
            try:
                piece = os.read(main, 1 << 16)
            except OSError:
                break
            if not piece:
                break
            said += piece
        process.wait()
    os.close(main)
    text = said.decode()
    assert "storage" in text
    assert "0;owned" in text, "the words are shown"
    for evil in ("\x1b]0;", "\x1b[2J", "\x9b", "\u202e", "\x07", "\x7f"):
        assert evil not in text


def test_numbers_of_a_table_are_unharmed(tmp_path, capsys):
    path = labels(tmp_path)
    assert exit_code(lambda: run(["inspect", str(path), "--json"])) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["points"] == 12
    assert np.isclose(found["loss"]["to"], 24.0)
