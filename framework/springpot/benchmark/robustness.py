"""What of a ranking stands, and what all optimisers of a study have in common.

A search that follows the noise has a small objective, and parameters that are worth less.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from springpot.benchmark.summary import CellSummary
from springpot.report.page import Entry, Table
from springpot.rheology.points import Real
from springpot.writing import Html, tag

from .comparison import CellScores, JudgingScale, ProblemRace, rank_blocks
from .plan import stream_of
from .statistics import (
    Interval,
    mean_interval,
    mean_range,
    mean_ranks,
    median,
    pooled_ranks,
    ranked,
    wilson_over,
)

LEVELS = np.array([1e-1, 1e-2, 1e-4])
"""Excesses at which the attainment function is shown, beside the study's target."""
FEWEST = 6
"""Problems from which on a bootstrap over them is shown, the fewest by which a signed-rank test can
tell two optimisers apart; below it their range is."""


def anytime_table(name: str, races: Sequence[ProblemRace], scale: JudgingScale) -> Table:
    """Area over the curve and share of targets, one number for all budgets up to the study's."""
    rows: list[tuple[Entry, ...]] = []
    if races:
        areas = np.array([race.of_trials("area").mean(axis=1) for race in races])
        targets = np.array(
            [[cell.attained.mean() for cell in race.cells] for race in races], dtype=float
        )
        ranks = mean_ranks(-areas)
        area, target = _intervals(areas, "area"), _intervals(targets, "targets")
        rows = [
            (races[0].labels[i], area[i], target[i], float(ranks[i]), len(races))
            for i in np.argsort(-areas.mean(axis=0), kind="stable")
        ]
    note = (
        "Area over the convergence curve (AOCC): one less the mean over all evaluations up to"
        f" {scale.budget} of log10 of the excess between {scale.target:g} and 1, over the decades"
        " between them; 1 for who is at the target from the first evaluation, 0 for who never gets"
        " below the reference or failed. Targets: share of all trials and targets reached, mean"
        " over the logarithm of the evaluations. Means over problems with bootstrap 95 % intervals,"
        f" or their range below {FEWEST} problems."
    )
    columns = ("optimiser", "area over the curve", "targets", "mean rank by area", "problems")
    return Table(f"{name}: anytime", columns, rows, note)


def attainment_table(name: str, races: Sequence[ProblemRace], scale: JudgingScale) -> Table:
    """The attainment function: the chance to be below an excess by a number of evaluations."""
    levels = np.append(LEVELS[1.01 * scale.target < LEVELS], scale.target)
    rows: list[tuple[Entry, ...]] = []
    if races:
        # Of one problem at a time, (problems, k, levels, m) when all are there.
        shares = np.array(
            [(race.values[:, None] <= levels[:, None, None]).mean(axis=2) for race in races]
        )
        means = shares.mean(axis=0)
        rows = [
            (label, float(level), *map(float, own))
            for label, each in zip(races[0].labels, means, strict=True)
            for level, own in zip(levels, each, strict=True)
        ]
    note = (
        "Empirical attainment function: the share of trials whose excess is at most that of the row"
        " by the evaluations of the column, mean over problems. Read along a row it says when an"
        " accuracy is reached, read down a column how far a budget leads."
    )
    columns = ("optimiser", "excess", *(f"by {mark}" for mark in scale.marks))
    return Table(f"{name}: attainment", columns, rows, note)


def _intervals(values: Real, what: str) -> list[Interval]:
    """Means of the columns of `values` (problems, k)."""
    if len(values) >= FEWEST:
        return mean_interval(values, np.random.default_rng(stream_of(0, "anytime", what)))
    return mean_range(values)


@dataclass(frozen=True, eq=False)
class WithoutSome:
    """A ranking without some problems.

    Parameters
    ----------
    without : str
        Which.
    ranks : ndarray, shape (k,)
        Mean ranks.
    """

    without: str
    ranks: Real

    @property
    def places(self) -> Real:
        """Places (k,), the best being 1; equals share the better."""
        # Rounded: means of the same ranks in another order differ in their last bits.
        ranks = np.round(self.ranks, 9)
        places: Real = 1 + (ranks < ranks[:, None]).sum(axis=1)
        return places


def without_each(races: Sequence[ProblemRace], scale: JudgingScale) -> Iterator[WithoutSome]:
    """The ranking at the whole budget: of all, then without each problem and without each model."""
    # What another problem ranks moves no rank within this one.
    ranks = ranked(rank_blocks(races, len(scale.marks) - 1, scale.target))
    yield WithoutSome("", ranks.mean(axis=0))
    if len(races) < 2:
        return
    for i, race in enumerate(races):
        told = f"{race.problem.model} on {race.problem.dataset}, {race.problem.objective}"
        yield WithoutSome(told, np.delete(ranks, i, axis=0).mean(axis=0))
    models = [race.problem.model for race in races]
    for model in dict.fromkeys(models):
        left = [own != model for own in models]
        if any(left) and models.count(model) > 1:
            yield WithoutSome(f"all of {model}", ranks[left].mean(axis=0))


