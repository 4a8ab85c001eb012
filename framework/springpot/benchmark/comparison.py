"""Who wins where, and with what certainty: on each problem, and over several.

Each cell's trials are arrays, read off the store in one pass. Values are *excesses*, (f - f_best) /
(g - f_best) with f_best the best value known of the problem and g that at the centre of the box, or
of a model without any response where that is smaller: 1 there, 0 at the best. Two trials are
compared at a budget by the excess they had reached by then; below the study's target it no longer
counts, so that two trials which reached the target are equal. A trial that failed has an infinite
excess, and comes last.

On one problem, trials are compared (`OptimiserChoice`); over several, problems are (`MeanRanks`),
because trials of one problem say nothing of the next. Every table, diagram and sentence about who
is better is one of these two.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from springpot.numerics import AT_ONCE
from springpot.rheology.points import Real
from springpot.writing import counted

from .plan import ProblemRow, stream_of
from .statistics import (
    Interval,
    Pairings,
    bands,
    data_profile,
    expected_running_times,
    friedman,
    goals_of,
    least_mann_whitney,
    least_signed_rank,
    mean_interval,
    mean_range,
    mean_ranks_of,
    performance_profile,
    pooled_ranks,
    ranked,
    signed_rank_posterior,
    wilcoxon_holm,
    wilson,
)
from .summary import CellRow, CellTrials, TrialRow
from .trial import Traces, at, geometric_grid

if TYPE_CHECKING:
    from .store import Store


MARKS = (100, 500, 2000, 8000, 40_000, 200_000, 1_000_000)
"""Budgets at which optimisers are compared, beside a study's own.

Each four or five times the one before; about 8000
are what the paper's swarm of 20 particles spends in 400 instances."""

TARGETS = 10.0 ** np.arange(-0.5, -8.01, -0.5)
"""Excesses whose reaching the distribution over targets counts, down to the study's own.

Two to a decade, to the
last target of COCO (1e-8)."""


@dataclass(frozen=True, eq=False)
class CellScores:
    """The trials of one cell.

    Parameters
    ----------
    cell : CellRow
        Which cell.
    repetitions : ndarray of int, shape (n,)
        Which trials.
    hits : ndarray, shape (n,)
        Evaluation at which the study's target was reached, infinite where it was not.
    spent : ndarray, shape (n,)
        Evaluations of each trial.
    values : ndarray, shape (n, m)
        Excess at each of the study's marks.
    attained : ndarray, shape (g,)
        Share of trials and targets reached by each evaluation of the grid.
    curve : ndarray, shape (3, g)
        Quartiles of the excess along the grid.
    clean : ndarray, shape (3, g), or None
        Quartiles of the noise-free objective of what was best at the time, over that at the first
        evaluation's median; only for data with noise and a known truth.
    dimension : int
        Number of parameters; zero if no trial came to anything.
    oracles, errors, covered : ndarray, shape (n,)
        Noise-free objective, largest relative error of the parameters, and share of their intervals
        that hold the truth; infinite, and of `covered` zero, where a trial failed; NaN where they
        are not known. Empty in a study without levels of noise, which asks for none of them.
    area : ndarray, shape (n,)
        Area over the convergence curve of each trial; see `area_over_curve`.
    """

    cell: CellRow
    repetitions: NDArray[np.int64]
    hits: Real
    spent: Real
    values: Real
    attained: Real
    curve: Real
    clean: Real | None
    dimension: int
    oracles: Real = field(default_factory=lambda: np.empty(0))
    errors: Real = field(default_factory=lambda: np.empty(0))
    covered: Real = field(default_factory=lambda: np.empty(0))
    area: Real = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True, eq=False)
class JudgingScale:
    """How a study is judged.

    Parameters
    ----------
    target : float
        Excess that counts as success.
    budget : int
        Evaluations of each trial.
    """

    target: float
    budget: int

    @classmethod
    def of(cls, store: Store) -> JudgingScale:
        """That of a store's study."""
        facts = store.facts()
        return cls(float(facts["target"]), int(facts["budget"]))

    @property
    def marks(self) -> tuple[int, ...]:
        """At most four budgets, the last of them the study's."""
        return (*[mark for mark in MARKS if mark < self.budget][-3:], self.budget)

    @cached_property
    def targets(self) -> Real:
        """Excesses, falling to the target."""
        # One that differs from the study's own by rounding only would count twice.
        return np.append(TARGETS[1.01 * self.target < TARGETS], self.target)

    @cached_property
    def grid(self) -> NDArray[np.int64]:
        """Evaluations (g,) of curves, the marks among them."""
        return np.union1d(geometric_grid(self.budget), np.array(self.marks))


