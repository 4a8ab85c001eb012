"""Stores of any size without the work: trials as a search with shrinking steps would leave them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, TypeAlias

import numpy as np
from benchmark_fakes import TRUTH, Walk, measurement

from springpot.benchmark import Store, Study
from springpot.benchmark.plan import Plan
from springpot.benchmark.runner import provenance
from springpot.benchmark.trial import Status, TrialResult, pack
from springpot.measurement import DataSet

BUDGET = 8000
FAILED = 0.01
BANK = 40

Results: TypeAlias = list[TrialResult]


@dataclass(frozen=True)
class Mock(Walk):
    """An entrant by number; it is never run."""

    number: int = field(default=0)

    name: ClassVar[str] = "mock"


def dataset(number: int) -> DataSet:
    """One of many artificial data sets."""
    name = f"mock-{number}"
    return DataSet(
        name,
        "mock data",
        lambda: measurement(0.0, name),
        kind="artificial",
        truth=TRUTH,
        model="fractional-kelvin",
    )


def plan_of(problems: int, entrants: int, repetitions: int) -> Plan:
    """A study of that size."""
    optimisers = [(f"mock-{i}", Mock(number=i)) for i in range(entrants)]
    data = [dataset(i) for i in range(problems)]
    return Study("mock", data, ["own"], ["paper"], optimisers, repetitions, BUDGET).plan()


def fallen(
    start: float, rate: float, rng: np.random.Generator, improvements: int = 150
) -> tuple[float, bytes]:
    """Last objective and packed trace of a search whose objective falls geometrically."""
    last = BUDGET * rng.uniform(0.5, 1.0)
    evaluations = np.unique(np.geomspace(1, last, improvements).astype(np.int64))
    values = start * np.exp(-rate * rng.uniform(0.5, 2.0) * np.cumsum(rng.random(len(evaluations))))
    return float(values[-1]), pack(list(zip(evaluations.tolist(), values.tolist(), strict=True)))


def results(
    cell: int, repetitions: int, bank: Sequence[tuple[float, bytes]], rng: np.random.Generator
) -> Results:
    """Trials of one cell, their traces drawn from a bank; some failed."""
    found = []
    for repetition in range(repetitions):
        if rng.random() < FAILED:
            found.append(
                TrialResult(cell, repetition, Status.ERROR, "ValueError: out of luck", seconds=0.1)
            )
            continue
        best, trace = bank[rng.integers(len(bank))]
        found.append(
            TrialResult(
                cell,
                repetition,
                Status.BUDGET,
                best=best,
                theta=dict(TRUTH),
                parameter_error=0.1,
                oracle=best,
                evaluations=BUDGET,
                seconds=0.1,
                trace=trace,
                recommended=b"",
                seen=b"",
            )
        )
    return found


def synthetic_store(
    path: Path, problems: int, entrants: int, repetitions: int, improvements: int = 150
) -> Path:
    """A store of problems x entrants x repetitions trials."""
    plan = plan_of(problems, entrants, repetitions)
    rng = np.random.default_rng(11)
    start = plan.cases[0].reference
    banks = [
        [fallen(start, rate, rng, improvements) for _ in range(BANK)]
        for rate in np.geomspace(0.05, 0.5, entrants)
    ]
    with Store(path, write=True) as store:
        numbers = store.register(plan, provenance(plan))
        for cell in plan.cells:
            store.add(results(cell.index, repetitions, banks[cell.entrant], rng), numbers)
    return path
