"""Export to IOHanalyzer and iohinspector.

A folder for each optimiser, an index and improvements per problem.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from springpot.files import write_text

from .exported import Block, Export, blocks, created, left_out
from .rows import TrialRow
from .store import Store
from .trace import at

FORMAT = "0.3.5"
"""Version of the format; readers take files before 0.3.3 for an older one."""


def write_ioh(store: Store, folder: Path) -> Export:
    """Write a study as IOHprofiler data.

    Each problem is a function, each repetition an instance of it.
    """
    name = store.facts()["name"]
    files: list[Path] = []
    count = 0
    for block in blocks(store):
        where = created(folder / block.folder)
        stem = f"f{block.function}_{block.name}"
        data = (
            created(where / f"data_{stem}")
            / f"IOHprofiler_f{block.function}_DIM{block.dimension}.dat"
        )
        files.append(write_text(data, "".join(_lines(block))))
        index = _index(block, name, str(data.relative_to(where).as_posix()))
        files.append(
            write_text(where / f"IOHprofiler_{stem}.json", json.dumps(index, indent=1) + "\n")
        )
        count += len(block.trials)
    hint = (
        "upload a zip of a folder to IOHanalyzer, or iohinspector: DataManager().add_folder(FOLDER)"
    )
    return Export(folder, tuple(files), count, left_out(store), hint)


def _oracles(block: Block) -> bool:
    """Whether every trial knows what it was worth without noise."""
    return all(
        row.recommendations() is not None and row.oracle_trace() is not None for row in block.trials
    )


def _lines(block: Block) -> Iterator[str]:
    # All trials of a file have the same columns, or none of these.
    extra: tuple[str, ...] = ()
    if _oracles(block):
        extra = ("recommended", "oracle")
    head = " ".join(("evaluations", "raw_y", *extra)) + "\n"
    for row in block.trials:
        yield head
        evaluations, values = row.improvements()
        # Readers split runs where the evaluation is 1, and take the last one for the length of the
        # run.
        grid = np.union1d(evaluations, [1, row.evaluations])
        columns = [at(evaluations, values, grid)]
        if extra:
            for trace in (row.recommendations(), row.oracle_trace()):
                assert trace is not None
                columns.append(at(*trace, grid))
        for number, point in zip(grid.tolist(), np.column_stack(columns).tolist(), strict=True):
            yield " ".join([str(number), *map(_number, point)]) + "\n"


def _number(value: float) -> str:
    if not isfinite(value):
        # What is no number is told as the worst: its readers have no other word for it.
        return "inf"
    return f"{value:.16e}"


def _index(block: Block, study: str, data: str) -> dict[str, Any]:
    problem = block.cell.problem
    about = {
        "dataset": problem.dataset,
        "model": problem.model,
        "objective": problem.objective,
        "study": study,
        "budget": str(block.cell.budget),
    }
    return {
        "version": FORMAT,
        "suite": "springpot",
        "function_id": block.function,
        "function_name": block.name,
        "maximization": False,
        "algorithm": {"name": block.cell.label, "info": f"{block.cell.optimiser} in springpot"},
        "experiment_attributes": [{key: value} for key, value in about.items()],
        "run_attributes": ["gradients", "batched", "seconds"],
        "attributes": [
            "evaluations",
            "raw_y",
            *(("recommended", "oracle") if _oracles(block) else ()),
        ],
        "scenarios": [
            {
                "dimension": block.dimension,
                "path": data,
                "runs": [_run(block, row) for row in block.trials],
            }
        ],
    }


def _run(block: Block, row: TrialRow) -> dict[str, Any]:
    evaluations, values = row.improvements()
    best = {"evals": int(evaluations[-1]), "y": float(values[-1]), "x": list(row.theta.values())}
    return {
        "instance": row.repetition + 1,
        "evals": row.evaluations,
        "best": best,
        "gradients": row.gradients,
        "batched": row.batched,
        "seconds": row.seconds,
    }
