"""Cells in numbers: success, cost, accuracy, time and failures; and where a study's results are.

A user's study is a script, loaded by its path in the command and in every worker.
"""

from __future__ import annotations

import json
import os
import sys
import traceback
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from functools import cached_property
from importlib.util import module_from_spec, spec_from_file_location
from itertools import compress
from operator import itemgetter
from pathlib import Path
from types import ModuleType
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from springpot.errors import SpringpotError, StudyError
from springpot.report.page import Entry, Table
from springpot.rheology.points import Real

from .plan import ProblemRow, stream_of
from .statistics import Interval, median, medians, running_time_interval, wilson
from .study import Study
from .trial import Status, TrialResult, unpack, unpack_values


def load_script(path: Path) -> ModuleType:
    """The script as a module, executed once in a process.

    It has the same name everywhere, so that an optimiser defined in it is found again in a worker.

    Raises
    ------
    StudyError
        If it cannot be read or fails, with file and line.
    """
    # Not by Path.resolve, for which a link that leads to itself is a fault.
    path = Path(os.path.realpath(path))
    name = f"springpot_study_{path.stem}"
    loaded = sys.modules.get(name)
    if loaded is not None and loaded.__file__ == str(path):
        return loaded
    if not path.is_file():
        raise StudyError(f"there is no study script {path}: give the path of a Python file")
    spec = spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise StudyError(f"{path} is no Python file: a study script ends in .py")
    module = module_from_spec(spec)
    # Before it runs, as pickle looks for what it defines under this name.
    sys.modules[name] = module
    # As Python does for a script: files beside it can be imported.
    if str(path.parent) not in sys.path:
        sys.path.insert(0, str(path.parent))
    try:
        # What a script prints is no part of a command's own output.
        with redirect_stdout(sys.stderr):
            spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        raise StudyError(_one_line(path, error)) from error
    return module


def _one_line(path: Path, error: BaseException) -> str:
    lines = [
        frame.lineno
        for frame in traceback.extract_tb(error.__traceback__)
        if frame.filename == str(path)
    ]
    if isinstance(error, SyntaxError) and error.filename == str(path):
        lines.append(error.lineno)
    line: int | None = 1
    # The last of the script's own lines: the user can mend that one, and not the library it calls.
    if lines:
        line = lines[-1]
    message = str(error)
    if isinstance(error, SyntaxError):
        # Its text would name the file and the line once more.
        message = error.msg
    message = " ".join(message.split())
    if not isinstance(error, SpringpotError):
        message = f"{type(error).__name__}: {message}"
    return f"{path}, line {line}: {message}"


def load_study(path: str | Path) -> Study:
    """The study that a script declares.

    Parameters
    ----------
    path : str or Path
        A Python file with ``study = Study(...)``.

    Raises
    ------
    StudyError
        If the script fails (with file and line) or declares none, or several of which none is
        called ``study``.
    """
    module = load_script(Path(path))
    studies = {name: value for name, value in vars(module).items() if isinstance(value, Study)}
    if "study" in studies:
        return studies["study"]
    if len({id(value) for value in studies.values()}) == 1:
        return next(iter(studies.values()))
    if not studies:
        raise StudyError(f"{path} declares no study: write study = Study(...) in it")
    raise StudyError(f"{path} declares {', '.join(studies)}: call the one to run 'study'")


@dataclass(frozen=True)
class CellRow:
    """One problem and one entrant."""

    id: int
    problem: ProblemRow
    label: str
    optimiser: str
    options: str
    budget: int
    digest: str = ""


@dataclass(frozen=True, slots=True)
class TrialRow(TrialResult):
    """One finished trial as the store has it.

    Its cell by the store's number, its parameters empty if it failed.
    """

    theta: Mapping[str, float] = field(default_factory=dict)

    @property
    def theta_text(self) -> str | None:
        """Its parameters as JSON, None if it failed."""
        if not self.theta:
            return None
        return json.dumps(self.theta)

    def improvements(self) -> tuple[NDArray[np.int64], Real]:
        """Evaluation numbers (n,) and objectives (n,) of the improvements."""
        return unpack(self.trace)

    def recommendations(self) -> tuple[NDArray[np.int64], Real] | None:
        """Evaluation numbers (n,) and noise-free objectives (n,) of what was best at the time.

        May rise.

        None where the truth is unknown or was not kept.
        """
        if self.recommended is None:
            return None
        evaluations, values = self.improvements()
        if self.recommended:
            values = unpack_values(self.recommended)
        return evaluations, values

    def oracle_trace(self) -> tuple[NDArray[np.int64], Real] | None:
        """Evaluation numbers (n,) and values (n,) of the best noise-free objective evaluated.

        None where the truth is unknown or was not kept.
        """
        if self.seen is None:
            return None
        # Of exact data it is kept empty: there the objective itself has no noise.
        if not self.seen:
            return self.improvements()
        return unpack(self.seen)


