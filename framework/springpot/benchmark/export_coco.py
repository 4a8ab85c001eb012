"""Export to COCO: one folder for each optimiser with the index and data files that cocopp reads.

COCO's targets are absolute, from 100 down to 1e-8, so what is written is the precision (f - f_best)
/ (g - f_best): one at the study's reference g, zero at the best that is known. On noisy data with a
known truth f is the noise-free objective, best of all that was evaluated so far, as COCO defines
its third column.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from springpot.files import write_text
from springpot.rheology.points import Real

from .coco_suite import NAMES, SUITE
from .exported import Block, Export, blocks, created, left_out
from .rows import TrialRow
from .store import Store
from .trace import at, geometric_grid

PRECISION = 1e-8
"""COCO's final target."""
_HEAD = (
    "% f evaluations | g evaluations | best noise-free fitness - Fopt (%13.12e) + sum g_i+ |"
    " measured fitness | best measured fitness or single-digit g-values | x1 | x2...\n"
)


@dataclass
class Scale:
    """How a problem's objective becomes a precision.

    Parameters
    ----------
    best, reference : float
        Objective with precision zero and with precision one.
    noise_free : bool
        Whether it is the noise-free objective.
    """

    best: float
    reference: float
    noise_free: bool

    def precision(self, values: Real) -> Real:
        """Precision (n,) of objectives (n,), never below zero."""
        room = self.reference - self.best
        # The reference itself may be the best that is known: then there is nothing to scale by.
        if not room > 0:
            room = 1.0
        scaled: Real = np.maximum(values - self.best, 0.0) / room
        return scaled


def write_coco(store: Store, folder: Path) -> Export:
    """Write a study as COCO data.

    Each problem is a function of the suite, each repetition an instance of it.
    """
    # Once through all trials beforehand: what is best of a problem is known only when all have been
    # seen.
    scales = _scales(store)
    files: list[Path] = []
    names: dict[int, str] = {}
    count = 0
    for block in blocks(store):
        where = created(folder / block.folder)
        scale = scales[block.cell.problem.id]
        data = (
            created(where / f"data_f{block.function}")
            / f"bbobexp_f{block.function}_DIM{block.dimension}.dat"
        )
        files.append(
            write_text(data, "".join(_text(row, scale, grid=False) for row in block.trials))
        )
        timed = data.with_suffix(".tdat")
        files.append(
            write_text(timed, "".join(_text(row, scale, grid=True) for row in block.trials))
        )
        index = _index(block, scale, data.relative_to(where).as_posix())
        files.append(write_text(where / f"bbobexp_f{block.function}.info", index))
        # cocopp shows numbers only: the names are kept beside them, for whoever reads its report.
        names[block.function] = block.name
        count += len(block.trials)
    lines = [f"{number} {name}\n" for number, name in sorted(names.items())]
    files.append(write_text(folder / NAMES, "".join(lines)))
    return Export(
        folder,
        tuple(files),
        count,
        left_out(store),
        f"python -m springpot.benchmark.coco_suite {folder}",
    )


def _scales(store: Store) -> dict[int, Scale]:
    """Scale of every problem by its number: noise-free if every trial of it knows that."""
    scales: dict[int, Scale] = {}
    lowest: dict[int, float] = {}
    made = {cell.problem.id for cell in store.cells() if cell.problem.known is not None}
    for block in blocks(store):
        problem = block.cell.problem
        scale = scales.setdefault(problem.id, Scale(block.best, problem.reference, True))
        for row in block.trials:
            trace = row.oracle_trace()
            # One trial without it, and the whole problem is told by its measured objective: a scale
            # must be one.
            scale.noise_free &= trace is not None
            least = inf
            if trace is not None:
                least = float(trace[1][-1])
            lowest[problem.id] = min(least, lowest.get(problem.id, inf))
    for number, scale in scales.items():
        if scale.noise_free:
            scale.best = lowest[number]
            # Where the model made the data, its noise-free objective ends at zero, reached or not.
            if number in made:
                scale.best = 0.0
    return scales


def _text(row: TrialRow, scale: Scale, grid: bool) -> str:
    """A run's lines: at improvements in the .dat file, at a geometric grid in the .tdat file."""
    measured, shown = row.improvements(), _shown(row, scale)
    # The first and the last evaluation too, so that the trace has both ends of the run.
    numbers: NDArray[np.int64] = np.union1d(shown[0], [1, row.evaluations])
    if grid:
        numbers = geometric_grid(row.evaluations)
    precision, best = scale.precision(at(*shown, numbers)), at(*measured, numbers)
    return _HEAD + "".join(_rows(numbers, precision, best))


def _rows(numbers: NDArray[np.int64], precision: Real, best: Real) -> Iterator[str]:
    for number, gap, value in zip(numbers.tolist(), precision.tolist(), best.tolist(), strict=True):
        yield f"{number} 0 {gap:+10.9e} {value:+10.9e} {value:+10.9e}\n"


def _index(block: Block, scale: Scale, data: str) -> str:
    """The .info file; without COCO's newest key ``settings``, at which iohinspector 0.0.8 fails."""
    keys = {
        "suite": f"'{SUITE}'",
        "funcId": block.function,
        "DIM": block.dimension,
        "Precision": f"{PRECISION:.3e}",
        "algId": f"'{block.folder}'",
        "coco_version": "'2.8.2'",
        "logger": "'bbob'",
        "data_format": "'bbob-new2'",
    }
    runs = ", ".join(
        f"{row.repetition + 1}:{row.evaluations}|{_final(row, scale):.1e}" for row in block.trials
    )
    objective = "objective"
    if scale.noise_free:
        objective = "noise-free objective"
    comment = (
        f"% {block.name}: (f - {scale.best!r}) / ({scale.reference!r} - {scale.best!r}), f the"
        f" {objective}"
    )
    return (
        ", ".join(f"{key} = {value}" for key, value in keys.items())
        + f"\n{comment}\n{data}, {runs}\n"
    )


def _shown(row: TrialRow, scale: Scale) -> tuple[NDArray[np.int64], Real]:
    """Evaluations and objectives of improvements, noise-free ones where every trial knows them."""
    if not scale.noise_free:
        return row.improvements()
    trace = row.oracle_trace()
    assert trace is not None
    return trace


def _final(row: TrialRow, scale: Scale) -> float:
    return float(scale.precision(_shown(row, scale)[1][-1:])[0])
