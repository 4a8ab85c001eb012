"""A resolved study: problems, entrants and cells, each known by a digest of its content.

A plan holds data, not files or names to look up, so that it can cross to a worker once and be used
there. A case is a problem with its reference, its optimum where that is known beforehand, and the
noise that a repetition draws.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256

import numpy as np

from springpot.identification.native import fit, minima_in_box
from springpot.identification.problem import Objective, Problem, SpecimenProblem
from springpot.identification.runs import BatchedOptimiser, Optimiser, options_of
from springpot.identification.space import rounded_up
from springpot.measurement.measurement import Measurement
from springpot.measurement.opening import Test, sweep_of
from springpot.measurement.rows import told_of
from springpot.measurement.scatter import with_noise
from springpot.measurement.timetest import TimeTest
from springpot.numerics import ALIKE
from springpot.registry import parse_model
from springpot.rheology.model import Model
from springpot.rheology.points import Complex, Real

SCHEME = 1
"""Version of what a trial is; a change to it makes every stored trial count as another one."""

COMMON = "common"
"""All optimisers of a repetition are given the same first point."""

ASKED = ("question", "measure", "what would answer it")
"""What a study says before its tables, where it does."""

BLOCK = 50
"""Repetitions that a batched optimiser runs at once.

What Python costs for each call is then shared by all of them
(the paper's swarm takes two thirds of its time with 25). Each gives the same bits alone (the
contract of a batched optimiser), so that only those that are missing are run.
"""


def digest_of(*parts: object) -> str:
    """SHA-256 of a sequence of plain values, free of ambiguity between neighbours."""
    return sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


@dataclass(frozen=True, eq=False)
class Source:
    """What was measured on a specimen, and what is known of its truth.

    Parameters
    ----------
    name : str
        The data set's name.
    tests : tuple of Test
        The data: a sweep, or tests in time and sweeps of one specimen.
    digest : str
        Of the data's content.
    kind : str
        ``measured``, ``artificial`` or ``reconstruction``.
    model : str
        Expression of the model behind the data, empty if unknown.
    truth : mapping of str to float
        Its element parameters, empty if unknown.
    stiffness_scale : float or None
        k-bar of the search box, where it is given.
    objective : str
        By which it is raced where a study says ``"own"``, empty if nobody says.
    best : float or None
        Least objective known in the box, of its own model by its own objective.
    """

    name: str
    tests: tuple[Test, ...]
    digest: str
    kind: str
    model: str
    truth: Mapping[str, float]
    stiffness_scale: float | None
    objective: str = ""
    best: float | None = None

    @property
    def sweep(self) -> Measurement | None:
        """The sweep that stands alone; None where there are tests in time."""
        return sweep_of(self.tests)

    def model_of(self, expression: str) -> Model:
        """A model as these data can have it, with a parameter for each level of a column."""
        from springpot.timetests import as_had_by

        return as_had_by(parse_model(expression), self.tests)


@dataclass(frozen=True)
class DrawnNoise:
    """Noise of which every repetition draws its own.

    Parameters
    ----------
    level : float
        Of eq. (53), with both signs.
    seed : int
        The study's.
    of : str
        Name of the data to which it is added.
    """

    level: float
    seed: int
    of: str


@dataclass(frozen=True, eq=False)
class RaceCase:
    """One problem of a study: data, a model and an objective.

    Parameters
    ----------
    source : Source
        The data.
    model : str
        Canonical model expression.
    objective : Objective
        How the misfit is measured.
    reference : float
        Objective at the centre of the search box, or without any response where that is less: what
        a target is a fraction of.
    known : float or None
        Objective at the true parameters, if this model made the data.
    optimum : float or None
        Smallest objective in the box, where it is wanted and could be found beforehand.
    noise : DrawnNoise or None
        What every repetition adds to the data; then all of the above is that of data without it.
    """

    source: Source
    model: str
    objective: Objective
    reference: float
    known: float | None
    optimum: float | None = None
    noise: DrawnNoise | None = None

    @property
    def digest(self) -> str:
        """Digest of the problem's content."""
        noise: list[object] = []
        if self.noise is not None:
            noise = [self.noise.level, self.noise.seed]
        scale = self.source.stiffness_scale
        if scale is not None:
            # Read off data that are computed, it ends in other bits on another processor.
            scale = told_of(scale)
        return digest_of(
            SCHEME,
            self.source.name,
            self.source.digest,
            scale,
            self.model,
            self.objective.name,
            *noise,
        )