class CellTrials(Sequence[TrialRow]):
    """The finished trials of one cell, one by one or column by column.

    A study has many thousands of them: what tables compute is computed of columns, without an
    object for each trial.

    Parameters
    ----------
    names : sequence of str
        What each value of a row is of a `TrialRow`.
    rows : sequence of tuple
        As the store has them; what they hold behind these values is passed over.
    """

    def __init__(self, names: Sequence[str], rows: Sequence[tuple[Any, ...]]) -> None:
        self._names, self._rows = names, rows
        self._numbers: dict[str, Real] = {}

    def __len__(self) -> int:
        return len(self._rows)

    @overload
    def __getitem__(self, at: int) -> TrialRow: ...
    @overload
    def __getitem__(self, at: slice) -> CellTrials: ...
    def __getitem__(self, at: int | slice) -> TrialRow | CellTrials:
        if isinstance(at, slice):
            return CellTrials(self._names, self._rows[at])
        return self._trial(self._rows[at])

    def __iter__(self) -> Iterator[TrialRow]:
        return map(self._trial, self._rows)

    def _trial(self, row: tuple[Any, ...]) -> TrialRow:
        kept = dict(zip(self._names, row, strict=False))
        kept |= {"status": Status(kept["status"]), "trace": kept["trace"] or b""}
        kept["theta"] = json.loads(kept["theta"]) if kept["theta"] else {}
        return TrialRow(**kept)

    def column(self, name: str) -> tuple[Any, ...]:
        """What a column holds of each trial (n,), as the store has it."""
        return tuple(map(itemgetter(self._names.index(name)), self._rows))

    def numbers(self, name: str) -> Real:
        """Numbers of a column (n,), NaN where a trial has none."""
        if name not in self._numbers:
            self._numbers[name] = np.array(self.column(name), dtype=float)
        return self._numbers[name]

    def parameters(self, which: NDArray[np.int64]) -> int:
        """How many parameters the first of some trials has, zero without one."""
        texts = self.column("theta")
        return next((len(json.loads(texts[i] or "{}")) for i in which.tolist()), 0)

    @cached_property
    def failed(self) -> NDArray[np.bool_]:
        """Which trials came to nothing (n,)."""
        return np.array([status in _FAILED for status in self.column("status")], dtype=bool)


_FAILED = frozenset(str(status) for status in Status if status.failed)


@dataclass(frozen=True, eq=False)
class CellSummary:
    """The trials of one cell in numbers.

    Parameters
    ----------
    cell : CellRow
        Which cell.
    trials, failed : int
        Trials kept, and those that came to nothing.
    success : Interval or None
        Share that reached the target.
    to_target : float or None
        Median of the evaluations to the target; infinite if fewer than half of the trials reached
        it.
    running_time : Interval or None
        Expected evaluations to the target with restarts.
    accurate : Interval or None
        Share of trials with every parameter within the accuracy, where the truth is known.
    parameter_error, best, oracle : float or None
        Medians over the trials that came to something.
    evaluations, gradients : float or None
        Medians over the same.
    processor, each : float or None
        Processor time [s] of such a trial run alone and of each of its evaluations, medians over
        those that were.
    processor_batched : float or None
        Share in the processor time [s] of a batch, median over those that were run in one.
    reasons : Counter
        How often trials failed, by status and reason.
    """

    cell: CellRow
    trials: int
    failed: int
    success: Interval | None
    to_target: float | None
    running_time: Interval | None
    accurate: Interval | None
    parameter_error: float | None
    best: float | None
    oracle: float | None
    evaluations: float | None
    gradients: float | None
    processor: float | None
    each: float | None
    processor_batched: float | None
    reasons: Counter[tuple[str, str]]


def summarise_cell(cell: CellRow, trials: CellTrials, hits: Real, accuracy: float) -> CellSummary:
    """Summary of a cell; `hits` are evaluations at which its trials reached the target, or inf."""
    problem, spent = cell.problem, trials.numbers("evaluations")
    # From names, so that a cell's interval is the same whatever other cells there are.
    rng = np.random.default_rng(
        stream_of(0, "bootstrap", problem.dataset, problem.model, problem.objective, cell.label)
    )
    reasons = zip(trials.column("status"), trials.column("reason"), strict=True)
    sound = ~trials.failed
    # What failed is in the rates and running times, where it counts in full.
    columns = [*(trials.numbers(name) for name in _TYPICAL), _each(trials)]
    typical = dict(zip((*_TYPICAL, "each"), medians(np.array(columns)[:, sound]), strict=True))
    accurate = None
    # Without true parameters nothing can be said of those that were found.
    if problem.known is not None:
        within = trials.numbers("parameter_error")[sound] <= accuracy
        accurate = wilson(int(within.sum()), len(trials))
    return CellSummary(
        cell,
        trials=len(trials),
        failed=int(trials.failed.sum()),
        success=wilson(int(np.isfinite(hits).sum()), len(hits)),
        to_target=median(hits),
        running_time=running_time_interval(hits, spent, rng),
        accurate=accurate,
        reasons=Counter(compress(reasons, trials.failed)),
        **typical,
    )


