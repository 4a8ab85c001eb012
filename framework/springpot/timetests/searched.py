"""Tests in time as a problem for any optimiser.

The same sum of squares that the native solver minimises.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from springpot.errors import SpringpotError
from springpot.identification.problem import Searched
from springpot.identification.space import box_of
from springpot.rheology.model import Model
from springpot.rheology.points import Real

from .residuals_of_tests import InTimePart, Part

FASTEST = 10.0
"""By how much the stiffness of the shortest time may exceed what was measured.

Glass lies beyond it.
"""


class InTimeProblem(Searched):
    """Minimise the residuals of tests over their noise.

    Parameters
    ----------
    model : Model
        What is fitted.
    parts : sequence of Part
        To what, each with its weight.
    reference : float
        Temperature in kelvin at which shifts are one.
    size, reach : float
        Typical stiffness and largest displacement of the tests.
    """

    def __init__(
        self, model: Model, parts: Sequence[Part], reference: float, size: float, reach: float
    ) -> None:
        self.model, self.parts, self.reference = model, list(parts), reference
        slowest = min(_slowest(part) for part in parts)
        self.space = box_of(model, FASTEST * size, max(1.0, 1.0 / slowest), reach)

    def evaluate(self, x: Real) -> Real:
        """Sum of squares (...) at search points (..., d).

        Endless where the model cannot be followed.
        """
        rows = x.reshape(-1, x.shape[-1])
        squares = np.array([float(np.sum(self._one(row)[0] ** 2)) for row in rows])
        return squares.reshape(x.shape[:-1])

    def residuals_and_jacobian(self, x: Real) -> tuple[Real, Real]:
        """Residuals (..., m) and their derivative (..., m, d)."""
        rows = x.reshape(-1, x.shape[-1])
        pairs = [self._one(row) for row in rows]
        value = np.stack([residual for residual, _ in pairs]).reshape(*x.shape[:-1], -1)
        slopes = np.stack([by_x for _, by_x in pairs])
        return value, slopes.reshape(*value.shape, x.shape[-1])

    def _one(self, x: Real) -> tuple[Real, Real]:
        theta = self.space.theta(x)
        # Counted here, where every evaluation passes, so that none goes past the recorder.
        self.tally.points += 1
        try:
            residuals = [part.residual(self.model, theta, self.reference) for part in self.parts]
        except SpringpotError:
            # Somewhere in the box a model may leave what can be followed: an optimiser goes on from
            # elsewhere.
            count = sum(part.count() for part in self.parts)
            return np.full(count, np.inf), np.zeros((count, len(x)))
        value = np.concatenate([each.value for each in residuals])
        by_theta = np.concatenate([each.by_theta for each in residuals])
        return value, by_theta @ self.space.jacobian(x)


def _slowest(part: Part) -> float:
    """Lowest angular frequency, or one over the longest time, that a part tells something of."""
    if isinstance(part, InTimePart):
        return part.test.seen[0]
    return float(part.test.omega.min())
