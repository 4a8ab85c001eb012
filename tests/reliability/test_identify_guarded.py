"""``identify --optimiser`` is protected like a study.

What the optimiser does is one line, never a result.
"""

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from faulty_optimisers import MARK, left_behind

import springpot
from springpot.identification import Card, Objective, Optimiser

HERE = Path(__file__).parent
PROGRAM = """
import json, os, sys
sys.path.insert(0, {here!r})
import springpot.api
from faulty_optimisers import Faulty, Innocent
from springpot import registry
from springpot.cli import main
from springpot.identification import searching as guard

guard.DEADLINE, guard.MEMORY = 3.0, 512
find = registry.Registry.find
def finding(self, word, name):
    return made if word == "optimiser" else find(self, word, name)
for name, words in json.loads(sys.argv[1]):
    if os.fork() == 0:
        made = (lambda: Faulty(deed=name)) if name else Innocent
        registry.Registry.find = finding
        for stream in (1, 2):
            os.dup2(os.open(f"{{name}}.{{stream}}", os.O_WRONLY | os.O_CREAT), stream)
        main(words)
    print(os.waitstatus_to_exitcode(os.wait()[1]), flush=True)
"""
"""One command line after the other, each in a process of its own with all imports made."""
DATA = "artificial-fractional-maxwell"
ASKED = [
    "identify",
    DATA,
    "--model",
    "fractional-maxwell",
    "--optimiser",
    "x",
    "--budget",
    "300",
    "--json",
]
DEEDS = {
    "success without a result": "the process ended with exit code 0",
    "segfault": "the process was ended by SIGSEGV",
    "an error": "ValueError: out of",
    "sys.exit": "SystemExit: enough",
    "sleep": "it did not end within 3 s",
    "ask for nothing finite": "",
    "no exception": "NoException: neither",
    "leave a session": "it did not end within 3 s",
    "evaluate unseen": "points were evaluated past the recorder",
    "ask the user": "EOFError",
}


@dataclass(frozen=True)
class Done:
    """What came of a command."""

    returncode: int
    stdout: str
    stderr: str


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """What came of `identify` with each faulty optimiser and, unnamed, with the innocent one."""
    folder = tmp_path_factory.mktemp("guarded")
    commands = [(deed, ASKED) for deed in (*DEEDS, "shout", "leave an orphan")] + [
        ("", [*ASKED, "--seed", "3"])
    ]
    program = [sys.executable, "-c", PROGRAM.format(here=str(HERE)), json.dumps(commands)]
    # What is piped to the command is not for the optimiser.
    ran = subprocess.run(
        program,
        text=True,
        capture_output=True,
        cwd=folder,
        check=True,
        input="y\n" * 99,
        env=os.environ | {MARK: str(folder)},
    )
    codes = ran.stdout.split()
    assert left_behind(str(folder)) == []
    return {
        name: Done(int(code), *((folder / f"{name}.{stream}").read_text() for stream in (1, 2)))
        for (name, _), code in zip(commands, codes, strict=True)
    }


@pytest.mark.soak
@pytest.mark.parametrize(("deed", "told"), DEEDS.items())
def test_a_faulty_optimiser_is_one_line_and_no_result(done, deed, told):
    found = done[deed]
    if not told:
        assert found.returncode == 0
        return
    assert found.returncode == 2
    assert found.stdout == ""
    assert found.stderr.startswith("springpot: the optimiser faulty found nothing: ")
    assert found.stderr.count("\n") == 1
    assert told in found.stderr


@pytest.mark.soak
def test_what_an_optimiser_prints_is_not_in_the_json(done):
    found = done["shout"]
    assert found.returncode == 0
    assert json.loads(found.stdout)["schema"] == "springpot.identification/2"
    assert "{}{}" in found.stderr


@pytest.mark.soak
def test_an_innocent_optimiser_finds_what_it_finds_without_protection(done):
    one = json.loads(done[""].stdout)
    from faulty_optimisers import Innocent

    from springpot.identification import Problem, default_objective, run

    data = springpot.read(DATA)
    problem = Problem.of(springpot.parse_model("fractional-maxwell"), data, default_objective(data))
    alone = run(Innocent(), problem, 300, np.random.default_rng(3).spawn(1)[0])
    assert one["objective"]["value"] == alone.best
    assert one["evaluations"] == 300


def test_weights_that_are_no_numbers_are_one_line_that_names_the_objective():
    def nothing(data):
        return np.full(data.stiffness.shape, np.nan + 1j * np.nan)

    from faulty_optimisers import Innocent

    objective = Objective("nan", "nothing", nothing)
    for optimiser in (Innocent(), None):
        with pytest.raises(
            springpot.errors.PluginError, match="the objective 'nan' weighs points of"
        ):
            springpot.identify(DATA, "fractional-maxwell", optimiser=optimiser, objective=objective)


def test_a_restart_that_fails_is_a_note_where_another_finds_something():
    class Moody(Optimiser):
        name, card = "moody", Card("moody")

        def minimise(self, problem, budget, rng):
            problem(0.5 * (problem.lower + problem.upper))
            if rng.random() < 0.5:
                raise ValueError("not today")

    found = springpot.identify(DATA, "fractional-maxwell", optimiser=Moody(), restarts=8, seed=1)
    assert any(
        "of 8 restarts failed, the first: ValueError: not today" in note for note in found.notes
    )
