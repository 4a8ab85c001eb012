"""Results as columns: what CSV, Parquet and data frames are made of."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from springpot.errors import StudyError

from .archive import opened
from .comparison import JudgingScale, judged, reference_of
from .statistics import goal_of, hitting_time
from .store import Store
from .study import Study
from .summary import CellRow, TrialRow, store_path
from .trial import at, geometric_grid

Columns = dict[str, list[Any]]
"""Values by column, all of one length; None where there is nothing to say."""

_WHO = ("dataset", "kind", "model", "objective", "optimiser", "options", "budget", "repetition")
TRIAL = (
    *_WHO,
    *("status", "reason", "best", "oracle", "parameter_error", "theta"),
    *("evaluations", "gradients", "batched", "seconds", "processor", "processor_batched"),
    *("reference", "f_best", "target", "hit", "covered"),
)
TRACE = (*_WHO, "evaluations", "best", "recommended", "oracle")


def trial_columns(store: Store) -> Columns:
    """One row for each trial; a failed one has a reason and no values.

    ``reference``, ``f_best`` and ``target`` are the objectives by which it is judged, ``hit`` the
    evaluation at which it reached the target: who has these can compute every table anew.
    """
    scale = JudgingScale.of(store)
    rows = (
        _trial(cell, row, float(best), scale)
        for cell, trials, bests in judged(store)
        for row, best in zip(trials, bests, strict=True)
    )
    return _filled(TRIAL, rows)


def trace_columns(store: Store) -> Columns:
    """One row for each point of each trial's trace: the geometric grid and every improvement.

    ``best`` is the smallest objective so far, ``recommended`` what that point is worth without
    noise, ``oracle`` the smallest noise-free objective among all that was evaluated so far; the
    last two only where the truth is known.
    """
    points = (point for cell, rows in store.raced() for row in rows for point in _points(cell, row))
    return _filled(TRACE, points)


TABLES: dict[str, Callable[[Store], Columns]] = {"trials": trial_columns, "traces": trace_columns}


def frame(
    study: Study | str | Path,
    library: str = "pandas",
    what: str = "trials",
    out: Path = Path("results"),
) -> Any:
    """A study's results as a data frame.

    Parameters
    ----------
    study : Study, str or Path
        A study, its script, its store, its archive, its folder, or its name.
    library : str
        ``pandas`` or ``polars``, which must be installed.
    what : str
        ``trials`` (one row for each) or ``traces`` (one row for each point of them).
    out : Path
        Folder of all results.

    Returns
    -------
    pandas.DataFrame or polars.DataFrame

    Raises
    ------
    StudyError
        If there are no results, the library is missing or a name is unknown.
    """
    if library not in ("pandas", "polars"):
        raise StudyError(f"unknown library '{library}': use pandas or polars")
    if what not in TABLES:
        raise StudyError(f"unknown results '{what}': use {' or '.join(TABLES)}")
    module = required(library, f"results as a {library} frame")
    with opened(store_path(study, out)) as store:
        columns = TABLES[what](store)
    if library == "polars":
        # It reads the kind of a column off its first rows, which may all be empty.
        return module.DataFrame(columns, infer_schema_length=None)
    return module.DataFrame(columns)


def required(name: str, purpose: str) -> Any:
    """An optional library.

    Raises
    ------
    StudyError
        If it is not installed.
    """
    try:
        return import_module(name)
    except ImportError:
        raise StudyError(f"{purpose} needs {name}: pip install {name}") from None


def _filled(names: tuple[str, ...], rows: Iterator[tuple[Any, ...]]) -> Columns:
    # Column by column from the start: a table of rows would be in memory twice.
    columns: Columns = {name: [] for name in names}
    fill = [column.append for column in columns.values()]
    for row in rows:
        for add, value in zip(fill, row, strict=True):
            add(value)
    return columns


def _who(cell: CellRow, row: TrialRow) -> tuple[Any, ...]:
    problem = cell.problem
    return (
        *(problem.dataset, problem.kind, problem.model, problem.objective),
        *(cell.label, cell.options, cell.budget, row.repetition),
    )


def _trial(cell: CellRow, row: TrialRow, best: float, scale: JudgingScale) -> tuple[Any, ...]:
    reference = reference_of(cell.problem, row)
    target, hit, f_best = goal_of(reference, best, scale.target), np.inf, None
    if row.best is not None and row.best <= target:
        hit = hitting_time(*row.improvements(), target)
    # Where all trials failed nothing is known to be good.
    if np.isfinite(best):
        f_best = best
    return (
        *_who(cell, row),
        *(str(row.status), row.reason, row.best, row.oracle, row.parameter_error, row.theta_text),
        *(row.evaluations, row.gradients, row.batched),
        *(row.seconds, row.processor, row.processor_batched),
        *(reference, f_best, target if f_best is not None else None),
        *(int(hit) if np.isfinite(hit) else None, row.covered),
    )


def _points(cell: CellRow, row: TrialRow) -> Iterator[tuple[Any, ...]]:
    best = row.improvements()
    if not len(best[0]):
        return
    told, seen = row.recommendations(), row.oracle_trace()
    # Improvements alone would do, but whoever draws a mean of several trials needs them at common
    # evaluations.
    grid = np.union1d(geometric_grid(row.evaluations), best[0])
    # Before its first value a trial has none.
    grid = grid[grid >= best[0][0]]
    columns: list[list[Any]] = []
    for trace in (best, told, seen):
        if trace is None:
            columns.append([None] * len(grid))
        else:
            columns.append(at(*trace, grid).tolist())
    who = _who(cell, row)
    yield from ((*who, *point) for point in zip(grid.tolist(), *columns, strict=True))
