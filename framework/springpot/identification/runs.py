"""One supervised run of an optimiser, and what came of it according to the recorder.

What an optimiser is: a frozen dataclass of options with a capability card and one method; one that
is asked for points and told values may have several out at once. Whether the record of a run
contradicts itself or the problem, as far as another process can still check.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from enum import Enum
from math import inf
from time import perf_counter, process_time
from typing import Any, ClassVar, NamedTuple

import numpy as np

from springpot.errors import OptionError, StudyError
from springpot.rheology.points import Real

from .problem import Searched
from .recorder import BudgetSpent, Diary, Recorder, RecorderGroup


@dataclass(frozen=True)
class Card:
    """What an optimiser needs and can do.

    Parameters
    ----------
    summary : str
        One sentence on the method.
    citation : str
        Its source.
    globally : bool
        Searches the whole box rather than descending from one point.
    gradient : bool
        Uses exact derivatives.
    batched : bool
        Carries several repetitions side by side: a `BatchedOptimiser`.
    stochastic : bool
        Depends on the generator.
    started : bool
        Begins at the race's common first point where there is one (`Recorder.start`).
    distribution : str
        The installed distribution that does the work, whose version is written beside results.
    """

    summary: str
    citation: str = ""
    globally: bool = True
    gradient: bool = False
    batched: bool = False
    stochastic: bool = True
    started: bool = False
    distribution: str = ""


class Optimiser(ABC):
    """Base of all optimisers; a plugin is a frozen dataclass of this with its options as fields."""

    name: ClassVar[str]
    card: ClassVar[Card]

    @abstractmethod
    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Search until done or until the recorder ends the run.

        Parameters
        ----------
        problem : Recorder
            Call it for values; it counts, keeps the best point and raises when the budget is spent.
        budget : int
            Evaluations that will be counted before that.
        rng : numpy.random.Generator
            The only source of randomness.
        """

    def _require(self, option: str, holds: bool, rule: str) -> None:
        """Check an option in ``__post_init__``.

        Raises
        ------
        OptionError
            If the rule does not hold.
        """
        if not holds:
            raise OptionError(
                f"{self.name}: option {option} is {getattr(self, option)!r} but must be {rule}"
            )


