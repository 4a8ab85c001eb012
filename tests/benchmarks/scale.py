"""What many trials cost: size of the store, time and memory of the tables, as a Markdown table.

    python tests/benchmarks/scale.py [TRIALS ...]

Trials are made up (20 optimisers, 50 repetitions, 150 improvements each, one in a hundred failed);
each size is made and read in processes of its own, whose peak memory is told. Times are processor
times.
"""

from __future__ import annotations

import resource
import sys
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmark"))

from synthetic import synthetic_store

from springpot.benchmark import Store
from springpot.benchmark.standings import TABLES, study_tables

ENTRANTS, REPETITIONS = 20, 50
SIZES = (1000, 10_000, 100_000)


def tables(path: Path, names: tuple[str, ...], answer: Connection) -> None:
    """Send the seconds that some tables take, and the most memory [MiB] that was used by then."""
    start = process_time()
    with Store(path) as store:
        for _ in study_tables(store, names):
            pass
    answer.send((process_time() - start, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024))


def measured(path: Path, names: tuple[str, ...]) -> tuple[float, float]:
    """Seconds and MiB of some tables, in a process of their own."""
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=tables, args=(path, names, theirs))
    process.start()
    found: tuple[float, float] = ours.recv()
    process.join()
    return found


def main(sizes: list[int]) -> None:
    """Print one row for each size."""
    print(
        "| trials | store [MB] | bytes a trial | summary [s] | memory [MiB] | "
        "all tables [s] | memory [MiB] |"
    )
    print("|---:|---:|---:|---:|---:|---:|---:|")
    for trials in sizes:
        with TemporaryDirectory() as folder:
            path = Path(folder) / "mock.sqlite"
            synthetic_store(path, trials // (ENTRANTS * REPETITIONS), ENTRANTS, REPETITIONS)
            size = path.stat().st_size
            summary, little = measured(path, ("summary",))
            everything, most = measured(path, TABLES)
        figures = (f"{size / 1e6:.1f}", f"{size / trials:.0f}", f"{summary:.2f}", f"{little:.0f}")
        print(
            "|",
            " | ".join((str(trials), *figures, f"{everything:.2f}", f"{most:.0f}")),
            "|",
            flush=True,
        )


if __name__ == "__main__":
    main([int(float(word)) for word in sys.argv[1:]] or list(SIZES))
