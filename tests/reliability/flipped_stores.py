"""A store with one bit flipped, and what springpot makes of it."""

from __future__ import annotations

import contextlib
import io
import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from faulty_optimisers import Innocent, data

from springpot.benchmark import Store, Study, run_study
from springpot.benchmark.standings import study_tables
from springpot.errors import StudyError

SAME, NAMED, REFUSED, WRONG, FAULT = (
    "same tables",
    "named, the rest used",
    "one line",
    "other numbers",
    "a fault",
)
HARMLESS = (SAME, NAMED, REFUSED)


def study() -> Study:
    """A small one: 24 trials, most of its store are their traces."""
    entrants = [(f"innocent {i}", Innocent(0.1 * i)) for i in range(1, 5)]
    return Study("flips", [data()], ["own"], ["paper"], entrants, repetitions=6, budget=60)


@dataclass(frozen=True)
class Seen:
    """What a store says: every sound trial, and the lines told."""

    trials: dict[tuple[str, int], tuple[object, ...]]
    failed: int
    told: str


def look(path: Path) -> Seen:
    """Read all that a store holds, and make all of its tables."""
    told = io.StringIO()
    trials, failed = {}, 0
    with contextlib.redirect_stderr(told), Store(path) as store:
        labels = {cell.id: cell.label for cell in store.cells()}
        store.bests()
        for number, rows in store.trials():
            for row in rows:
                if number not in labels:
                    continue
                if row.status.failed:
                    failed += 1
                    continue
                evaluations, values = row.improvements()
                trials[labels[number], row.repetition] = (
                    row.status,
                    row.best,
                    row.theta_text,
                    row.oracle,
                    row.evaluations,
                    row.trace,
                    row.recommended,
                    row.seen,
                    tuple(evaluations),
                    tuple(values),
                )
        for _, table in study_tables(store):
            str(table)
    return Seen(trials, failed, told.getvalue())


def flip(whole: bytes, path: Path, rng: np.random.Generator) -> None:
    """Write the store with one bit of it flipped."""
    flipped = bytearray(whole)
    bit = int(rng.integers(8 * len(flipped)))
    flipped[bit // 8] ^= 1 << bit % 8
    path.write_bytes(flipped)


def verdict(path: Path, sound: Seen) -> str:
    """What became of a store that was flipped."""
    try:
        seen = look(path)
    except StudyError as error:
        return REFUSED if "\n" not in str(error) and path.name in str(error) else FAULT
    except Exception:
        return FAULT
    if not seen.trials.items() <= sound.trials.items():
        return WRONG
    if len(seen.trials) == len(sound.trials):
        return SAME
    return NAMED if seen.told.count("\n") == 1 and "--retry-failed" in seen.told else FAULT


def mended(path: Path, sound: Seen) -> bool:
    """Whether ``--retry-failed`` restores everything, or refuses in one line to touch the file."""
    before = path.read_bytes()
    try:
        with contextlib.redirect_stderr(io.StringIO()):
            run_study(
                study(),
                engine="serial",
                out=path.parents[1],
                quiet=True,
                retry_failed=True,
                tables=False,
            )
    except StudyError as error:
        # What no longer looks like a store of ours is left alone.
        return "\n" not in str(error) and path.read_bytes() == before
    again = look(path)
    return again.trials == sound.trials and not again.told and not again.failed


def pristine(folder: Path) -> tuple[Path, Seen]:
    """A sound store, and what it says."""
    path = run_study(study(), engine="serial", out=folder, quiet=True, tables=False).store
    return path, look(path)


def copy_of(path: Path, folder: Path) -> Path:
    """Where a copy of a store belongs in another folder of results."""
    target = folder / path.parent.name / path.name
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(path, target)
    return target
