"""The native solver as a competitor: its descents run through the recorder, which counts every one of their steps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from springpot.identification import Card, Optimiser, Recorder, levenberg_marquardt, scanned_starts
from springpot.rheology import Real

from .cube import keep_on


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
        descent = _Descent(problem)

        def attempt() -> None:
            # Scanned shapes cost model evaluations too: the recorder is asked for the objective at each.
            starts = descent.admitted(scanned_starts(problem.problem, rng))
            values = problem.batch(starts)
            best = starts[np.argsort(values)[: self.starts]]
            levenberg_marquardt(
                descent.evaluate, descent.inner(best), descent.inner(problem.lower), descent.inner(problem.upper)
            )

        keep_on(problem, attempt)


class _Descent:
    """Residuals in coordinates in which every parameter is a ratio: logarithms, or fractions of the box."""

    def __init__(self, problem: Recorder) -> None:
        self.problem = problem
        self.log = np.array([p.scale == "log" and p.lower >= 0 for p in problem.problem.space.parameters])

    def admitted(self, x: Real) -> Real:
        """The points that are finite, moved into the box."""
        return np.clip(x[np.all(np.isfinite(x), axis=1)], self.problem.lower, self.problem.upper)

    def inner(self, x: Real) -> Real:
        """Inner coordinates of search points (..., d)."""
        return np.log(x, out=np.array(x), where=self.log)

    def evaluate(self, y: Real, rows: object) -> tuple[Real, Real]:
        """Residuals (r, 2n) and their derivative (r, d, 2n) by the inner coordinates (r, d)."""
        x = np.exp(y, out=np.array(y), where=self.log)
        residual, jacobian = self.problem.residual_batch(x)
        slope: Real = jacobian.swapaxes(-1, -2) * np.where(self.log, x, 1.0)[:, :, None]
        return residual, slope
