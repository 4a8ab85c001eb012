"""Short descents from starts of two scales, and then in turns with another optimiser.

Descents of several kinds in turn are what most problems need. How their starts are drawn, which
kinds in which order, when a descent is given up, who takes turns with them and for how long: all of
it was learnt by ``studies/suite_choice.py`` from problems that are drawn by a seed, and is kept in
``auto.toml``.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
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
)
from springpot.rheology import Real

from .cube import keep_on
from .leastsquares import LeastSquares, Misfit

NEGLIGIBLE = 1e-6
"""Change that ends a short descent, and share of the best end within which another is as low."""

SIZED = "logarithms"
"""How the rules call starts that are drawn by them."""


class _CutShortError(Exception):
    """Ends a descent that has had its evaluations."""


@dataclass(frozen=True)
class Auto(Optimiser):
    """Look at a problem by descents, then let them take turns with another optimiser.

    Parameters
    ----------
    share : float
        Of the budget, for descents alone.
    """

    share: float = 0.05

    name: ClassVar[str] = "auto"
    card: ClassVar[Card] = Card(
        "least squares from starts of two scales, then in turns with another",
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
        # The best made exact, as far as that is done quickly.
        with suppress(_CutShortError):
            polished = Watched(problem, limit + int(rules()["longest"]), logarithmic=True)
            LeastSquares().descend(polished, problem.best_x)
        name = chosen()
        problem.remark(f"{name} was chosen to take turns with descents: {told(seen)}")
        other: Optimiser = springpot.plugins().find("optimiser", name)()
        turns = cycle([descents, other.minimise])
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


def looked(problem: Recorder, limit: int, rng: np.random.Generator) -> list[Watched]:
    """The descents that were made until so many evaluations were spent."""
    seen, ways = list[Watched](), kinds()
    while problem.evaluations < limit:
        seen.append(descended(problem, next(ways), rng, limit))
    return seen


def told(seen: Sequence[Watched]) -> str:
    """What descents have shown, in one line."""
    best = min(each.least for each in seen)
    # Of data without noise rounding is all that is left at the best, and no two ends are alike:
    # residuals of a millionth of those at the start are as low as any.
    alike = sum(
        each.least <= (1.0 + NEGLIGIBLE) * best + NEGLIGIBLE**2 * each.begun for each in seen
    )
    return f"{alike} of {len(seen)} descents ended as low as the best"


@dataclass(frozen=True)
class Way:
    """A kind of descent, and how its start is drawn.

    Uniform in the box a parameter has the size of its upper end; drawn by logarithms any order
    below that is as likely, which is what a mass or a time needs that shows at high frequencies
    only.
    """

    kind: LeastSquares
    sized: bool


def kinds() -> Iterator[Way]:
    """The ways to descend in the order of the rules, over and over."""
    ways = [
        Way(LeastSquares(told["method"], told["logarithmic"], NEGLIGIBLE), told["begins"] == SIZED)
        for told in rules()["descents"]
    ]
    return cycle(ways)


def descended(problem: Recorder, way: Way, rng: np.random.Generator, limit: int) -> Watched:
    """A short descent, at the latest until `limit` evaluations of the run."""
    longest = problem.evaluations + int(rules()["longest"])
    misfit = Watched(problem, min(limit, longest), way.kind.logarithmic)
    start = Misfit(problem, way.sized).placed(rng.random(problem.dimension))
    with suppress(_CutShortError):
        way.kind.descend(misfit, problem.first(start))
    return misfit


class Watched(Misfit):
    """Residuals that remember the least objective, and end a descent that leads no further.

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
        self.limit, self.bests = limit, [np.inf]

    @property
    def begun(self) -> float:
        """The objective at the start, nothing where none was evaluated."""
        return self.bests[1] if len(self.bests) > 1 else 0.0

    @property
    def least(self) -> float:
        """The least objective so far."""
        return self.bests[-1]

    def both(self, y: Real) -> tuple[Real, Real]:
        """Both, unless it has had enough."""
        before, late = self.problem.evaluations, self.bests[-1 - rules()["patience"] :]
        lost = len(late) > rules()["patience"] and late[-1] > rules()["progress"] * late[0]
        if before >= self.limit or lost:
            raise _CutShortError
        residual, jacobian = super().both(y)
        if self.problem.evaluations > before:
            self.bests.append(min(self.least, float(residual @ residual)))
        return residual, jacobian


@cache
def rules() -> Mapping[str, Any]:
    """What was learnt."""
    return tomllib.loads(files(__package__).joinpath("auto.toml").read_text(encoding="utf-8"))


def chosen() -> str:
    """Who takes turns: the first of those that were learnt that is installed.

    Raises
    ------
    ModelError
        If none of them is.
    """
    for name in rules()["optimisers"]:
        if _installed(name):
            return str(name)
    raise ModelError(f"none of {', '.join(rules()['optimisers'])} is installed")


def _installed(name: str) -> bool:
    try:
        springpot.plugins().find("optimiser", name)
    except ModelError:
        return False
    return True
