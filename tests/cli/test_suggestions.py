"""Every command that springpot suggests is one that it takes.

By its names, its quotes and its choices of rows.
"""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from springpot.registry import plugins

pytestmark = pytest.mark.usefixtures("asked_once")

FREQUENCY = np.geomspace(0.5, 50.0, 8).tolist()
COMMAND = re.compile(r"^(?:next|or, [^:]*): springpot (.*?)(?:   \(|$)", re.MULTILINE)
WITHIN = re.compile(r"""springpot (inspect (?:'[^']*'(?:"'"'[^']*')*))""")
OPENED = re.compile(
    r"""(?:open|by|or|write|by name or number:|such as|modulus:) ('/[^']*'(?:"'"'[^']*')*)"""
)
PLACEHOLDER = re.compile(r"(?:^|[ '/?,])[A-Z]{2,}(?:\.\w+)?(?=$|[ '#?,@=])")
"""A word in capitals stands for what only the user knows."""
WORDS = [
    "",
    "gel A",
    "Bob's gel",
    'the "good" one',
    "50 % @ 20",
    "which?",
    "no #2",
    "a, b",
    "a=b",
    "$HOME",
    "früh",
    "-x",
]


class Reached(Exception):
    """The command is understood and its data are open; its result is tested elsewhere."""


@pytest.fixture
def understood(monkeypatch, springpot, tmp_path):
    """Run a suggestion as far as its computation; its complaint, or nothing."""
    monkeypatch.chdir(tmp_path)

    def stop(*given, **named):
        raise Reached

    def complaint(command):
        monkeypatch.setattr("springpot.api.mastercurve", stop)
        for name in ("compare", "diagnose", "discover", "identify"):
            monkeypatch.setattr(f"springpot.api.{name}", stop)
            monkeypatch.setattr(f"springpot.timetests.{name}", stop)
        words = ["maxwell" if word == "EXPR" else word for word in shlex.split(command)]
        answer = springpot(*words)
        if answer.code == 0 or "Reached" in answer.err:
            return ""
        # Of a file that leaves something open this is what asks for it.
        if words[0] == "inspect" and Path(words[1]).exists():
            return ""
        return f"springpot {command}\n  {answer.err}"

    return complaint


def suggestions(*texts):
    """Commands in what was printed, and the opening of each file that was offered."""
    plain = "\n".join(texts)
    found = [match[1] for pattern in (COMMAND, WITHIN) for match in pattern.finditer(plain)]
    # Lines are broken at blanks, as in the name of a file.
    unbroken = re.sub(r"\n +", " ", plain)
    found += [f"inspect {match[1]}" for match in OPENED.finditer(unbroken)]
    return [
        command
        for command in dict.fromkeys(found)
        if not PLACEHOLDER.search(command.replace("EXPR", ""))
    ]


def file_of(folder, title, words, name="gel 1's #2.csv"):
    """The same sweep for each word of a column."""
    cells = ['"' + word.replace('"', '""') + '"' for word in words]
    rows = [f"{f!r},{100 + f!r},{10 + f!r},{cell}" for cell in cells for f in FREQUENCY]
    path = folder / name
    path.write_text("\n".join([f"frequency [Hz],storage [Pa],loss [Pa],{title}", *rows]) + "\n")
    return path


@pytest.mark.parametrize("word", WORDS)
def test_rows_of_any_word_are_chosen_by_what_is_suggested(springpot, understood, tmp_path, word):
    path = file_of(tmp_path, "comment", sorted({word, "zz"}))
    answer = springpot("inspect", path)
    found = suggestions(answer.out)
    assert any("@comment=" in command for command in found), answer.out
    assert [complaint for command in found if (complaint := understood(command))] == []


FILES = {
    "several temperatures": (
        "frequency [Hz],storage [Pa],loss [Pa],temperature [degC]\n"
        + "".join(f"{f},{100 + f},{10 + f},{t}\n" for t in (20, 30) for f in (1, 2, 4, 8, 16))
    ),
    "no units": "frequency,storage,loss\n1,2,3\n2,3,4\n4,5,6\n",
    "no frequency": "storage [Pa],loss [Pa],strain [%]\n1,2,3\n2,3,4\n4,5,6\n",
    "no names": "1,2,3\n2,3,4\n4,5,6\n8,9,9\n",
    "unknown unit": "omega [rad/s],storage [V],loss [V]\n1,2,3\n2,3,4\n4,5,6\n",
    "logarithms": "log omega,log G',log G''\n0,2,1\n1,3,2\n2,4,3\n",
    "a temperature in the name": "omega [rad/s],storage [Pa],loss [Pa]\n1,2,3\n2,3,4\n4,5,6\n",
    "two tables": 2 * "frequency [Hz],storage [Pa],loss [Pa]\n1,2,3\n2,3,4\n4,5,6\n\n",
    "the wrong sign": "omega [rad/s],storage [Pa],loss [Pa]\n1,-2,-3\n2,-3,-4\n4,-5,-6\n",
    "a step without units": "time,relaxation\n0.1,3\n0.2,2\n0.4,1\n0.8,0.5\n",
    "a step": "time [s],relaxation [Pa]\n0.1,3\n0.2,2\n0.4,1\n0.8,0.5\n",
    "a force alone": "time [s],Distance [mm],force [N]\n0,0,0\n1,1,1\n2,2,2\n3,3,3\n4,4,4\n",
    "no force": "time [s],displacement [mm]\n0,0\n1,1\n2,2\n3,3\n",
    "a record": (
        "time [s],displacement [mm],force [N]\n"
        + "".join(
            f"{0.01 * i:.2f},{np.sin(0.2 * i):.5f},{np.sin(0.2 * i + 0.3):.5f}\n"
            for i in range(200)
        )
    ),
    "a record of the wrong sign": (
        "time [s],displacement [mm],force [N]\n"
        + "".join(
            f"{0.01 * i:.2f},{np.sin(0.2 * i):.5f},{-np.sin(0.2 * i + 0.3):.5f}\n"
            for i in range(200)
        )
    ),
}


@pytest.mark.parametrize("name", ["my gel 20C's.csv", "50% #2?@x=1.csv"])
@pytest.mark.parametrize("what", FILES)
def test_what_is_suggested_of_a_file_is_taken(springpot, understood, tmp_path, what, name):
    path = tmp_path / name
    path.write_text(FILES[what])
    said = [springpot(verb, path) for verb in ("inspect", "signals")]
    found = suggestions(*(text for answer in said for text in (answer.out, answer.err)))
    assert [complaint for command in found if (complaint := understood(command))] == []


@pytest.mark.soak_cases("discover --accept inertia", "identify", "diagnose")
@pytest.mark.parametrize("asked", ["identify", "diagnose", "compare", "discover --accept inertia"])
def test_what_is_suggested_of_an_answer_is_taken(springpot, understood, damper, asked):
    path = damper.rename(damper.with_name("Bob's #1 @ 20.csv"))
    verb, *options = asked.split()
    answer = springpot(verb, path, "--model", "kelvin", *options)
    assert answer.code == 0, answer.err
    found = suggestions(answer.out, answer.err)
    assert found
    assert [complaint for command in found if (complaint := understood(command))] == []


def test_what_is_suggested_of_registered_data_is_taken(springpot, understood):
    names = [
        data.name
        for data in plugins().items("data set")
        if not data.unavailable and not data.remote
    ]
    found = {command for name in names for command in suggestions(springpot("inspect", name).out)}
    assert len(found) >= len(names) > 3
    assert [complaint for command in sorted(found) if (complaint := understood(command))] == []
