"""One trial: an optimiser's run on a problem, judged against what is known of the truth.

A canary: a small run of known outcome, which tells a process in which something was changed.

An optimiser shares its process with the objective and the recorder. Whatever it replaced or
overwrote there, a method, an array of the measurement, the generator, shows in what the canary
finds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from hashlib import sha256
from typing import ClassVar

import numpy as np

from springpot.distributions import student
from springpot.errors import LONGEST_REASON
from springpot.identification.problem import SpecimenProblem, watched
from springpot.identification.recorder import Recorder, all_points
from springpot.identification.runs import Card, Optimiser, Run, run, run_batch
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL

from .plan import Cell, Plan, RaceCase, WorkOrder, drawn, noise_free, noisy, problem_of, truth_fits
from .traces import improvements, pack, pack_values

BUDGET = 4
"""A single evaluation, two in a stack, one with its gradient.

About 0.2 ms, which is added to every trial.
"""


@dataclass(frozen=True)
class Canary(Optimiser):
    """Asks for values one by one, in a stack and with a derivative."""

    name: ClassVar[str] = "canary"
    card: ClassVar[Card] = Card("fixed points", gradient=True)

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Evaluate a few points of the box."""
        # By each door of the recorder: whichever of them was tampered with, one of these shows it.
        x = problem.lower + rng.random((3, problem.dimension)) * (problem.upper - problem.lower)
        problem(x[0])
        problem.batch(x[:2])
        problem.gradient(x[2])


def outcome(problem: SpecimenProblem) -> str:
    """What the canary finds, to the last bit."""
    # With a diary: an array that was changed shows in the points that are seen even where the best
    # stays.
    done = run(Canary(), problem, BUDGET, np.random.default_rng(7), diary=True)
    seen = sha256(
        repr((done.status, done.evaluations, done.gradients, done.batched, done.trace)).encode()
    )
    for array in (done.best_x, done.theta, done.point, *(page for page, _ in done.diary or ())):
        seen.update(np.ascontiguousarray(array).tobytes())
    return seen.hexdigest()


def digest_of_objective(problem: SpecimenProblem) -> str:
    """SHA-256 of the data, the weights, the box, and the objective at three points of it."""
    low, high = problem.lower, problem.upper
    # Three places: what was changed may have no part in the value at one of them.
    x: Real = low + np.array([[0.2], [0.5], [0.8]]) * (high - low)
    with np.errstate(all="ignore"):
        value = problem.evaluate(x)
    seen = sha256()
    for array in (low, high, problem.space.lowest, problem.space.highest, *problem.fixed, value):
        seen.update(np.ascontiguousarray(array).tobytes())
    return seen.hexdigest()


@dataclass(frozen=True)
class Witness:
    """What a problem answered in a process that had run no optimiser.

    Parameters
    ----------
    objective, canary : str
        Digests.
    """

    objective: str
    canary: str

    @classmethod
    def of(cls, problem: SpecimenProblem) -> Witness:
        """The witness of a problem as it is now."""
        return cls(digest_of_objective(problem), outcome(problem))

    def complaint(self, problem: SpecimenProblem) -> str:
        """What has changed since, in one line; nothing if all is as it was."""
        try:
            now = Witness.of(problem)
        except Exception as error:
            return (
                f"after the trial a canary failed in its process: {type(error).__name__}: {error}"
            )
        if now.objective != self.objective:
            return "after the trial its process had another objective than before"
        if now.canary != self.canary:
            return "after the trial a canary found something else in its process than before"
        return ""


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
    reference, known, optimum : float or None
        Of its own data, where every repetition draws its noise: as in `RaceCase`.
    covered : float or None
        Share of the parameters whose 95 % interval at the best point holds the truth; None where no
        truth is known, the data have no noise, or there is no interval.
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
    reference: float | None = None
    known: float | None = None
    optimum: float | None = None
    covered: float | None = None


