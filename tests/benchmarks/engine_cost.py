"""What isolated trials cost and what a second worker gains.

Wall times, so the machine should be quiet.

    python tests/benchmarks/engine_cost.py

Each line is the median of five turns, the two sides taken by turns.
"""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time
from typing import ClassVar

import numpy as np

from springpot.benchmark import Study, run_study
from springpot.identification import Card, Optimiser, Recorder

TURNS, SHORT, LONG, MILLISECONDS = 5, 1000, 80, 50


@dataclass(frozen=True)
class Busy(Optimiser):
    """Computes for some milliseconds of processor time, then is content with one point."""

    milliseconds: int = 0

    name: ClassVar[str] = "busy"
    card: ClassVar[Card] = Card("busy")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Burn, then evaluate once."""
        end = process_time() + 1e-3 * self.milliseconds
        problem(problem.lower + rng.random(problem.dimension) * (problem.upper - problem.lower))
        while process_time() < end:
            pass


study = Study(
    "busy", ["artificial-springpot"], ["own"], ["paper"], [Busy()], repetitions=SHORT, budget=10
)


def seconds(declared: Study, workers: int | None) -> float:
    """Duration of a run without its start: that of all trials less that of one.

    Serial without workers.
    """

    def whole(repeats: int) -> float:
        with TemporaryDirectory() as folder:
            start = perf_counter()
            run_study(
                replace(declared, repetitions=repeats),
                workers,
                "local" if workers else "serial",
                out=Path(folder),
                quiet=True,
                tables=False,
            )
            return perf_counter() - start

    few = workers or 1
    return (whole(declared.repetitions) - whole(few)) / (declared.repetitions - few)


def main() -> None:
    """Print three lines."""
    sides: list[tuple[Study, int | None]] = [(study, None), (study, 1)]
    burning = replace(study, optimisers=[Busy(MILLISECONDS)], repetitions=LONG)
    sides += [(burning, 1), (burning, 2)]
    alone, isolated, one, two = np.median(
        [[seconds(*side) for side in sides] for _ in range(TURNS)], axis=0
    )
    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")
    print(f"a trial: {1e3 * alone:.2f} ms in this process, {1e3 * isolated:.2f} ms in a worker")
    print(f"isolation: {1e3 * (isolated - alone):.2f} ms a trial")
    print(
        f"trials of {MILLISECONDS} ms: one worker {1 / one:.1f}/s, two {1 / two:.1f}/s, "
        f"ratio {one / two:.2f}"
    )


if __name__ == "__main__":
    # The workers import what is defined here under its own name, not as the program.
    sys.path.insert(0, str(Path(__file__).parent))
    from engine_cost import main as imported

    imported()