class BatchedOptimiser(Optimiser):
    """An optimiser that carries several runs side by side; a single run is a batch of one."""

    @abstractmethod
    def minimise_batch(
        self, problems: RecorderGroup, budget: int, rngs: Sequence[np.random.Generator]
    ) -> None:
        """Search as `minimise` does for each run, with bit-identical results.

        Parameters
        ----------
        problems : RecorderGroup
            Values of all runs in one call.
        budget : int
            Evaluations of each run.
        rngs : sequence of numpy.random.Generator
            The only source of randomness of each run.
        """

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Search with a batch of one run."""
        self.minimise_batch(RecorderGroup([problem]), budget, [rng])


@dataclass(frozen=True)
class OptimiserFamily:
    """The optimisers of a large library, imported only when one of them is asked for.

    Parameters
    ----------
    name : str
        As listed: what all their names begin with, and ``NAME``, such as ``optimagic-NAME``.
    summary : str
        One sentence on the library.
    members : callable
        Imports the library and gives its optimisers by name.
    """

    name: str
    summary: str
    members: Callable[[], Mapping[str, type[Optimiser]]]

    @property
    def prefix(self) -> str:
        """What all their names begin with."""
        return self.name.removesuffix("NAME")


def options_of(optimiser: Optimiser) -> dict[str, Any]:
    """An optimiser's options as plain values.

    Raises
    ------
    StudyError
        If one of them is no plain value: it could not be told from another.
    """
    # An optimiser without options need not be one.
    if not is_dataclass(optimiser):
        return {}
    return {
        f.name: _plain(getattr(optimiser, f.name), f"{optimiser.name}.{f.name}")
        for f in fields(optimiser)
    }


def _plain(value: Any, where: str) -> Any:
    if value is None or isinstance(value, bool | int | float | str):
        # A word of an enumeration may be a string as well.
        if isinstance(value, Enum):
            return value.value
        return value
    if isinstance(value, Enum):
        return _plain(value.value, where)
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _plain(item, where) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(item, where) for item in value]
    if is_dataclass(value) and not isinstance(value, type):
        return {f.name: _plain(getattr(value, f.name), where) for f in fields(value)}
    kind = type(value).__name__
    raise StudyError(
        f"option {where} is a {kind}: options must be numbers, texts or sequences of them"
    )


class Unrecorded(Exception):
    """An optimiser has evaluated points where nobody counts them."""


@dataclass(frozen=True, eq=False)
class Run:
    """What one run found, as the recorder has it; nothing that a library claims.

    Parameters
    ----------
    optimiser : str
        Its name.
    status : str
        ``budget``, ``target``, ``converged`` (ended by itself before either) or ``failed: REASON``.
    best : float
        Smallest objective recorded.
    best_x : ndarray, shape (d,)
        Where, in search parameters and with the order kinf > k0 restored; NaN if no value was
        finite.
    theta : ndarray, shape (p,)
        The same in element parameters.
    evaluations, gradients, batched : int
        Points evaluated, how many of them with a derivative, and how many in calls for several at
        once.
    seconds, processor : float
        Duration of the optimiser's own call and processor time of this process in it; in a batch,
        an equal share.
    trace : tuple of (int, float)
        Evaluation number and objective at every improvement.
    diary : list, optional
        Every point evaluated, if that was asked for.
    point : ndarray, shape (d,)
        Where it was best, as it was evaluated; empty if no value was finite.
    remarks : tuple of str
        What the optimiser said of it.
    """

    optimiser: str
    status: str
    best: float
    best_x: Real
    theta: Real
    evaluations: int
    gradients: int
    seconds: float
    trace: tuple[tuple[int, float], ...]
    batched: int = 0
    diary: Diary | None = None
    point: Real = field(default_factory=lambda: np.empty(0))
    processor: float = 0.0
    remarks: tuple[str, ...] = ()

    @property
    def failed(self) -> bool:
        """Whether the run ended by a fault."""
        return self.status.startswith("failed")


def run(
    optimiser: Optimiser,
    problem: Searched,
    budget: int,
    rng: np.random.Generator,
    target: float = -inf,
    diary: bool = False,
    start: Real | None = None,
) -> Run:
    """Let `optimiser` minimise `problem`.

    Parameters
    ----------
    optimiser : Optimiser
        With its options.
    problem : Problem, or whatever else can be searched
        What is minimised.
    budget : int
        Evaluations that are made at most.
    rng : numpy.random.Generator
        The only source of randomness.
    target : float
        The run ends once the objective is this small.
    diary : bool
        Keep every point evaluated.
    start : ndarray, shape (d,), optional
        First point that is evaluated, in the unit cube of the box, whatever the optimiser does; it
        is told of it as `Recorder.start`.

    Raises
    ------
    OptionError
        If the budget is not positive.
    """
    if start is not None:
        start = problem.lower + start * (problem.upper - problem.lower)
    recorder = Recorder(problem, _checked(budget), target, _pages(diary), start)
    # Counted by the problem too: an optimiser that goes around the recorder is found out.
    before = problem.tally.points

    def search() -> None:
        if start is not None:
            recorder(start)
        optimiser.minimise(recorder, budget - recorder.evaluations, rng)

    spent, fault = _supervised(search)
    fault = fault or _past([recorder], problem.tally.points - before)
    return _outcome(optimiser.name, recorder, spent, fault)


def run_batch(
    optimiser: Optimiser,
    problem: Searched,
    budget: int,
    rngs: Sequence[np.random.Generator],
    target: float = -inf,
    diary: bool = False,
) -> list[Run]:
    """One run for each generator, side by side where the optimiser can.

    The results are those of `run`.

    One run of an optimiser that is not stochastic stands for all.
    """
    if rngs and not optimiser.card.stochastic:
        return [run(optimiser, problem, budget, rngs[0], target, diary)] * len(rngs)
    if not isinstance(optimiser, BatchedOptimiser) or not rngs:
        return [run(optimiser, problem, budget, rng, target, diary) for rng in rngs]
    recorders = [Recorder(problem, _checked(budget), target, _pages(diary)) for _ in rngs]
    group, before = RecorderGroup(recorders), problem.tally.points
    spent, fault = _supervised(lambda: optimiser.minimise_batch(group, budget, rngs))
    fault = fault or _past(recorders, problem.tally.points - before)
    # Side by side nobody knows whose second it was.
    share = Spent(spent.seconds / len(recorders), spent.processor / len(recorders))
    return [_outcome(optimiser.name, each, share, fault) for each in recorders]


def _checked(budget: int) -> int:
    if budget < 1:
        raise OptionError(f"the budget is {budget} evaluations but must be at least 1")
    return budget


class Spent(NamedTuple):
    """Time of a call: by the clock, and that of the processor, which no other program adds to."""

    seconds: float
    processor: float


def _supervised(call: Callable[[], None]) -> tuple[Spent, BaseException | None]:
    """Time that `call` took, and its exception, unless that was the end of the budget."""
    fault: BaseException | None = None
    start, worked = perf_counter(), process_time()
    try:
        with np.errstate(all="ignore"):
            # Wild points overflow on the way to a minimum: that is no news to anybody.
            call()
    except BudgetSpent:
        pass  # this is how the recorder ends an optimiser, and no fault of it
    except (Exception, SystemExit) as error:
        # Some optimisers turn Ctrl-C into an error of their own: it is the user's, and no fault.
        if isinstance(error.__cause__ or error.__context__, KeyboardInterrupt):
            raise KeyboardInterrupt from error
        fault = error
    return Spent(perf_counter() - start, process_time() - worked), fault


def _past(recorders: Sequence[Recorder], evaluated: int) -> Unrecorded | None:
    """What is wrong if more points were evaluated than the recorders have counted."""
    hidden = evaluated - sum(recorder.evaluations for recorder in recorders)
    if hidden <= 0:
        return None
    return Unrecorded(
        f"{hidden} points were evaluated past the recorder, which counts what a run may cost"
    )


def _pages(diary: bool) -> Diary | None:
    """An empty diary to be written, if one is to be kept: one of its own for each run."""
    if not diary:
        return None
    return []


def _outcome(name: str, recorder: Recorder, spent: Spent, fault: BaseException | None) -> Run:
    space = recorder.problem.space
    point = recorder.best_x
    x = np.full(recorder.problem.dimension, np.nan)
    if point.size:
        # The box is searched without regard to the order kinf > k0: what is told has it restored.
        x = space.repaired(point)
    return Run(
        name,
        _status(recorder, fault),
        recorder.best,
        x,
        space.theta(x),
        recorder.evaluations,
        recorder.gradients,
        spent.seconds,
        tuple(recorder.improvements),
        recorder.batched,
        recorder.diary,
        point,
        spent.processor,
        tuple(recorder.remarks),
    )


def _status(recorder: Recorder, fault: BaseException | None) -> str:
    # A library may wrap the end of the budget in an exception of its own: only the recorder knows.
    if fault is not None and (recorder.left > 0 or isinstance(fault, Unrecorded)):
        # The first line names it; what follows is often a printed array.
        lines = f"{type(fault).__name__}: {fault}".splitlines()
        return f"failed: {lines[0][:200]}"
    if not recorder.improvements:
        return f"failed: no finite value in {recorder.evaluations} evaluations"
    if recorder.met:
        return "target"
    if recorder.spent:
        return "budget"
    return "converged"


class Enquiry(ABC):
    """A search that is asked for points of the unit cube and told their values, in any order."""

    @abstractmethod
    def ask(self) -> Real:
        """Next point (d,) to evaluate; others may be out, asked for and not told yet."""

    @abstractmethod
    def tell(self, u: Real, value: float) -> None:
        """Take the objective at a point (d,) that was asked for.

        Parameters
        ----------
        u : ndarray, shape (d,)
            The point.
        value : float
            Its objective.
        """


class AskingOptimiser(Optimiser):
    """An optimiser that can be asked: several of its points may be evaluated at the same time."""

    @abstractmethod
    def enquiry(self, dimension: int, budget: int, rng: np.random.Generator) -> Enquiry:
        """Begin a search.

        Parameters
        ----------
        dimension : int
            Number of parameters.
        budget : int
            Evaluations that will be counted.
        rng : numpy.random.Generator
            The only source of randomness.
        """

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Ask for one point after another until the recorder ends the run."""
        enquiry = self.enquiry(problem.dimension, budget, rng)
        width = problem.upper - problem.lower
        while True:
            u = enquiry.ask()
            enquiry.tell(u, problem(problem.lower + u * width))
