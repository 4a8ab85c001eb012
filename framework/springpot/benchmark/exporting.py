"""Exports of a study for other tools: IOHanalyzer, COCO, CSV, Parquet, data frames.

All share its trials by problem and optimiser, numbered as other tools do. For IOHanalyzer and
iohinspector there is a folder for each optimiser, with an index and the improvements per problem;
for COCO one with the index and data files that cocopp reads; of columns CSV, Parquet and data
frames are made.

COCO's targets are absolute, from 100 down to 1e-8, so what is written is the precision (f - f_best)
/ (g - f_best): one at the study's reference g, zero at the best that is known. On noisy data with a
known truth f is the noise-free objective, best of all that was evaluated so far, as COCO defines
its third column.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from math import inf, isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from springpot.errors import OutputError, StudyError
from springpot.files import write_text, write_with
from springpot.rheology.points import Real
from springpot.writing import csv_text

from .archive import opened
from .coco_suite import NAMES, SUITE, required
from .comparison import JudgingScale, judged, reference_of
from .plan import ProblemRow
from .statistics import goal_of, hitting_time
from .store import Store
from .study import Study
from .summary import CellRow, TrialRow, median_of, store_path
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


CLOCKS = ("processor", "processor_batched")
"""Times of a trial that say what it costs: those of a call that served several would not."""
PRECISION = 1e-8
"""COCO's final target."""
_HEAD = (
    "% f evaluations | g evaluations | best noise-free fitness - Fopt (%13.12e) + sum g_i+ |"
    " measured fitness | best measured fitness or single-digit g-values | x1 | x2...\n"
)


@dataclass
class PrecisionScale:
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
        return np.maximum(values - self.best, 0.0) / room


def write_coco(store: Store, folder: Path) -> Export:
    """Write a study as COCO data.

    Each problem is a function of the suite, each repetition an instance of it.
    """
    # Once through all trials beforehand: what is best of a problem is known only when all have been
    # seen.
    scales = _scales(store)
    # cocopp shows numbers only: the names are kept beside them, for whoever reads its report.
    names: dict[int, str] = {}

    def files_of(block: Block) -> Iterator[tuple[str, str]]:
        scale = scales[block.cell.problem.id]
        data = f"data_f{block.function}/bbobexp_f{block.function}_DIM{block.dimension}"
        for suffix, grid in (("dat", False), ("tdat", True)):
            yield f"{data}.{suffix}", "".join(_text(row, scale, grid) for row in block.trials)
        yield f"bbobexp_f{block.function}.info", _info_file(block, scale, f"{data}.dat")
        names[block.function] = block.name

    hint = f"python -m springpot.benchmark.coco_suite {folder}"
    whole = _written(store, folder, files_of, hint)
    lines = [f"{number} {name}\n" for number, name in sorted(names.items())]
    listed = write_text(folder / NAMES, "".join(lines))
    return replace(whole, files=(*whole.files, listed))


def _scales(store: Store) -> dict[int, PrecisionScale]:
    """Scale of every problem by its number: noise-free if every trial of it knows that."""
    scales: dict[int, PrecisionScale] = {}
    lowest: dict[int, float] = {}
    made = {cell.problem.id for cell in store.cells() if cell.problem.known is not None}
    for block in blocks(store):
        problem = block.cell.problem
        scale = scales.setdefault(problem.id, PrecisionScale(block.best, problem.reference, True))
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


def _text(row: TrialRow, scale: PrecisionScale, grid: bool) -> str:
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


def _info_file(block: Block, scale: PrecisionScale, data: str) -> str:
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
    for name, seconds in block.clocks().items():
        comment += f", {name} {seconds:.4g} s"
    return (
        ", ".join(f"{key} = {value}" for key, value in keys.items())
        + f"\n{comment}\n{data}, {runs}\n"
    )


def _shown(row: TrialRow, scale: PrecisionScale) -> tuple[NDArray[np.int64], Real]:
    """Evaluations and objectives of improvements, noise-free ones where every trial knows them."""
    if not scale.noise_free:
        return row.improvements()
    trace = row.oracle_trace()
    assert trace is not None
    return trace


