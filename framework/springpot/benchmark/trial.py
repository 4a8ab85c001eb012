"""One trial: an optimiser's run on a problem, judged against what is known of the truth.

Its improvements are a trace, kept as compact bytes. Between them a trace is flat, so they hold its
value at every evaluation; `geometric_grid` chooses some. Those of many trials are read together, as
`Traces`.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property, lru_cache
from math import inf

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import student
from springpot.errors import LONGEST_REASON
from springpot.identification.problem import SpecimenProblem, watched
from springpot.identification.recorder import all_points
from springpot.identification.runs import Run, run, run_batch
from springpot.rheology.points import Real
from springpot.thresholds import INTERVAL

from ..numerics import AT_ONCE, ROUNDING
from .plan import Cell, Plan, RaceCase, WorkOrder, drawn, noise_free, noisy, problem_of, truth_fits

# The order of bytes is part of the format: a store may be read on another machine.
_STEP = np.dtype("<u4")
_VALUE = np.dtype("<f8")


def pack(trace: Sequence[tuple[int, float]]) -> bytes:
    """Bytes of a trace of (evaluation, objective) pairs with rising evaluations."""
    if not trace:
        return b""
    # Steps and values apart: small numbers among themselves compress well, and values hardly.
    evaluations, values = zip(*trace, strict=True)
    steps = np.diff(np.array(evaluations, dtype=np.int64), prepend=0).astype(_STEP)
    return _stream(steps.tobytes(), np.array(values, dtype=_VALUE).tobytes())


def _stream(packed: bytes, plain: bytes) -> bytes:
    """A zlib stream (RFC 1950) whose first bytes are compressed, and whose others lie as they are.

    Last digits hardly compress, and steps as well by the format's own table as by one of each
    trace: those of suite_race and suite_rugged are 2 and 4 % longer than by one that tries both,
    made in 0.4 of the time and read in a third.
    """
    head, most = zlib.compressobj(6, strategy=zlib.Z_FIXED), 0xFFFF
    parts = [head.compress(packed), head.flush(zlib.Z_FULL_FLUSH)]
    for first in range(0, len(plain), most):
        block = plain[first : first + most]
        # Whether it is the last, its length and that length's complement (RFC 1951, 3.2.4).
        about = first + most >= len(plain), len(block), len(block) ^ most
        parts += [struct.pack("<BHH", *about), block]
    return b"".join(parts) + struct.pack(">I", zlib.adler32(plain, zlib.adler32(packed)))


def unpack(blob: bytes) -> tuple[NDArray[np.int64], Real]:
    """Evaluations (n,) and values (n,) of a packed trace."""
    raw = zlib.decompress(blob) if blob else b""
    count = len(raw) // (_STEP.itemsize + _VALUE.itemsize)
    # By itself: every trial's is looked at as it comes, and `Traces` is made for many.
    steps = np.frombuffer(raw, _STEP, count)
    return np.cumsum(steps, dtype=np.int64), np.frombuffer(raw, _VALUE, offset=steps.nbytes)


def pack_values(values: Real) -> bytes:
    """Bytes of values (n,) whose evaluation numbers are those of another trace."""
    return zlib.compress(np.asarray(values, dtype=_VALUE).tobytes(), 6)


def unpack_values(blob: bytes) -> Real:
    """Values (n,) of `pack_values`."""
    return np.frombuffer(zlib.decompress(blob), _VALUE)


def improvements(values: Real) -> list[tuple[int, float]]:
    """Trace of the running minimum of `values` (n,), row i being evaluation i + 1."""
    before = np.concatenate([[inf], np.minimum.accumulate(values)[:-1]])
    rows = np.flatnonzero(values < before)
    return list(zip((rows + 1).tolist(), values[rows].tolist(), strict=True))


def geometric_grid(last: int, per_decade: int = 20) -> NDArray[np.int64]:
    """Evaluation numbers (m,) from 1 to `last` in equal ratios, both ends included."""
    steps = np.arange(int(per_decade * np.log10(max(last, 1))) + 1)
    # A power that rounding has left just below a whole number is that number.
    numbers = np.floor(10.0 ** (steps / per_decade) * (1 + ROUNDING)).astype(np.int64)
    return np.unique(np.append(numbers[numbers <= last], last))


def at(evaluations: NDArray[np.int64], values: Real, grid: NDArray[np.int64]) -> Real:
    """Value (m,) of a trace at evaluation numbers `grid` (m,), infinite before its first point."""
    index = np.searchsorted(evaluations, grid, side="right")
    return np.concatenate([[inf], values])[index]


def _places(grid: NDArray[np.int64], evaluations: NDArray[np.int64]) -> NDArray[np.int64]:
    """Where each evaluation (N,) is seen first on a grid, its length where it never is."""
    if grid[-1] < AT_ONCE:
        return _place_of(tuple(grid.tolist())).take(evaluations, mode="clip")
    return np.searchsorted(grid, evaluations)


@lru_cache(maxsize=1)
def _place_of(grid: tuple[int, ...]) -> NDArray[np.int64]:
    """Where each of the numbers 0, 1, ... up to one beyond a grid is seen first on it."""
    return np.searchsorted(grid, np.arange(grid[-1] + 2))


@dataclass(frozen=True, eq=False)
class Traces:
    """The improvements of several trials, one behind the other.

    Parameters
    ----------
    counts : ndarray of int, shape (n,)
        How many each trial has.
    evaluations, values : ndarray, shape (N,)
        Of all of them.
    """

    counts: NDArray[np.int64]
    evaluations: NDArray[np.int64]
    values: Real

    @classmethod
    def of(cls, blobs: Sequence[bytes]) -> Traces:
        """Those of packed traces, an empty one having none."""
        raw = [zlib.decompress(blob) if blob else b"" for blob in blobs]
        each = _STEP.itemsize + _VALUE.itemsize
        counts = np.array([len(one) // each for one in raw], dtype=np.int64)
        ends = (_STEP.itemsize * counts).tolist()
        steps = b"".join([one[:end] for one, end in zip(raw, ends, strict=True)])
        values = b"".join([one[end:] for one, end in zip(raw, ends, strict=True)])
        # Counted on from the trials before, whose sum is then taken off again.
        along = np.zeros(len(steps) // _STEP.itemsize + 1, dtype=np.int64)
        np.cumsum(np.frombuffer(steps, _STEP), out=along[1:])
        begun = np.repeat(along[np.cumsum(counts) - counts], counts)
        return cls(counts, along[1:] - begun, np.frombuffer(values, _VALUE))

    @cached_property
    def owners(self) -> NDArray[np.int64]:
        """Whose each improvement is (N,)."""
        return np.repeat(np.arange(len(self.counts)), self.counts)

    def at(self, worth: Real, grid: NDArray[np.int64]) -> Real:
        """What of `worth` (N,) is seen (n, g) at `grid` (g,), infinite before an improvement."""
        # How many are new at each place of the grid: counted, as to seek each place takes longer.
        trials, width = len(self.counts), len(grid) + 1
        own = _places(grid, self.evaluations) + width * self.owners
        new = np.bincount(own, None, trials * width).reshape(trials, width)[:, :-1]
        seen, before = np.cumsum(new, axis=1), np.cumsum(self.counts) - self.counts
        shown: Real = np.concatenate([[inf], worth])[seen + before[:, None]]
        shown[seen == 0] = inf
        return shown

    def hits(self, goals: Real) -> Real:
        """Evaluation at which each trial reached its goal (n,), infinite where it did not."""
        found = np.full(len(self.counts), inf)
        there = np.flatnonzero(self.values <= goals[self.owners])
        first = there[np.diff(self.owners[there], prepend=-1) > 0]
        found[self.owners[first]] = self.evaluations[first]
        return found

    def means(self, values: Real, last: int) -> Real:
        """Means (n,) over evaluations 1 to `last` of what each improvement is worth (N,).

        Nothing is worth anything before the first one.
        """
        following = np.concatenate([self.evaluations[1:], self.evaluations[:1]])
        following[np.cumsum(self.counts)[self.counts > 0] - 1] = last + 1
        lasting = following - self.evaluations
        return np.bincount(self.owners, lasting * values, len(self.counts)) / last


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
    reference: float | None = None
    known: float | None = None
    optimum: float | None = None
    covered: float | None = None


def contradiction(result: TrialResult, budget: int) -> str:
    """What is wrong with the record of a trial that came to something, or nothing."""
    numbers, values = unpack(result.trace)
    if not len(numbers) or result.best is None:
        return "the trace is missing"
    if not 1 <= result.evaluations <= budget:
        return f"the record counts {result.evaluations} evaluations of {budget}"
    if not 0 <= max(result.gradients, result.batched) <= result.evaluations:
        return "the record counts more evaluations of one kind than of all"
    rising = numbers[0] >= 1 and numbers[-1] <= result.evaluations and np.all(np.diff(numbers) > 0)
    if not (rising and np.all(np.diff(values) < 0)):
        return "the trace contradicts the count of evaluations"
    # Not but for rounding: both are one number that was written down twice.
    if values[-1] != result.best:
        return "the best value is not the last of the trace"
    return ""


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
        return [self._tried(task) for task in tasks]

    def _bench(self, task: WorkOrder) -> TwinProblem | Exception:
        """The problem of a task."""
        number = self.plan.cells[task.cell].case
        bench, case = self._benches[number], self.plan.cases[number]
        if case.noise is None or isinstance(bench, Exception):
            return bench
        return _built(case, self.plan, task.repetitions[0])

    def _tried(self, task: WorkOrder) -> list[TrialResult]:
        bench = self._bench(task)
        if isinstance(bench, Exception):
            return failure(task, Status.ERROR, f"{type(bench).__name__}: {bench}")
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
        return TwinProblem(case)
    except Exception as error:
        return error


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
        # The thermodynamic order kinf > k0 is restored in it.
        error = oracle = None
        with np.errstate(all="ignore"):
            if self.truth is not None:
                error = relative_error(done.theta, self.truth)
            if self.clean is not None:
                oracle = float(self.clean.evaluate(done.best_x))
        recommended, seen = self._without_noise(done)
        return TrialResult(
            cell,
            repetition,
            status,
            best=float(done.best),
            theta=self.problem.model.named(done.theta),
            parameter_error=error,
            oracle=oracle,
            trace=pack(done.trace),
            recommended=recommended,
            seen=seen,
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
