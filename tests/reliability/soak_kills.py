"""A study killed again and again.

Nothing is lost, nothing is double, and the end is bit for bit the same.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from time import monotonic, sleep

import numpy as np
from soak import Row
from test_faulty_optimisers import trials

from springpot.benchmark import Store, run_study
from springpot.errors import StudyError

KILLS = 50
PATIENCE = 60.0
"""Seconds in which a study must get on."""
SCRIPT = """
import sys
sys.path.insert(0, {here!r})
from dataclasses import dataclass, replace
from time import sleep
from faulty_optimisers import Innocent, race

@dataclass(frozen=True)
class Slow(Innocent):
    name = "slow"
    def minimise(self, problem, budget, rng):
        sleep({pause})
        super().minimise(problem, budget, rng)

study = replace(race([], {repetitions}), optimisers=[("a", Slow(0.2)), ("b", Slow(0.4))])
"""


def rows(rng: np.random.Generator, scale: float) -> Iterator[Row]:
    """A row each for what was kept at a kill, for the end, for what the killed left running."""
    kills = max(2, round(scale * KILLS))
    # So many trials, that the study is never done before the last kill.
    repetitions = 40 * kills
    with TemporaryDirectory() as name:
        folder = Path(name)
        script = folder / "killed.py"
        text = SCRIPT.format(
            here=str(Path(__file__).parent), pause="{pause}", repetitions=repetitions
        )
        script.write_text(text.format(pause=0.005))
        kept = sound = at_work = 0
        for i in range(kills):
            now = _killed(script, folder, rng, kept if i % 4 else -1)
            sound += now >= kept
            at_work += now > kept
            kept = now
        yield Row(
            "kill -9, nothing lost", kills, sound, f"{at_work} of them while trials were coming in"
        )
        left = _left_behind()
        yield Row("kill -9, no process left behind", kills, kills - left)
        outcome = run_study(script, out=folder, quiet=True, tables=False)
        script.write_text(text.format(pause=0.0))
        alone = run_study(
            _renamed(script), engine="serial", out=folder / "alone", quiet=True, tables=False
        )
        here, there = trials(outcome.store), trials(alone.store)
        same = sum(here.get(key) == row for key, row in there.items())
        yield Row("trials at the end, bit for bit those of an undisturbed study", len(there), same)
        yield Row("trials at the end, none double", len(there), len(here))


def _killed(script: Path, folder: Path, rng: np.random.Generator, least: int) -> int:
    """Trials that are kept after a run was killed, some time after more than `least` had been."""
    command = [
        sys.executable,
        "-m",
        "springpot",
        "run",
        str(script),
        "--out",
        str(folder),
        "--workers",
        "2",
        "--quiet",
    ]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    end = monotonic() + PATIENCE
    while least >= 0 and _count(folder) <= least and process.poll() is None and monotonic() < end:
        sleep(0.02)
    sleep(rng.uniform(0.0, 0.4))
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    return _count(folder)


def _count(folder: Path) -> int:
    try:
        with Store(folder / "faulty" / "faulty.sqlite") as store:
            return sum(len(rows) for _, rows in store.trials())
    except StudyError:
        return 0


def _renamed(script: Path) -> Path:
    """The same under another name: a process loads a script once."""
    other = script.with_name("undisturbed.py")
    other.write_text(script.read_text())
    return other


def _left_behind() -> int:
    """Servers of workers that run although nobody listens to them any more."""
    sleep(1.0)
    found = 0
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            command = (entry / "cmdline").read_bytes()
            parent = (entry / "stat").read_text().rsplit(")", 1)[1].split()[1]
        except OSError:
            continue
        found += b"springpot.benchmark.fork_server" in command and parent == "1"
    return found
