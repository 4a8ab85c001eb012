"""What each promise of a study costs, in the time of the optimiser comparison.

    python tests/benchmarks/comparison_cost.py [TURNS] [PROMISE ...]

The promises are those of docs/reliability.md that a study pays for: for each trial, for each
process, or once. What one costs is the difference that it makes to the same study with a budget of
a few evaluations, where nothing else takes long; runs with and without it take turns. The share is
that of the whole comparison with one repetition, in which a process does the fewest trials. Times
are processor times of all processes that a run has started, those that outlive their parent too;
Linux only.
"""

from __future__ import annotations

import ctypes
import os
import resource
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

HERE = Path(__file__).resolve()
ROOT = HERE.parents[2]
ADOPT = 36
"""PR_SET_CHILD_SUBREAPER of prctl(2): orphans become ours, and their times are told when they end.
"""
PROMISES = {
    "own-processes": "supervisor.Backlog.entrant_of = lambda self, task: 0",
    "settings": "fork_server.settings = tuple",
    "children": "fork_server.end_children = int",
    "seals": "store.seal = lambda values: b''; store.sound = store.whole = lambda *_: True",
    "derivatives": "problem.require_derivative = lambda *_: None",
}
"""What leaves each of them out.

A line of a script, which coordinator and workers run before anything else.
"""
SCRIPT = """
import sys
sys.path.insert(0, {studies!r})
from springpot.benchmark import fork_server, store, supervisor
from springpot.identification import problem
{lines}
from optimiser_comparison import study
"""


FEW = 20
"""Evaluations of each trial where only what surrounds it is to be timed."""


def seconds(promises: list[str], *options: str) -> float:
    """Processor seconds of the study without some promises."""
    paths = os.pathsep.join(str(ROOT / folder) for folder in ("framework", "plugins", "studies"))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with TemporaryDirectory() as folder:
        script = Path(folder, "comparison.py")
        lines = "\n".join(PROMISES[name] for name in promises)
        script.write_text(SCRIPT.format(studies=str(ROOT / "studies"), lines=lines))
        command = ["-m", "springpot", "run", str(script), "--repeats", "1", "--workers", "2"]
        subprocess.run(
            [sys.executable, *command, "--quiet", "--out", folder, *options],
            env=os.environ | {"PYTHONPATH": paths},
            check=True,
            stdout=subprocess.DEVNULL,
        )
        while True:
            try:
                os.wait()
            except ChildProcessError:
                break
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main(turns: int, names: list[str]) -> None:
    """Print what each promise costs, and all of them together."""
    ctypes.CDLL(None).prctl(ADOPT, 1, 0, 0, 0)
    seconds([], "--budget", str(FEW))  # the first run reads everything from the disk
    whole = seconds([])
    print(f"the whole comparison: {whole:.1f} s", flush=True)
    left_out = {name: [name] for name in names} | {"all of these": names}
    for name, promises in left_out.items():
        costs = []
        for turn in range(turns):
            pair = {}
            # Whoever comes first finds the machine as the last one left it: they change places.
            for without in [promises, []] if turn % 2 else [[], promises]:
                pair[bool(without)] = seconds(without, "--budget", str(FEW))
            costs.append(pair[False] - pair[True])
        low, middle, high = np.quantile(costs, [0.25, 0.5, 0.75])
        says = f"{middle:.2f} s [{low:.2f}, {high:.2f}], {100 * middle / whole:.1f} %"
        print(f"{name}: {says}", flush=True)


if __name__ == "__main__":
    numbers = [int(text) for text in sys.argv[1:] if text.isdigit()]
    named = [text for text in sys.argv[1:] if not text.isdigit()]
    main(numbers[0] if numbers else 7, named or list(PROMISES))
