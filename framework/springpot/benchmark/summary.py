"""Cells in numbers: success, cost, accuracy, time and failures; and where a study's results are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from springpot.rheology.points import Real

from .plan import stream_of
from .rows import CellRow, TrialRow
from .statistics import Interval, median, running_time_interval, wilson
from .study import Study
from .tables import Entry, Table


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


def summarise_cell(
    cell: CellRow, trials: Sequence[TrialRow], hits: Real, accuracy: float
) -> CellSummary:
    """Summary of a cell; `hits` are evaluations at which its trials reached the target, or inf."""
    # Medians of what came to something; what failed is in the rates and running times, where it
    # counts in full.
    sound = [trial for trial in trials if not trial.status.failed]
    spent = np.array([trial.evaluations for trial in trials], dtype=float)
    problem = cell.problem
    # From names, so that a cell's interval is the same whatever other cells there are.
    rng = np.random.default_rng(
        stream_of(0, "bootstrap", problem.dataset, problem.model, problem.objective, cell.label)
    )
    errors = [trial.parameter_error for trial in sound if trial.parameter_error is not None]
    accurate = None
    if (
        problem.known is not None
    ):  # without true parameters nothing can be said of those that were found
        accurate = wilson(sum(error <= accuracy for error in errors), len(trials))
    return CellSummary(
        cell,
        trials=len(trials),
        failed=len(trials) - len(sound),
        success=wilson(int(np.isfinite(hits).sum()), len(hits)),
        to_target=median(hits),
        running_time=running_time_interval(hits, spent, rng),
        accurate=accurate,
        parameter_error=_median(errors),
        best=_median([trial.best for trial in sound]),
        oracle=_median([trial.oracle for trial in sound]),
        evaluations=_median([trial.evaluations for trial in sound]),
        gradients=_median([trial.gradients for trial in sound]),
        processor=_median([trial.processor for trial in sound]),
        each=_median([_each(trial) for trial in sound]),
        processor_batched=_median([trial.processor_batched for trial in sound]),
        reasons=Counter((str(t.status), t.reason) for t in trials if t.status.failed),
    )


def _median(values: Sequence[float | None]) -> float | None:
    given: Real = np.array([value for value in values if value is not None], dtype=float)
    return median(given)


_WHO = ("data set", "model", "objective", "optimiser")


def _who(cell: CellRow) -> tuple[Entry, ...]:
    return cell.problem.dataset, cell.problem.model, cell.problem.objective, cell.label


def summary_table(name: str, summaries: Sequence[CellSummary], target: str, accuracy: str) -> Table:
    """Success, cost and accuracy of every cell; the same bytes whatever engine ran the study."""
    columns = (
        *(*_WHO, "budget", "trials", "failed", "success"),
        *("evaluations to target", "expected running time"),
        *(f"parameters within {float(accuracy):g}", "parameter error"),
        *("objective", "noise-free objective"),
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


def _each(trial: TrialRow) -> float | None:
    """Processor time of an evaluation in a trial that was run alone."""
    # A clock that shows nothing gives no rate.
    if not trial.processor or not trial.evaluations:
        return None
    return trial.processor / trial.evaluations


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


def store_path(study: Study | str | Path, out: Path = Path("results")) -> Path:
    """Where a study's results are.

    Parameters
    ----------
    study : Study, str or Path
        A study, its script, its store, its folder, or its name.
    out : Path
        Folder of all results.
    """
    if isinstance(study, Study):
        return out / study.name / f"{study.name}.sqlite"
    path = Path(study)
    if path.suffix == ".py":
        from .script import load_study

        return store_path(load_study(path), out)
    if path.suffix == ".sqlite":
        return path
    # Whoever gives a folder means that one, wherever it is; any other word is the name of a study.
    folder = out / path
    if path.is_dir():
        folder = path
    return folder / f"{folder.name}.sqlite"
