"""Tables of a comparison: choices, ranks, pairs, profiles, progress.

A study's findings and their tables: pure functions of its store, computed when asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import prod
from pathlib import Path
from tempfile import SpooledTemporaryFile
from typing import Any, TypeAlias
from weakref import finalize

import numpy as np
from numpy.typing import NDArray

from springpot.errors import StudyError
from springpot.numerics import AT_ONCE
from springpot.report.page import FORMATS, Entry, Table, save_table

from .archive import opened
from .comparison import (
    OVER_ALL,
    CellScores,
    JudgingScale,
    MeanRanks,
    OptimiserChoice,
    ProblemRace,
    choices,
    hits_of,
    judged,
    profiles,
    races_of,
    rankings,
    score_cell,
    with_truth,
)
from .robustness import (
    OF_ITS_OWN,
    anytime_table,
    attainment_table,
    noise_table,
    sensitivity_table,
)
from .statistics import ROPE, intervals
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

SIMPLEX = (10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0, 10_000.0)
RATIOS = (1.0, 2.0, 5.0, 10.0, 30.0, 100.0)
WHERE = ("model", "data set", "objective")


def _where(race: ProblemRace) -> tuple[Entry, ...]:
    return race.problem.model, race.problem.dataset, race.problem.objective


def choice_table(name: str, chosen: Sequence[OptimiserChoice], target: float) -> Table:
    """Which optimiser to use for each model, data set and budget."""
    rows = [
        (
            *(*_where(c.race), c.budget, c.label or "none: all trials failed"),
            *(c.success, c.running_time, c.excess),
            *(", ".join(c.alike) or None, c.runner_up, c.chance),
        )
        for c in chosen
    ]
    columns = (
        *(*WHERE, "budget", "use", "success", "expected running time", "excess"),
        *("as good", "next", "chance against next"),
    )
    return Table(
        f"{name}: which optimiser to use", columns, rows, CHOICE_NOTE.format(target=f"{target:g}")
    )


CHOICE_NOTE = (
    "Use: of the optimisers that no other beats for certain at this budget, the one with the fewest"
    " evaluations to the target; as good: the others of these, the cheapest first. Excess: (f -"
    " f_best) / (g - f_best), median; success: excess at most {target} within the budget, with"
    " Wilson's 95 % interval. Told apart by Mann and Whitney's test over repetitions, adjusted by"
    " Holm, at 5 %. Next: the best of those that are worse for certain; chance: that a trial of the"
    " choice ends below one of the next, ties by half (A12). At a budget below the study's, trials"
    " are judged by what they had found by then. An evaluation with its gradient counts as one: see"
    " the table of times."
)


def rank_table(name: str, rankings_shown: Sequence[MeanRanks]) -> Table:
    """Mean ranks over problems, with their certainty."""
    rows: list[tuple[Entry, ...]] = []
    for ranking in rankings_shown:
        for i in np.argsort(ranking.means, kind="stable"):
            alike = ranking.doubt or ", ".join(ranking.alike(int(i)))
            rows.append(
                (
                    *(ranking.scope, ranking.budget, ranking.labels[i], ranking.ranks[i]),
                    *(alike or None, f"{ranking.blocks} {ranking.unit}"),
                    *(ranking.least, _or_none(ranking.p_all)),
                )
            )
    columns = (
        "problems",
        "budget",
        "optimiser",
        "mean rank",
        "not told from",
        "blocks",
        "least p",
        "p of Friedman",
    )
    note = (
        "Rank by the excess reached at the budget, no better than the target counted, 1 being best;"
        " with a bootstrap 95 % interval over problems, or their range where they are too few to"
        " tell any two optimisers apart. Not told from: Wilcoxon's signed-rank test over problems,"
        " adjusted by Holm for all pairs, above 5 %; least p: the smallest that so many problems"
        " can give, if all of them agree. Of a single problem the trials are ranked and tested"
        " (Mann and Whitney), which says nothing of another."
    )
    return Table(f"{name}: ranks", columns, rows, note)


def pair_table(name: str, rankings_shown: Sequence[MeanRanks]) -> Table:
    """All pairs over all problems: effect sizes with adjusted p-values."""
    rows: list[tuple[Entry, ...]] = []
    for ranking in (each for each in rankings_shown if each.scope == OVER_ALL):
        order = np.argsort(ranking.means, kind="stable")
        for place, i in enumerate(order):
            # Each pair once, the better by rank first: the chance then mostly lies above one half.
            for j in order[place + 1 :]:
                p = float(ranking.p[i, j])
                verdict = ranking.doubt or "no"
                if ranking.told(int(i), int(j)):
                    verdict = "yes"
                rows.append(
                    (
                        ranking.budget,
                        ranking.labels[i],
                        ranking.labels[j],
                        float(ranking.chances[i, j]),
                        p,
                        verdict,
                        *posterior(ranking, int(i), int(j)),
                    )
                )
    columns = (
        *("budget", "optimiser", "against", "chance to end below", "p (Holm)", "told apart"),
        *("probably better", "equal in practice", "probably worse"),
    )
    note = (
        "Chance: that a trial of the optimiser ends below one of the other on the same problem at"
        " that budget, ties by half (A12, Vargha and Delaney), mean over problems; from 0.56, 0.64"
        " and 0.71 on it is called small, medium and large. p: as in the table of ranks."
        " Probably better, equal in practice, worse: on a further problem like these, by the"
        " Bayesian signed-rank test (Benavoli and others 2014, 2017) on the chances by problem;"
        f" equal in practice is a chance within 0.5 and {ROPE:g}, less than a small effect. No"
        " evidence of a difference is not evidence of none: the second number is."
    )
    return Table(f"{name}: pairs", columns, rows, note)


def posterior(ranking: MeanRanks, i: int, j: int) -> tuple[Entry, ...]:
    """Probabilities that one optimiser is better, equal and worse; nothing of a single problem."""
    if ranking.posterior is None:
        return None, None, None
    return tuple(float(each) for each in ranking.posterior[i, j])


def profile_table(name: str, races: Sequence[ProblemRace], scale: JudgingScale) -> Table:
    """Data and performance profiles as numbers."""
    simplex = np.array(SIMPLEX)
    head = tuple(f"{s:g} (d+1)" for s in SIMPLEX) + tuple(f"{r:g} x best" for r in RATIOS)
    rows: list[tuple[Entry, ...]] = []
    if races:
        shares = profiles(races, simplex, np.array(RATIOS))
        # By the area under the data profile: who solves more, and sooner, stands higher.
        order = np.argsort(-shares.data.sum(axis=1), kind="stable")
        rows = [
            (shares.labels[i], *map(float, shares.data[i]), *map(float, shares.performance[i]))
            for i in order
        ]
    note = (
        f"Share of trials with an excess of at most {scale.target:g} within so many evaluations:"
        " multiples of d + 1, d being the number of parameters (data profile, More and Wild), and"
        " of the evaluations of the best optimiser on the same problem and repetition (performance"
        " profile, Dolan and More). Failures and misses never count as solved."
    )
    return Table(f"{name}: profiles", ("optimiser", *head), rows, note)


def progress_table(name: str, scores: Sequence[CellScores], scale: JudgingScale) -> Table:
    """Anytime curves as numbers.

    Quartiles of the excess, and the share of targets reached, at each mark.
    """
    # The marks are among the grid: nothing is interpolated.
    places = np.searchsorted(scale.grid, scale.marks)
    rows: list[tuple[Entry, ...]] = []
    for s in scores:
        problem = s.cell.problem
        low, middle, high = s.curve[:, places]
        excess = intervals(middle, low, high)
        reached = map(float, s.attained[places])
        rows.append(
            (problem.dataset, problem.model, problem.objective, s.cell.label, *excess, *reached)
        )
    columns = (
        *("data set", "model", "objective", "optimiser"),
        *(f"excess at {mark}" for mark in scale.marks),
        *(f"targets at {mark}" for mark in scale.marks),
    )
    note = (
        "Excess: median with quartiles over all trials, infinite for a failed one. Targets: share"
        f" of all trials and {len(scale.targets)} targets, excesses from 0.3 to that of the study"
        " in half decades, reached by then."
    )
    return Table(f"{name}: progress", columns, rows, note)


def _or_none(value: float) -> float | None:
    # Of fewer than three optimisers there is no such test.
    if np.isnan(value):
        return None
    return value


class ArrayFile:
    """Arrays of many cells in a file that nobody else sees, while they are few in memory."""

    def __init__(self) -> None:
        self._file, self._end = SpooledTemporaryFile(32 * AT_ONCE), 0  # noqa: SIM115
        self._layouts: dict[tuple[Any, ...], dict[str, _Place]] = {}
        finalize(self, self._file.close)

    def put(self, arrays: Mapping[str, NDArray[Any]]) -> tuple[int, Mapping[str, _Place]]:
        """Where some arrays begin, and where each is from there."""
        sizes = [array.nbytes for array in arrays.values()]
        starts = np.cumsum([0, *sizes]).tolist()
        layout = {
            name: (start, array.dtype, array.shape)
            for start, (name, array) in zip(starts, arrays.items(), strict=False)
        }
        self._file.seek(self._end)
        self._file.write(b"".join(array.tobytes() for array in arrays.values()))
        begun, self._end = self._end, self._end + starts[-1]
        # Most cells have as many trials: what is said of them is kept once.
        return begun, self._layouts.setdefault(tuple(layout.items()), layout)

    def get(self, begun: int, place: _Place) -> NDArray[Any]:
        """One of them."""
        start, dtype, shape = place
        self._file.seek(begun + start)
        return np.frombuffer(self._file.read(prod(shape) * dtype.itemsize), dtype).reshape(shape)


_Place: TypeAlias = tuple[int, np.dtype[Any], tuple[int, ...]]


class FiledScores(CellScores):
    """Scores whose arrays are in a file, from where each is read when it is asked for.

    What is known of a million trials and of the curves of 20,000 cells is then not in memory.
    """

    @classmethod
    def of(cls, scores: CellScores, file: ArrayFile) -> FiledScores:
        """The same scores, their arrays in a file."""
        arrays = {k: value for k, value in vars(scores).items() if isinstance(value, np.ndarray)}
        begun, layout = file.put(arrays)
        kept = {k: value for k, value in vars(scores).items() if k not in arrays}
        filed = object.__new__(cls)
        vars(filed).update(kept, _file=file, _begun=begun, _layout=layout)
        return filed

    def __getattr__(self, name: str) -> Any:
        # Nothing of its own is missing but while a copy is made.
        if name.startswith("_") or name not in self._layout:
            raise AttributeError(name)
        return self._file.get(self._begun, self._layout[name])


@dataclass(frozen=True, eq=False)
class Findings:
    """What came of a study.

    Parameters
    ----------
    facts : mapping of str to str
        Name, versions, machine, command.
    scale : JudgingScale
        How it is judged.
    summaries : tuple of CellSummary
        Every cell in numbers, in the order of the study.
    scores : tuple of CellScores
        The same cells as arrays; empty if they were not wanted.
    """

    facts: Mapping[str, str]
    scale: JudgingScale
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
        facts, scale = store.facts(), JudgingScale.of(store)
        summaries: dict[int, CellSummary] = {}
        scores: dict[int, CellScores] = {}
        file = ArrayFile()
        # One cell at a time: a study of a million trials does not fit into memory.
        for cell, trials, best in judged(store):
            if scored:
                found = score_cell(cell, trials, best, scale)
                hits = found.hits
                found = with_truth(found, trials) if NOISY in facts else found
                scores[cell.id] = FiledScores.of(found, file)
            else:
                hits = hits_of(cell, trials, best, scale)
            summaries[cell.id] = summarise_cell(cell, trials, hits, float(facts["accuracy"]))
            del trials
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
    def races(self) -> list[ProblemRace]:
        """All entrants on each problem."""
        return races_of(self.scores)

    @cached_property
    def choices(self) -> list[OptimiserChoice]:
        """Which optimiser to use for each problem at each budget."""
        return choices(self.races, self.scale)

    @cached_property
    def rankings(self) -> list[MeanRanks]:
        """Mean ranks over all problems, by model and by data set, at each budget."""
        return rankings(self.races, self.scale)


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
    "anytime": lambda f: anytime_table(f.name, f.races, f.scale),
    "attainment": lambda f: attainment_table(f.name, f.races, f.scale),
    "sensitivity": lambda f: sensitivity_table(f.name, f.races, f.scale),
    "noise": lambda f: noise_table(f.facts, f.races, f.scale),
}
"""Tables that need every trial's trace."""

