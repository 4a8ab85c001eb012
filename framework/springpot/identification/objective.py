"""Objectives: how a model's misfit is measured.

Every objective is a weighted sum of squares in one plane, so that one exact Jacobian serves them
all.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from springpot.errors import PluginError
from springpot.measurement.measurement import Measurement
from springpot.owners import owned
from springpot.rheology.points import Complex, Real

LEAST_SIZE = 1e-9
"""Share of the largest |K| by which a difference is divided at least.

What is smaller is rounding of the others.
"""


@dataclass(frozen=True)
class Objective:
    """A weighted sum of squared differences of K' and K'' (or of ln|K| and the phase).

    Parameters
    ----------
    name : str
        What users type.
    summary : str
        One sentence with the formula.
    weights : callable
        Measurement to complex weights (..., n): the real part weighs K', the imaginary part K''.
    logarithmic : bool
        Compare ln K instead of K.
    citation : str
        Source of the formula.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> from springpot.identification import default_objective
    >>> data = Measurement([1.0], [3.0 + 4.0j])
    >>> objective = default_objective(data)
    >>> round(float(objective.value(np.array([3.0 + 4.5j]), data, objective.weights(data))), 6)
    0.01
    """

    name: str
    summary: str
    weights: Callable[[Measurement], Complex]
    logarithmic: bool = False
    citation: str = ""

    def weighing(self, measurement: Measurement) -> Complex:
        """The weights for a measurement, checked.

        Raises
        ------
        PluginError
            If one of them is no finite number: nothing could be compared by it.
        """
        weights = np.asarray(self.weights(measurement), dtype=np.complex128)
        if not np.all(np.isfinite(weights)):
            raise PluginError(
                f"the {owned('objective', self.name)} weighs points of {measurement.name} by what"
                " is no finite number"
            )
        return weights

    def residual(self, stiffness: Complex, measurement: Measurement, weights: Complex) -> Real:
        """Weighted residuals, shape (..., 2n).

        Those of the real part, then those of the imaginary part.
        """
        if self.logarithmic:
            return weighted(np.log(stiffness / measurement.stiffness), weights)
        return weighted(stiffness - measurement.stiffness, weights)

    def value(self, stiffness: Complex, measurement: Measurement, weights: Complex) -> Real:
        """Sum of squared residuals, shape (...), without laying their parts side by side."""
        if self.logarithmic:
            error = np.log(stiffness / measurement.stiffness)
            storage, loss = error.real * weights.real, error.imag * weights.imag
        else:
            # Part by part: each is read once and then lies side by side.
            storage = (stiffness.real - measurement.stiffness.real) * weights.real
            loss = (stiffness.imag - measurement.stiffness.imag) * weights.imag
        storage *= storage
        loss *= loss
        storage += loss
        return total(storage)

    def derivative(self, by_theta: Complex, stiffness: Complex, weights: Complex) -> Real:
        """Derivative of `residual`, shape (..., p, 2n), from dK/dtheta of shape (..., p, n)."""
        # d ln K = dK / K.
        if self.logarithmic:
            by_theta = by_theta / stiffness[..., None, :]
        return weighted(by_theta, weights)


def weighted(values: Complex, weights: Complex) -> Real:
    """Real and imaginary parts side by side, each times its own weight."""
    return np.concatenate([values.real * weights.real, values.imag * weights.imag], axis=-1)


def numbers_of(weights: Complex) -> int:
    """How many numbers count: K' and K'' of each point, but none that has no weight."""
    return int(np.count_nonzero(weights.real) + np.count_nonzero(weights.imag))


def total(terms: Real) -> Real:
    """Sum of (..., n) over its last axis, term after term.

    A sum by halves would depend on how the terms lie in memory, and so a run on what is evaluated
    beside it.
    """
    if terms.ndim == 2 and terms.strides[0] < terms.strides[1] and len(terms) > 1:
        # Whole columns are added: each row's terms come one after another, and all rows side by
        # side.
        columns: Real = np.add.reduce(terms, axis=-1)
        return columns
    sums: Real = np.add.accumulate(terms, axis=-1)[..., -1]
    return sums


def sizes(measurement: Measurement) -> Real:
    """|K| (n,) by which differences are divided."""
    size = measurement.magnitude
    # A point of nearly no stiffness, as at an antiresonance, must not divide by zero and decide
    # alone.
    return np.asarray(np.maximum(size, LEAST_SIZE * size.max()), dtype=np.float64)


def relative_objective() -> Objective:
    """The differences of K' and K'' over |K|: the objective where none is asked for."""
    return Objective("relative", "the differences of K' and K'' over |K|", _over_magnitude)


def _over_magnitude(measurement: Measurement) -> Complex:
    return np.asarray((1.0 + 1.0j) / sizes(measurement), dtype=np.complex128)


def _over_sd(measurement: Measurement) -> Complex:
    sd = measurement.sd
    assert sd is not None
    return np.asarray(1.0 / sd.real + 1.0j / sd.imag, dtype=np.complex128)


def default_objective(measurement: Measurement) -> Objective:
    """Weighted by the given standard deviations, or relative where none are given.

    Examples
    --------
    >>> from springpot import Measurement
    >>> from springpot.identification import default_objective
    >>> default_objective(Measurement([1.0], [3.0 + 4.0j], sd=[0.1 + 0.1j])).name
    'weighted'
    """
    if measurement.sd is None:
        return relative_objective()
    return Objective("weighted", "the differences over their given standard deviations", _over_sd)