def sensitivity_table(name: str, races: Sequence[ProblemRace], scale: JudgingScale) -> Table:
    """How far each optimiser moves if a problem, or all problems of a model, had not been there."""
    rows: list[tuple[Entry, ...]] = []
    if races:
        whole, *others = without_each(races, scale)
        places = np.array([each.places for each in others], dtype=float)
        places = places.reshape(len(others), len(whole.ranks))
        for i in np.argsort(whole.ranks, kind="stable"):
            place = int(whole.places[i])
            rows.append(
                (
                    races[0].labels[i],
                    float(whole.ranks[i]),
                    place,
                    *_moved(places[:, i], place, [each.without for each in others]),
                )
            )
    columns = ("optimiser", "mean rank", "place", "best", "worst", "moved most without")
    note = (
        f"Place by mean rank at {scale.budget} evaluations over all problems; best and worst: its"
        " place when one problem, or all problems of one model, are left out. Whose place hangs on"
        " one problem is not known to be there on others."
    )
    return Table(f"{name}: sensitivity", columns, rows, note)


def _moved(places: Real, place: int, names: Sequence[str]) -> tuple[Entry, ...]:
    if not len(places):
        return None, None, None
    steps = np.abs(places - place)
    furthest = None
    if steps.max() > 0:
        furthest = names[int(steps.argmax())]
    return int(places.min()), int(places.max()), furthest


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
        " for all optimisers. Success: as in the summary, on the noisy data, with a 95 % interval"
        " over problems. Noise-free regret: (f - f_best) / (g - f_best) of the best point against"
        " the data without noise; parameter error: the largest relative one; both medians over all"
        " trials. Intervals with the truth:"
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
    lost = [_regret(race) for race in races]
    for i, label in enumerate(races[0].labels):
        regrets = np.concatenate([regret[i] for regret in lost])
        cells = [race.cells[i] for race in races]
        rows.append(
            (
                *(100.0 * level, label, len(races)),
                wilson_over([race.of_one(i, "hits") for race in races]),
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
    return median(values)


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


OF_ITS_OWN = {
    "native": (
        "native knows how the model is built: it reads its starts off the data by variable"
        " projection, which no other optimiser could do with what it is given."
    ),
    "auto": (
        "auto descends by rules that were learnt from drawn problems, and who takes turns with"
        " descents is from half of springpot-60: on that half it is no newcomer."
    ),
    "least-squares-alternating": (
        "least-squares-alternating was made for these models: that logarithms and parameters take"
        " turns was found by a trial on sweeps of springpot-60."
    ),
    "pso-paper": (
        "pso-paper is born where the paper has it, in (0, k-bar) of a box that reaches twice as"
        " far, and may leave the box."
    ),
}
"""What is peculiar to some optimisers, by name."""


def fairness(facts: Mapping[str, str], summaries: Sequence[CellSummary]) -> Iterator[Html]:
    """The section of the report."""
    yield tag("h2", "What is fair about it")
    lines = [*_common(facts), *_different(summaries)]
    yield tag("ul", *(tag("li", line) for line in lines))


def _common(facts: Mapping[str, str]) -> Iterator[str]:
    yield (
        "In common: data, model, objective, box and budget. Evaluations are counted by springpot,"
        " not by the optimiser; one with its derivative counts as one."
    )
    levels = noise_levels(facts)
    if levels:
        percent = ", ".join(f"{100 * level:g}" for level in sorted(set(levels.values())))
        yield (
            f"Noise: {percent} %, drawn anew for every repetition from the seed, the name of the"
            " data and the repetition: the same draw for all optimisers, models and levels. Data"
            " whose truth is unknown keep what they have."
        )
    else:
        yield "Noise: whatever the data sets hold, the same in every repetition."
    if "common start" in facts:
        begin = json.loads(facts["common start"])
        yield (
            "First point: common. Each repetition has one, uniform in the box; it is evaluation 1"
            f" of every optimiser. Those that begin at a point begin there: {_listed(begin)}. The"
            " others have its value and go their own way."
        )
    else:
        yield (
            "First point: each optimiser's own. All of a repetition get one stream of random"
            " numbers, but use it in their own ways, so that their first points differ;"
            " x0='common' gives them the same one."
        )


def _different(summaries: Sequence[CellSummary]) -> Iterator[str]:
    labels = dict.fromkeys(summary.cell.label for summary in summaries)
    graded = [
        label
        for label in labels
        if any(summary.gradients for summary in summaries if summary.cell.label == label)
    ]
    yield f"Not in common: derivatives, used by {_listed(graded)}."
    yield (
        "Settings are the authors' or the library's defaults, unless the label names others:"
        " nobody's were tuned on these problems. An optimiser without randomness runs once where"
        " nothing but random numbers differs between repetitions, and that run stands for all."
    )
    names = {summary.cell.optimiser for summary in summaries}
    yield from (sentence for name, sentence in OF_ITS_OWN.items() if name in names)


def _listed(names: Sequence[str]) -> str:
    if not names:
        return "nobody"
    return ", ".join(names)
