"""Faulty optimisers among innocent ones, on the local engine and on a dask cluster."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np
from dask_cluster import cluster
from faulty_optimisers import DEEDS, TOLD, TRUE, race
from soak import Row
from test_faulty_optimisers import trials

from springpot.benchmark import run_study

REPETITIONS = 12
"""Of each of four innocent optimisers: 48 innocent trials, as the adversary had."""


def rows(rng: np.random.Generator, scale: float) -> Iterator[Row]:
    """A row for what became of the faulty trials and one for the innocent, for each engine."""
    deeds = [
        str(deed) for deed in rng.permutation(list(DEEDS))[: max(2, round(scale * len(DEEDS)))]
    ]
    with TemporaryDirectory() as folder:
        yield from _race("local engine", "local", deeds, Path(folder))
    if find_spec("distributed") is None:
        yield Row("dask: left out, distributed is not installed", 0, 0)
        return
    with TemporaryDirectory() as folder, cluster(Path(folder)) as found:
        yield from _race("dask, two workers", f"dask:{found.address}", deeds, Path(folder))
        alive = sum(worker.poll() is None for worker in found.workers)
        yield Row("dask: workers of the cluster that are still there", 2, alive)


def _race(where: str, engine: str, deeds: list[str], folder: Path) -> Iterator[Row]:
    alone = run_study(
        race([], REPETITIONS), engine="serial", out=folder / "alone", quiet=True, tables=False
    )
    undisturbed = trials(alone.store)
    start = perf_counter()
    outcome = run_study(
        race(deeds, REPETITIONS), engine=engine, out=folder, quiet=True, tables=False
    )
    took = perf_counter() - start
    found = trials(outcome.store)
    status = {deed: [found[f"faulty {deed}", r] for r in range(REPETITIONS)] for deed in deeds}
    held = [deed for deed in deeds if all(_true_or_told(row) for row in status[deed])]
    told = sum(any(row[0] in TOLD for row in status[deed]) for deed in deeds)
    says = f"{told} told by a status, the others harmless to their numbers; {took:.0f} s"
    yield Row(
        f"{where}: kinds of faulty optimiser, {REPETITIONS} trials of each",
        len(deeds),
        len(held),
        says,
    )
    same = sum(found[key] == row for key, row in undisturbed.items())
    yield Row(f"{where}: innocent trials beside them, bit for bit", len(undisturbed), same)


def _true_or_told(row: tuple[object, ...]) -> bool:
    status, reason, best = row[:3]
    return (
        bool(reason)
        if status in TOLD
        else status in TRUE and isinstance(best, float) and best > 1e-6
    )
