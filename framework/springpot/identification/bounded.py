"""Descents that keep to the search box and whose every model evaluation is recorded."""

from __future__ import annotations

import numpy as np

from springpot.errors import OptionError
from springpot.rheology.points import Real

from .leastsquares import levenberg_marquardt
from .native import scanned_starts
from .problem import Problem
from .recorder import Recorder


class BoundedDescent:
    """Levenberg-Marquardt in coordinates in which every parameter is a ratio.

    Logarithms, or fractions of the box.

    Parameters
    ----------
    recorder : Recorder
        Where values come from; it counts them and ends the descent.
    """

    def __init__(self, recorder: Recorder) -> None:
        self.recorder = recorder
        self._log = np.array(
            [p.scale == "log" and p.lower >= 0 for p in recorder.problem.space.parameters]
        )

    def from_scan(self, rng: np.random.Generator, starts: int) -> Real:
        """Objectives (starts,) at the ends of descents from the best of one scan of shapes.

        Parameters
        ----------
        rng : numpy.random.Generator
            Moves the scan.
        starts : int
            Descents side by side.

        Raises
        ------
        OptionError
            If it is not a sweep that is fitted.
        """
        problem = self.recorder.problem
        if not isinstance(problem, Problem):
            raise OptionError("shapes are scanned among sweeps only")
        # A scanned shape costs a model evaluation too: the recorder is asked for the objective at
        # each. The scan gives the best first, of which a run that has counted a few of them must
        # know nothing yet.
        scanned = rng.permutation(self._admitted(scanned_starts(problem, rng)))
        best = scanned[np.argsort(self.recorder.batch(scanned))[:starts]]
        # In the box of the study, so that this descent searches where all others do.
        low, high = self._inner(self.recorder.lower), self._inner(self.recorder.upper)
        return levenberg_marquardt(self._evaluate, self._inner(best), low, high).cost

    def _admitted(self, x: Real) -> Real:
        """The points that are finite, moved into the box."""
        return np.clip(x[np.all(np.isfinite(x), axis=1)], self.recorder.lower, self.recorder.upper)

    def _inner(self, x: Real) -> Real:
        """Inner coordinates of search points (..., d)."""
        return np.log(x, out=np.array(x), where=self._log)

    def _evaluate(self, y: Real, rows: object) -> tuple[Real, Real]:
        """Residuals (r, 2n) and their derivative (r, d, 2n) by the inner coordinates (r, d)."""
        x = np.exp(y, out=np.array(y), where=self._log)
        residual, jacobian = self.recorder.residual_batch(x)
        slope: Real = jacobian.swapaxes(-1, -2) * np.where(self._log, x, 1.0)[:, :, None]
        return residual, slope


def minima_in_box(problem: Problem, scans: int = 4, starts: int = 8) -> Real:
    """Objectives (n,) at the ends of descents from several scans, smallest first.

    Parameters
    ----------
    problem : Problem
        What is minimised.
    scans, starts : int
        Scans, and descents from each.
    """
    descent, rng = BoundedDescent(Recorder(problem, 10**9)), np.random.default_rng(0)
    with np.errstate(all="ignore"):
        return np.sort(np.concatenate([descent.from_scan(rng, starts) for _ in range(scans)]))