@dataclass(frozen=True)
class Entrant:
    """An optimiser with its options, under the label that tables show."""

    label: str
    optimiser: Optimiser

    @property
    def options(self) -> str:
        """The options as canonical JSON."""
        return json.dumps(options_of(self.optimiser), sort_keys=True)


@dataclass(frozen=True)
class Cell:
    """One problem and one entrant; its repetitions are the trials."""

    index: int
    case: int
    entrant: int
    digest: str


@dataclass(frozen=True, slots=True)
class WorkOrder:
    """What a worker is told to do: repetitions of one cell, by number."""

    cell: int
    repetitions: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Plan:
    """A study with everything looked up; see `Study` for the meaning of the fields."""

    name: str
    cases: tuple[RaceCase, ...]
    entrants: tuple[Entrant, ...]
    cells: tuple[Cell, ...]
    repetitions: int
    budget: int
    seed: int
    target: float
    accuracy: float
    stop_at_target: bool
    deadline: float
    memory: int
    requirements: Mapping[str, float]
    x0: str = "own"
    noise: tuple[float, ...] = ()
    asks: tuple[str, ...] = ()

    @property
    def size(self) -> int:
        """Number of trials."""
        return len(self.cells) * self.repetitions

    @property
    def levels(self) -> dict[str, float]:
        """Level of noise of each data set whose truth is known."""
        told = dict[str, float]()
        for case in self.cases:
            if case.noise is not None:
                told[case.source.name] = case.noise.level
            elif case.source.truth:
                told[case.source.name] = 0.0
        return told

    def stream(self, cell: Cell, repetition: int) -> np.random.SeedSequence:
        """The trial's random stream, from names only and the same for every optimiser."""
        case = self.cases[cell.case]
        # Common random numbers: what differs between two optimisers is then less often luck.
        return stream_of(self.seed, case.source.name, case.model, case.objective.name, repetition)

    def start(self, cell: Cell, repetition: int) -> Real | None:
        """The first point (d,) in the unit cube that all optimisers share; None of their own."""
        if self.x0 != COMMON:
            return None
        case = self.cases[cell.case]
        data = case.source.name
        if case.noise is not None:
            data = case.noise.of
        rng = np.random.default_rng(stream_of(self.seed, "x0", data, case.model, repetition))
        return rng.random(len(case.source.model_of(case.model).names))

    def each_its_own(self, cell: Cell) -> bool:
        """Whether repetitions differ by more than an optimiser's random numbers."""
        return self.x0 == COMMON or self.cases[cell.case].noise is not None

    def stop_value(self, case: RaceCase) -> float:
        """Objective at which a run may end."""
        if not self.stop_at_target or case.optimum is None:
            return -np.inf
        return case.optimum + self.target * (case.reference - case.optimum)

    def flown_together(self, task: WorkOrder) -> bool:
        """Whether its repetitions are run side by side."""
        optimiser = self.entrants[self.cells[task.cell].entrant].optimiser
        stochastic = optimiser.card.stochastic
        return isinstance(optimiser, BatchedOptimiser) and stochastic and len(task.repetitions) > 1

    def runs_of(self, task: WorkOrder) -> int:
        """How many runs a task is."""
        # One stands for all of an optimiser without randomness.
        if not self.entrants[self.cells[task.cell].entrant].optimiser.card.stochastic:
            return 1
        # One of those flown together is run alone as well, for its time.
        return len(task.repetitions) + self.flown_together(task)

    def tasks(self, finished: Callable[[Cell], set[int]]) -> Iterator[WorkOrder]:
        """The work still to do, lazily: a study of a million trials needs no list of them.

        It goes from optimiser to optimiser, because trials of two never share a process.

        Parameters
        ----------
        finished : callable
            Repetitions of a cell that are done.
        """
        # Sorting keeps the order among equals: the problems of each optimiser come as the study
        # names them.
        for cell in sorted(self.cells, key=lambda cell: cell.entrant):
            done = finished(cell)
            optimiser = self.entrants[cell.entrant].optimiser
            together = isinstance(optimiser, BatchedOptimiser) or not optimiser.card.stochastic
            if together and not self.each_its_own(cell):
                for first in range(0, self.repetitions, BLOCK):
                    block = tuple(range(first, min(first + BLOCK, self.repetitions)))
                    missing = tuple(r for r in block if r not in done)
                    # One run of an optimiser without randomness stands for all: it is told of all
                    # of them anew.
                    if missing and not optimiser.card.stochastic:
                        missing = block
                    if missing:
                        yield WorkOrder(cell.index, missing)
            else:
                yield from (
                    WorkOrder(cell.index, (r,)) for r in range(self.repetitions) if r not in done
                )


