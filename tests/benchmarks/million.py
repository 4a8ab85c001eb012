"""A million trials on a dask cluster of this machine, killed on the way and resumed.

    python tests/benchmarks/million.py [TRIALS [SECONDS]]

Two workers; the command is ended by SIGKILL after so many seconds and given again. Trials are as
short as they can be, so that what is measured is all that is not an optimiser's own: scheduler,
workers, supervisors, store, tables and report. Times are processor times of all processes.
"""

from __future__ import annotations

import os
import resource
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "reliability"))

from dask_cluster import cluster

STUDY = """
from springpot.benchmark import Study

study = Study(
    "many",
    ["artificial-springpot", "artificial-fractional-kelvin", "artificial-fractional-maxwell"],
    ["own"],
    ["paper"],
    ["random-search"],
    repetitions={repetitions},
    budget=10,
)
"""
DATA, TRIALS, SECONDS = 3, 1_000_000, 30.0


def processor(pids: Iterable[int]) -> float:
    """Seconds that processes and all that came of them have used."""
    found: dict[int, tuple[int, int]] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                words = (entry / "stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue  # gone meanwhile
            found[int(entry.name)] = int(words[1]), sum(map(int, words[11:15]))
    whose, ticks = set(pids), 0
    while new := {pid for pid, (parent, _) in found.items() if parent in whose} - whose:
        whose |= new
    ticks = sum(found[pid][1] for pid in whose if pid in found)
    return ticks / os.sysconf("SC_CLK_TCK")


def stored(path: Path) -> tuple[int, float]:
    """How many trials a store has, and seconds that their optimisers took."""
    with closing(sqlite3.connect(path)) as db:
        count, own = db.execute("SELECT COUNT(*), SUM(processor) FROM trial").fetchone()
    return int(count), float(own or 0.0)


def main(trials: int, seconds: float) -> None:
    """Print one row."""
    with TemporaryDirectory() as name, cluster(Path(name)) as running:
        folder = Path(name)
        script, store = folder / "many.py", folder / "many" / "many.sqlite"
        script.write_text(STUDY.format(repetitions=-(-trials // DATA)), encoding="utf-8")
        command = [sys.executable, "-m", "springpot", "run", str(script), "--quiet"]
        command += ["--engine", f"dask:{running.address}", "--out", str(folder)]
        there = [running.scheduler.pid, *(worker.pid for worker in running.workers)]
        start, before = perf_counter(), processor(there)
        first = subprocess.Popen(command)
        try:
            first.wait(seconds)
        except subprocess.TimeoutExpired:
            first.send_signal(signal.SIGKILL)
        first.wait()
        kept, _ = stored(store)
        subprocess.run(command, check=True)
        wall, cluster_time = perf_counter() - start, processor(there) - before
        count, own = stored(store)
        # Of the two commands alone: the cluster's processes have not been waited for yet.
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    command_time, memory = usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024
    beyond = 1e3 * (cluster_time + command_time - own) / count
    print(
        "| trials | kept at the kill | by the clock [s] | cluster [s] | command [s] |"
        " its memory [MiB] | optimisers' own [s] | beyond it [ms a trial] |"
    )
    print("|---:|---:|---:|---:|---:|---:|---:|---:|")
    print(
        f"| {count} | {kept} | {wall:.0f} | {cluster_time:.0f} | {command_time:.0f} |"
        f" {memory:.0f} | {own:.0f} | {beyond:.2f} |"
    )


if __name__ == "__main__":
    given = [float(word) for word in sys.argv[1:]]
    main(int(given[0]) if given else TRIALS, given[1] if len(given) > 1 else SECONDS)
