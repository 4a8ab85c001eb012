"""Whether noise changes who wins, and by which measure.

A search that follows the noise has a small objective, and parameters that are worth less.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

import numpy as np

from springpot.report.tables import Entry, Table
from springpot.rheology.points import Real

from .comparison import CellScores, JudgingScale, ProblemRace
from .statistics import mean_ranks, median, pooled_ranks, wilson

MEASURES = ("objective", "noise-free regret", "parameter error")


def noise_levels(facts: Mapping[str, str]) -> dict[str, float]:
    """Level of noise of each data set of a study that has noise for an axis."""
    levels: dict[str, float] = json.loads(facts.get("noise", "{}"))
    return levels


def noise_table(
    facts: Mapping[str, str], races: Sequence[ProblemRace], scale: JudgingScale
) -> Table:
    """Every optimiser at every level of noise, by four measures."""
    levels = noise_levels(facts)
    rows: list[tuple[Entry, ...]] = []
    for level in sorted(set(levels.values())):
        chosen = [race for race in races if levels.get(race.problem.dataset) == level]
        if chosen:
            rows += _rows(level, chosen, scale)
    columns = (
        *("noise [%]", "optimiser", "problems", "success", "noise-free regret", "parameter error"),
        "intervals with the truth",
        *(f"rank by {measure}" for measure in MEASURES),
    )
    note = (
        "Every repetition has a draw of the noise of its own, eq. (53) with both signs, the same"
        " for all optimisers. Success: as in the summary, on the noisy data. Noise-free regret: (f"
        " - f_best) / (g - f_best) of the best point against the data without noise; parameter"
        " error: the largest relative one; both medians over all trials. Intervals with the truth:"
        " share of the 95 % intervals of least squares at the best point that hold the true"
        " parameter, mean over trials. Ranks: mean over problems at the whole budget, the best"
        " being 1; where they differ, the measure decides who wins."
    )
    return Table(f"{facts['name']}: noise", columns, rows, note)


def _rows(
    level: float, races: Sequence[ProblemRace], scale: JudgingScale
) -> list[tuple[Entry, ...]]:
    ranks = [_ranks(races, measure, scale) for measure in MEASURES]
    rows: list[tuple[Entry, ...]] = []
    for i, label in enumerate(races[0].labels):
        hits = np.concatenate([race.hits[i] for race in races])
        regrets = np.concatenate([_regret(race)[i] for race in races])
        cells = [race.cells[i] for race in races]
        rows.append(
            (
                *(100.0 * level, label, len(races)),
                wilson(int(np.isfinite(hits).sum()), len(hits)),
                _median(regrets),
                _median(_joined(cells, "errors")),
                _mean(_joined(cells, "covered")),
                *(None if rank is None else float(rank[i]) for rank in ranks),
            )
        )
    return rows


def _joined(cells: Sequence[CellScores], name: str) -> Real:
    return np.concatenate([getattr(cell, name) for cell in cells])


def _median(values: Real) -> float | None:
    """Of those that are known; a failed trial counts as infinite."""
    return median(values[~np.isnan(values)])


def _mean(values: Real) -> float | None:
    known = values[~np.isnan(values)]
    if not len(known):
        return None
    return float(known.mean())


def _regret(race: ProblemRace) -> Real:
    """Noise-free excess (k, n) of what each trial recommends."""
    values = race.of_trials("oracles")
    best = race.problem.known
    if best is None:
        # Another model than that of the data: the best that anybody found of them.
        best = float(np.min(values, initial=np.inf, where=np.isfinite(values)))
    regret: Real = (values - best) / (race.problem.reference - best)
    return np.where(np.isnan(regret), regret, np.maximum(regret, 0.0))


def _ranks(races: Sequence[ProblemRace], measure: str, scale: JudgingScale) -> Real | None:
    """Mean ranks (k,) over the problems on which a measure is known."""
    blocks = []
    for race in races:
        # Below the target nothing counts: whoever got further is no better.
        values = np.maximum(race.values[:, :, -1], scale.target)
        if measure == MEASURES[1]:
            values = np.maximum(_regret(race), scale.target)
        if measure == MEASURES[2]:
            values = race.of_trials("errors")
        if not np.isnan(values).any():
            blocks.append(pooled_ranks(values).mean(axis=1))
    if not blocks:
        return None
    return mean_ranks(np.array(blocks))
