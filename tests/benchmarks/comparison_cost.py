"""What the promises of a study cost: the optimiser comparison with and without them, side by side.

    python tests/benchmarks/comparison_cost.py [TURNS] [REPEATS] [PROMISE ...]

The promises are those of docs/reliability.md that a study pays for; all of them are left out unless some are named.
With and without take turns. Times are processor times of all processes that a run has started, those that outlive
their parent too; Linux only.
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
"""PR_SET_CHILD_SUBREAPER of prctl(2): orphans become ours, and their times are told when they end."""
PROMISES = {
    "own-processes": "supervisor.Backlog.entrant_of = lambda self, task: 0",
    "canary": "canary.Witness.of = classmethod(lambda cls, problem: cls('', ''))",
    "audit": "audit.Audit.__call__ = lambda self, task, results: list(results)",
    "settings": "worker.settings = tuple",
    "children": "worker.end_children = int",
    "seals": "store.seal = lambda values: b''; store.sound = store.whole = lambda *_: True",
    "derivatives": "problem.require_derivative = lambda *_: None",
}
"""What leaves each of them out: a line of a script, which coordinator and workers run before anything else."""
SCRIPT = """
import sys
sys.path.insert(0, {studies!r})
from springpot.benchmark import audit, canary, store, supervisor, worker
from springpot.identification import problem
{lines}
from optimiser_comparison import study
"""


def seconds(promises: list[str], repeats: int) -> float:
    """Processor seconds of the study without some promises."""
    paths = os.pathsep.join(str(ROOT / folder) for folder in ("framework", "plugins", "studies"))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with TemporaryDirectory() as folder:
        script = Path(folder, "comparison.py")
        lines = "\n".join(PROMISES[name] for name in promises)
        script.write_text(SCRIPT.format(studies=str(ROOT / "studies"), lines=lines))
        command = ["-m", "springpot", "run", str(script), "--repeats", str(repeats), "--workers", "2"]
        subprocess.run(
            [sys.executable, *command, "--quiet", "--out", folder],
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


def main(turns: int, repeats: int, promises: list[str]) -> None:
    """Print the times of both and their ratio."""
    ctypes.CDLL(None).prctl(ADOPT, 1, 0, 0, 0)
    times = []
    for turn in range(turns):
        pair = {}
        # Whoever comes first finds the machine as the last one left it: they change places.
        for without in [promises, []] if turn % 2 else [[], promises]:
            pair[bool(without)] = seconds(without, repeats)
        times.append((pair[True], pair[False]))
        print(_line(*times[-1]), flush=True)
    print(f"least of {turns}: {_line(*np.min(times, axis=0))}")


def _line(without: float, full: float) -> str:
    return f"without {without:.1f} s, with {full:.1f} s, ratio {full / without:.3f}"


if __name__ == "__main__":
    numbers = [int(text) for text in sys.argv[1:] if text.isdigit()]
    named = [text for text in sys.argv[1:] if not text.isdigit()]
    main(*(numbers + [3, 2][len(numbers) :]), named or list(PROMISES))
