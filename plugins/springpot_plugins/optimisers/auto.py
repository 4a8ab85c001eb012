"""Least squares first, and then the optimiser that suits what they have shown of the problem.

Short descents of several kinds in turn are what most problems need, and what they leave behind may
tell the others apart: how many of them agree, how far they fell, how the valley is shaped. Which
kinds, in which order, how long a descent may be, who comes next and for how long: all of it was
learnt from half of the problems of springpot-60 by ``studies/suite_choice.py`` and is kept in
``auto.toml``.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, fields
from functools import cache
from importlib.resources import files
from itertools import cycle
from typing import Any, ClassVar, TypeAlias

import numpy as np

import springpot
from springpot.errors import ModelError
from springpot.identification import (
    BudgetSpent,
    Card,
    Optimiser,
    Recorder,
    Searched,
    SpecimenProblem,
)
from springpot.rheology import Real

from .cube import keep_on
from .leastsquares import LeastSquares, Misfit

NEGLIGIBLE = 1e-6
"""Share that is as good as nothing.

Of the way from no response at all to the best end, of the box at its edges, and of the changes that
end a short descent.
"""
LARGEST = 16.0
"""Decades beyond which nothing but rounding is told."""


@dataclass(frozen=True)
class Seen:
    """What some descents by least squares have shown of a problem.

    Parameters
    ----------
    parameters : int
        That are searched.
    descents : int
        That ended, each at a minimum or where it could not go on.
    agreement : float
        Share of them that ended as low as the best, but for a millionth of the way.
    spread : float
        Decades between the best end and the middle one, of what is more than that.
    fall : float
        Decades from the middle start to the best end, likewise.
    conditioning : float
        Decades between the longest and the shortest axis of the valley where it is best.
    edges : float
        Share of the parameters that lie at an edge of the box there.
    """

    parameters: int
    descents: int
    agreement: float
    spread: float
    fall: float
    conditioning: float
    edges: float

    def to_dict(self) -> dict[str, float]:
        """By name."""
        return {each.name: float(getattr(self, each.name)) for each in fields(self)}


class _CutShortError(Exception):
    """Ends a descent that has had its evaluations."""


@dataclass(frozen=True)
class Auto(Optimiser):
    """Look at a problem by descents, then hand it to the optimiser that suits it.

    Parameters
    ----------
    share : float
        Of the budget, for looking; what is found then counts like all else.
    """

    share: float = 0.05

    name: ClassVar[str] = "auto"
    card: ClassVar[Card] = Card(
        "least squares first, then the optimiser that suits what they have shown",
        "Rice 1976, doi:10.1016/S0065-2458(08)60520-3; Xu et al. 2008, doi:10.1613/jair.2490",
        gradient=True,
        started=True,
    )

    def __post_init__(self) -> None:
        self._require("share", 0.0 < self.share < 1.0, "in (0, 1)")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Look, make the best exact, choose, and go on with what was chosen."""
        # A common start has been evaluated already.
        limit = problem.evaluations + max(1, int(self.share * budget))
        seen = looked(problem, limit, rng)
        LeastSquares().descend(Misfit(problem), problem.best_x)
        name, why = chosen(seen)
        problem.remark(f"{name} was chosen to take turns with descents: {why}")
        other: Optimiser = springpot.plugins().find("optimiser", name)()
        # In turns: where the rules err, half of the budget is still the descents'.
        turns = cycle([other.minimise, descents])
        length = max(1, int(rules()["turn"] * budget))
        keep_on(problem, lambda: in_turn(problem, next(turns), length, rng))


def descents(problem: Recorder, budget: int, rng: np.random.Generator) -> None:
    """Nothing but the short descents, until the recorder ends the run."""
    ways = kinds()
    keep_on(problem, lambda: descended(problem, next(ways), rng, budget))


class Turn(Searched):
    """A problem whose evaluations are those of a run that goes on after this turn."""

    def __init__(self, run: Recorder) -> None:
        self.run, self.space = run, run.problem.space

    def evaluate(self, x: Real) -> Real:
        """Objective (...) at search points (..., d)."""
        return self.run.batch(x.reshape(-1, x.shape[-1])).reshape(x.shape[:-1])

    def residuals_and_jacobian(self, x: Real) -> tuple[Real, Real]:
        """Residuals (..., m) and their derivative (..., m, d)."""
        if x.ndim == 1:
            return self.run.residuals(x)
        return self.run.residual_batch(x)

    def residuals(self, x: Real) -> Real:
        """Residuals (m,) alone."""
        return self.run.misfit(x)


Search: TypeAlias = Callable[[Recorder, int, np.random.Generator], None]


def in_turn(problem: Recorder, search: Search, length: int, rng: np.random.Generator) -> None:
    """Let somebody search for so many evaluations, or as many as the run has left."""
    length = min(length, problem.left)
    if length < 1:
        return
    try:
        search(Recorder(Turn(problem), length), length, rng)
    except BudgetSpent:
        # That of the turn; the end of the run ends this too.
        if problem.left < 1:
            raise


