"""One trial: an optimiser's run on a problem, judged against what is known of the truth."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property

import numpy as np

from springpot.identification.ledger import all_points
from springpot.identification.problem import Problem, watched
from springpot.identification.runs import Run, run, run_batch
from springpot.measurement.measurement import Measurement
from springpot.registry import parse_model
from springpot.rheology.points import Real

from .plan import Case, Cell, Plan, Source, Task
from .study import truth_fits
from .tamper_test import Witness
from .trace import improvements, pack, pack_values

LONGEST_REASON = 300
"""Signs of a reason that are kept: the message of an error may hold whole arrays."""


class Status(StrEnum):
    """How a trial ended.

    Examples
    --------
    >>> from springpot.benchmark import Status
    >>> Status.TIMEOUT.failed, Status.CONVERGED.failed
    (True, False)
    """

    CONVERGED = "converged"
    BUDGET = "budget"
    TARGET = "target"
    ERROR = "error"
    INVALID = "invalid"
    MEMORY = "memory"
    TIMEOUT = "timeout"
    CRASH = "crash"
    CHANGED = "changed"
    DAMAGED = "damaged"

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
        Counted by the recorder: all, those with a derivative, those in calls for several points at
        once.
    seconds : float
        Duration of the optimiser's own call; in a batch, an equal share of it.
    processor : float or None
        Processor time of the optimiser in a run of this trial alone; None where it was run beside
        others only.
    processor_batched : float or None
        Share of that of the batch in which it was run; None for a trial that was run alone.
    trace : bytes
        Its improvements, packed.
    recommended : bytes or None
        Noise-free objective of what was best at each improvement, packed; empty if it is the
        objective itself, None where the truth is unknown.
    seen : bytes or None
        Improvements of the noise-free objective over all that was evaluated, packed; empty and None
        likewise.
    point : tuple of float
        Search point of the smallest objective, as it was evaluated.
    factor : float
        Penalty in the value there.
    """

    cell: int
    repetition: int
    status: Status
    reason: str = ""
    best: float | None = None
    theta: Mapping[str, float] | None = None
    parameter_error: float | None = None
    oracle: float | None = None
    evaluations: int = 0
    gradients: int = 0
    batched: int = 0
    seconds: float = 0.0
    processor: float | None = None
    processor_batched: float | None = None
    trace: bytes = b""
    recommended: bytes | None = None
    seen: bytes | None = None
    point: tuple[float, ...] = ()
    factor: float = 1.0


def failure(task: Task, status: Status, reason: str, seconds: float = 0.0) -> list[TrialResult]:
    """The results of a task that came to nothing."""
    # One line, as it is shown in a table.
    line = " ".join(reason.split())[:LONGEST_REASON]
    return [TrialResult(task.cell, r, status, line, seconds=seconds) for r in task.repetitions]


