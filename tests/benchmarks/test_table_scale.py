"""Size of the store and time of the tables as trials become ten times as many.

In the soak, a hundred thousand.
"""

from __future__ import annotations

import sys
import zlib
from functools import cache
from pathlib import Path
from time import process_time

import numpy as np
import pytest
from patience import patient
from scale import measured

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmark"))

from synthetic import fallen, synthetic_store

from springpot.benchmark import Store
from springpot.benchmark.standings import TABLES, study_tables
from springpot.benchmark.trial import Traces

SHAPES = {
    1000: (2, 10, 50),
    2000: (4, 10, 50),
    10_000: (20, 10, 50),
    20_000: (20, 20, 50),
    100_000: (100, 20, 50),
}
"""Data sets, optimisers and repetitions of so many trials."""
SLACK = 2.0
"""Cost per trial at the largest size over that at the middle one; a quadratic cost would give 10.
"""


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """Where so many trials are kept."""
    folder = tmp_path_factory.mktemp("scale")

    @cache
    def made(trials):
        return synthetic_store(folder / f"{trials}.sqlite", *SHAPES[trials])

    return made


def seconds(path: Path, names: tuple[str, ...]) -> float:
    """Processor time of some tables."""
    with Store(path) as store:
        start = process_time()
        for _ in study_tables(store, names):
            pass
        return process_time() - start


@pytest.mark.soak_cases("1000-10000")
@pytest.mark.slow
@pytest.mark.parametrize(
    ("small", "large"),
    [(1000, 10_000), *(pytest.param(n, 10 * n, marks=pytest.mark.soak) for n in (2000, 10_000))],
)
@patient
def test_store_and_tables_grow_linearly(stored, capsys, small, large):
    stores = {trials: stored(trials) for trials in (1000, small, large)}
    sizes = {n: path.stat().st_size / n for n, path in stores.items()}
    summary = {n: seconds(path, ("summary",)) for n, path in stores.items()}
    everything = {n: seconds(path, TABLES) for n, path in stores.items()}
    with capsys.disabled():
        for n in stores:
            print(
                f"\n{n} trials: {sizes[n]:.0f} B each; summary {summary[n]:.2f} s, "
                f"all tables {everything[n]:.2f} s"
            )
    assert max(sizes.values()) < 1.1 * min(sizes.values())
    assert summary[large] / large < SLACK * summary[small] / small
    assert everything[large] / large < SLACK * everything[small] / small


@pytest.mark.benchmark(group="tables")
@pytest.mark.parametrize("name", ["summary", "choice"])
def test_one_table_of_ten_thousand_trials(benchmark, stored, name):
    trials = 10_000 if benchmark.enabled else 1000
    benchmark.pedantic(seconds, args=(stored(trials), (name,)), rounds=3)


MILLION, SHORT = (50, 20, 1000), 8
"""Data sets, optimisers and repetitions of a million trials, and improvements of each."""
MOST_SECONDS, MOST_MIB = 25.0, 280.0
"""Of all their tables: half as much again as on two cores with three other jobs."""


@pytest.mark.soak
@pytest.mark.slow
def test_a_million_trials_give_all_tables(tmp_path, capsys):
    path = synthetic_store(tmp_path / "million.sqlite", *MILLION, SHORT)
    taken, memory = measured(path, TABLES)
    with capsys.disabled():
        print(f"\na million trials: all tables {taken:.1f} s, {memory:.0f} MiB")
    assert taken <= MOST_SECONDS
    assert memory <= MOST_MIB


def unpacking(blobs: list[bytes]) -> float:
    """Processor time in which traces are unpacked, the least of five."""
    spent = []
    for _ in range(5):
        start = process_time()
        Traces.of(blobs)
        spent.append(process_time() - start)
    return min(spent)


@patient
def test_traces_are_unpacked_sooner_than_those_of_older_stores():
    rng = np.random.default_rng(1)
    blobs = [fallen(1.0, 0.1, rng)[1] for _ in range(200)]
    older = [zlib.compress(zlib.decompress(blob), 6) for blob in blobs]
    assert sum(map(len, blobs)) < 1.05 * sum(map(len, older))
    assert unpacking(blobs) < 0.55 * unpacking(older)