def _final(row: TrialRow, scale: PrecisionScale) -> float:
    return float(scale.precision(_shown(row, scale)[1][-1:])[0])


@dataclass(frozen=True)
class Export:
    """What was written.

    Parameters
    ----------
    folder : Path
        Where.
    files : tuple of Path
        The files.
    trials, left_out : int
        Trials in them, and those without a value that are not.
    hint : str
        How to open it.
    """

    folder: Path
    files: tuple[Path, ...]
    trials: int
    left_out: int
    hint: str = ""


@dataclass(frozen=True, eq=False)
class Block:
    """The trials of one optimiser on one problem, as other tools number them.

    Parameters
    ----------
    cell : CellRow
        Problem and optimiser.
    folder : str
        Folder of the optimiser, different for each.
    function : int
        Number of the problem, counted from 1 in the order of the study.
    dimension : int
        Parameters searched.
    best : float
        Smallest objective known of the problem.
    trials : tuple of TrialRow
        Those with a value.
    """

    cell: CellRow
    folder: str
    function: int
    dimension: int
    best: float
    trials: tuple[TrialRow, ...]

    @property
    def name(self) -> str:
        """Data set, model and objective in one word."""
        return function_name(self.cell.problem)

    def clocks(self) -> dict[str, float]:
        """Processor time [s] of one trial alone, and a share in a batch.

        Medians over the trials that have it: of a batch, one is run alone as well.
        """
        times = {name: [getattr(row, name) for row in self.trials] for name in CLOCKS}
        medians = {name: median_of(each) for name, each in times.items()}
        return {name: each for name, each in medians.items() if each is not None}


