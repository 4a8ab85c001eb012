"""A study's findings and their tables: pure functions of its store, computed when asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from springpot.errors import StudyError

from .comparison import Choice, Ranking, choices, rankings
from .rows import TrialRow
from .scores import CellScores, Race, Scale, goal_of, judged, races_of, score_cell
from .standings import choice_table, pair_table, profile_table, progress_table, rank_table
from .statistics import hitting_time
from .store import Store
from .study import Study
from .summary import (
    CellSummary,
    failure_table,
    store_path,
    summarise_cell,
    summary_table,
    timing_table,
)
from .tables import FORMATS, Table, save_table


@dataclass(frozen=True, eq=False)
class Findings:
    """What came of a study.

    Parameters
    ----------
    facts : mapping of str to str
        Name, versions, machine, command.
    scale : Scale
        How it is judged.
    summaries : tuple of CellSummary
        Every cell in numbers, in the order of the study.
    scores : tuple of CellScores
        The same cells as arrays; empty if they were not wanted.
    """

    facts: Mapping[str, str]
    scale: Scale
    summaries: tuple[CellSummary, ...]
    scores: tuple[CellScores, ...]

    @classmethod
    def of(cls, store: Store, scored: bool = True) -> Findings:
        """Read a store in one pass, one cell's trials at a time.

        Parameters
        ----------
        store : Store
            The study's.
        scored : bool
            Whether optimisers will be compared.
        """
        facts, scale = store.facts(), Scale.of(store)
        summaries: dict[int, CellSummary] = {}
        scores: dict[int, CellScores] = {}
        # One cell at a time: a study of a million trials does not fit into memory.
        for cell, trials, best in judged(store):
            if scored:
                scores[cell.id] = score_cell(cell, trials, best, scale)
                hits = scores[cell.id].hits
            else:
                goal = goal_of(cell.problem, best, scale.target)
                # For the summary alone: no trace is unpacked of which the best shows already that
                # it missed.
                hits = np.array([_hit(trial, goal) for trial in trials])
            summaries[cell.id] = summarise_cell(cell, trials, hits, float(facts["accuracy"]))
        # In the order of the study, which is not that in which the store has its trials.
        order = [cell.id for cell in store.cells() if cell.id in summaries]
        return cls(
            facts,
            scale,
            tuple(summaries[number] for number in order),
            tuple(scores[number] for number in order if scored),
        )

    @property
    def name(self) -> str:
        """The study's."""
        return self.facts["name"]

    @cached_property
    def races(self) -> list[Race]:
        """All entrants on each problem."""
        return races_of(self.scores)

    @cached_property
    def choices(self) -> list[Choice]:
        """Which optimiser to use for each problem at each budget."""
        return choices(self.races, self.scale)

    @cached_property
    def rankings(self) -> list[Ranking]:
        """Mean ranks over all problems, by model and by data set, at each budget."""
        return rankings(self.races, self.scale)


def _hit(trial: TrialRow, goal: float) -> float:
    """Evaluation at which a trial reached `goal`; its trace is read only if it did."""
    if trial.best is None or trial.best > goal:
        return np.inf
    return hitting_time(*trial.improvements(), goal)


def summarise(store: Store) -> list[CellSummary]:
    """A summary of every cell, in the order of the study."""
    return list(Findings.of(store, scored=False).summaries)


PLAIN: dict[str, Callable[[Findings], Table]] = {
    "summary": lambda f: summary_table(f.name, f.summaries, f.facts["target"], f.facts["accuracy"]),
    "timing": lambda f: timing_table(f.name, f.summaries),
    "failures": lambda f: failure_table(f.name, f.summaries),
}
"""Tables that compare nobody, by file stem."""

COMPARING: dict[str, Callable[[Findings], Table]] = {
    "choice": lambda f: choice_table(f.name, f.choices, f.scale.target),
    "ranks": lambda f: rank_table(f.name, f.rankings),
    "pairs": lambda f: pair_table(f.name, f.rankings),
    "profiles": lambda f: profile_table(f.name, f.races, f.scale),
    "progress": lambda f: progress_table(f.name, f.scores, f.scale),
}
"""Tables that need every trial's trace."""

TABLES = ("choice", "summary", "ranks", "pairs", "profiles", "progress", "timing", "failures")
"""All of them, in the order in which they are shown."""


def study_tables(store: Store, names: Sequence[str] = TABLES) -> Iterator[tuple[str, Table]]:
    """File stem and table of what is written after a run.

    Parameters
    ----------
    store : Store
        The study's.
    names : sequence of str
        Which of `TABLES`.
    """
    # Every trace is read only if a table that is wanted compares by them.
    findings = Findings.of(store, scored=any(name in COMPARING for name in names))
    for name in names:
        yield name, (PLAIN | COMPARING)[name](findings)


def write_tables(
    study: Study | str | Path, formats: Sequence[str] = tuple(FORMATS), out: Path = Path("results")
) -> list[Path]:
    """Write a study's tables beside its store.

    Parameters
    ----------
    study : Study, str or Path
        As for `store_path`.
    formats : sequence of str
        Of ``md``, ``csv``, ``latex``, ``html``.
    out : Path
        Folder of all results.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    StudyError
        If there are no results or a format is unknown.
    """
    # Before the store is read, which may take long.
    unknown = [name for name in formats if name not in FORMATS]
    if unknown:
        raise StudyError(f"unknown table format '{unknown[0]}': use {', '.join(FORMATS)}")
    path = store_path(study, out)
    with Store(path) as store:
        # All of them before the first is written: a fault in one leaves no half of a set behind.
        tables = list(study_tables(store))
    files = []
    for stem, table in tables:
        files += save_table(table, path.parent, stem, formats)
    return files
