"""Races where an evaluation is what costs: few of them, several at the same time.

Time is that of a simulated clock: every evaluation takes its own time on one of some workers, as
drawn by chance, so that the same seed gives the same race on any machine. An optimiser that can be
asked (`springpot.identification.AskingOptimiser`) gives a free worker its next point at once. Any
other is served as it asks: a point or a derivative on one worker while the others wait, a batch on
all of them. What an optimiser itself needs to think is measured beside it, and is not in the clock.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from heapq import heapify, heappop, heappush, heapreplace
from time import process_time
from typing import Protocol, TypeVar

import numpy as np

from springpot.errors import StudyError
from springpot.identification import (
    AskingOptimiser,
    BudgetSpent,
    Enquiry,
    Optimiser,
    Recorder,
    Searched,
)
from springpot.report.page import Entry, Table
from springpot.rheology.points import Real

from .plan import stream_of
from .statistics import mean_ranks

MARKS = (10, 20, 50, 100, 200)
"""Evaluations at which optimisers are compared."""
T = TypeVar("T")


@dataclass(frozen=True)
class Site:
    """Where evaluations are made.

    Parameters
    ----------
    workers : int
        Evaluations at the same time.
    seconds : float
        Median time of one.
    spread : float
        Standard deviation of its logarithm.
    """

    workers: int = 4
    seconds: float = 0.05
    spread: float = 0.3

    def __post_init__(self) -> None:
        if self.workers < 1 or not self.seconds > 0 or self.spread < 0:
            raise StudyError("a site has at least one worker, and evaluations that take time")


@dataclass(frozen=True, eq=False)
class PacedRun:
    """What came of a run.

    Parameters
    ----------
    ended : ndarray, shape (n,)
        When each evaluation was ready, in the order in which they were.
    values : ndarray, shape (n,)
        The objective.
    thought : float
        Seconds of processor time that the optimiser itself took.
    """

    ended: Real
    values: Real
    thought: float

    def after(self, evaluations: int) -> float:
        """Least objective of the first evaluations that were ready."""
        return float(np.min(self.values[:evaluations], initial=np.inf))

    def by(self, seconds: float) -> float:
        """Least objective of what was ready by then."""
        return self.after(int(np.searchsorted(self.ended, seconds, side="right")))


class WorkerPool(Protocol):
    """Where points are given to, and where they come back from as they are ready."""

    @property
    def full(self) -> bool:
        """Whether no worker is free."""

    def give(self, u: Real) -> None:
        """Let a point (d,) be evaluated."""

    def take(self) -> tuple[Real, float]:
        """The next point that is ready, and its objective."""


def asked(enquiry: Enquiry, pool: WorkerPool, budget: int) -> None:
    """Keep every worker busy until the budget is spent."""
    given = 0
    for _ in range(budget):
        while given < budget and not pool.full:
            pool.give(enquiry.ask())
            given += 1
        enquiry.tell(*pool.take())


class _Clock:
    """Workers, when each is free, and what was ready when."""

    def __init__(self, site: Site, rng: np.random.Generator) -> None:
        self._site, self._rng = site, rng
        self._free = [0.0] * site.workers
        self.now = self.evaluating = 0.0
        self.ready: list[tuple[float, float]] = []

    def lasting(self) -> float:
        """How long the next evaluation takes."""
        return float(self._site.seconds * np.exp(self._site.spread * self._rng.standard_normal()))

    def evaluated(self, call: Callable[[], T]) -> T:
        """What a call for values gives, its processor time set apart from the optimiser's."""
        start = process_time()
        try:
            return call()
        finally:
            self.evaluating += process_time() - start

    def pass_over(self, values: Sequence[float]) -> None:
        """Let values be computed on all workers, and wait for the last."""
        free, latest = [self.now] * self._site.workers, self.now
        heapify(free)
        for value in values:
            end = free[0] + self.lasting()
            heapreplace(free, end)
            latest = max(latest, end)
            self.ready.append((end, value))
        self.now = latest

    def course(self, started: float) -> PacedRun:
        """All that was ready, the first first."""
        thought = process_time() - started - self.evaluating
        ready = np.array(sorted(self.ready, key=lambda each: each[0])).reshape(-1, 2)
        return PacedRun(ready[:, 0], ready[:, 1], max(thought, 0.0))


class _Simulated:
    """A pool on a clock."""

    def __init__(self, problem: Recorder, clock: _Clock, workers: int) -> None:
        self._problem, self._clock, self._workers = problem, clock, workers
        self._out: list[tuple[float, int, Real]] = []
        self._given = 0

    @property
    def full(self) -> bool:
        return len(self._out) >= self._workers

    def give(self, u: Real) -> None:
        self._given += 1
        heappush(self._out, (self._clock.now + self._clock.lasting(), self._given, u))

    def take(self) -> tuple[Real, float]:
        self._clock.now, _, u = heappop(self._out)
        problem = self._problem
        x = problem.lower + u * (problem.upper - problem.lower)
        value = self._clock.evaluated(lambda: problem(x))
        self._clock.ready.append((self._clock.now, value))
        return u, value


class OnThreads:
    """A pool of an executor's workers, for evaluations that take their time in earnest.

    Parameters
    ----------
    executor : concurrent.futures.Executor
        Whose workers evaluate.
    objective : callable
        Objective at a point (d,) of the unit cube.
    workers : int
        Points that are out at the same time.
    """

    def __init__(
        self, executor: Executor, objective: Callable[[Real], float], workers: int
    ) -> None:
        self._executor, self._objective, self._workers = executor, objective, workers
        self._out: dict[Future[float], Real] = {}

    @property
    def full(self) -> bool:
        """Whether no worker is free."""
        return len(self._out) >= self._workers

    def give(self, u: Real) -> None:
        """Let a point (d,) be evaluated."""
        self._out[self._executor.submit(self._objective, u)] = u

    def take(self) -> tuple[Real, float]:
        """The next point that is ready, and its objective."""
        done = next(iter(wait(self._out, return_when=FIRST_COMPLETED).done))
        return self._out.pop(done), done.result()