def judged(store: Store) -> Iterator[tuple[CellRow, CellTrials, Real]]:
    """Each cell of the study with its trials and the best objective (n,) known of their data."""
    bests, draws = store.bests(), store.bests_of_draws()
    for cell, trials in store.raced():
        known = np.full(len(trials), bests.get(cell.problem.id, np.inf))
        # Noise of its own makes a trial's data another problem than those of its neighbours.
        for i, repetition in enumerate(trials.column("repetition") if draws else ()):
            known[i] = draws.get((cell.problem.id, repetition), known[i])
        yield cell, trials, known
        # Or it would be in memory while the next is read.
        del trials


def reference_of(problem: ProblemRow, trial: TrialRow) -> float:
    """Objective from which the progress of a trial is measured."""
    if trial.reference is None:
        return problem.reference
    return trial.reference


def hits_of(cell: CellRow, trials: CellTrials, bests: Real, scale: JudgingScale) -> Real:
    """Evaluation at which each trial (n,) reached its target, infinite where it did not.

    No trace is read of which the best shows already that it missed.
    """
    goals, blobs = goals_of(_references(cell, trials), bests, scale.target), trials.column("trace")
    there, hits = trials.numbers("best") <= goals, np.empty(len(trials))
    for own in _parts(len(trials), scale):
        hits[own] = _traces(blobs[own], there[own]).hits(goals[own])
    return hits


