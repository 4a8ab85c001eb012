"""What is known of vertical factors before the data speak.

Tikhonov's regularisation with a width that has a meaning, which is Bayes' theorem with a normal
prior of ln b; data that contradict it have their way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from springpot.rheology.levels import Levels
from springpot.rheology.model import Model
from springpot.rheology.points import Real

POWER = 1.0
"""Standard deviation of n in b = (T / Tr)^n.

1 for an ideal rubber (Flory), below 0 for a glass, whose modulus falls
by tenths of a per cent for each kelvin."""
REPEATED = 0.03
"""Standard deviation of ln b of one sweep by itself.

The gap and the grip of a specimen give and slip by some per
cent when the temperature changes."""
ELSEWHERE = float(np.log(2.0))
"""Standard deviation of ln b along other columns: only its order of magnitude is known."""


@dataclass(frozen=True, eq=False)
class Expected:
    """What is known of the effects' parameters before the data speak.

    Attributes
    ----------
    rows : ndarray, shape (r, q)
        The logarithms of the parameters times these are expected to be normal, of unit variance
        about zero; nothing is expected of one whose column is zero.
    unit : float
        Variance of a weighted residual of the data, by which departures are weighed against these.
    moved : ndarray, shape (q,), optional
        By how much the search coordinates, of factors the logarithms, would be others with what
        the evidence did not ask for.
    """

    rows: Real
    unit: float
    moved: Real | None = None

    @property
    def weighted(self) -> Real:
        """Rows (r, q) whose squares stand beside those of the residuals."""
        return np.asarray(np.sqrt(self.unit) * self.rows, dtype=np.float64)

    @property
    def covariance(self) -> Real:
        """Covariance (q, q) of logarithms of which something is expected; zero for others."""
        precision = self.rows.T @ self.rows
        known = np.flatnonzero(np.diag(precision) > 0.0)
        covariance = np.zeros_like(precision)
        covariance[np.ix_(known, known)] = np.linalg.inv(precision[np.ix_(known, known)])
        return covariance

    def of(self, columns: Sequence[int]) -> Expected | None:
        """The same of some of the parameters; none where nothing is expected of them."""
        rows = self.rows[:, list(columns)]
        rows = rows[np.any(rows != 0.0, axis=1)]
        if not len(rows):
            return None
        moved = None if self.moved is None else self.moved[list(columns)]
        return Expected(rows, self.unit, moved)


def expectation(model: Model) -> Real:
    """Rows (r, q) that whiten the logarithms of free vertical factors by what is expected of them.

    Of the parameters of all effects; zero where nothing is expected.

    Every level, that of reference too, has an error of its own, so that no level is trusted before
    the others.
    """
    blocks = np.zeros((0, 0))
    for effect in model.effects:
        element = effect.element
        own = np.zeros((0, len(element.parameters)))
        if isinstance(element, Levels) and not element.logarithmic:
            own = np.linalg.inv(np.linalg.cholesky(_covariance(element)))
        blocks = block_diag(blocks, own)
    return np.asarray(blocks, dtype=np.float64)


def _covariance(element: Levels) -> Real:
    """Of the logarithms of the free vertical factors, one at the reference."""
    free = list(element.free)
    size, along = ELSEWHERE, np.zeros(len(free))
    if element.column == "temperature":
        size = REPEATED
        kelvin = np.array(element.values)
        along = POWER * np.log(kelvin[free] / kelvin[element.reference])
    shared = np.ones((len(free), len(free)))
    return np.asarray(
        np.outer(along, along) + size**2 * (np.eye(len(free)) + shared), dtype=np.float64
    )


def spread_between(element: Levels) -> Real:
    """Expected standard deviation (m, m) of ln b from each level to each other."""
    size, along = ELSEWHERE, np.zeros(len(element.values))
    if element.column == "temperature":
        size, along = REPEATED, POWER * np.log(np.array(element.values))
    return np.asarray(
        np.sqrt(np.subtract.outer(along, along) ** 2 + 2.0 * size**2), dtype=np.float64
    )