TABLES = (
    *("choice", "summary", "ranks", "pairs", "sensitivity", "anytime", "profiles", "progress"),
    *("attainment", "timing", "failures"),
)
"""All of them, in the order in which they are shown."""

RANKING = frozenset({"choice", "ranks", "pairs", "sensitivity", "anytime", "profiles"})
INSIDER = "native"
"""Tables that say who is ahead, and the optimiser that knows more of a problem than the others."""

NOISY = "noise"
"""The table of a study that has noise for an axis."""


def table_names(store: Store) -> tuple[str, ...]:
    """The tables that a study has."""
    if NOISY in store.facts():
        return (*TABLES, NOISY)
    return TABLES


def study_tables(store: Store, names: Sequence[str] | None = None) -> Iterator[tuple[str, Table]]:
    """File stem and table of what is written after a run.

    Parameters
    ----------
    store : Store
        The study's.
    names : sequence of str, optional
        Which of them; all by default.
    """
    # Every trace is read only if a table that is wanted compares by them.
    if names is None:
        names = table_names(store)
    findings = Findings.of(store, scored=any(name in COMPARING for name in names))
    yield from tables_of(findings, names)


def tables_of(findings: Findings, names: Sequence[str]) -> Iterator[tuple[str, Table]]:
    """File stem and table of what is wanted of a study that is read."""
    raced = {summary.cell.optimiser for summary in findings.summaries}
    for name in names:
        table = (PLAIN | COMPARING)[name](findings)
        # Nobody is to read it off a ranking that it won by what the others are not told.
        if name in RANKING and INSIDER in raced:
            table = replace(table, note=f"{table.note} {OF_ITS_OWN[INSIDER]}")
        yield name, table


def write_tables(
    study: Study | str | Path,
    formats: Sequence[str] = tuple(FORMATS),
    out: Path = Path("results"),
    beside: Path | None = None,
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
    beside : Path, optional
        An archive whose trials are shown too.

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
    with opened(path, beside) as store:
        # All of them before the first is written: a fault in one leaves no half of a set behind.
        tables = list(study_tables(store))
    files = []
    for stem, table in tables:
        files += save_table(table, path.parent, stem, formats)
    return files