def stream_of(seed: int, *names: object) -> np.random.SeedSequence:
    """A random stream derived from names, never from order, worker or clock."""
    # 128 bits, which is all that a SeedSequence holds of its entropy.
    return np.random.SeedSequence(int(digest_of("stream", SCHEME, seed, *names)[:32], 16))


def cell_digest(
    case: RaceCase, entrant: Entrant, budget: int, seed: int, stop: float, x0: str = "own"
) -> str:
    """Digest of a cell: the problem, the optimiser with its options, the budget and the seed."""
    stop_text = None
    # JSON, of which the digest is made, has no word for infinity.
    if stop != -np.inf:
        stop_text = told_of(stop)
    parts = [case.digest, entrant.optimiser.name, entrant.options, budget, seed, stop_text]
    # Not written where every optimiser begins as it likes, as all trials did before there was this.
    if x0 == COMMON:
        parts.append(x0)
    return digest_of(*parts)


AGREEING = 5
"""Descents within the box that must end at the same value before it is taken for the optimum."""


def with_noise_axis(
    source: Source, levels: Sequence[float], seed: int
) -> list[tuple[Source, DrawnNoise | None]]:
    """The data at each level of noise; those in time or of unknown truth stay as they are.

    At level zero they have no noise. Above it they hold the noise-free data too, to which every
    repetition adds its own noise.
    """
    clean = noise_free(source)
    # Eq. (53) is of sweeps.
    if not levels or clean is None or source.sweep is None:
        return [(source, None)]
    if not noisy(source, clean):
        # To the last bit what the data set holds, so that its trials are those of other studies.
        clean = source.tests
    (sweep,) = clean
    assert isinstance(sweep, Measurement)
    scale = source.stiffness_scale
    if scale is None:
        # Read off what has no noise: all repetitions search the same box.
        scale = rounded_up(float(np.max(sweep.magnitude)))
    # What is the best of the data with their own noise says nothing of other draws.
    exact = replace(source, tests=clean, digest=sweep.digest(), best=None)
    found: list[tuple[Source, DrawnNoise | None]] = []
    for level in levels:
        if level == 0.0:
            found.append((exact, None))
            continue
        name = f"{source.name}+{100 * level:g}%"
        drawn = DrawnNoise(level, seed, source.name)
        found.append((replace(exact, name=name, stiffness_scale=scale), drawn))
    return found


def noisy(source: Source, clean: Sequence[Test]) -> bool:
    """Whether data differ from those without noise by more than rounding."""
    return not all(
        np.allclose(_numbers(exact), _numbers(test), rtol=ALIKE, atol=0.0)
        for exact, test in zip(clean, source.tests, strict=True)
    )


def _numbers(test: Test) -> Real | Complex:
    if isinstance(test, Measurement):
        return test.stiffness
    assert isinstance(test, TimeTest)
    return test.response


def drawn(plan: Plan, case: RaceCase, repetition: int) -> RaceCase:
    """The case as a repetition has it: with noise of its own where the study draws noise."""
    noise = case.noise
    if noise is None:
        return case
    # From the names of the data and the repetition only: models, objectives, optimisers and levels
    # share a draw, whatever process asks for it.
    rng = np.random.default_rng(stream_of(noise.seed, "noise", noise.of, repetition))
    sweep = case.source.sweep
    assert sweep is not None
    data = with_noise(sweep, noise.level, rng, symmetric=True)
    source = replace(case.source, tests=(data,), digest="")
    wanted = None
    if plan.stop_at_target:
        wanted = plan.target
    return case_of(source, case.model, case.objective, wanted)


