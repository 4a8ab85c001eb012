"""What comparisons are made of: each cell's trials as arrays, read off the store in one pass.

Values are *excesses*, (f - f_best) / (g - f_best) with f_best the best value known of the problem
and g that at the centre of the box, or of a model without any response where that is smaller: 1
there, 0 at the best. A trial that failed has an infinite excess, and comes last.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from springpot.rheology.points import Real

from .rows import CellRow, ProblemRow, TrialRow
from .statistics import bands, hitting_time, target_value
from .store import Store
from .trace import at, geometric_grid

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


@dataclass(frozen=True, eq=False)
class Scale:
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
    def of(cls, store: Store) -> Scale:
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


def judged(store: Store) -> Iterator[tuple[CellRow, list[TrialRow], float]]:
    """Each cell of the study with its trials and the best objective known of its problem."""
    bests = store.bests()
    cells = {cell.id: cell for cell in store.cells()}
    for number, trials in store.trials():
        if number in cells:
            yield cells[number], trials, bests.get(cells[number].problem.id, np.inf)


def goal_of(problem: ProblemRow, best: float, target: float) -> float:
    """Objective that counts as success; nothing does where no value is known."""
    if not np.isfinite(best):
        return -np.inf
    return target_value(best, problem.reference, target)


def score_cell(cell: CellRow, trials: Sequence[TrialRow], best: float, scale: Scale) -> CellScores:
    """Scores of a cell on a problem whose best known objective is `best`."""
    goal = goal_of(cell.problem, best, scale.target)
    along = np.full((len(trials), len(scale.grid)), np.inf)
    hits = np.full(len(trials), np.inf)
    dimension = 0
    for row, trial in enumerate(trials):
        # A trial that failed keeps its infinite time: it is never given a number.
        if trial.best is None:
            continue
        evaluations, values = trial.improvements()
        along[row] = at(evaluations, values, scale.grid)
        hits[row] = hitting_time(evaluations, values, goal)
        dimension = dimension or len(trial.theta)
    # Only now, on the few evaluations of the grid: the traces may have thousands.
    along = _excess(along, best, cell.problem.reference)
    return CellScores(
        cell,
        repetitions=np.array([trial.repetition for trial in trials]),
        hits=hits,
        spent=np.array([trial.evaluations for trial in trials], dtype=float),
        values=along[:, np.searchsorted(scale.grid, scale.marks)],
        attained=np.searchsorted(-scale.targets, -along, side="right").mean(axis=0)
        / len(scale.targets),
        curve=bands(along),
        clean=_clean(trials, scale),
        dimension=dimension,
    )


def _excess(values: Real, best: float, reference: float) -> Real:
    """Zero at the best.

    Infinite values stay so, and all but the best are where nothing is worse than it.
    """
    above = np.zeros_like(values)
    np.subtract(values, best, out=above, where=values > best)
    span = max(reference - best, 0.0)
    if span > 0.0:
        return above / span
    # Nothing is worse than the best that is known: there is no scale on which to be half as bad.
    return np.where((above > 0.0) | np.isinf(values), np.inf, 0.0)


def _clean(trials: Sequence[TrialRow], scale: Scale) -> Real | None:
    """Quartiles of the noise-free objective of what was recommended, where the data have noise."""
    if not any(trial.recommended for trial in trials):
        return None
    along = np.full((len(trials), len(scale.grid)), np.inf)
    for row, trial in enumerate(trials):
        if (known := trial.recommendations()) is not None and len(known[0]):
            along[row] = at(*known, scale.grid)
    return bands(along)


@dataclass(frozen=True, eq=False)
class Race:
    """All entrants on one problem, in the repetitions that every one of them has finished.

    Parameters
    ----------
    problem : ProblemRow
        Which problem.
    cells : tuple of CellScores
        One for each entrant.
    hits, spent : ndarray, shape (entrants, n)
        As in `CellScores`.
    values : ndarray, shape (entrants, n, m)
        Excess at each mark.
    """

    problem: ProblemRow
    cells: tuple[CellScores, ...]
    hits: Real
    spent: Real
    values: Real

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the entrants."""
        return tuple(scores.cell.label for scores in self.cells)

    @property
    def dimension(self) -> int:
        """Number of parameters."""
        return max(scores.dimension for scores in self.cells)


def races_of(scores: Iterable[CellScores]) -> list[Race]:
    """The races of a study, without problems on which some entrant has finished nothing yet."""
    by_problem: dict[int, list[CellScores]] = {}
    for found in scores:
        by_problem.setdefault(found.cell.problem.id, []).append(found)
    # Ranks among fewer entrants would be better ones: such a problem cannot stand beside the
    # others.
    entrants = max((len(cells) for cells in by_problem.values()), default=0)
    complete = [_race(cells) for cells in by_problem.values() if len(cells) == entrants]
    return [race for race in complete if race.hits.shape[1]]


def _race(cells: Sequence[CellScores]) -> Race:
    # Only where all have run: an entrant must not win by the repetitions that others have still to
    # do.
    common = set.intersection(*(set(scores.repetitions.tolist()) for scores in cells))
    rows = [np.isin(scores.repetitions, sorted(common)) for scores in cells]

    def stacked(name: str) -> Real:
        return np.stack(
            [getattr(scores, name)[chosen] for scores, chosen in zip(cells, rows, strict=True)]
        )

    return Race(
        cells[0].cell.problem, tuple(cells), stacked("hits"), stacked("spent"), stacked("values")
    )
