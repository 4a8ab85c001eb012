"""Nonlinear least squares from many starts, with the exact Jacobian: SciPy's and the native solver.

As a competitor the native one runs through the recorder, which counts every one of its steps.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import cycle
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from springpot.identification import BoundedDescent, Card, Optimiser, Recorder
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