_TYPICAL = (
    *("parameter_error", "best", "oracle", "evaluations", "gradients"),
    *("processor", "processor_batched"),
)
"""Columns of whose numbers a summary has the median."""


def median_of(values: Sequence[float | None]) -> float | None:
    """Median of those that are known; None where none is."""
    return median(np.array(values, dtype=float))


_WHO = ("data set", "model", "objective", "optimiser")


def _who(cell: CellRow) -> tuple[Entry, ...]:
    return cell.problem.dataset, cell.problem.model, cell.problem.objective, cell.label


def summary_table(name: str, summaries: Sequence[CellSummary], target: str, accuracy: str) -> Table:
    """Success, cost and accuracy of every cell; the same bytes whatever engine ran the study."""
    columns = (
        *(*_WHO, "budget", "trials", "failed", "success"),
        *("evaluations to target", "expected running time"),
        *(f"parameters within {float(accuracy):g}", "parameter error"),
        *("objective reached", "noise-free objective"),
    )
    rows = [
        (
            *(*_who(s.cell), s.cell.budget, s.trials, s.failed, s.success),
            *(s.to_target, s.running_time),
            *(s.accurate, s.parameter_error),
            *(s.best, s.oracle),
        )
        for s in summaries
    ]
    note = (
        f"Success: objective at most f + {float(target):g} (g - f), where f is the best value known"
        " of the problem and g that at the centre of the box, or of a model without any response"
        " where that is smaller. Rates with Wilson's and running times with bootstrap 95 %"
        " intervals; a trial that failed or missed the target counts as infinite. Parameter error:"
        " the largest relative one; it, the objective and the noise-free objective are medians"
        " over the trials that did not fail."
    )
    return Table(f"{name}: summary", columns, rows, note)


def timing_table(name: str, summaries: Sequence[CellSummary]) -> Table:
    """Medians of the optimiser's own time; kept apart because no two runs take the same."""
    rows = []
    for s in summaries:
        each = None
        if s.each is not None:
            each = 1e6 * s.each
        rows.append(
            (*_who(s.cell), s.evaluations, s.gradients, s.processor, each, s.processor_batched)
        )
    columns = (
        *(*_WHO, "evaluations", "of these with gradient"),
        *("one trial alone [s]", "an evaluation of it [us]", "share in a batch [s]"),
    )
    note = (
        "Processor time; medians over the trials that did not fail; start-up is not counted. An"
        " optimiser that runs its repetitions side by side runs one of each batch alone as well,"
        " for its time."
    )
    return Table(f"{name}: time", columns, rows, note)


def _each(trials: CellTrials) -> Real:
    """Processor time of an evaluation in each trial (n,), NaN in one that was not run alone."""
    spent, count = trials.numbers("processor"), trials.numbers("evaluations")
    # A clock that shows nothing gives no rate.
    rates: Real = np.divide(spent, count, out=np.full(len(trials), np.nan), where=spent * count > 0)
    return rates


def failure_table(name: str, summaries: Sequence[CellSummary]) -> Table:
    """How often and why trials failed."""
    rows = []
    for summary in summaries:
        for (status, reason), count in sorted(summary.reasons.items()):
            rows.append((*_who(summary.cell), status, reason, count))
    note = ""
    # An empty table alone could as well be one that was never filled.
    if not rows:
        note = "No trial failed."
    return Table(f"{name}: failures", (*_WHO, "status", "reason", "trials"), rows, note)


SUFFIX = ".zip"
"""Of an archive."""


def store_path(study: Study | str | Path, out: Path = Path("results")) -> Path:
    """Where a study's results are.

    Parameters
    ----------
    study : Study, str or Path
        A study, its script, its store, its archive, its folder, or its name.
    out : Path
        Folder of all results.
    """
    if isinstance(study, Study):
        return out / study.name / f"{study.name}.sqlite"
    path = Path(study)
    if path.suffix == ".py":
        return store_path(load_study(path), out)
    if path.suffix in (".sqlite", SUFFIX):
        return path
    # Whoever gives a folder means that one, wherever it is; any other word is the name of a study.
    folder = out / path
    if path.is_dir():
        folder = path
    return folder / f"{folder.name}.sqlite"
