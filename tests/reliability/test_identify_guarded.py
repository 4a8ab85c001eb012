"""``identify --optimiser`` is protected like a study: what the optimiser does is one line, never a result."""

import json
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

import springpot
from springpot.identification import Card, Objective, Optimiser, guard

HERE = Path(__file__).parent
PROGRAM = """
import sys
sys.path.insert(0, {here!r})
from faulty_optimisers import Faulty, Innocent
from springpot import registry
from springpot.cli import main
from springpot.identification import guard

guard.DEADLINE, guard.MEMORY = 3.0, 512
find = registry.Registry.find
registry.Registry.find = lambda self, word, name: {made} if word == "optimiser" else find(self, word, name)
main(sys.argv[1:])
"""
DATA = "artificial-fractional-maxwell"


def command(made, *options):
    program = textwrap.dedent(PROGRAM.format(here=str(HERE), made=made))
    asked = ["identify", DATA, "--model", "fractional-maxwell", "--optimiser", "x", "--budget", "300", *options]
    return subprocess.run([sys.executable, "-c", program, *asked], text=True, capture_output=True)


@pytest.mark.parametrize(
    ("deed", "told"),
    [
        ("success without a result", "the process ended with exit code 0"),
        ("segfault", "the process was ended by SIGSEGV"),
        ("an error", "ValueError: out of"),
        ("sys.exit", "SystemExit: enough"),
        ("spin", "it did not end within 3 s"),
        ("ask for nothing finite", ""),
        ("forge the trace", "its best point has the objective"),
        ("no exception", "NoException: neither"),
    ],
)
def test_a_faulty_optimiser_is_one_line_and_no_result(deed, told):
    done = command(f"lambda: Faulty(deed={deed!r})", "--json")
    if not told:
        assert done.returncode == 0
        return
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("springpot: the optimiser faulty found nothing: ")
    assert done.stderr.count("\n") == 1
    assert told in done.stderr


def test_what_an_optimiser_prints_is_not_in_the_json():
    done = command("lambda: Faulty(deed='shout')", "--json")
    assert done.returncode == 0
    assert json.loads(done.stdout)["schema"] == "springpot.identification/1"
    assert "{}{}" in done.stderr


def test_an_innocent_optimiser_finds_what_it_finds_without_protection():
    one = json.loads(command("Innocent", "--json", "--seed", "3").stdout)
    from faulty_optimisers import Innocent

    from springpot.identification import Problem, default_objective, run

    data = springpot.read(DATA)
    problem = Problem.of(springpot.parse_model("fractional-maxwell"), data, default_objective(data))
    alone = run(Innocent(), problem, 300, np.random.default_rng(3).spawn(1)[0])
    assert one["objective"]["value"] == alone.best
    assert one["evaluations"] == 300


def test_values_that_are_never_finite_are_one_line():
    def nothing(data):
        return np.full(data.stiffness.shape, np.nan + 1j * np.nan)

    from faulty_optimisers import Innocent

    with pytest.raises(
        springpot.errors.OptionError, match="innocent found nothing: no finite value in 50 evaluations"
    ):
        springpot.identify(
            DATA,
            "fractional-maxwell",
            optimiser=Innocent(),
            budget=50,
            objective=Objective("nan", "nothing", nothing),
        )


def test_a_restart_that_fails_is_a_note_where_another_finds_something():
    class Moody(Optimiser):
        name, card = "moody", Card("moody")

        def minimise(self, problem, budget, rng):
            problem(0.5 * (problem.lower + problem.upper))
            if rng.random() < 0.5:
                raise ValueError("not today")

    found = springpot.identify(DATA, "fractional-maxwell", optimiser=Moody(), restarts=8, seed=1)
    assert any("of 8 restarts failed, the first: ValueError: not today" in note for note in found.notes)


def test_where_threads_run_the_record_is_checked_all_the_same(monkeypatch):
    from faulty_optimisers import Faulty

    monkeypatch.setattr(guard.threading, "active_count", lambda: 2)
    with pytest.raises(springpot.errors.OptionError, match="its best point has the objective"):
        springpot.identify(DATA, "fractional-maxwell", optimiser=Faulty(deed="forge the trace"), budget=60)
