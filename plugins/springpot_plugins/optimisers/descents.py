"""Short descents: least squares from many starts, and in turns with another optimiser.

The exact Jacobian serves SciPy's and the native solver; as a competitor the native one runs through
the recorder, which counts every one of its steps. Descents of several kinds in turn are what most
problems need. How their starts are drawn, which kinds in which order, when a descent is given up,
who takes turns with them and for how long: all of it was learnt by ``studies/suite_choice.py`` from
problems that are drawn by a seed, and is kept in ``auto.toml``.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from itertools import cycle
from typing import Any, ClassVar, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

import springpot
from springpot.errors import ModelError
from springpot.identification import (
    BoundedDescent,
    BudgetSpent,
    Card,
    Optimiser,
    Recorder,
    Searched,
)
from springpot.rheology import Real

from .cube import keep_on


@dataclass(frozen=True)
class LeastSquares(Optimiser):
    """Least squares from random starts until the budget is spent.

    Parameters
    ----------
    method : {"trf", "dogbox", "lm"}
        Trust region or dogleg inside the box, or MINPACK's Levenberg-Marquardt without it.
    logarithmic : bool
        Search positive parameters without an upper limit by their logarithm.
    tolerance : float
        Relative change of objective, point and gradient that ends a descent.
    """

    method: Literal["trf", "dogbox", "lm"] = "trf"
    logarithmic: bool = True
    tolerance: float = 1e-12

    name: ClassVar[str] = "least-squares"
    card: ClassVar[Card] = Card(
        "multi-start nonlinear least squares with exact Jacobian (SciPy)",
        "Branch et al. 1999, doi:10.1137/S1064827595289108; More 1978, doi:10.1007/BFb0067700",
        gradient=True,
        started=True,
    )

    def __post_init__(self) -> None:
        self._require("method", self.method in ("trf", "dogbox", "lm"), "trf, dogbox or lm")
        self._require("tolerance", 2.3e-16 < self.tolerance < 1, "in (2.3e-16, 1)")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Descend from one uniform start after another."""
        misfit = Misfit(problem, self.logarithmic)

        def descend() -> None:
            width = problem.upper - problem.lower
            start = problem.first(problem.lower + rng.random(problem.dimension) * width)
            self.descend(misfit, start)

        keep_on(problem, descend)

    def descend(self, misfit: Misfit, start: Real) -> None:
        """Descend from one point (d,) of the box until no step leads further."""
        from scipy.optimize import least_squares

        problem = misfit.problem
        lower, upper = misfit.inner(problem.lower), misfit.inner(problem.upper)
        bounds: tuple[Real | float, Real | float] = (lower, upper)
        scale: Real | float = upper - lower
        if self.method == "lm":
            # MINPACK knows no box.
            bounds, scale = (-np.inf, np.inf), 1.0
        least_squares(
            misfit.residuals,
            misfit.within(start),
            jac=misfit.jacobian,
            bounds=bounds,
            method=self.method,
            ftol=self.tolerance,
            xtol=self.tolerance,
            gtol=self.tolerance,
            x_scale=scale,
            # Never reached: the recorder ends the run when the budget is spent.
            max_nfev=problem.budget,
        )


@dataclass(frozen=True)
class AlternatingLeastSquares(Optimiser):
    """Short descents from random starts, by logarithms and by the parameters themselves in turn.

    By logarithms a parameter that is too small by orders comes back, and one that is drawn to
    nothing never does; by themselves it is the other way round.

    Parameters
    ----------
    tolerance : float
        Relative change of objective, point and gradient that ends a descent.
    """

    tolerance: float = 1e-6

    name: ClassVar[str] = "least-squares-alternating"
    card: ClassVar[Card] = Card(
        "multi-start nonlinear least squares, by logarithms and by parameters in turn (SciPy)",
        "Branch et al. 1999, doi:10.1137/S1064827595289108",
        gradient=True,
        started=True,
    )

    def __post_init__(self) -> None:
        self._require("tolerance", 2.3e-16 < self.tolerance < 1, "in (2.3e-16, 1)")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Descend from one uniform start after another."""
        ways = cycle(Misfit(problem, logarithmic) for logarithmic in (True, False))
        keep_on(problem, lambda: self.descend(next(ways), rng))

    def descend(self, misfit: Misfit, rng: np.random.Generator) -> None:
        """Descend from a uniform start."""
        problem = misfit.problem
        width = problem.upper - problem.lower
        start = problem.first(problem.lower + rng.random(problem.dimension) * width)
        LeastSquares(tolerance=self.tolerance).descend(misfit, start)


class Misfit:
    """Residuals and Jacobian by inner coordinates.

    Logarithms of positive parameters without an upper limit where asked for, search parameters
    elsewhere.
    """

    def __init__(self, problem: Recorder, logarithmic: bool = True) -> None:
        self.problem = problem
        parameters = problem.problem.space.parameters
        self.logarithmic: NDArray[np.bool_] = np.array(
            [logarithmic and p.scale == "log" and p.lower >= 0 for p in parameters]
        )
        self._at: Real = np.empty(0)
        self._found: tuple[Real, Real] = self._at, self._at

    def inner(self, x: Real) -> Real:
        """Inner coordinates of a search point."""
        return np.log(x, out=np.array(x), where=self.logarithmic)

    def within(self, x: Real) -> Real:
        """Inner coordinates of a search point, moved into the box."""
        lower, upper = self.inner(self.problem.lower), self.inner(self.problem.upper)
        return np.clip(self.inner(x), lower, upper)

    def placed(self, share: Real) -> Real:
        """Search point at shares (d,) of the box's widths by inner coordinates."""
        lower, upper = self.inner(self.problem.lower), self.inner(self.problem.upper)
        return self._outer(lower + share * (upper - lower))

    def _outer(self, y: Real) -> Real:
        # exp(230) is 1e100, whose square is still a number: without a box a step may lead anywhere.
        return np.exp(np.minimum(y, 230.0), out=np.array(y), where=self.logarithmic)

    def residuals(self, y: Real) -> Real:
        """Residuals (2n,); the Jacobian that comes with them is kept."""
        return self.both(y)[0]

    def jacobian(self, y: Real) -> Real:
        """Jacobian (2n, d) by inner coordinates, usually without a further evaluation."""
        return self.both(y)[1]

    def both(self, y: Real) -> tuple[Real, Real]:
        """Both, evaluated once for each point."""
        if not np.array_equal(y, self._at):
            x = self._outer(y)
            residual, jacobian = self.problem.residuals(x)
            # By ln x a derivative is x times that by x. A copy of y, since the library may change
            # its own.
            self._at, self._found = (
                y.copy(),
                (residual, jacobian * np.where(self.logarithmic, x, 1.0)),
            )
        return self._found


@dataclass(frozen=True)
class Native(Optimiser):
    """Batched Levenberg-Marquardt in the search form, from starts read off the data.

    Parameters
    ----------
    starts : int
        Descents side by side.
    """

    starts: int = 4

    name: ClassVar[str] = "native"
    card: ClassVar[Card] = Card(
        "multi-start Levenberg-Marquardt, starts by variable projection, exact Jacobian",
        "Marquardt 1963, doi:10.1137/0111030; Golub and Pereyra 1973, doi:10.1137/0710036",
        gradient=True,
    )

    def __post_init__(self) -> None:
        self._require("starts", self.starts >= 1, "at least 1")

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Descend from the best starts of one scan after another."""
        # Every descent of it keeps to the box, unlike those of a fit: a race is run by all in the
        # same box.
        descent = BoundedDescent(problem)
        keep_on(problem, lambda: descent.from_scan(rng, self.starts))


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