def looked(problem: Recorder, limit: int, rng: np.random.Generator) -> Seen:
    """Descend from uniform points until so many evaluations are made, and say what was seen."""
    starts, ends, ways = list[float](), list[float](), kinds()
    while problem.evaluations < limit:
        misfit = descended(problem, next(ways), rng, limit)
        # One that was cut short by the limit has ended nowhere; without it there may be none.
        if misfit.cut and problem.evaluations >= limit and ends:
            break
        starts.append(misfit.first)
        ends.append(misfit.least)
    return _told(problem, np.array(starts), np.array(ends))


def kinds() -> Iterator[LeastSquares]:
    """The kinds of descent in the order of the rules, over and over."""
    return cycle(LeastSquares(tolerance=NEGLIGIBLE, **each) for each in rules()["descents"])


def descended(
    problem: Recorder, kind: LeastSquares, rng: np.random.Generator, limit: int
) -> Watched:
    """A short descent from a uniform point, at the latest until `limit` evaluations of the run."""
    longest = problem.evaluations + int(rules()["longest"])
    misfit = Watched(problem, min(limit, longest), kind.logarithmic)
    width = problem.upper - problem.lower
    start = problem.first(problem.lower + rng.random(problem.dimension) * width)
    with suppress(_CutShortError):
        kind.descend(misfit, start)
    return misfit


class Watched(Misfit):
    """Residuals that remember the first and the least objective, and end a descent in time.

    Parameters
    ----------
    problem : Recorder
        The run.
    limit : int
        Its evaluations at which the descent is cut short.
    logarithmic : bool
        As of `Misfit`.
    """

    def __init__(self, problem: Recorder, limit: int, logarithmic: bool) -> None:
        super().__init__(problem, logarithmic)
        self.limit, self.first, self.least, self.cut = limit, np.inf, np.inf, False

    def both(self, y: Real) -> tuple[Real, Real]:
        """Both, unless it has had enough."""
        before = self.problem.evaluations
        if before >= self.limit:
            self.cut = True
            raise _CutShortError
        residual, jacobian = super().both(y)
        if self.problem.evaluations > before:
            value = float(residual @ residual)
            if not np.isfinite(self.first):
                self.first = value
            self.least = min(self.least, value)
        return residual, jacobian


def _told(problem: Recorder, starts: Real, ends: Real) -> Seen:
    best, middle = float(np.min(ends)), float(np.median(starts))
    # Of exact data the best is rounding, which says nothing of a problem.
    way = min(middle, _nothing(problem)) - best
    nothing = NEGLIGIBLE * max(way, np.finfo(float).tiny)
    # At the best point: the evaluation is one of the search, and counted.
    width, x = problem.upper - problem.lower, problem.best_x
    conditioning = LARGEST
    if problem.left > 0 and x.size:
        stretch = np.linalg.svd(problem.residuals(x)[1] * width, compute_uv=False)
        conditioning = _decades(float(stretch[0]), float(stretch[-1]))
    share = (x - problem.lower) / width
    return Seen(
        problem.dimension,
        len(ends),
        float(np.mean(ends <= best + nothing)),
        _decades(float(np.median(ends)) + nothing, best + nothing),
        _decades(middle + nothing, best + nothing),
        conditioning,
        float(np.mean((share < NEGLIGIBLE) | (share > 1.0 - NEGLIGIBLE))),
    )


def _nothing(problem: Recorder) -> float:
    """Objective of no response: where a start is absurd, it says nothing of the data."""
    of = problem.problem
    if isinstance(of, SpecimenProblem) and np.isfinite(of.nothing):
        return of.nothing
    return np.inf


def _decades(large: float, small: float) -> float:
    if not large < np.inf or small <= 0.0:
        return LARGEST
    return float(np.clip(np.log10(max(large, small) / small), 0.0, LARGEST))


@cache
def rules() -> Mapping[str, Any]:
    """The descents, the turns and the tree, as they were learnt."""
    return tomllib.loads(files(__package__).joinpath("auto.toml").read_text(encoding="utf-8"))


def chosen(seen: Seen) -> tuple[str, str]:
    """The optimiser for a problem, and why in one line.

    Raises
    ------
    ModelError
        If none of those that were learnt is installed.
    """
    names, reasons = leaf(rules()["tree"], seen.to_dict())
    for name in names:
        if _installed(name):
            why = " and ".join(reasons) or "it did best on the problems that the rules are from"
            return name, f"{why}; {seen.descents} descents were looked at"
    raise ModelError(f"none of {', '.join(names)} is installed")


def leaf(tree: Mapping[str, Any], told: Mapping[str, float]) -> tuple[list[str], list[str]]:
    """Optimisers that a tree names for what was told, the best first, and its reasons."""
    reasons = list[str]()
    while "feature" in tree:
        value, limit = told[tree["feature"]], tree["limit"]
        side, word = "above", "not below"
        if value < limit:
            side = word = "below"
        reasons.append(f"{tree['feature']} {value:.3g} is {word} {limit:.3g}")
        tree = tree[side]
    return list(tree["optimisers"]), reasons


def _installed(name: str) -> bool:
    try:
        springpot.plugins().find("optimiser", name)
    except ModelError:
        return False
    return True
