"""Where a search for a spectrum is: the best lines at a setting, and the way to the next one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from springpot.rheology.points import Real

from ..numerics import ALIKE
from .leastsquares import REACH

SHORTEST = 1e-7
"""Step in coordinates, most of them logarithms, that changes nothing that is printed."""


@dataclass(frozen=True, eq=False)
class Trial:
    """The best spectrum at given parameters of the effects."""

    u: Real
    log_rates: Real
    weights: Real
    cost: float


@dataclass
class Solving:
    """A trial whose weights are solved for, the best of them, and the cost that is foretold."""

    trial: Trial
    best: Trial
    foretold: float = np.inf


@dataclass
class Way:
    """A descent: where it is, the residual and its fall there, and where it goes next.

    It is at rest where a step changes nothing that is printed.
    """

    trial: Trial
    damping: float = 1e-3
    slopes: tuple[Real, Real] = (np.zeros(0), np.zeros((0, 0)))
    better: bool = True
    at_rest: bool = True

    def moves(self, low: Real, high: Real) -> bool:
        """Take the next step in view, and tell whether it is one."""
        # Nearly a Gauss-Newton step at first; what the data do not bear makes it shorter.
        self.ahead = np.clip(self.trial.u + _step(*self.slopes, self.damping), low, high)
        self.at_rest = bool(np.max(np.abs(self.ahead - self.trial.u)) < SHORTEST)
        return not self.at_rest

    def take(self, other: Trial, still: float) -> None:
        """Go on to the best spectrum there, if it is better."""
        drop = self.trial.cost - other.cost
        self.better, self.at_rest = drop > 0.0, False
        if not self.better:
            # Not better, or no number: a shorter step, nearer to the steepest descent.
            self.damping *= 10.0
            return
        self.trial, self.damping = other, max(0.1 * self.damping, 1e-9)
        self.at_rest = drop <= still * other.cost


def _step(residual: Real, slopes: Real, damping: float) -> Real:
    """A damped Gauss-Newton step (q,), no coordinate of it beyond `REACH`."""
    size = np.linalg.norm(slopes, axis=0)
    # Slopes so small that their squares are zero have no size: divided by less they would drown the
    # damping.
    size = np.maximum(size, ALIKE * max(float(size.max()), 1e-150))
    scaled = slopes / size
    matrix = scaled.T @ scaled + damping * np.eye(len(size))
    step: Real = np.clip(np.linalg.solve(matrix, scaled.T @ residual) / size, -REACH, REACH)
    return step
