"""What the promises of a study cost: the optimiser comparison in two checkouts, side by side.

    python tests/benchmarks/comparison_cost.py OTHER_CHECKOUT [TURNS] [REPEATS]

The two take turns. Times are processor times of all processes that a run has started, those that outlive their
parent too; Linux only.
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

HERE = Path(__file__).resolve().parents[2]
ADOPT = 36
"""PR_SET_CHILD_SUBREAPER of prctl(2): orphans become ours, and their times are told when they end."""


def seconds(checkout: Path, repeats: int) -> float:
    """Processor seconds of the study in one checkout."""
    paths = os.pathsep.join(str(checkout / folder) for folder in ("framework", "plugins"))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with TemporaryDirectory() as folder:
        command = ["-c", "import springpot.cli; springpot.cli.main()", "run", "studies/optimiser_comparison.py"]
        options = ["--repeats", str(repeats), "--workers", "2", "--quiet", "--out", folder]
        subprocess.run(
            [sys.executable, *command, *options],
            cwd=checkout,
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


def main(other: Path, turns: int, repeats: int) -> None:
    """Print the times of both and their ratio."""
    ctypes.CDLL(None).prctl(ADOPT, 1, 0, 0, 0)
    times = []
    for _ in range(turns):
        before, now = (seconds(checkout, repeats) for checkout in (other, HERE))
        print(f"there {before:.1f} s, here {now:.1f} s, ratio {now / before:.3f}", flush=True)
        times.append((before, now))
    least = np.min(times, axis=0)
    print(f"least of {turns}: there {least[0]:.1f} s, here {least[1]:.1f} s, ratio {least[1] / least[0]:.3f}")


if __name__ == "__main__":
    given = [int(text) for text in sys.argv[2:]]
    main(Path(sys.argv[1]).resolve(), *(given + [3, 2][len(given) :]))