def case_of(
    source: Source, expression: str, objective: Objective, target: float | None
) -> RaceCase:
    """The problem of a model on data by an objective.

    Parameters
    ----------
    source : Source
        The data.
    expression : str
        The model.
    objective : Objective
        How the misfit is measured.
    target : float or None
        Fraction at which trials will end, if they will: the optimum is looked for only then.
    """
    model = source.model_of(expression)
    # Here already: a model that does not fit its data is told before the first trial.
    problem = problem_of(source, model, objective)
    reference = reference_of(problem)
    known = None
    if truth_fits(source, model):
        with np.errstate(all="ignore"):
            known = float(problem.evaluate(problem.space.from_theta(_truth(source, model))))
    optimum = None
    if target is not None and source.best is not None and objective.name == source.objective:
        if parse_model(source.model).name == model.name:
            optimum = source.best
    elif target is not None and isinstance(problem, Problem):
        optimum = _optimum(problem, reference, known, target)
    return RaceCase(source, model.name, objective, reference, known, optimum)


def problem_of(source: Source, model: Model, objective: Objective) -> SpecimenProblem:
    """A model on the data of a source: of a sweep, or of all tests of a specimen together."""
    from springpot.timetests.fitting import InTimeProblem

    sweep = source.sweep
    if sweep is not None:
        return Problem.of(model, sweep, objective, source.stiffness_scale)
    return InTimeProblem.alike(model, source.tests, objective, source.stiffness_scale)


def reference_of(problem: SpecimenProblem) -> float:
    """Objective from which progress is measured.

    At the centre of the box, or of no answer at all if that is less.

    Where the centre is absurd (a box far too large, an inertia at high frequency) its objective
    says nothing of the data, and a millionth of it would be reached by fits that are of no use.
    """
    with np.errstate(all="ignore"):
        centre = problem.evaluate(0.5 * (problem.lower + problem.upper))
        nothing = problem.nothing
    # No answer has no logarithm.
    return float(np.fmin(centre, nothing))


def _optimum(
    problem: Problem, reference: float, known: float | None, target: float
) -> float | None:
    """Smallest objective in the box; None where that is not certain.

    It is where the native solver, which knows no box, finds nothing better outside, or where
    several descents within the box end at the same value.
    """
    # The native solver is told nothing of the box: it says what there is at best.
    unbounded = fit(problem.model, problem.measurement, problem.objective)
    least = np.inf
    with np.errstate(all="ignore"):
        x = np.clip(problem.space.from_theta(unbounded.theta), problem.lower, problem.upper)
        if np.all(np.isfinite(x)):
            least = float(problem.evaluate(x))
    if known is not None:
        least = min(least, known)
    # What rounding and the ends of the box cost must not matter beside the target.
    slack = 0.01 * target * (reference - unbounded.cost)
    if least - unbounded.cost <= slack:
        return least
    minima = minima_in_box(problem)
    least = float(minima[0])
    # Descents that agree on what is above the truth have all missed the optimum.
    missed = known is not None and known < least - slack
    if missed or not minima[AGREEING - 1] - least <= slack:
        return None
    return least


def truth_fits(source: Source, model: Model) -> bool:
    """Whether the true parameters are those of this model."""
    return (
        bool(source.truth)
        and parse_model(source.model).name == model.name
        and set(source.truth) == set(model.names)
    )


def noise_free(source: Source) -> tuple[Test, ...] | None:
    """The data as they would be without noise, where the truth is known."""
    if not source.truth:
        return None
    from springpot.timetests import answered

    model = source.model_of(source.model)
    return answered(model, _truth(source, model), source.tests)


def _truth(source: Source, model: Model) -> Real:
    return model.vector(dict(source.truth))


@dataclass(frozen=True)
class ProblemRow:
    """What the store knows of one problem."""

    id: int
    dataset: str
    kind: str
    points: int
    stiffness_unit: str
    model: str
    objective: str
    reference: float
    known: float | None
    truth: Mapping[str, float]
    digest: str = ""