class _Paced(Recorder):
    """A recorder whose evaluations take their time on the clock."""

    _clock: _Clock

    @classmethod
    def on(cls, clock: _Clock, problem: Searched, budget: int) -> _Paced:
        made = cls(problem, budget)
        made._clock = clock
        return made

    def __call__(self, x: Real) -> float:
        value = self._clock.evaluated(lambda: Recorder.__call__(self, x))
        self._clock.pass_over([value])
        return value

    def batch(self, x: Real, factor: Real | None = None) -> Real:
        count = min(len(x), self.left)
        values = self._clock.evaluated(lambda: Recorder.batch(self, x, factor))
        self._clock.pass_over(values[:count].tolist())
        return values

    def gradient(self, x: Real) -> tuple[float, Real]:
        value, slope = self._clock.evaluated(lambda: Recorder.gradient(self, x))
        self._clock.pass_over([value])
        return value, slope

    def residuals(self, x: Real) -> tuple[Real, Real]:
        residual, jacobian = self._clock.evaluated(lambda: Recorder.residuals(self, x))
        self._clock.pass_over([float(residual @ residual)])
        return residual, jacobian

    def misfit(self, x: Real) -> Real:
        residual = self._clock.evaluated(lambda: Recorder.misfit(self, x))
        self._clock.pass_over([float(residual @ residual)])
        return residual

    def residual_batch(self, x: Real) -> tuple[Real, Real]:
        count = min(len(x), self.left)
        found = self._clock.evaluated(lambda: Recorder.residual_batch(self, x))
        self._clock.pass_over(np.einsum("ij,ij->i", found[0], found[0])[:count].tolist())
        return found


def paced_run(
    optimiser: Optimiser, problem: Searched, budget: int, site: Site, seed: int, *names: object
) -> PacedRun:
    """Let an optimiser search on a site.

    Parameters
    ----------
    optimiser : Optimiser
        With its options.
    problem : Problem, or whatever else can be searched
        What is minimised.
    budget : int
        Evaluations that are made at most.
    site : Site
        Where.
    seed, names : int, object
        What all randomness comes of; the times of evaluations are the same for all optimisers.
    """
    clock = _Clock(site, np.random.default_rng(stream_of(seed, "times", *names)))
    rng = np.random.default_rng(stream_of(seed, "expensive", *names))
    recorder, started = _Paced.on(clock, problem, budget), process_time()
    with np.errstate(all="ignore"):
        if isinstance(optimiser, AskingOptimiser):
            enquiry = optimiser.enquiry(problem.dimension, budget, rng)
            plain = Recorder(problem, budget)
            asked(enquiry, _Simulated(plain, clock, site.workers), budget)
        else:
            with suppress(BudgetSpent):
                optimiser.minimise(recorder, budget, rng)
    return clock.course(started)


def expensive_table(
    courses: Mapping[str, Sequence[Sequence[PacedRun]]], site: Site, marks: Sequence[int] = MARKS
) -> Table:
    """Mean ranks over problems after some evaluations and by some times, the best at last first.

    Parameters
    ----------
    courses : mapping of str to sequence of sequence of PacedRun
        By optimiser, for each problem its repetitions.
    site : Site
        Where they ran.
    marks : sequence of int
        Evaluations at which they are compared; times are those in which all workers make as many.
    """
    labels = list(courses)
    times = [site.seconds * mark / site.workers for mark in marks]
    ranks = [_ranks(courses, partial(_after, mark)) for mark in marks]
    ranks += [_ranks(courses, partial(_by, time)) for time in times]
    rows: list[tuple[Entry, ...]] = []
    for i in np.argsort(ranks[-1], kind="stable"):
        all_of = [course for problem in courses[labels[i]] for course in problem]
        own = float(np.median([course.thought / len(course.values) for course in all_of]))
        rows.append((labels[i], *(float(each[i]) for each in ranks), 1000.0 * own))
    columns = (
        "optimiser",
        *(f"rank, {mark} evaluations" for mark in marks),
        *(f"rank, {time:.3g} s" for time in times),
        "own ms an evaluation",
    )
    problems = len(next(iter(courses.values())))
    note = (
        f"Mean ranks over {problems} problems by the median objective of the repetitions."
        f" Evaluations take {1000 * site.seconds:g} ms (median) on {site.workers} workers, by a"
        " simulated clock. After as many evaluations nobody's time matters; by as many seconds"
        " those that can be asked for several points at once are ahead. Who ends before keeps what"
        " it had. The last column is processor time of the optimiser itself for each evaluation:"
        " a surrogate pays only while it is less than what an evaluation takes."
    )
    return Table("Expensive evaluations", columns, rows, note)


def _after(evaluations: int, course: PacedRun) -> float:
    return course.after(evaluations)


def _by(seconds: float, course: PacedRun) -> float:
    return course.by(seconds)


def _ranks(
    courses: Mapping[str, Sequence[Sequence[PacedRun]]], worth: Callable[[PacedRun], float]
) -> Real:
    found = np.array(
        [
            [np.median([worth(course) for course in repetitions]) for repetitions in problems]
            for problems in courses.values()
        ]
    )
    return mean_ranks(found.T)
