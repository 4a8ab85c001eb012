"""One supervised run of an optimiser, and what came of it according to the ledger."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf
from time import perf_counter, process_time
from typing import NamedTuple

import numpy as np

from springpot.errors import OptionError
from springpot.rheology.points import Real

from .ledger import BudgetSpent, Diary, Ledger
from .optimiser import BatchedOptimiser, Optimiser
from .problem import Searched
from .recorder import Recorder, RecorderGroup


class Unrecorded(Exception):
    """An optimiser has evaluated points where nobody counts them."""


@dataclass(frozen=True, eq=False)
class Run:
    """What one run found, as the ledger has it; nothing that a library claims.

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
    factor : float
        Penalty in the value there.
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
    factor: float = 1.0
    processor: float = 0.0

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

    Raises
    ------
    OptionError
        If the budget is not positive.
    """
    ledger = Ledger(problem, _checked(budget), target, _pages(diary))
    # Counted on both sides of the door: an optimiser that goes around the recorder is found out.
    recorder, before = Recorder.of(ledger), problem.tally.points
    spent, fault = _supervised(lambda: optimiser.minimise(recorder, budget, rng))
    fault = fault or _past([ledger], problem.tally.points - before)
    return _outcome(optimiser.name, ledger, spent, fault)


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
    ledgers = [Ledger(problem, _checked(budget), target, _pages(diary)) for _ in rngs]
    group, before = RecorderGroup.of(ledgers), problem.tally.points
    spent, fault = _supervised(lambda: optimiser.minimise_batch(group, budget, rngs))
    fault = fault or _past(ledgers, problem.tally.points - before)
    # Side by side nobody knows whose second it was.
    share = Spent(spent.seconds / len(ledgers), spent.processor / len(ledgers))
    return [_outcome(optimiser.name, ledger, share, fault) for ledger in ledgers]


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


def _past(ledgers: Sequence[Ledger], evaluated: int) -> Unrecorded | None:
    """What is wrong if more points were evaluated than are in the ledgers."""
    hidden = evaluated - sum(ledger.evaluations for ledger in ledgers)
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


def _outcome(name: str, ledger: Ledger, spent: Spent, fault: BaseException | None) -> Run:
    space = ledger.problem.space
    any_finite = ledger.best_x.size > 0
    x = np.full(ledger.problem.dimension, np.nan)
    if any_finite:
        # The box is searched without regard to the order kinf > k0: what is told has it restored.
        x = space.repaired(ledger.best_x)
    return Run(
        name,
        _status(ledger, fault),
        ledger.best,
        x,
        space.theta(x),
        ledger.evaluations,
        ledger.gradients,
        spent.seconds,
        tuple(ledger.trace),
        ledger.batched,
        ledger.diary,
        ledger.best_x,
        ledger.best_factor,
        spent.processor,
    )


def _status(ledger: Ledger, fault: BaseException | None) -> str:
    # A library may wrap the end of the budget in an exception of its own: only the recorder knows.
    if fault is not None and (ledger.left > 0 or isinstance(fault, Unrecorded)):
        # The first line names it; what follows is often a printed array.
        lines = f"{type(fault).__name__}: {fault}".splitlines()
        return f"failed: {lines[0][:200]}"
    if not ledger.best_x.size:
        return f"failed: no finite value in {ledger.evaluations} evaluations"
    if ledger.met:
        return "target"
    if ledger.spent:
        return "budget"
    return "converged"
