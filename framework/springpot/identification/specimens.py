"""Specimens of one kind fitted together: they differ, which repeats of one specimen do not."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from springpot.distributions import f_sf
from springpot.measurement.conversion import FILE
from springpot.measurement.measurement import CONDITIONS, Measurement
from springpot.rheology.points import Real
from springpot.thresholds import WHERE

from ..numerics import SMALLEST
from .bordered import Bordered, LevelSlopes
from .material import is_material
from .native import Fit

FEWEST = 3
"""Specimens from which their scatter says how well a parameter is known.

Two leave one degree of freedom.
"""


@dataclass(frozen=True, eq=False)
class Specimens:
    """The files of a joint fit.

    Attributes
    ----------
    number : ndarray of int, shape (n,)
        Of the file that each point is from.
    count : int
        How many files there are.
    """

    number: NDArray[np.intp]
    count: int

    @classmethod
    def of(cls, measurement: Measurement) -> Specimens | None:
        """Those of joined files that all hold the same test.

        None where one file, or each another condition.
        """
        if FILE not in measurement.labels:
            return None
        names, number = np.unique(measurement.labels[FILE], return_inverse=True)
        if len(names) < 2:
            return None
        # A temperature in each file makes no specimens: what differs there is what was varied.
        for name in set(CONDITIONS) & set(measurement.conditions):
            levels = measurement.levels(name)
            if len({tuple(np.unique(levels[number == i])) for i in range(len(names))}) > 1:
                return None
        return cls(number.astype(np.intp), len(names))

    def sandwich(self, jacobian: Real, residual: Real, inverse: Real) -> Real:
        """Covariance (p, p) from how much each specimen alone pulls at the parameters.

        Parameters
        ----------
        jacobian : ndarray, shape (2n, p)
            Of the weighted residuals, real parts first.
        residual : ndarray, shape (2n,)
            These residuals.
        inverse : ndarray, shape (p, p)
            Inverse of the jacobian's square.

        Notes
        -----
        Liang and Zeger 1986, doi:10.1093/biomet/73.1.13, with the factor G / (G - 1) of few
        clusters and Student's t of G - 1 degrees of freedom (Cameron and Miller 2015,
        doi:10.3368/jhr.50.2.317).
        """
        both = np.concatenate([self.number, self.number])
        pulls = np.array([jacobian[both == i].T @ residual[both == i] for i in range(self.count)])
        moved = pulls @ inverse
        covariance: Real = self.count / (self.count - 1) * moved.T @ moved
        return covariance

    def sandwich_of_levels(
        self, slopes: LevelSlopes, residual: Real, inverse: Bordered
    ) -> Bordered:
        """The same of specimens among levels that have parameters of their own."""
        both = np.concatenate([self.number, self.number])
        moved = inverse.times(slopes.pulls(residual, both, self.count))
        columns = np.sqrt(self.count / (self.count - 1)) * moved.T
        return replace(inverse, blocks=np.zeros_like(inverse.blocks), columns=columns)

    def scatter(self, fit: Fit) -> float:
        """Standard deviation of the specimens' stiffness over their mean.

        0 where noise alone may be all of it.
        """
        model = fit.model.stiffness(fit.theta, fit.measurement.points)
        off = (fit.measurement.stiffness - model) / model
        parts = [off[self.number == i].real for i in range(self.count)]
        means = np.array([part.mean() for part in parts])
        sizes = np.array([len(part) for part in parts])
        spare = int(sizes.sum()) - self.count
        if spare < 1:
            return 0.0
        within = sum(float(np.sum((part - part.mean()) ** 2)) for part in parts) / spare
        whole = float(np.average(means, weights=sizes))
        between = float(np.sum(sizes * (means - whole) ** 2)) / (self.count - 1)
        if f_sf(between / max(within, SMALLEST), self.count - 1, spare) > WHERE.levels_differ:
            return 0.0
        return float(np.sqrt(max(between - within, 0.0) / sizes.mean()))


def follows_specimens(fit: Fit) -> Specimens | None:
    """The specimens that the intervals of a fit can follow.

    None where they are too few, or it has a spectrum.
    """
    specimens = _among_levels(fit)
    if specimens is None or specimens.count < FEWEST or is_material(fit.model):
        return None
    return specimens


def _among_levels(fit: Fit) -> Specimens | None:
    """The specimens of a fit; None where each is a level that has parameters of its own.

    How levels differ is what their parameters say: they are no scatter of the others.
    """
    specimens = Specimens.of(fit.measurement)
    if specimens is None or fit.task.levels is None:
        return specimens
    level = fit.task.levels.layout.number
    pairs = np.unique(np.column_stack([level, specimens.number]), axis=0)
    return specimens if len(pairs) > len(np.unique(level)) else None


def told(fit: Fit) -> Iterator[str]:
    """What is to be known of specimens that were fitted together."""
    specimens = _among_levels(fit)
    if specimens is None:
        return
    scatter = specimens.scatter(fit)
    differ = "the files are taken for specimens of one kind"
    if scatter:
        differ = f"the specimens differ by {100.0 * scatter:.2g} %"
    if follows_specimens(fit) is not None:
        yield (
            f"{differ}: intervals follow the scatter of {specimens.count} specimens,"
            " not that of the points"
        )
    else:
        yield (
            f"{differ}: intervals do not know it, and are too narrow;"
            " three or more specimens would tell"
        )