def failure(
    task: WorkOrder, status: Status, reason: str, seconds: float = 0.0
) -> list[TrialResult]:
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

    def run(self, tasks: Sequence[WorkOrder]) -> list[list[TrialResult]]:
        """The results of each task; whatever an optimiser raises becomes a status."""
        results, used = [], dict[int, TwinProblem]()
        for task in tasks:
            bench = self._bench(task)
            if isinstance(bench, Exception):
                error = f"{type(bench).__name__}: {bench}"
                results.append(failure(task, Status.ERROR, error))
            else:
                results.append(self._tried(task, bench))
                used[id(bench)] = bench
        # What a trial itself reports of a fault says more than that the process was changed by it.
        if all(result.status.failed for own in results for result in own):
            return results
        # An optimiser shares the process with the problem: one that has changed it has raced on
        # another.
        for bench in used.values():
            if complaint := bench.witness.complaint(bench.problem):
                return [failure(task, Status.CHANGED, complaint) for task in tasks]
        return results

    def _bench(self, task: WorkOrder) -> TwinProblem | Exception:
        """The problem of a task."""
        number = self.plan.cells[task.cell].case
        bench, case = self._benches[number], self.plan.cases[number]
        if case.noise is None or isinstance(bench, Exception):
            return bench
        return _built(case, self.plan, task.repetitions[0])

    def _tried(self, task: WorkOrder, bench: TwinProblem) -> list[TrialResult]:
        try:
            return self._race(task, self.plan.cells[task.cell], bench)
        # Not within its run only: to keep what it did may be what takes the memory.
        except MemoryError:
            return failure(task, Status.MEMORY, f"needs more than {self.plan.memory} MiB")
        except (Exception, SystemExit) as error:
            return failure(task, Status.ERROR, f"{type(error).__name__}: {error}")

    def _race(self, task: WorkOrder, cell: Cell, bench: TwinProblem) -> list[TrialResult]:
        entrant = self.plan.entrants[cell.entrant]
        # A generator for each repetition: a trial is the same alone, in a batch, and on another
        # worker.
        rngs = [np.random.default_rng(self.plan.stream(cell, r)) for r in task.repetitions]
        target = self.plan.stop_value(bench.case)
        if self.plan.each_its_own(cell):
            return [self._single(task.cell, r, bench, target) for r in task.repetitions]
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

    def _single(self, cell: int, repetition: int, bench: TwinProblem, target: float) -> TrialResult:
        """A trial of data or with a first point of its own."""
        known = self.plan.cells[cell]
        rng = np.random.default_rng(self.plan.stream(known, repetition))
        done = run(
            self.plan.entrants[known.entrant].optimiser,
            bench.problem,
            self.plan.budget,
            rng,
            target,
            bench.noisy,
            self.plan.start(known, repetition),
        )
        result = bench.judge(cell, repetition, done)
        if self.plan.cases[known.case].noise is None:
            return result
        # What a value of these data is worth can be read off no other trial's.
        case = bench.case
        return replace(result, reference=case.reference, known=case.known, optimum=case.optimum)

    def warm_up(self, task: WorkOrder, begun: Callable[[], None] = lambda: None) -> None:
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


def _built(
    case: RaceCase, plan: Plan | None = None, repetition: int = 0
) -> TwinProblem | Exception:
    """A problem ready to run, or why it cannot: that is told by its trials.

    With a plan it has the noise of a repetition.
    """
    try:
        if plan is not None:
            case = drawn(plan, case, repetition)
        bench = TwinProblem(case)
        bench.witness  # noqa: B018  taken now, while no optimiser has run
    except Exception as error:
        return error
    return bench


@dataclass(frozen=True)
class PointWorth:
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


class TwinProblem:
    """A problem with its noise-free twin and its true parameters.

    Parameters
    ----------
    case : RaceCase
        The problem's description.
    """

    def __init__(self, case: RaceCase) -> None:
        self.case, source = case, case.source
        model = source.model_of(case.model)
        self.problem = problem_of(source, model, case.objective)
        clean = noise_free(source)
        self.clean: SpecimenProblem | None = None
        if clean is not None:
            self.clean = self.problem.with_tests(clean)
        # Exact data differ from computed ones by rounding only; their objective is its own oracle.
        self.noisy = clean is not None and noisy(source, clean)
        self.truth: Real | None = None
        if truth_fits(source, model):
            self.truth = model.vector(dict(source.truth))

    @cached_property
    def witness(self) -> Witness:
        """What the problem answers before any optimiser has run."""
        return Witness.of(self.problem)

    def judged(self, point: Real) -> PointWorth:
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
        return PointWorth(value, self.problem.model.named(theta), error, oracle)

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
            covered=self.coverage(done.point),
            **common,  # type: ignore[arg-type]
        )

    def coverage(self, point: Real) -> float | None:
        """Share of the search parameters whose 95 % interval at a point (d,) holds the truth.

        Intervals of least squares: Student's t times the standard error that Jacobian and scatter
        give.
        """
        if self.truth is None or not self.noisy:
            return None
        problem = self.problem
        with np.errstate(all="ignore"):
            x = problem.space.repaired(point)
            residual, jacobian = problem.residuals_and_jacobian(x)
            # Both in widths of the box: parameters are of very different sizes.
            width = problem.upper - problem.lower
            away = (x - problem.space.from_theta(self.truth)) / width
            information = (jacobian * width).T @ (jacobian * width)
            freedom = len(residual) - problem.dimension
            if freedom < 1 or not np.linalg.cond(information) < 1.0 / np.finfo(float).eps:
                return None
            variance = residual @ residual / freedom * np.diag(np.linalg.inv(information))
        inside = np.abs(away) <= student(INTERVAL, freedom) * np.sqrt(variance)
        return float(inside.mean())

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