def _parts(trials: int, scale: JudgingScale) -> Iterator[slice]:
    """Some trials at once: what is unpacked of a trace is many times what is kept of it."""
    step = max(1, AT_ONCE // len(scale.grid))
    for first in range(0, trials, step):
        yield slice(first, first + step)


def score_cell(
    cell: CellRow, trials: CellTrials, best: Real | float, scale: JudgingScale
) -> CellScores:
    """Scores of a cell on data whose best known objective is `best`, (n,) or one for all."""
    bests, dead = np.broadcast_to(best, len(trials)), np.isnan(trials.numbers("best"))
    hits, area = np.empty((2, len(trials)))
    along = np.empty((len(trials), len(scale.grid)))
    reached, blobs = np.zeros(len(scale.grid)), trials.column("trace")
    references = _references(cell, trials)
    goals = goals_of(references, bests, scale.target)
    for own in _parts(len(trials), scale):
        # A trial that failed keeps its infinite time: it is never given a number.
        traces = _traces(blobs[own], ~dead[own])
        owners = traces.owners
        excess = _excess(traces.values, bests[own][owners], references[own][owners])
        # On the few evaluations of the grid: the traces may have thousands.
        along[own] = traces.at(excess, scale.grid)
        # How many of the falling targets each has reached, all trials together.
        reached += np.searchsorted(-scale.targets, -along[own], side="right").sum(axis=0)
        hits[own] = traces.hits(goals[own])
        area[own] = area_over_curve(traces, excess, scale)
    return CellScores(
        cell,
        repetitions=np.array(trials.column("repetition")),
        hits=hits,
        spent=trials.numbers("evaluations"),
        values=along[:, np.searchsorted(scale.grid, scale.marks)],
        attained=reached / len(trials) / len(scale.targets),
        curve=bands(along),
        clean=_clean(trials, scale),
        dimension=trials.parameters(np.flatnonzero(~dead)),
        area=area,
    )


def with_truth(scores: CellScores, trials: CellTrials) -> CellScores:
    """Scores with what is known of a cell's trials by the truth: asked for by levels of noise."""
    dead = np.isnan(trials.numbers("best"))
    return replace(
        scores,
        oracles=np.where(dead, np.inf, trials.numbers("oracle")),
        errors=np.where(dead, np.inf, trials.numbers("parameter_error")),
        covered=np.where(dead, 0.0, trials.numbers("covered")),
    )


def _references(cell: CellRow, trials: CellTrials) -> Real:
    """`reference_of` for each trial (n,)."""
    own = trials.numbers("reference")
    return np.where(np.isnan(own), cell.problem.reference, own)


def _traces(blobs: Sequence[bytes | None], wanted: NDArray[np.bool_]) -> Traces:
    """Improvements of the trials that are wanted (n,), of the others none."""
    each = zip(blobs, wanted.tolist(), strict=True)
    return Traces.of([blob or b"" if one else b"" for blob, one in each])


def area_over_curve(traces: Traces, excess: Real, scale: JudgingScale) -> Real:
    """One less the mean of log10 of the excess over all evaluations of the budget.

    In decades from 1 down to the target, outside of which nothing counts.

    Parameters
    ----------
    traces : Traces
        The improvements of n trials.
    excess : ndarray, shape (N,)
        Of each improvement.
    scale : JudgingScale
        Target and budget.

    Returns
    -------
    ndarray, shape (n,)
        Of each trial.
    """
    # A target of no decade leaves no area: it is then taken over one.
    lowest = min(scale.target, 0.1)
    decades = np.log10(np.clip(excess, lowest, 1.0)) / np.log10(lowest)
    return traces.means(decades, scale.budget)


def _excess(values: Real, best: Real | float, reference: Real | float) -> Real:
    """Zero at the best.

    Infinite values stay so, and all but the best are where nothing is worse than it.
    """
    span = np.broadcast_to(np.asarray(reference - best), values.shape)
    if (span > 0.0).all():
        excess: Real = (np.maximum(values, best) - best) / span
        return excess
    above = np.zeros_like(values)
    np.subtract(values, best, out=above, where=values > best)
    # Nothing is worse than the best that is known: there is no scale on which to be half as bad.
    found = np.where((above > 0.0) | np.isinf(values), np.inf, 0.0)
    np.divide(above, span, out=found, where=span > 0.0)
    return found


def _clean(trials: CellTrials, scale: JudgingScale) -> Real | None:
    """Quartiles of the noise-free objective of what was recommended, where the data have noise."""
    if not any(trials.column("recommended")):
        return None
    along = np.full((len(trials), len(scale.grid)), np.inf)
    for row, trial in enumerate(trials):
        if (known := trial.recommendations()) is not None and len(known[0]):
            along[row] = at(*known, scale.grid)
    return bands(along)


@dataclass(frozen=True, eq=False)
class ProblemRace:
    """All entrants on one problem, in the repetitions that every one of them has finished.

    Parameters
    ----------
    problem : ProblemRow
        Which problem.
    cells : tuple of CellScores
        One for each entrant; their numbers are brought together when asked for, and not kept twice.
    """

    problem: ProblemRow
    cells: tuple[CellScores, ...]
    _wins: dict[tuple[int, float], Real] = field(default_factory=dict, init=False, repr=False)

    def pairings(self, mark: int, target: float) -> Pairings:
        """What the trials of any two had reached at a mark, compared."""
        found = Pairings.of(quality(self, mark, target))
        # The choice asks for them, each ranking that holds the problem, and its sensitivity.
        self._wins[mark, target] = found.wins
        return found

    def wins(self, mark: int, target: float) -> Real:
        """`Pairings.wins` (entrants, entrants) at a mark."""
        if (mark, target) not in self._wins:
            self.pairings(mark, target)
        return self._wins[mark, target]

    def mean_ranks(self, mark: int, target: float) -> Real:
        """Mean ranks (entrants,) of what the trials had reached at a mark, all of them together."""
        return mean_ranks_of(self.wins(mark, target), self.repetitions)

    def chances(self, mark: int, target: float) -> Real:
        """`a12` (entrants, entrants) of what any two had reached at a mark."""
        return self.wins(mark, target) / self.repetitions**2

    @cached_property
    def shared(self) -> list[NDArray[np.bool_] | slice]:
        """Which trials of each cell every entrant has; a slice where those are all."""
        first = self.cells[0].repetitions
        if all(np.array_equal(cell.repetitions, first) for cell in self.cells):
            return [slice(None)] * len(self.cells)
        # Only where all have run: an entrant must not win by the repetitions that others have still
        # to do.
        common = sorted(set.intersection(*(set(cell.repetitions.tolist()) for cell in self.cells)))
        masks = [np.isin(cell.repetitions, common) for cell in self.cells]
        # A million trials are not to be picked one by one where none is left out.
        return [slice(None) if mask.all() else mask for mask in masks]

    @property
    def repetitions(self) -> int:
        """How many every entrant has finished."""
        return len(self.cells[0].repetitions[self.shared[0]])

    @property
    def hits(self) -> Real:
        """Evaluations (entrants, n) at which the target was reached, as in `CellScores`."""
        return self.of_trials("hits")

    @property
    def spent(self) -> Real:
        """Evaluations of each trial, (entrants, n)."""
        return self.of_trials("spent")

    @property
    def values(self) -> Real:
        """Excess at each mark, (entrants, n, m)."""
        return self.of_trials("values")

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the entrants."""
        return tuple(scores.cell.label for scores in self.cells)

    def of_trials(self, name: str, *at: int) -> Real:
        """A property of the cells' trials, (entrants, n, ...), or one column of it."""
        each = zip(self.cells, self.shared, strict=True)
        return np.stack([getattr(cell, name)[(which, *at)] for cell, which in each])

    def of_one(self, entrant: int, name: str) -> Real:
        """A property of one entrant's trials, (n, ...)."""
        found: Real = getattr(self.cells[entrant], name)[self.shared[entrant]]
        return found

    @property
    def dimension(self) -> int:
        """Number of parameters."""
        return max(scores.dimension for scores in self.cells)


def races_of(scores: Iterable[CellScores]) -> list[ProblemRace]:
    """The races of a study, without problems on which some entrant has finished nothing yet."""
    by_problem: dict[int, list[CellScores]] = {}
    for found in scores:
        by_problem.setdefault(found.cell.problem.id, []).append(found)
    # Ranks among fewer entrants would be better ones: such a problem cannot stand beside the
    # others.
    entrants = max((len(cells) for cells in by_problem.values()), default=0)
    complete = [cells for cells in by_problem.values() if len(cells) == entrants]
    races = [ProblemRace(cells[0].cell.problem, tuple(cells)) for cells in complete]
    return [race for race in races if race.repetitions]


LEVEL = 0.05
"""Adjusted p-values up to this tell two optimisers apart.

The level at which comparisons of optimisers are usually
published (Derrac and others 2011, doi:10.1016/j.swevo.2011.02.002)."""

OVER_ALL = "all problems"
PROBLEMS = "problems"
"""What is ranked in where there are several."""


@dataclass(frozen=True, eq=False)
class OptimiserChoice:
    """Which optimiser to use for one problem at one budget.

    Parameters
    ----------
    race : ProblemRace
        The problem.
    budget : int
        Evaluations.
    label : str or None
        Of those that no other beats for certain, the one that takes the fewest evaluations; None if
        all failed.
    success : Interval
        Share of its trials that reached the target.
    running_time : float
        Its expected evaluations to the target with restarts, infinite without a success.
    excess : float
        Median of what it reached.
    alike : tuple of str
        Others that cannot be told from the best at this budget, the cheapest first.
    runner_up : str or None
        Best of those that are worse for certain.
    chance : float or None
        That a trial of the choice ends below one of the runner-up, ties by half (A12).
    decided : bool
        Whether there were enough trials to tell any optimiser from the best.
    """

    race: ProblemRace
    budget: int
    label: str | None
    success: Interval
    running_time: float
    excess: float
    alike: tuple[str, ...]
    runner_up: str | None
    chance: float | None
    decided: bool


def quality(race: ProblemRace, mark: int, target: float) -> Real:
    """What each trial had reached at a mark, (entrants, n).

    No better than the target, infinite if it failed.
    """
    # Below the target a race is over: who got further beyond it is no better.
    return np.maximum(race.of_trials("values", mark), target)


def choices(races: Sequence[ProblemRace], scale: JudgingScale) -> list[OptimiserChoice]:
    """The choice for every problem at every mark."""
    chosen = []
    for race in races:
        chosen += [choose(race, mark, scale) for mark in range(len(scale.marks))]
    return chosen


def choose(race: ProblemRace, mark: int, scale: JudgingScale) -> OptimiserChoice:
    """The choice for one problem at one mark."""
    budget = scale.marks[mark]
    p = race.pairings(mark, scale.target).p
    # By ranks, not means: a single failed trial has an infinite excess, which would decide alone.
    ranks = race.mean_ranks(mark, scale.target)
    # As if the race had ended at this budget: what was reached later did not happen yet.
    hits = race.hits
    hits[hits > budget] = np.inf
    times = expected_running_times(hits, np.minimum(race.spent, budget))
    best = int(np.argmin(ranks))
    others = [i for i in range(len(ranks)) if i != best]
    # Among those that are as good the cheapest is chosen, and of equally cheap ones that of the
    # better rank.
    alike = sorted(
        [best, *(i for i in others if p[best, i] > LEVEL)], key=lambda i: (times[i], ranks[i])
    )
    worse = sorted((i for i in others if p[best, i] <= LEVEL), key=lambda i: ranks[i])
    first, labels = alike[0], race.labels
    # A share of twenty trials is known to some ten per cent: its interval is shown beside it.
    success = wilson(int(np.isfinite(hits[first]).sum()), hits.shape[1])
    assert success is not None
    best_name = None
    # Where no run reached a finite value there is nothing to choose by; who did is ahead of others.
    if np.isfinite(race.of_one(best, "values")[:, mark]).any():
        best_name = labels[first]
    next_name = advantage = None
    if worse:
        next_name, advantage = (
            labels[worse[0]],
            float(race.chances(mark, scale.target)[first, worse[0]]),
        )
    trials = hits.shape[1]
    # All trials of one below all of the other, times the number of pairs (Holm): if even that is
    # too large, more trials are needed and not a better optimiser.
    least = 2 * least_mann_whitney(trials, trials) * max(pairs_of(len(ranks)), 1)
    return OptimiserChoice(
        race,
        budget,
        best_name,
        success,
        float(times[first]),
        float(bands(race.of_one(first, "values")[:, mark], (0.5,))[0]),
        tuple(labels[i] for i in alike[1:]),
        next_name,
        advantage,
        least <= LEVEL,
    )


def pairs_of(entrants: int) -> int:
    """How many pairs so many make."""
    return entrants * (entrants - 1) // 2


@dataclass(frozen=True, eq=False)
class MeanRanks:
    """Mean ranks of all optimisers over some problems at one budget.

    Of a single problem its repetitions are ranked, and nothing is said beyond that problem.

    Parameters
    ----------
    scope : str
        Which problems.
    budget, mark : int
        Evaluations, and which of the study's marks they are.
    labels : tuple of str
        The optimisers.
    ranks : tuple of Interval
        Mean rank, the best being 1, with its bootstrap interval over blocks; with their range where
        they are too few to tell any two apart.
    p : ndarray, shape (k, k)
        Of all pairs, adjusted by Holm: Wilcoxon's signed-rank test over problems, of a single one
        Mann and Whitney's over its trials.
    races : sequence of ProblemRace
        What is ranked; their trials are compared by pairs when asked for.
    target : float
        Excess below which nothing counts.
    statistic, p_all : float
        Friedman's test that all are alike.
    blocks : int
        What was ranked in: problems, or the repetitions of a single one.
    unit : str
        Which of the two.
    least : float
        Smallest adjusted p-value that so many blocks can give.
    """

    scope: str
    budget: int
    mark: int
    labels: tuple[str, ...]
    ranks: tuple[Interval, ...]
    p: Real
    races: Sequence[ProblemRace]
    target: float
    statistic: float
    p_all: float
    blocks: int
    unit: str
    least: float

    @property
    def decided(self) -> bool:
        """Whether there are blocks enough to tell any two apart."""
        return self.least <= LEVEL

    def told(self, i: int, j: int) -> bool:
        """Whether optimisers `i` and `j` are told apart."""
        return bool(self.p[i, j] <= LEVEL)

    @property
    def doubt(self) -> str:
        """Why nothing can be told, in words; empty if something can."""
        if self.decided:
            return ""
        return f"{counted(self.blocks, self.unit.removesuffix('s'))} cannot tell"

    @property
    def means(self) -> Real:
        """Mean ranks (k,)."""
        return np.array([rank.value for rank in self.ranks])

    @property
    def chance_tables(self) -> Real:
        """`a12` of what any two optimisers had reached on each problem, (problems, k, k)."""
        return np.array([race.chances(self.mark, self.target) for race in self.races])

    @cached_property
    def posterior(self) -> Real | None:
        """Probabilities (k, k, 3) that the row's optimiser is better than the column's.

        Then that they are equal in practice, and that it is worse; None of a single problem.
        """
        if self.unit != PROBLEMS:
            return None
        gaps = self.chance_tables - 0.5
        k = len(self.labels)
        found = np.zeros((k, k, 3))
        first, second = np.triu_indices(k, 1)
        # A chance above one half is the better one's.
        below, equal, above = signed_rank_posterior(gaps[:, first, second].T).T
        found[first, second] = np.column_stack([above, equal, below])
        found[second, first] = np.column_stack([below, equal, above])
        return found

    @cached_property
    def chances(self) -> Real:
        """Chances (k, k) that the row's optimiser ends below the column's on a problem (A12)."""
        table: Real = self.chance_tables.mean(axis=0)
        return table

    def alike(self, i: int) -> tuple[str, ...]:
        """Optimisers that cannot be told from optimiser `i`, by rank."""
        order = np.argsort(self.means, kind="stable")
        return tuple(self.labels[j] for j in order if j != i and not self.told(i, int(j)))


def scopes(races: Sequence[ProblemRace]) -> Iterator[tuple[str, list[ProblemRace]]]:
    """All problems, then those of each model and of each data set.

    What holds one problem is left to the choices.
    """
    yield OVER_ALL, list(races)
    ways: tuple[Callable[[ProblemRace], str], ...] = (
        lambda race: f"model {race.problem.model}",
        lambda race: f"data {race.problem.dataset}",
    )
    for way in ways:
        counts = Counter(map(way, races))
        for name in (name for name, count in counts.items() if 1 < count < len(races)):
            yield name, [race for race in races if way(race) == name]


def rankings(races: Sequence[ProblemRace], scale: JudgingScale) -> list[MeanRanks]:
    """The ranking in every scope at every mark; none with fewer than two optimisers."""
    if not races or len(races[0].labels) < 2:
        return []
    ranked = []
    for scope, chosen in scopes(races):
        ranked += [rank(scope, chosen, mark, scale) for mark in range(len(scale.marks))]
    return ranked


def rank_blocks(races: Sequence[ProblemRace], mark: int, target: float) -> Real:
    """Mean ranks of each problem's trials at a mark, (problems, entrants)."""
    return np.stack([race.mean_ranks(mark, target) for race in races])


def rank(scope: str, races: Sequence[ProblemRace], mark: int, scale: JudgingScale) -> MeanRanks:
    """The ranking over some races at one mark."""
    labels = races[0].labels
    pairs = pairs_of(len(labels))
    if len(races) > 1:
        unit = PROBLEMS
        blocks = rank_blocks(races, mark, scale.target)
        within = ranked(blocks)
        p, least = wilcoxon_holm(blocks), least_signed_rank(len(blocks)) * pairs
    else:
        unit = "repetitions"
        reached = quality(races[0], mark, scale.target)
        blocks = reached.T
        # A trial's place among one trial of each: in the order of the choice, which ranks all of
        # them at once.
        within = (pooled_ranks(reached).T - 0.5) / len(blocks) + 0.5
        p = Pairings.of(reached).p
        least = 2 * least_mann_whitney(len(blocks), len(blocks)) * pairs
    statistic = p_all = np.nan
    # Friedman's test takes three or more.
    if len(labels) > 2 and len(blocks) > 1:
        statistic, p_all = friedman(blocks)
    # A stream of its own for each ranking: the same table, whatever else is computed before it.
    rng = np.random.default_rng(stream_of(0, "ranking", scope, scale.marks[mark]))
    ranks = mean_interval(within, rng)
    if least > LEVEL:
        # A bootstrap of a few problems is too sure of them.
        ranks = mean_range(within)
    return MeanRanks(
        scope,
        scale.marks[mark],
        mark,
        labels,
        tuple(ranks),
        p,
        races,
        scale.target,
        statistic,
        p_all,
        len(blocks),
        unit,
        min(1.0, least),
    )


@dataclass(frozen=True, eq=False)
class Profiles:
    """Shares of all trials' problems solved to the study's target, by cost.

    Parameters
    ----------
    labels : tuple of str
        The optimisers.
    simplex : ndarray, shape (m,)
        Budgets in simplex gradients, evaluations / (d + 1).
    data : ndarray, shape (k, m)
        Data profiles (More and Wild 2009).
    ratios : ndarray, shape (r,)
        Multiples of the best optimiser's evaluations.
    performance : ndarray, shape (k, r)
        Performance profiles (Dolan and More 2002).
    """

    labels: tuple[str, ...]
    simplex: Real
    data: Real
    ratios: Real
    performance: Real


def profiles(races: Sequence[ProblemRace], simplex: Real, ratios: Real) -> Profiles:
    """Profiles over all races.

    Each repetition counts as a problem, as its random numbers are shared.
    """
    costs = np.concatenate([race.hits.T for race in races])
    dimensions = np.concatenate([np.full(race.hits.shape[1], race.dimension) for race in races])
    return Profiles(
        races[0].labels,
        simplex,
        data_profile(costs, dimensions, simplex),
        ratios,
        performance_profile(costs, ratios),
    )
