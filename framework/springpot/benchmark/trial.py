"""One trial: an optimiser's run on a problem, judged against what is known of the truth."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache

import numpy as np

from springpot.identification import Problem, all_points
from springpot.identification.run import Run, run, run_batch
from springpot.measurement import Measurement
from springpot.registry import parse_model
from springpot.rheology import Real

from .plan import Case, Entrant, Plan, Source, Task
from .study import truth_fits
from .trace import improvements, pack, pack_values


class Status(StrEnum):
    """How a trial ended."""

    CONVERGED = "converged"
    BUDGET = "budget"
    TARGET = "target"
    ERROR = "error"
    INVALID = "invalid"
    MEMORY = "memory"
    TIMEOUT = "timeout"
    CRASH = "crash"

    @property
    def failed(self) -> bool:
        """Whether there is no result to judge."""
        return self not in (Status.CONVERGED, Status.BUDGET, Status.TARGET)


@dataclass(frozen=True, slots=True)
class TrialResult:
    """What is kept of a trial; a failed one has a reason and no numbers.

    Parameters
    ----------
    cell, repetition : int
        Which trial.
    status : Status
        How it ended.
    reason : str
        One line if it failed.
    best : float or None
        Smallest objective.
    theta : dict of str to float
        Element parameters there, by name.
    parameter_error : float or None
        Largest relative error of a parameter, where the truth is known.
    oracle : float or None
        Objective of the same parameters against noise-free data, where the truth is known.
    evaluations, gradients, batched : int
        Counted by the recorder: all, those with a derivative, those in calls for several points at once.
    seconds : float
        Of the optimiser alone.
    trace : bytes
        Its improvements, packed.
    recommended : bytes or None
        Noise-free objective of what was best at each improvement, packed; empty if it is the objective itself, None
        where the truth is unknown.
    seen : bytes or None
        Improvements of the noise-free objective over all that was evaluated, packed; empty and None likewise.
    """

    cell: int
    repetition: int
    status: Status
    reason: str = ""
    best: float | None = None
    theta: dict[str, float] | None = None
    parameter_error: float | None = None
    oracle: float | None = None
    evaluations: int = 0
    gradients: int = 0
    batched: int = 0
    seconds: float = 0.0
    trace: bytes = b""
    recommended: bytes | None = None
    seen: bytes | None = None


def failure(task: Task, status: Status, reason: str, seconds: float = 0.0) -> list[TrialResult]:
    """The results of a task that came to nothing."""
    line = " ".join(reason.split())[:300]
    return [TrialResult(task.cell, r, status, line, seconds=seconds) for r in task.repetitions]


class Workshop:
    """Runs the trials of a plan; each problem is built once.

    Parameters
    ----------
    plan : Plan
        The study.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self._warm: set[type] = set()
        self._bench = cache(lambda case: Bench(plan.cases[case]))

    def run(self, task: Task) -> list[TrialResult]:
        """The results of a task; whatever an optimiser raises becomes a status."""
        cell = self.plan.cells[task.cell]
        entrant = self.plan.entrants[cell.entrant]
        try:
            bench = self._bench(cell.case)
            self._warm_up(entrant, bench.problem)
            rngs = [np.random.default_rng(self.plan.stream(cell, r)) for r in task.repetitions]
            target = self.plan.stop_value(self.plan.cases[cell.case])
            runs = run_batch(entrant.optimiser, bench.problem, self.plan.budget, rngs, target, bench.noisy)
            return [bench.judge(task.cell, r, done) for r, done in zip(task.repetitions, runs, strict=True)]
        except MemoryError:
            return failure(task, Status.MEMORY, f"needs more than {self.plan.memory} MiB")
        except (Exception, SystemExit) as error:
            return failure(task, Status.ERROR, f"{type(error).__name__}: {error}")

    def _warm_up(self, entrant: Entrant, problem: Problem) -> None:
        """Let an optimiser import what it needs before it is timed; its trial reports what goes wrong."""
        if type(entrant.optimiser) in self._warm:
            return
        self._warm.add(type(entrant.optimiser))
        try:
            run(entrant.optimiser, problem, 1, np.random.default_rng(0))
        except (Exception, SystemExit):
            return


class Bench:
    """A problem with its noise-free twin and its true parameters.

    Parameters
    ----------
    case : Case
        The problem's description.
    """

    def __init__(self, case: Case) -> None:
        source = case.source
        model = parse_model(case.model)
        self.problem = Problem.of(model, source.measurement, case.objective, source.stiffness_scale)
        clean = noise_free(source)
        self.clean = None if clean is None else replace(self.problem, measurement=clean)
        # Exact data differ from computed ones by rounding only; their objective is its own oracle.
        self.noisy = clean is not None and not np.allclose(
            clean.stiffness, source.measurement.stiffness, rtol=1e-9, atol=0.0
        )
        fits = truth_fits(source, model.name, model.names)
        self.truth: Real | None = model.vector(dict(source.truth)) if fits else None

    def judge(self, cell: int, repetition: int, done: Run) -> TrialResult:
        """What is kept of a run."""
        status, reason = _status(done)
        common = {
            "evaluations": done.evaluations, "gradients": done.gradients, "batched": done.batched,
            "seconds": done.seconds,
        }  # fmt: skip
        if status.failed:
            return TrialResult(cell, repetition, status, reason, **common)  # type: ignore[arg-type]
        theta = np.asarray(done.theta, dtype=float)
        recommended, seen = self._without_noise(done)
        return TrialResult(
            cell,
            repetition,
            status,
            best=float(done.best),
            theta=dict(zip(self.problem.model.names, theta.tolist(), strict=True)),
            parameter_error=None if self.truth is None else relative_error(theta, self.truth),
            oracle=None if self.clean is None else float(self.clean.evaluate(done.best_x)),
            trace=pack(done.trace),
            recommended=recommended,
            seen=seen,
            **common,  # type: ignore[arg-type]
        )

    def _without_noise(self, done: Run) -> tuple[bytes | None, bytes | None]:
        """Packed traces of what was recommended and of what was seen, judged against noise-free data."""
        if self.clean is None:
            return None, None
        if done.diary is None:
            return b"", b""
        points, factors = all_points(done.diary, self.problem.dimension)
        values = self.clean.evaluate(points) * factors
        values[np.isnan(values)] = np.inf
        rows = np.array([evaluation for evaluation, _ in done.trace], dtype=np.int64) - 1
        return pack_values(values[rows]), pack(improvements(values))


def relative_error(theta: Real, truth: Real) -> float:
    """Largest relative error of a parameter; the absolute one where the truth is zero."""
    return float(np.max(np.abs(theta - truth) / np.where(truth == 0, 1.0, np.abs(truth))))


def noise_free(source: Source) -> Measurement | None:
    """The data as they would be without noise, where the truth is known."""
    if not source.truth:
        return None
    model = parse_model(source.model)
    stiffness = model.stiffness(model.vector(dict(source.truth)), source.measurement.points)
    return replace(source.measurement, stiffness=stiffness)


def _status(done: Run) -> tuple[Status, str]:
    name, _, reason = done.status.partition(": ")
    if reason.startswith("MemoryError"):
        return Status.MEMORY, reason
    if not done.failed:
        return Status(name), ""
    return (Status.INVALID if reason.startswith("no finite") else Status.ERROR), reason
