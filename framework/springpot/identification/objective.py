"""Objectives: how a model's misfit is measured.

Every objective is a weighted sum of squares in one plane, so that one exact Jacobian serves them all.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from springpot.measurement import Measurement
from springpot.rheology import Complex, Real


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
    """

    name: str
    summary: str
    weights: Callable[[Measurement], Complex]
    logarithmic: bool = False
    citation: str = ""

    def residual(self, stiffness: Complex, measurement: Measurement, weights: Complex) -> Real:
        """Weighted residuals, shape (..., 2n): those of the real part, then those of the imaginary part."""
        if self.logarithmic:
            return weighted(np.log(stiffness / measurement.stiffness), weights)
        return weighted(stiffness - measurement.stiffness, weights)

    def value(self, stiffness: Complex, measurement: Measurement, weights: Complex) -> Real:
        """Sum of squared residuals, shape (...), without laying their parts side by side."""
        if self.logarithmic:
            error = np.log(stiffness / measurement.stiffness)
        else:
            error = np.subtract(stiffness, measurement.stiffness, order="C")
        parts = np.ascontiguousarray(error).view(np.float64)
        parts *= np.ascontiguousarray(weights).view(np.float64)
        value: Real = np.einsum("...i,...i->...", parts, parts)
        return value

    def derivative(self, by_theta: Complex, stiffness: Complex, weights: Complex) -> Real:
        """Derivative of `residual`, shape (..., p, 2n), from dK/dtheta of shape (..., p, n)."""
        slope = by_theta / stiffness[..., None, :] if self.logarithmic else by_theta
        return weighted(slope, weights)


def weighted(values: Complex, weights: Complex) -> Real:
    """Real and imaginary parts side by side, each times its own weight."""
    return np.concatenate([values.real * weights.real, values.imag * weights.imag], axis=-1)