class Workshop:
    """Runs the trials of a plan.

    Every problem is built before the first of them, in a process that is still clean.

    Parameters
    ----------
    plan : Plan
        The study.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self._warm: set[type] = set()
        self._benches = [_built(case) for case in plan.cases]

    def run(self, task: Task) -> list[TrialResult]:
        """The results of a task; whatever an optimiser raises becomes a status."""
        cell = self.plan.cells[task.cell]
        bench = self._benches[cell.case]
        if isinstance(bench, Exception):
            return failure(task, Status.ERROR, f"{type(bench).__name__}: {bench}")
        try:
            results = self._race(task, cell, bench)
        # Not within its run only: to keep what it did may be what takes the memory.
        except MemoryError:
            return failure(task, Status.MEMORY, f"needs more than {self.plan.memory} MiB")
        except (Exception, SystemExit) as error:
            return failure(task, Status.ERROR, f"{type(error).__name__}: {error}")
        # An optimiser shares the process with the problem: one that has changed it has raced on
        # another.
        complaint = bench.witness.complaint(bench.problem)
        # What the trial itself reports of a fault says more than that the process was changed by
        # it.
        if complaint and not all(result.status.failed for result in results):
            return failure(task, Status.CHANGED, complaint)
        return results

    def _race(self, task: Task, cell: Cell, bench: Bench) -> list[TrialResult]:
        entrant = self.plan.entrants[cell.entrant]
        # A generator for each repetition: a trial is the same alone, in a batch, and on another
        # worker.
        rngs = [np.random.default_rng(self.plan.stream(cell, r)) for r in task.repetitions]
        target = self.plan.stop_value(self.plan.cases[cell.case])
        runs = run_batch(
            entrant.optimiser, bench.problem, self.plan.budget, rngs, target, bench.noisy
        )
        results = [
            bench.judge(task.cell, r, done) for r, done in zip(task.repetitions, runs, strict=True)
        ]
        if not self.plan.flown_together(task):
            return results
        # A share of many says little of what one costs who runs one: the first is run once more,
        # alone.
        rng = np.random.default_rng(self.plan.stream(cell, task.repetitions[0]))
        alone = run(entrant.optimiser, bench.problem, self.plan.budget, rng, target).processor
        times = [alone, *[None] * (len(results) - 1)]
        return [
            replace(result, processor=time, processor_batched=result.processor)
            for result, time in zip(results, times, strict=True)
        ]

    def warm_up(self, task: Task, begun: Callable[[], None] = lambda: None) -> None:
        """Let the optimiser of a task import what it needs before it is timed.

        Its trial reports what goes wrong.

        Once for each optimiser `begun` is called, when it asks for its first value or ends without
        having done so.
        """
        cell = self.plan.cells[task.cell]
        optimiser, bench = self.plan.entrants[cell.entrant].optimiser, self._benches[cell.case]
        if type(optimiser) in self._warm or isinstance(bench, Exception):
            return
        # Before it is tried: one that fails here would be tried again before each of its trials.
        self._warm.add(type(optimiser))
        bell = Bell(begun)
        # What it raises its trial will tell.
        with suppress(Exception, SystemExit):
            run(optimiser, watched(bench.problem, bell), 1, np.random.default_rng(0))
        bell()


class Bell:
    """Calls something the first time that it is rung.

    Parameters
    ----------
    action : callable
        What is called.
    """

    def __init__(self, action: Callable[[], None]) -> None:
        self._action: Callable[[], None] | None = action

    def __call__(self, *_: object) -> None:
        """Ring it, with whatever there is to say."""
        action, self._action = self._action, None
        if action is not None:
            action()


def _built(case: Case) -> Bench | Exception:
    """A problem ready to run, or why it cannot: that is told by its trials."""
    try:
        bench = Bench(case)
        bench.witness  # noqa: B018  taken now, while no optimiser has run
    except Exception as error:
        return error
    return bench


@dataclass(frozen=True)
class Judged:
    """What a point of a problem is worth.

    Parameters
    ----------
    best : float
        Its objective.
    theta : dict of str to float
        Element parameters there, by name.
    parameter_error, oracle : float or None
        Largest relative error of them and noise-free objective, where the truth is known.
    """

    best: float
    theta: dict[str, float]
    parameter_error: float | None
    oracle: float | None


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
        self.clean: Problem | None = None
        if clean is not None:
            self.clean = replace(self.problem, measurement=clean)
        # Exact data differ from computed ones by rounding only; their objective is its own oracle.
        self.noisy = clean is not None and not np.allclose(
            clean.stiffness, source.measurement.stiffness, rtol=1e-9, atol=0.0
        )
        self.truth: Real | None = None
        if truth_fits(source, model.name, model.names):
            self.truth = model.vector(dict(source.truth))

    @cached_property
    def witness(self) -> Witness:
        """What the problem answers before any optimiser has run."""
        return Witness.of(self.problem)

    def judged(self, point: Real) -> Judged:
        """What a search point (d,) is worth, the order kinf > k0 restored."""
        # What is reported is a point that thermodynamics allows; its value is that of the point
        # that was evaluated.
        x = self.problem.space.repaired(point)
        theta = np.asarray(self.problem.space.theta(x), dtype=float)
        error = oracle = None
        with np.errstate(all="ignore"):
            value = float(self.problem.evaluate(point))
            if self.truth is not None:
                error = relative_error(theta, self.truth)
            if self.clean is not None:
                oracle = float(self.clean.evaluate(x))
        return Judged(
            value, dict(zip(self.problem.model.names, theta.tolist(), strict=True)), error, oracle
        )

    def judge(self, cell: int, repetition: int, done: Run) -> TrialResult:
        """What is kept of a run."""
        status, reason = _status(done)
        common = {
            "evaluations": done.evaluations,
            "gradients": done.gradients,
            "batched": done.batched,
            "seconds": done.seconds,
            "processor": done.processor,
        }
        # A value found before the fault is not kept: what comes of a trial that breaks off would
        # depend on luck.
        if status.failed:
            return TrialResult(cell, repetition, status, reason, **common)  # type: ignore[arg-type]
        # From the point itself, evaluated anew: what it is worth is found here, and not told by the
        # run.
        judged = self.judged(done.point)
        recommended, seen = self._without_noise(done)
        return TrialResult(
            cell,
            repetition,
            status,
            best=float(done.best),
            theta=judged.theta,
            parameter_error=judged.parameter_error,
            oracle=judged.oracle,
            trace=pack(done.trace),
            recommended=recommended,
            seen=seen,
            point=tuple(done.point.tolist()),
            factor=done.factor,
            **common,  # type: ignore[arg-type]
        )

    def _without_noise(self, done: Run) -> tuple[bytes | None, bytes | None]:
        """Packed traces of what was recommended and seen, judged against noise-free data."""
        if self.clean is None:
            return None, None
        if done.diary is None:
            return b"", b""
        points, factors = all_points(done.diary, self.problem.dimension)
        # All at once at the end, so that the optimiser's own time is not that of judging it.
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
    # The error's own name is in the reason of a failed run, and the limit of memory raises one of
    # these.
    name, _, reason = done.status.partition(": ")
    if reason.startswith("MemoryError"):
        return Status.MEMORY, reason
    if not done.failed:
        return Status(name), ""
    if reason.startswith("no finite"):
        return Status.INVALID, reason
    return Status.ERROR, reason