def created(folder: Path) -> Path:
    """The folder, made if it is missing.

    Raises
    ------
    OutputError
        If it cannot be.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"cannot write {folder}: {error.strerror or error}") from error
    return folder


def blocks(store: Store) -> Iterator[Block]:
    """Every cell of a study that has a trial with a value, one at a time."""
    cells = store.cells()
    # From 1 on in the order of the study, as other tools number functions; the store's own numbers
    # have gaps.
    numbers = {n: i for i, n in enumerate(dict.fromkeys(cell.problem.id for cell in cells), 1)}
    folders = _folders([cell.label for cell in cells])
    bests = store.bests()
    for cell, rows in store.raced():
        # What failed has no value, for which these formats have no word: it is counted by
        # `left_out`.
        sound = tuple(row for row in rows if row.trace)
        if sound:
            folder, problem = folders[cell.label], cell.problem.id
            dimension = len(sound[0].theta)
            yield Block(cell, folder, numbers[problem], dimension, bests[problem], sound)


def _written(
    store: Store, folder: Path, files_of: Callable[[Block], Iterator[tuple[str, str]]], hint: str
) -> Export:
    """The files of every block, by their names within the folder of its optimiser."""
    files: list[Path] = []
    count = 0
    for block in blocks(store):
        for name, content in files_of(block):
            path = folder / block.folder / name
            created(path.parent)
            files.append(write_text(path, content))
        count += len(block.trials)
    return Export(folder, tuple(files), count, left_out(store), hint)


def left_out(store: Store) -> int:
    """Trials without a value, which other tools have no way to tell of."""
    return sum(not row.trace for _, rows in store.raced() for row in rows)


def function_name(problem: ProblemRow) -> str:
    """Data set, model and objective in one word."""
    return slug(f"{problem.dataset}_{problem.model}_{problem.objective}")


def slug(text: str) -> str:
    """`text` as a file name."""
    return "".join(c if c.isalnum() or c in "-_." else "-" for c in text)


def _folders(labels: list[str]) -> dict[str, str]:
    """A folder name for each label, no two the same even where file systems ignore case."""
    names: dict[str, str] = {}
    taken: set[str] = set()
    for label in dict.fromkeys(labels):
        # Labels that differ in a sign only may become the same name.
        name, n = slug(label), 1
        # Two labels must not share a folder where upper and lower case are one.
        while name.lower() in taken:
            n += 1
            name = f"{slug(label)}-{n}"
        taken.add(name.lower())
        names[label] = name
    return names


FORMAT = "0.3.5"
"""Version of the format; readers take files before 0.3.3 for an older one."""


def write_ioh(store: Store, folder: Path) -> Export:
    """Write a study as IOHprofiler data.

    Each problem is a function, each repetition an instance of it.
    """
    name = store.facts()["name"]

    def files_of(block: Block) -> Iterator[tuple[str, str]]:
        stem = f"f{block.function}_{block.name}"
        data = f"data_{stem}/IOHprofiler_f{block.function}_DIM{block.dimension}.dat"
        yield data, "".join(_lines(block))
        index = _iohprofiler_index(block, name, data)
        yield f"IOHprofiler_{stem}.json", json.dumps(index, indent=1) + "\n"

    hint = (
        "upload a zip of a folder to IOHanalyzer, or iohinspector: DataManager().add_folder(FOLDER)"
    )
    return _written(store, folder, files_of, hint)


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


def _iohprofiler_index(block: Block, study: str, data: str) -> dict[str, Any]:
    problem = block.cell.problem
    about = {
        "dataset": problem.dataset,
        "model": problem.model,
        "objective": problem.objective,
        "study": study,
        "budget": str(block.cell.budget),
        **{f"{name} [s]": f"{seconds:.6g}" for name, seconds in block.clocks().items()},
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
                "runs": [_run(row) for row in block.trials],
            }
        ],
    }


def _run(row: TrialRow) -> dict[str, Any]:
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


def export(
    study: Study | str | Path, kind: str, folder: Path | None = None, out: Path = Path("results")
) -> Export:
    """Write a study's results for another tool.

    Parameters
    ----------
    study : Study, str or Path
        A study, its script, its store, its archive, its folder, or its name.
    kind : str
        ``ioh``, ``coco``, ``csv`` or ``parquet``.
    folder : Path, optional
        Where; by default a folder of that name beside the results.
    out : Path
        Folder of all results.

    Raises
    ------
    StudyError
        If there are no results, the format is unknown or its library is missing.
    OutputError
        If a file cannot be written.
    """
    if kind not in WRITERS:
        raise StudyError(f"unknown export format '{kind}': use {', '.join(WRITERS)}")
    path = store_path(study, out)
    if folder is None:
        folder = path.parent / kind
    # Opened first: a study that has no results leaves no empty folder behind.
    with opened(path) as store:
        return WRITERS[kind](store, created(folder))


def write_csv(store: Store, folder: Path) -> Export:
    """One CSV file of trials and one of their traces; numbers in full."""
    files = []
    for name, read in TABLES.items():
        columns = read(store)
        rows = chain([columns], zip(*columns.values(), strict=True))
        files.append(write_text(folder / f"{name}.csv", csv_text(rows)))
    return _whole(
        store,
        folder,
        files,
        "one row for each trial in trials.csv, one for each point in traces.csv",
    )


def write_parquet(store: Store, folder: Path) -> Export:
    """The same as Parquet, with the study's facts as metadata."""
    arrow, parquet = (
        required(name, "export to parquet") for name in ("pyarrow", "pyarrow.parquet")
    )
    files = []
    for name, read in TABLES.items():
        # A file that is passed on alone still says what it was made with.
        table = arrow.table(read(store)).replace_schema_metadata(store.facts())
        files.append(write_with(folder / f"{name}.parquet", partial(parquet.write_table, table)))
    return _whole(
        store, folder, files, "open with pandas, polars, DuckDB or anything that reads Parquet"
    )


def _whole(store: Store, folder: Path, files: list[Path], hint: str) -> Export:
    return Export(folder, tuple(files), sum(len(rows) for _, rows in store.raced()), 0, hint)


WRITERS: dict[str, Callable[[Store, Path], Export]] = {
    "ioh": write_ioh,
    "coco": write_coco,
    "csv": write_csv,
    "parquet": write_parquet,
}
"""Name of a format to its writer."""
